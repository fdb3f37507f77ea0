"""soma:Closing: close a drawer or a door: push its front, else by its handle."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from cramlite.model import Action, Belief, ExpectedContact, ExpectedGrip, Fingers, Location, Motion, Stage
from cramlite.plugin import Decomposition, Parameter, TaskType, hookimpl

from ..task_kit.bases import FORCES, SPEED, ByHandle
from ..task_kit.preconditions import empty_hand

TOUCH = {"speed_m_s": 0.012, "free_m_s": 0.1, "force_n": 3.0, "beyond_m": 0.01, "expect": ExpectedContact.ANY}
"""Parameters of the guarded motion of the fingers to the front of a drawer or a door: slow at the end, since a thing that is hit sets off
with a jolt, and as fast through the air as things are lifted."""
PRESS = {"beyond_m": 0.05, "expect": ExpectedContact.ANY}
"""Parameters of the push that closes a joint: it aims 50 mm beyond the goal, since a compliant push that a door's damping held back ended
13 mm before its place, and one that aimed 20 mm beyond left the door open."""

SHUT = {"most": 0.1}
"""Share of the joint's range to which nothing may stand in the way: of what is left the motions tell more."""


class Closing(ByHandle):
    task = "soma:Closing"
    aliases = ("Close", "CloseContainer")
    summary = "close a drawer or a door: push its front, hold it by its handle, or one after the other"
    parameters = (
        SPEED, *FORCES, Parameter("press_n", 10.0, "twice what damping of 50 N s/m takes at 0.1 m/s: more is the stop, or what jams")
    )  # fmt: skip
    stroke = "push"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if self.holds(action, belief):
            yield from super().decompose(action, belief)
            return
        by_front = not self.strokes(action, belief)  # what turns so far has none that stays before the hand
        if by_front:
            yield self._by_its_front(action, belief)
        for held in super().decompose(action, belief):
            yield Decomposition(held.steps, held.reason, 1.0)
        thing = belief.thing(action.roles["Patient"].entity or action.roles["Patient"].name)
        if by_front and thing.joint is not None and thing.joint.kind == "hinge":
            yield self._led_then_pushed(action, belief)

    def _led_then_pushed(self, action: Action, belief: Belief) -> Decomposition:
        """Closing of a door that turns farther than the arm can lead it: by its handle as far as the arm
        comes, then by pushing its front."""
        begun = Location(action.inside("begun"), "closed", action.roles["Patient"].name, {"ajar": 1.0})
        led = self.led_by_handle(replace(action, name=action.inside("led")), begun)
        steps = (*led, *self._by_its_front(action, belief).steps)
        return Decomposition(steps, "lead it by its handle as far as the arm comes, then push its front, to the stop", 2.0)

    def _by_its_front(self, action: Action, belief: Belief) -> Decomposition:
        empty_hand(belief)
        patient, touch = action.roles["Patient"], (action.roles["Patient"].name,)
        front, back = Location(action.inside("front"), "front", patient.name, SHUT), Location(action.inside("away"), "retreat")
        way, end = self.way(action), Location(action.inside("stop"), "stop", patient.name)
        limits = {k: self.parameter(action, k) for k in ("speed_m_s", "force_limit_n")} | {"paced": 1.0}
        press = {"speed_m_s": 0.015, "force_n": self.parameter(action, "press_n"), "paced": 1.0, **PRESS}
        steps = (
            front,
            Motion(action.inside("transfer"), "transfer", front, reason=f"before {patient.entity}"),
            Motion(action.inside("shut"), "gripper", None, {"to": Fingers.SHUT, "expect": ExpectedGrip.NONE}, reason="fingers together"),
            Motion(action.inside("tare"), "zero_sensor", reason="what the sensor reads here is no contact force"),
            Motion(action.inside("touch"), "until_contact", front, TOUCH, touch, f"to the front of {patient.entity}"),
            way,
            Motion(action.inside("push"), "force_path", way, limits, touch, f"{patient.entity} goes its way"),
            end,
            Motion(action.inside("press"), "until_contact", end, press, touch, "to the stop"),
            back,
            Motion(action.inside("back"), "linear", back, {"stage": Stage.POSE}, touch, "clear of the front"),
        )
        return Decomposition(steps, "push its front with closed fingers, to the stop")

    def begins_at(self, action: Action) -> Location:
        return replace(super().begins_at(action), parameters=SHUT)

    def way(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"closed({patient})", "closed", patient)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Closing()]

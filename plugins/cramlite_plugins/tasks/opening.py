"""soma:Opening: open a drawer or a door by its handle; a drawer also by pressing on its handle, a door by pushing on from inside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import Any

from msgspec.structs import replace

from cramlite.model import Action, Belief, ExpectedGrip, Fingers, Location, Motion, Place, Stage
from cramlite.plugin import HAND, Allowance, Decomposition, Parameter, TaskType, hookimpl

from ..shapes.carried_along import driven
from ..task_kit.bases import FORCES, SPEED, ByHandle
from ..task_kit.preconditions import empty_hand

LESS = (0.85, 0.8)
"""Shares of the joint's range to which the handle is moved if no grasp reaches farther, or if the next task needs room in front."""
DRIVES = "drives"
"""Name of the parameter of a location designator that lets a drawer push obstacles along."""
TOUCH = {"speed_m_s": 0.01, "free_m_s": 0.1, "force_n": 3.0, "beyond_m": 0.03}
"""Parameters of the guarded motion onto a handle: as fast through the air as things are lifted, slow on the last 15 mm."""


class Opening(ByHandle):
    task = "soma:Opening"
    aliases = ("Open", "OpenContainer")
    summary = "open a drawer or a door by its handle; press on that and draw a drawer out, or push a door on from inside"
    parameters = (
        SPEED, Parameter("share", 0.0, "of the joint's range; 0: 0.95 or 0.9, and 0.85 or 0.8 where neither is free"), *FORCES,
        Parameter("press_n", 12.0, "friction of 0.5 then draws 6 N, what damping of 50 N s/m takes at 0.12 m/s"),
    )  # fmt: skip
    stroke = "pull"
    lays_open = "Patient"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if self.holds(action, belief):
            yield from super().decompose(action, belief)
            return
        yield from self._led(action, belief)
        if not self.parameter(action, "share"):  # what others count as open is more than this, so that no other grip shall do before
            for k, share in enumerate(LESS):
                for way in self._led(replace(action, parameters={**action.parameters, "share": share}), belief):
                    yield replace(way, reason=f"{way.reason}; only to {share:g} of the range", cost=0.5 + 0.1 * k)
        thing = belief.thing(action.roles["Patient"].entity or action.roles["Patient"].name)
        if thing.joint is not None and thing.joint.kind == "hinge":
            yield self._push_from_inside(action)
        yield self._pressing(action)
        yield from self._driving(replace(action, parameters={**action.parameters, DRIVES: 1.0}), belief)

    def _led(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        """Decompositions of opening with the hand on the lever that is mounted on a door, and on the handle."""
        if belief.world.mounted_on(action.roles["Patient"].entity or ""):
            yield self._by_lever(action, belief)
        yield from super().decompose(action, belief)

    def _driving(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        """Decompositions of opening a drawer, in which the moving drawer pushes obstacles along.

        They are tried last, since it is less certain where the obstacles end up.
        """
        joint = belief.thing(action.roles["Patient"].entity or "").joint
        ways = (*super().decompose(action, belief), self._pressing(action)) if joint is not None and joint.kind == "slide" else ()
        for way in ways:
            yield replace(way, reason=f"{way.reason}; obstacles in its way are pushed along", cost=way.cost + 2.0)

    def _by_lever(self, action: Action, belief: Belief) -> Decomposition:
        """Opening of a door by the lever that is mounted on it."""
        empty_hand(belief)
        patient, least = action.roles["Patient"], self._least(action)["least"]
        turned = Location(action.inside("turned"), "opened", patient.name, {"share": least, "lever": True})
        level = Location(action.inside("level"), "closed", patient.name, {"lever": True})
        lever = Location(self._lever(action), "handle", patient.name, {"least": least, "lever": True})
        limits = {k: self.parameter(action, k) for k in ("speed_m_s", "force_limit_n")}
        held = self.led_by_handle(action, self.way(action), at=lever)
        k = next(k for k, step in enumerate(held) if step.name == self.way(action).name)
        touch = (patient.name,)
        turn = Motion(action.inside("turn"), "force_path", turned, limits, touch, f"the lever frees {patient.entity}")
        back = Motion(action.inside("turn_back"), "force_path", level, limits, touch, "the lever as it was")
        steps = (*held[:k], turned, turn, *held[k : k + 2], level, back, *held[k + 2 :])
        return Decomposition(steps, "turn the lever, hold it turned while the door opens, and lead it back")

    @staticmethod
    def _lever(action: Action) -> str:
        """Name of the location designator for the hand on a door's lever."""
        return action.inside("lever")

    def _push_from_inside(self, action: Action) -> Decomposition:
        patient, touch, way = action.roles["Patient"], (action.roles["Patient"].name,), self.way(action)
        least, off = self._least(action), Location(action.inside("off"), "retreat")
        begun = Location(action.inside("begun"), "opened", patient.name, {"ajar": least["least"]})
        inner = Location(action.inside("inner"), "inner_side", patient.name, least)
        limits = {k: self.parameter(action, k) for k in ("speed_m_s", "force_limit_n")}
        meet = {"stage": Stage.POSE, "speed_m_s": TOUCH["free_m_s"]}
        steps = (
            *self.led_by_handle(action, begun),
            inner,
            Motion(action.inside("around"), "transfer", inner, reason=f"behind {patient.entity}, which stands ajar"),
            Motion(action.inside("shut"), "gripper", None, {"to": Fingers.SHUT, "expect": ExpectedGrip.NONE}, reason="fingers together"),
            Motion(action.inside("meet"), "linear", inner, meet, touch, "to its inner side"),
            way,
            Motion(action.inside("push"), "force_path", way, limits, touch, f"{patient.entity} goes on its way"),
            off,
            Motion(action.inside("leave"), "linear", off, {"stage": Stage.POSE}, touch, "clear of its inner side"),
        )
        return Decomposition(steps, "draw it ajar by its handle, then push it on from inside", 0.8)

    def _pressing(self, action: Action) -> Decomposition:
        patient, touch, way = action.roles["Patient"], (action.roles["Patient"].name,), self.way(action)
        atop, back = Location(action.inside("atop"), "atop", patient.name, self._least(action)), Location(action.inside("away"), "retreat")
        limits = {k: self.parameter(action, k) for k in ("speed_m_s", "force_limit_n", "press_n")}
        steps = (
            atop,
            Motion(action.inside("transfer"), "transfer", atop, reason=f"above the handle of {patient.entity}"),
            Motion(action.inside("shut"), "gripper", None, {"to": Fingers.SHUT, "expect": ExpectedGrip.NONE}, reason="fingers together"),
            Motion(action.inside("tare"), "zero_sensor", reason="what the sensor reads here is no contact force"),
            Motion(action.inside("touch"), "until_contact", atop, TOUCH, touch, "onto the handle"),
            way,
            Motion(action.inside("draw"), "force_path", way, limits, touch, f"{patient.entity} comes along"),
            back,
            Motion(action.inside("back"), "linear", back, {"stage": Stage.POSE}, touch, "clear of the handle"),
        )
        return Decomposition(steps, "press on the handle from above and draw it along", 1.0)

    def begins_at(self, action: Action) -> Location:
        return replace(super().begins_at(action), parameters=self._least(action))

    def _least(self, action: Action) -> dict[str, Any]:
        """Parameters of a location designator: the share of the joint's range from which a thing counts as open,
        and whether obstacles may be pushed along."""
        return {"least": self.parameter(action, "share") or LESS[-1], **self._drives(action)}

    @staticmethod
    def _drives(action: Action) -> dict[str, bool]:
        return {DRIVES: True} if action.parameters.get(DRIVES) else {}

    def way(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"opened({patient})", "opened", patient, {"share": self.parameter(action, "share"), **self._drives(action)})

    def allowance(self, action: Action, bindings: Mapping[str, Any]) -> Allowance:
        """Return the contacts that the task may make, which include the drawer with the obstacles that it pushes along."""
        allowed, patient = super().allowance(action, bindings), action.roles["Patient"]
        way = bindings.get(self.way(action).name)
        along = (patient.thing, *driven(way)) if isinstance(way, Place) else ()
        lever = bindings.get(self._lever(action))
        hand = {frozenset({HAND, lever.thing})} if isinstance(lever, Place) else set()
        return replace(allowed, touches=allowed.touches | hand | {frozenset(pair) for pair in combinations(along, 2)})


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Opening()]

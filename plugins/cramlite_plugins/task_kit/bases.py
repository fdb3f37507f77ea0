"""Base classes of tasks: motion of a drawer or a door by its handle, and sliding along a surface."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable
from typing import ClassVar

from msgspec.structs import replace

from cramlite.model import WRIST_TURN, Action, Belief, ExpectedGrip, Fingers, Location, Motion, Stage
from cramlite.plugin import Decomposition, Parameter, Role, TaskType

from .preconditions import empty_hand

APPROACH = 0.1  # of a hand to a handle [m/s]: as straight lines are by default; a faster robot brakes too late for what is behind it
SPEED = Parameter("speed_m_s", 0.08, "stops within a millimetre; ISO 10218 reduced speed is 0.25")
STRAIN = 20.0
"""Largest grip force of a hand that turns a thing in strokes [N]: a mounted thing does not give way, so that a grasp 2 mm off its middle
strains the arm by nearly the grip force, which must stay below the motion's force limit."""
FORCES = (
    Parameter("force_n", 0.0, "0: what bears a pull of force_limit_n on the friction of pads and handle, as far as the hand can"),
    Parameter("force_limit_n", 25.0, "rails of 1 N and damping of 5 N s/m took under 10 N in simulation"),
)


class ByHandle(TaskType):
    """Task that holds its Patient by the handle and moves it along its joint; a subclass states the path."""

    roles = (Role("Patient", features=("cram:Handle",), aliases=("object",)),)
    parameters: ClassVar[tuple[Parameter, ...]] = (SPEED, *FORCES)
    moves = ("Patient",)
    stroke: ClassVar[str]
    """Name of the motion along the joint."""
    rest_s: ClassVar[float] = 0.0
    """Time for which the hand stands still at the joint's goal before it lets go [s]."""

    @abstractmethod
    def way(self, action: Action) -> Location:
        """Return the location designator of the handle's path along the joint."""

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        again = self.holds(action, belief)
        if not again:
            empty_hand(belief)
        steps, begun = list(self._let_go(action)) if again else list[Location | Motion](), self.strokes(action, belief)
        most = STRAIN if begun else 0.0
        for way in begun:
            steps += self.led_by_handle(replace(action, name=way.name), way, f" of {way.name}", most)
        steps += self.led_by_handle(action, self.way(action), most_n=most)
        often = f", {len(begun) + 1} times" if begun else ""
        first = "let go of the handle, which the hand holds still, and begin again: " if again else ""
        yield Decomposition(tuple(steps), f"{first}hold the handle, follow the joint, let go{often}")

    @staticmethod
    def holds(action: Action, belief: Belief) -> bool:
        """Check whether the hand has the Patient by its handle already, as after a stop on its way."""
        return belief.held is not None and belief.held.thing == action.roles["Patient"].entity

    @staticmethod
    def _let_go(action: Action) -> tuple[Location | Motion, ...]:
        """Steps that let go of the handle, and leave it straight."""
        off = Location(action.inside("off"), "retreat", None, {"straight": True})
        touch = (action.roles["Patient"].name,)
        return (
            Motion(action.inside("let_go"), "gripper", None, {"to": Fingers.OPEN, "expect": ExpectedGrip.NONE}, reason="let go"),
            off,
            Motion(action.inside("clear"), "linear", off, {"stage": Stage.POSE}, touch, "clear of the handle"),
        )

    def strokes(self, action: Action, belief: Belief) -> tuple[Location, ...]:
        """Return the locations at which all strokes but the last end, if a hinge is to turn farther than the
        wrist can in one grasp; else none."""
        thing, way = belief.thing(action.roles["Patient"].entity or action.roles["Patient"].name), self.way(action)
        if thing.joint is None or thing.joint.kind != "hinge" or thing.name not in belief.poses:
            return ()
        joint = thing.moved_to(belief.poses[thing.name].pose).joint or thing.joint
        whole = joint.upper - joint.lower
        there, goal = (joint.value - joint.lower) / whole, way.parameters.get("share") or float(way.relation == "opened")
        count = math.ceil(abs(goal - there) * whole / WRIST_TURN)
        shares = (there + (goal - there) * k / count for k in range(1, count))
        ends = ({**way.parameters, "share": share} for share in shares)
        return tuple(replace(way, name=action.inside(f"stroke_{k}"), parameters=end) for k, end in enumerate(ends, 1))

    def led_by_handle(
        self, action: Action, way: Location, which: str = "", most_n: float = 0.0, at: Location | None = None
    ) -> tuple[Location | Motion, ...]:
        """Return the steps that take the handle, lead it along a way, and let go.

        Args:
            which: what tells the handle's location from others of the same task.
            most_n: bound of the grip force [N]; 0 for none.
            at: the place of the hand on it; None where the task begins.
        """
        patient, handle = action.roles["Patient"], at or self.begins_at(action)
        handle = replace(handle, name=f"{handle.name}{which}")
        limits = {k: self.parameter(action, k) for k in ("speed_m_s", "force_limit_n")} | {"paced": 1.0}
        close = {"to": Fingers.CLOSED, "expect": ExpectedGrip.OBJECT, "force_n": self.parameter(action, "force_n")}
        close |= {"most_n": most_n} if most_n else {}
        touch, back = (patient.name,), Location(action.inside("away"), "retreat", None, {"straight": True})
        still = Motion(action.inside("rest"), "hold", None, {"duration_s": self.rest_s}, reason=f"{patient.entity} comes to rest")
        return (
            handle,
            Motion(action.inside("open"), "gripper", handle, {"to": Fingers.PLACE}, reason="wider than the handle"),
            Motion(action.inside("transfer"), "transfer", handle, reason="in front of the handle"),
            Motion(action.inside("approach"), "linear", handle, {"stage": Stage.POSE, "speed_m_s": APPROACH}, touch, "around the handle"),
            Motion(action.inside("close"), "gripper", handle, close, reason="hold the handle"),
            way,
            Motion(action.inside(self.stroke), "force_path", way, limits, touch, f"the way that {patient.entity} moves"),
            *((still,) if self.rest_s else ()),
            Motion(action.inside("release"), "gripper", None, {"to": Fingers.OPEN, "expect": ExpectedGrip.NONE}, reason="let go"),
            back,
            Motion(action.inside("back"), "linear", back, {"stage": Stage.POSE}, touch, "clear of the handle"),
        )

    def begins_at(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"handle({patient})", "handle", patient)


class Sliding(TaskType):
    """Task that slides something along the surface of its Relatum; a subclass names what slides: the gripper or
    the payload."""

    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("distance_m", 0.08, "a short stroke; scenarios say what they need"),
        Parameter("speed_m_s", 0.02, "at 20 mm/s and less inertia does not look like contact"),
        Parameter("press_n", 12.0, "keeps contact in simulation; 3 N bounced for up to 1.2 s, 8 N for 0.1 s"),
        Parameter("force_limit_n", 25.0, "as for extraction; a free stroke stays below 17 N"),
    )

    def slide(self, action: Action) -> Decomposition:
        """Return the decomposition of sliding: tare the force sensor, then press onto the surface and move along it."""
        surface, far = action.roles["Relatum"], {"distance_m": self.parameter(action, "distance_m")}
        way = Location(action.inside("slide"), "slide", surface.name, far)
        force = {k: self.parameter(action, k) for k in ("speed_m_s", "press_n", "force_limit_n")}
        tare = Motion(action.inside("tare"), "zero_sensor", reason="from here on, more is pressing")
        stroke = Motion(action.inside("stroke"), "compliant_slide", way, force, (surface.name,), f"along {surface.entity}")
        return Decomposition((way, tare, stroke), "straight stroke that follows the surface")

"""artm:AssumingArmPoseConstrained: the arm moves on a straight line until it touches its goal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from msgspec.structs import replace

from cramlite.model import Action, Belief, Location, Motion, Stage, thing_of
from cramlite.plugin import HAND, HELD, Allowance, Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl


class AssumingArmPoseConstrained(TaskType):
    task = "artm:AssumingArmPoseConstrained"
    aliases = ("MoveArmConstrained",)
    roles = (Role("Relatum", features=("vrps:SurfaceFeature",), required=False),)
    summary = "move the arm on a straight line into contact"
    parameters = (
        Parameter("speed_m_s", 0.01, "a guarded approach at 10 mm/s peaks at 9 N in simulation"),
        Parameter("force_n", 3.0, "above sensor noise and the inertia of slow motion"),
        Parameter("duration_s", 0.2, "in contact at the end: a bump is over sooner, detection calls 0.06 s a state"),
    )
    leads_on = True

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if "Relatum" in action.roles:
            yield self._felt(action, belief)
            return
        goal = action.goal or Location("home", "home")
        touched = (goal.of,) if goal.of else ()
        steps = (
            Motion(action.inside("transfer"), "transfer", goal, reason=f"to the stand-off of {goal}"),
            Motion(action.inside("line"), "linear", goal, {"stage": Stage.POSE}, touched, reason=f"straight into {goal}"),
        )
        yield Decomposition(steps, f"straight line into {goal}")

    def allowance(self, action: Action, bindings: Mapping[str, Any]) -> Allowance:
        """Return the contacts that the motion may make: those of the task, and those with the thing that the motion's goal is about."""
        own, about = super().allowance(action, bindings), bindings.get(action.goal.of or "") if action.goal else None
        if not isinstance(about, str):
            return own
        return replace(own, touches=own.touches | {frozenset({who, thing_of(about)}) for who in (HAND, HELD)})

    def _felt(self, action: Action, belief: Belief) -> Decomposition:
        """Decomposition of a guarded motion down to a surface, until the empty hand feels it."""
        if belief.held is not None:
            raise Unresolvable(f"the gripper holds '{belief.held.thing}', and must be empty to feel for a surface; use PuttingDown")
        surface = action.roles["Relatum"]
        place = Location(f"touch({surface.name})", "touch", surface.name)
        guard = {k: self.parameter(action, k) for k in ("speed_m_s", "force_n")}
        stay = {"duration_s": self.parameter(action, "duration_s")}
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"above {surface.entity}"),
            Motion(action.inside("tare"), "zero_sensor", reason="what the sensor reads here is no contact force"),
            Motion(action.inside("touch"), "until_contact", place, guard, (surface.name,), f"down to {surface.entity}"),
            Motion(action.inside("stay"), "hold", None, stay, reason="in contact, not a bump"),
        )
        return Decomposition(steps, f"guarded motion down to {surface.entity}")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [AssumingArmPoseConstrained()]

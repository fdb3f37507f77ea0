"""soma:Retracting: withdraw the empty hand from a thing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from msgspec.structs import replace

from cramlite.model import Action, Belief, ExpectedGrip, Fingers, Location, Motion, Place, Stage, thing_of
from cramlite.plugin import Allowance, Decomposition, Role, TaskType, Unresolvable, hookimpl

from ..shapes.roofs import has_a_roof

SPEED = 0.05  # of fingers that push [m/s]: a thing ahead of them stays within 1 mm even with a friction of 0.15


class Retracting(TaskType):
    task = "soma:Retracting"
    aliases = ("Retract", "MoveAway")
    roles = (Role("Relatum", required=False), Role("Locatum", required=False))
    summary = "move the empty hand straight back until nothing is near it"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable.because_of_earlier_tasks(f"the gripper still holds '{belief.held.thing}'")
        under = [o.name for o in action.roles.values() if _under_a_roof(o.entity or "", belief)]
        for what in under[:1]:
            yield Decomposition((*self._farther_in(action, what), *self._back(action)), f"push {what} farther in, straight back")
        yield Decomposition(self._back(action), "straight back")

    def allowance(self, action: Action, bindings: Mapping[str, Any]) -> Allowance:
        """Return the contacts that the task may make and the things that it may move, which include the thing that it pushes farther in."""
        pushed: Place | None = bindings.get(action.inside("deeper"))
        return replace(super().allowance(action, bindings), moves=frozenset({thing_of(pushed.thing)} if pushed else ()))

    @staticmethod
    def _back(action: Action) -> tuple[Location, Motion]:
        away = Location(action.inside("away"), "retreat")
        touched = tuple(o.name for o in action.roles.values())
        return away, Motion(action.inside("back"), "linear", away, {"stage": Stage.POSE}, touched, "straight back out of contact")

    @staticmethod
    def _farther_in(action: Action, what: str) -> tuple[Location | Motion, ...]:
        """Steps that push a thing farther in with closed fingers, out of the way of a door or a drawer
        that is closed later."""
        off, deeper = Location(action.inside("off"), "off", what), Location(action.inside("deeper"), "deeper", what)
        push = {"stage": Stage.POSE, "speed_m_s": SPEED}
        return (
            off,
            Motion(action.inside("out"), "linear", off, {"stage": Stage.POSE}, (what,), f"fingers off {what}"),
            Motion(action.inside("shut"), "gripper", None, {"to": Fingers.SHUT, "expect": ExpectedGrip.NONE}, reason="fingers together"),
            deeper,
            Motion(action.inside("push"), "linear", deeper, push, (what,), f"{what} farther in, out of the way of what is closed later"),
        )


def _under_a_roof(name: str, belief: Belief) -> bool:
    """Whether a thing was put onto a support that also has a part above it."""
    onto = thing_of(belief.relates("on", name) or "")
    return onto in belief.poses and has_a_roof(belief.thing(onto), belief.pose(onto))


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Retracting()]

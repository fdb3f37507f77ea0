"""soma:Retracting: withdraw the empty hand from what it touched."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl


class Retracting(TaskType):
    task = "soma:Retracting"
    aliases = ("Retract", "MoveAway")
    roles = (Role("Relatum", required=False), Role("Locatum", required=False))
    summary = "move the empty hand straight back until nothing is near it"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable.because_of_earlier_tasks(f"the gripper still holds '{belief.held.thing}'")
        away = Location(action.inside("away"), "retreat")
        touched = tuple(o.name for o in action.roles.values())
        back = Motion(action.inside("back"), "linear", away, {"stage": "pose"}, touched, "straight back out of contact")
        yield Decomposition((away, back), "straight back")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Retracting()]

"""soma:Reaching: bring the empty hand near an object."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import (
    EARLIER_TASKS,
    Action,
    Belief,
    Decomposition,
    Location,
    Motion,
    Role,
    TaskType,
    Unresolvable,
    hookimpl,
)

HOME = Location("home", "home")  # where a free motion leads when nothing follows it


class Reaching(TaskType):
    task = "soma:Reaching"
    aliases = ("MoveToReach", "Reach")
    roles = (Role("Goal", required=False),)
    summary = "bring the empty hand near an object"
    leads_on = True

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable(
                f"the gripper holds '{belief.held.thing}'; only an empty hand reaches", because=(EARLIER_TASKS,)
            )
        goal = action.goal or HOME
        if goal == HOME and "Goal" in action.roles:  # nothing that follows says where: to where it could be grasped
            name = action.roles["Goal"].name
            near = Location(f"grasp({name})", "grasp", name)
            move = Motion(action.inside("move"), "transfer", near, reason=f"to the stand-off of {near}")
            yield Decomposition((near, move), f"collision-free motion to {near}")
        move = Motion(action.inside("move"), "transfer", goal, reason=f"to the stand-off of {goal}")
        yield Decomposition((move,), f"collision-free motion to {goal}", 1.0)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Reaching()]

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
        goal = action.goal or Location("home", "home")
        yield Decomposition(
            (Motion(action.inside("move"), "transfer", goal, reason=f"to the stand-off of {goal}"),),
            f"collision-free motion to {goal}",
        )


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Reaching()]

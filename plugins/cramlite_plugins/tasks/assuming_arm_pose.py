"""soma:AssumingArmPose: the arm moves freely to a goal."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Belief, Decomposition, Location, Motion, TaskType, hookimpl


class AssumingArmPose(TaskType):
    task = "soma:AssumingArmPose"
    aliases = ("MoveArm", "AssumePose")
    summary = "move the arm without touching anything"
    leads_on = True

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        goal = action.goal or Location("home", "home")
        move = Motion(action.inside("move"), "transfer", goal, reason=f"to where the arm stands before {goal}")
        yield Decomposition((move,), f"collision-free motion to {goal}")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [AssumingArmPose()]

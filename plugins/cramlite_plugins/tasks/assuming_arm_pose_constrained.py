"""artm:AssumingArmPoseConstrained: the arm moves on a straight line until it touches what it moves to."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Belief, Decomposition, Location, Motion, TaskType, hookimpl


class AssumingArmPoseConstrained(TaskType):
    task = "artm:AssumingArmPoseConstrained"
    aliases = ("MoveArmConstrained",)
    summary = "move the arm on a straight line into contact"
    leads_on = True

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        goal = action.goal or Location("home", "home")
        touched = (goal.of,) if goal.of else ()
        steps = (
            Motion(action.inside("transfer"), "transfer", goal, reason=f"to the stand-off of {goal}"),
            Motion(action.inside("line"), "linear", goal, {"stage": "pose"}, touched, reason=f"straight into {goal}"),
        )
        yield Decomposition(steps, f"straight line into {goal}")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [AssumingArmPoseConstrained()]

"""soma:AssumingArmPose: the arm moves freely to a goal."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion, Stage
from cramlite.plugin import Decomposition, TaskType, hookimpl

# Something was let go with the fingers around it and stays there, known to this standard deviation [m]: gripping.LET_GO
# is half of it. A planned path would brush against it.
IN_PLACE = 0.01


class AssumingArmPose(TaskType):
    task = "soma:AssumingArmPose"
    aliases = ("MoveArm", "AssumePose")
    summary = "move the arm without touching anything"
    leads_on = True
    touches = ()

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        goal = action.goal or Location("home", "home")
        move = Motion(action.inside("move"), "transfer", goal, reason=f"to the arm's pose before {goal}")
        let_go = (e for e in belief.poses.values() if e.source.startswith("predicted"))
        if belief.held is None and any(0 < e.sigma <= IN_PLACE for e in let_go):
            away = Location(action.inside("away"), "retreat")
            back = Motion(action.inside("back"), "linear", away, {"stage": Stage.POSE}, reason="clear of what was let go")
            yield Decomposition((away, back, move), f"straight back, then collision-free motion to {goal}")
        yield Decomposition((move,), f"collision-free motion to {goal}", 1.0)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [AssumingArmPose()]

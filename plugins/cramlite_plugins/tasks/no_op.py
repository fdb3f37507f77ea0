"""artm:NoOp: nothing happens."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Motion
from cramlite.plugin import Decomposition, Parameter, TaskType, hookimpl


class NoOp(TaskType):
    task = "artm:NoOp"
    aliases = ("Wait", "DoNothing")
    summary = "neither arm nor gripper moves"
    touches = ()
    parameters = (
        Parameter("duration_s", 0.0, "a pause of a demonstration means nothing; who wants one says how long"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        duration = self.parameter(action, "duration_s")
        wait = Motion(action.inside("wait"), "hold", parameters={"duration_s": duration}, reason="stand still")
        yield Decomposition((wait,) if duration > 0 else (), "stand still" if duration > 0 else "nothing to do")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [NoOp()]

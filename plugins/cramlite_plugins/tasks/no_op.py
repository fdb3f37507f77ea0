"""artm:NoOp: nothing happens."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Belief, Decomposition, TaskType, hookimpl


class NoOp(TaskType):
    task = "artm:NoOp"
    aliases = ("Wait", "DoNothing")
    summary = "neither arm nor gripper moves"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        yield Decomposition((), "nothing to do")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [NoOp()]

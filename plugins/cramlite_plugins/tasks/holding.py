"""soma:Holding: keep hold of an object, standing still."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Motion
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl


class Holding(TaskType):
    task = "soma:Holding"
    aliases = ("Hold",)
    roles = (Role("Patient", aliases=("object",)),)
    summary = "keep hold of an object, standing still"
    slides = False
    parameters = (Parameter("duration_s", 1.0, "long enough for a slip of 1 mm/s to show"),)

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is None:
            raise Unresolvable.because_of_earlier_tasks("nothing is held")
        hold = Motion(
            action.inside("hold"),
            "hold",
            parameters={"duration_s": self.parameter(action, "duration_s")},
            reason="keep hold",
        )
        yield Decomposition((hold,), "stand still with the fingers closed")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Holding()]

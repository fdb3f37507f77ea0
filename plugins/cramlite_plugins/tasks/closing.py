"""soma:Closing: close a drawer or a door by its handle."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import (
    EARLIER_TASKS,
    Action,
    Belief,
    Decomposition,
    Location,
    Parameter,
    Role,
    TaskType,
    Unresolvable,
    hookimpl,
)
from cramlite_plugins.motions.by_handle import by_handle, handle_of


class Closing(TaskType):
    task = "soma:Closing"
    aliases = ("Close", "CloseContainer")
    roles = (Role("Patient", features=("cram:Handle",)),)
    summary = "close a drawer or a door by its handle"
    parameters = (
        Parameter("speed_m_s", 0.05, "slow enough to stop within a millimetre, ISO 10218 reduced speed is 0.25"),
        Parameter("force_n", 50.0, "as for grasping"),
        Parameter("force_limit_n", 25.0, "rails of 1 N and damping of 5 N s/m took under 10 N in simulation"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable(f"the gripper already holds '{belief.held.thing}'", because=(EARLIER_TASKS,))
        patient = action.roles["Patient"].name
        way = Location(f"closed({patient})", "closed", patient)
        values = {p.name: self.parameter(action, p.name) for p in self.parameters}
        yield by_handle(action, way, "push", values)

    def begins_at(self, action: Action) -> Location:
        return handle_of(action)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Closing()]

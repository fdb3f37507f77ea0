"""soma:LookingAt: point the camera at a thing whose pose is believed."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl


class LookingAt(TaskType):
    task = "soma:LookingAt"
    aliases = ("LookAt",)
    roles = (Role("Patient", aliases=("object",)),)
    summary = "point the camera at a thing"
    touches = ()

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        patient = action.roles["Patient"]
        if belief.held is not None and belief.held.thing == patient.entity:
            raise Unresolvable(f"'{patient.entity}' is in the gripper and moves with the camera")
        view = self.begins_at(action)
        move = Motion(action.inside("look"), "transfer", view, reason=f"the camera sees {patient.entity}")
        yield Decomposition((view, move), f"the camera to a view of {patient.entity}")

    def begins_at(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"view({patient})", "view", patient)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [LookingAt()]

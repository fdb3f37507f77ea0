"""soma:LookingFor: bring the camera to where something that is not yet found would be seen."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl


class LookingFor(TaskType):
    task = "soma:LookingFor"
    aliases = ("LookFor", "Searching", "Detect")
    roles = (Role("Patient", required=False, aliases=("object",)),)
    looks = True
    summary = "bring the camera to where something would be seen"
    touches = ()

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        patient = action.roles.get("Patient")
        if action.goal is None and patient is None:
            raise Unresolvable("neither a place nor a thing to look for is named")
        name = patient.name if patient else ""
        view = action.goal or Location(f"view({name})", "view", name)
        where = ", ".join(view.parameters.get("around", ())) or (patient.entity if patient else "")
        move = Motion(action.inside("look"), "transfer", view, reason=f"the camera sees {where}; the picture is taken here")
        yield Decomposition((view, move), f"the camera to a view of {where}")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [LookingFor()]

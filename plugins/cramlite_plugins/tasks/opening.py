"""soma:Opening: open a drawer or a door by its handle."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Location
from cramlite.plugin import Parameter, TaskType, hookimpl

from ..task_kit.bases import FORCES, SPEED, ByHandle


class Opening(ByHandle):
    task = "soma:Opening"
    aliases = ("Open", "OpenContainer")
    summary = "open a drawer or a door by its handle"
    parameters = (SPEED, Parameter("share", 0.0, "of the joint's range; 0: 0.97, or 0.8 where the arm comes no further"), *FORCES)
    stroke = "pull"
    lays_open = "Patient"

    def way(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"opened({patient})", "opened", patient, {"share": self.parameter(action, "share")})


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Opening()]

"""soma:Opening: open a drawer or a door by its handle."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Location
from cramlite.plugin import Parameter, TaskType, hookimpl

from ..task_kit.bases import FORCES, SPEED, ByHandle

LESS = (0.8,)
"""Shares of the joint's range that it is opened by where nobody asked how far, and the arm does not come as far as the default."""


class Opening(ByHandle):
    task = "soma:Opening"
    aliases = ("Open", "OpenContainer")
    summary = "open a drawer or a door by its handle"
    parameters = (SPEED, Parameter("share", 0.95, "of the joint's range; open is what is open by 0.2"), *FORCES)
    stroke = "pull"
    lays_open = "Patient"

    def way(self, action: Action) -> Location:
        patient, share = action.roles["Patient"].name, self.parameter(action, "share")
        shares = (share,) if "share" in action.parameters else (share, *LESS)
        return Location(f"opened({patient})", "opened", patient, {"shares": shares})


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Opening()]

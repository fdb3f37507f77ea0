"""soma:Closing: close a drawer or a door by its handle."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Location
from cramlite.plugin import TaskType, hookimpl

from ..task_kit.bases import ByHandle


class Closing(ByHandle):
    task = "soma:Closing"
    aliases = ("Close", "CloseContainer")
    summary = "close a drawer or a door by its handle"
    stroke = "push"

    def way(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"closed({patient})", "closed", patient)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Closing()]

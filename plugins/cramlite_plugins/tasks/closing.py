"""soma:Closing: close a drawer or a door by its handle."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Location, TaskType, hookimpl
from cramlite_plugins.motions.by_handle import ByHandle


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

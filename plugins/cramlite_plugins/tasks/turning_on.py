"""cram:TurningOn: turn something on by its knob or switch."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Location
from cramlite.plugin import TaskType, hookimpl

from ..task_kit.bases import ByHandle


class TurningOn(ByHandle):
    task = "cram:TurningOn"
    aliases = ("TurnOn", "SwitchOn")
    summary = "turn something on by its knob or switch"
    stroke = "turn"

    def way(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"turned({patient})", "opened", patient, {"turned": True})


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [TurningOn()]

"""cram:TurningOff: turn something off by its knob or switch."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Location
from cramlite.plugin import TaskType, hookimpl

from ..task_kit.bases import ByHandle


class TurningOff(ByHandle):
    task = "cram:TurningOff"
    aliases = ("TurnOff", "SwitchOff")
    summary = "turn something off by its knob or switch"
    stroke = "turn"

    def way(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"turned({patient})", "closed", patient)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [TurningOff()]

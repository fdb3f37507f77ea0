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
    rest_s = 0.5  # a knob that still turned was let go at its stop, sprang back, and glided on for 1 s

    def way(self, action: Action) -> Location:
        patient = action.roles["Patient"].name
        return Location(f"turned({patient})", "closed", patient, {"turned": True})


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [TurningOff()]

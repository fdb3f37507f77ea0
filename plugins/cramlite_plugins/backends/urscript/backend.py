"""The URScript backend as a plugin."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Program, Robot
from cramlite.plugin import Backend, Code, hookimpl


class UrscriptBackend:
    """Text for e-Series controllers; it runs on the controller model of this package."""

    name = "urscript"
    executable = True

    def emit(self, program: Program, robot: Robot) -> Code:
        from .emit import emit

        return emit(program, robot)


@hookimpl
def backends() -> Iterable[Backend]:
    return [UrscriptBackend()]

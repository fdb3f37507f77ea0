"""The URScript backend as a plugin."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Program, Robot
from cramlite.plugin import Backend, Code, hookimpl


class UrscriptBackend:
    """URScript text for e-Series controllers; it runs on the controller model of this package."""

    name = "urscript"
    executable = True

    def emit(self, program: Program, robot: Robot) -> Code:
        """Write the program as URScript; see ``emit.emit``."""
        from .emit import emit

        return emit(program, robot)


@hookimpl
def backends() -> Iterable[Backend]:
    """Declare the URScript backend."""
    return [UrscriptBackend()]

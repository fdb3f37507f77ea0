"""The URScript backend as a plugin."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Backend, Code, Program, Robot, hookimpl


class UrscriptBackend:
    """Text for e-Series controllers; it runs on the controller model of this package."""

    name = "urscript"
    executable = True

    def emit(self, program: Program, robot: Robot) -> Code:
        from .urscript import emit

        return emit(program, robot)


@hookimpl
def backends() -> Iterable[Backend]:
    return [UrscriptBackend()]

"""The RAPID backends as a plugin: with and without ABB's option Force Control."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Program, Robot, Value
from cramlite.plugin import Backend, Code, hookimpl


class Rapid(Value):
    """Backend that writes RAPID modules for ABB arms; cramlite has no controller to run them on."""

    name: str
    forces: bool
    executable: bool = False
    typed_stands_in: bool = True
    remark: str = (
        "RAPID cannot be run here: instructions are unverified; targets are compared with the typed program by tests, "
        "syntax by rapidchecker"
    )

    def emit(self, program: Program, robot: Robot) -> Code:
        """Write the program as RAPID text; see ``emit.emit``."""
        from .emit import emit

        return emit(program, robot, forces=self.forces)


@hookimpl
def backends() -> Iterable[Backend]:
    """Declare the RAPID backends with and without Force Control."""
    return [Rapid("rapid", forces=False), Rapid("rapid_fc", forces=True)]

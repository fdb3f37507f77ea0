"""The backend of Python programs for ur_rtde as a plugin."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version

from cramlite.model import Program, Robot
from cramlite.plugin import Backend, Code, hookimpl


class UrRtdeBackend:
    """Python programs that drive a robot through the package ur-rtde; they run where it is installed."""

    name = "ur_rtde"
    typed_stands_in = True

    @property
    def executable(self) -> bool:
        """Check whether the package ur-rtde is installed."""
        return not _missing()

    @property
    def remark(self) -> str:
        """Return a sentence that goes with every result: how the Python program was run, or why it was
        not."""
        if missing := _missing():
            return f"the Python program was not run: {missing}"
        return (
            f"the Python program ran with the unmodified ur-rtde {version('ur-rtde')} against the virtual controller's ports, "
            "in wall time: another run differs by milliseconds"
        )

    def emit(self, program: Program, robot: Robot) -> Code:
        """Write the program as Python text; see ``emit.emit``."""
        from .emit import emit

        return emit(program, robot)


def _missing() -> str:
    from ...ur_controller.client_program import can_run

    return can_run()


@hookimpl
def backends() -> Iterable[Backend]:
    """Declare the ur_rtde backend."""
    return [UrRtdeBackend()]

"""General-purpose registers and digital outputs, which connect programs and RTDE clients.

Source: the URScript manual (e-Series 5.x), module "interfaces"; the RTDE Guide.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .rtde import REGISTERS
from .urscript.builtins import Library
from .urscript.values import ScriptError, real, show

KINDS: dict[str, Callable[[Any], Any]] = {"integer": int, "float": float, "boolean": bool}
OUTPUTS, TOOL = 18, 16
FIRST = {"": 0, "standard_": 0, "configurable_": 8, "tool_": TOOL}
"""First index of each kind of digital outputs among all of them (RTDE Guide, "actual_digital_output_bits")."""
_FIELDS = {"integer": "int", "float": "double", "boolean": "bit"}


class Registers:
    """Registers by the name of their RTDE field, with the time at which each input was last written.

    Args:
        clock: the time [s].
        log: is told of each digital output that changes, and when: nothing is wired to them, so that is all that they do.
    """

    def __init__(self, clock: Callable[[], float], log: Callable[[str], None] = lambda _: None) -> None:
        self.clock, self.log = clock, log
        self.fields: dict[str, Any] = {}
        self.written: dict[str, float] = {}
        self.watched: dict[str, tuple[float, str]] = {}
        self.outputs = 0

    def library(self) -> Library:
        """Return the URScript functions by which a program uses registers, digital outputs and the watchdog
        on inputs."""
        library: dict[str, Any] = {"rtde_set_watchdog": self.rtde_set_watchdog}
        for kind in KINDS:
            for way in ("input", "output"):
                library[f"read_{way}_{kind}_register"] = self._reader(way, kind)
            library[f"write_output_{kind}_register"] = self._writer(kind)
        for name, first in FIRST.items():
            library[f"set_{name}digital_out"], library[f"get_{name}digital_out"] = self._outputs(name, first)
        return library

    def write_inputs(self, values: dict[str, Any]) -> None:
        """Set the input registers to the values that a client sent, and note the time."""
        self.fields |= values
        self.written |= dict.fromkeys(values, self.clock())

    def late(self) -> str | None:
        """Return the name of a watched input that was not written in time; None if there is none.

        Inputs whose action is "pause" are treated like those with "stop": the program stops.
        """
        for name, (patience, action) in self.watched.items():
            if action != "ignore" and self.clock() - self.written[name] > patience:
                return name
        return None

    def rtde_set_watchdog(self, variable_name: Any, min_frequency: Any, action: Any = "pause") -> None:
        """Watch an input that must be written with at least a frequency [Hz]."""
        frequency = real(min_frequency, "rtde_set_watchdog")
        if frequency <= 0 or action not in ("pause", "stop", "ignore"):
            given = f"{show(min_frequency)} Hz and {show(action)!r}"
            raise ScriptError(f"rtde_set_watchdog needs a positive frequency and 'pause', 'stop' or 'ignore', not {given}")
        self.watched[show(variable_name)] = (1 / frequency, action)
        self.written[show(variable_name)] = self.clock()

    def _outputs(self, name: str, first: int) -> tuple[Callable[[Any, Any], None], Callable[[Any], bool]]:
        """Functions that set and get the digital outputs of one group, whose bits begin at ``first``."""
        count = OUTPUTS - first if first == TOOL else OUTPUTS if first == 0 else 8

        def put(n: Any, b: Any) -> None:
            bit = 1 << first + numbered(n, count)
            before, self.outputs = self.outputs, self.outputs | bit if b else self.outputs & ~bit
            if self.outputs != before:
                self.log(f"{name}digital_out({n}) is {'on' if b else 'off'}")

        def get(n: Any) -> bool:
            return bool(self.outputs >> first + numbered(n, count) & 1)

        return put, get

    def _reader(self, way: str, kind: str) -> Callable[..., Any]:
        def read(address: Any) -> Any:
            name = f"{way}_{_FIELDS[kind]}_register_{numbered(address, 128 if kind == 'boolean' else REGISTERS)}"
            return KINDS[kind](self.fields.get(name, 0))

        return read

    def _writer(self, kind: str) -> Callable[..., None]:
        def write(address: Any, value: Any) -> None:
            name = f"output_{_FIELDS[kind]}_register_{numbered(address, 128 if kind == 'boolean' else REGISTERS)}"
            if type(value) is not bool:
                real(value, name)
            self.fields[name] = KINDS[kind](value)

        return write


def numbered(value: Any, count: int) -> int:
    """Check the number of a register, an input or an output: below ``count``."""
    if type(value) is not int or not 0 <= value < count:
        raise ScriptError(f"address {show(value)} is not in 0 .. {count - 1}")
    return value

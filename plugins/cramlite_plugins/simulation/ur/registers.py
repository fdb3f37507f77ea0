"""General-purpose registers and digital outputs, which connect programs and RTDE clients.

Source: the URScript manual (e-Series 5.x), module "interfaces"; the RTDE Guide.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..urscript.builtins import Library
from ..urscript.values import ScriptError, real, show
from .rtde import REGISTERS

KINDS: dict[str, Callable[[Any], Any]] = {"integer": int, "float": float, "boolean": bool}
_FIELDS = {"integer": "int", "float": "double", "boolean": "bit"}


class Registers:
    """Registers by the name of their RTDE field, with the time at which each input was last written.

    Args:
        clock: the time [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.clock = clock
        self.fields: dict[str, Any] = {}
        self.written: dict[str, float] = {}
        self.watched: dict[str, tuple[float, str]] = {}
        self.outputs = 0

    def library(self) -> Library:
        """Return the functions that a program may call."""
        library: dict[str, Any] = {"rtde_set_watchdog": self.rtde_set_watchdog}
        for kind in KINDS:
            for way in ("input", "output"):
                library[f"read_{way}_{kind}_register"] = self._reader(way, kind)
            library[f"write_output_{kind}_register"] = self._writer(kind)
        for name in ("standard", "configurable", "tool"):
            library[f"set_{name}_digital_out"] = self.set_digital_out
        return {**library, "set_digital_out": self.set_digital_out, "get_digital_out": self.get_digital_out}

    def write_inputs(self, values: dict[str, Any]) -> None:
        """Write the inputs that a client sent."""
        self.fields |= values
        self.written |= dict.fromkeys(values, self.clock())

    def late(self) -> str | None:
        """Name a watched input that was not written in time; both actions, "pause" and "stop", stop the program."""
        for name, (patience, action) in self.watched.items():
            if action != "ignore" and self.clock() - self.written[name] > patience:
                return name
        return None

    def rtde_set_watchdog(self, variable_name: Any, min_frequency: Any, action: Any = "pause") -> None:
        """Watch an input that must be written with at least a frequency [Hz]."""
        frequency = real(min_frequency, "rtde_set_watchdog")
        if frequency <= 0 or action not in ("pause", "stop", "ignore"):
            raise ScriptError(f"rtde_set_watchdog: {show(min_frequency)} Hz and action {show(action)!r} do not fit")
        self.watched[show(variable_name)] = (1 / frequency, action)
        self.written[show(variable_name)] = self.clock()

    def set_digital_out(self, n: Any, b: Any) -> None:
        """Set a digital output."""
        bit = 1 << _address(n, 18)
        self.outputs = self.outputs | bit if b else self.outputs & ~bit

    def get_digital_out(self, n: Any) -> bool:
        """Return a digital output."""
        return bool(self.outputs >> _address(n, 18) & 1)

    def _reader(self, way: str, kind: str) -> Callable[..., Any]:
        def read(address: Any) -> Any:
            name = f"{way}_{_FIELDS[kind]}_register_{_address(address, 128 if kind == 'boolean' else REGISTERS)}"
            return KINDS[kind](self.fields.get(name, 0))

        return read

    def _writer(self, kind: str) -> Callable[..., None]:
        def write(address: Any, value: Any) -> None:
            name = f"output_{_FIELDS[kind]}_register_{_address(address, 128 if kind == 'boolean' else REGISTERS)}"
            if type(value) is not bool:
                real(value, name)
            self.fields[name] = KINDS[kind](value)

        return write


def _address(value: Any, count: int) -> int:
    if type(value) is not int or not 0 <= value < count:
        raise ScriptError(f"address {show(value)} is not in 0 .. {count - 1}")
    return value

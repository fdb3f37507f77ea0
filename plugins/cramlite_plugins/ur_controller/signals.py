"""Inputs, analogue outputs and flags of the controller, with nothing wired to its terminals.

Inputs read low (False, 0 V), as those of a controller without wires do; flags and analogue outputs are remembered. Names and
parameters: the URScript manual (e-Series 5.x), module "interfaces".
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .registers import numbered
from .urscript.builtins import Library
from .urscript.values import ScriptError, real, show

DIGITAL = {"get_standard_digital_in": 8, "get_configurable_digital_in": 8, "get_tool_digital_in": 2, "get_digital_in": 18}
ANALOG = {"get_standard_analog_in": 2, "get_tool_analog_in": 2, "get_analog_in": 4}
FLAGS = 33


class Signals:
    """Outputs and flags that a program set, and the readings of its inputs, to which nothing is wired.

    Args:
        log: is told at the first reading of each input that it is low.
    """

    def __init__(self, log: Callable[[str], None] = lambda _: None) -> None:
        self.log, self.read = log, set[str]()
        self.voltages = [0.0, 0.0]
        self.flags = [False] * FLAGS

    def library(self) -> Library:
        """Return the functions that a program may call."""
        low = {name: self._low(name, count, False) for name, count in DIGITAL.items()}
        low |= {name: self._low(name, count, 0.0) for name, count in ANALOG.items()}
        kept: dict[str, Callable[..., Any]] = {"get_flag": self.get_flag, "set_flag": self.set_flag}
        for prefix in ("", "standard_"):
            kept[f"set_{prefix}analog_out"] = self.set_analog_out
            kept[f"get_{prefix}analog_out"] = self.get_analog_out
        return {**low, **kept}

    def set_analog_out(self, n: Any, f: Any) -> None:
        """Set an analogue output to a share of its range, 0 to 1."""
        share = real(f, "set_analog_out")
        if not 0 <= share <= 1:
            raise ScriptError(f"set_analog_out takes a share of the output's range, 0 to 1, not {show(f)}")
        self.voltages[numbered(n, 2)] = share

    def get_analog_out(self, n: Any) -> float:
        """Return the value of an analogue output: a share of its range, 0 to 1."""
        return self.voltages[numbered(n, 2)]

    def set_flag(self, n: Any, b: Any) -> None:
        """Set a flag of the controller by its number; flags keep their values after the program's end."""
        self.flags[numbered(n, FLAGS)] = b is True

    def get_flag(self, n: Any) -> bool:
        """Return the value of a flag of the controller by its number."""
        return self.flags[numbered(n, FLAGS)]


    def _low(self, name: str, count: int, value: Any) -> Callable[[Any], Any]:
        def read(n: Any) -> Any:
            if (called := f"{name}({numbered(n, count)})") not in self.read:
                self.read.add(called)
                self.log(f"{called} reads {show(value)}: nothing is wired to the inputs here")
            return value

        return read

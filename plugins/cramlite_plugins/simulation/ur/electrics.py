"""URScript functions for the electrical settings of inputs, outputs and tool flange, which move nothing.

Names and parameters: the URScript manual (e-Series 5.x), modules "interfaces" and "ioconfiguration". PolyScope writes them
at the start of every program. There are no inputs and outputs here, so they are checked and have no effect.
"""

from __future__ import annotations

from typing import Any

from ..urscript.builtins import Library
from ..urscript.values import ScriptError, real, show


def electrics() -> Library:
    """Return the functions by name."""
    return {f.__name__: f for f in _FUNCTIONS}


def set_standard_analog_input_domain(port: Any, domain: Any) -> None:
    """Set an analog input to current (0) or voltage (1)."""
    _one_of(port, (0, 1), "set_standard_analog_input_domain's port")
    _one_of(domain, (0, 1), "set_standard_analog_input_domain's domain")


def set_tool_analog_input_domain(port: Any, domain: Any) -> None:
    """Set an analog input of the tool flange to current (0) or voltage (1)."""
    _one_of(port, (0, 1), "set_tool_analog_input_domain's port")
    _one_of(domain, (0, 1), "set_tool_analog_input_domain's domain")


def set_analog_outputdomain(port: Any, domain: Any) -> None:
    """Set an analog output to current (0) or voltage (1)."""
    _one_of(port, (0, 1), "set_analog_outputdomain's port")
    _one_of(domain, (0, 1), "set_analog_outputdomain's domain")


def set_input_actions_to_default() -> None:
    """Free every input of its action."""


def set_tool_voltage(voltage: Any) -> None:
    """Set the supply voltage of the tool flange: 0, 12 or 24 V."""
    _one_of(voltage, (0, 12, 24), "set_tool_voltage's voltage")


def set_tool_communication(
    enabled: Any, baud_rate: Any, parity: Any, stop_bits: Any, rx_idle_chars: Any, tx_idle_chars: Any
) -> None:
    """Set the serial line of the tool flange."""
    for value in (baud_rate, parity, stop_bits, rx_idle_chars, tx_idle_chars):
        real(value, "set_tool_communication")


def set_tool_output_mode(mode: Any) -> None:
    """Set the tool flange's outputs to digital (0) or to two-pin power (1)."""
    _one_of(mode, (0, 1), "set_tool_output_mode's mode")


def set_tool_digital_output_mode(n: Any, mode: Any) -> None:
    """Set an output of the tool flange to sinking (1), sourcing (2) or push and pull (3)."""
    _one_of(n, (0, 1), "set_tool_digital_output_mode's output")
    _one_of(mode, (1, 2, 3), "set_tool_digital_output_mode's mode")


def set_safety_mode_transition_hardness(type: Any) -> None:
    """Set how hard the arm changes between its safety modes; there is one mode here."""
    _one_of(type, (0, 1), "set_safety_mode_transition_hardness's type")


def _one_of(value: Any, valid: tuple[int, ...], where: str) -> None:
    if real(value, where) not in valid:
        raise ScriptError(f"{where} is one of {', '.join(map(str, valid))}, not {show(value)}")


_FUNCTIONS = (
    set_standard_analog_input_domain, set_tool_analog_input_domain, set_analog_outputdomain, set_input_actions_to_default,
    set_tool_voltage, set_tool_communication, set_tool_output_mode, set_tool_digital_output_mode,
    set_safety_mode_transition_hardness,
)  # fmt: skip

"""URScript functions for settings of inputs, outputs, tool flange and connections, which move nothing.

Names and parameters: the URScript manual (e-Series 5.x), modules "interfaces" and "ioconfiguration", and programs of PolyScope,
which writes them at the start of every program. Nothing is wired or connected here, so they are checked and have no effect.
"""

from __future__ import annotations

from typing import Any

from .urscript.builtins import Library
from .urscript.values import ScriptError, real, show


def electrics() -> Library:
    """Return this module's functions by name."""
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
    """Do nothing: a real controller removes the actions that its inputs start, but no input is connected
    here."""


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
    """Check the value that states how hard the arm changes its safety mode: 0 or 1. It has no further effect."""
    _one_of(type, (0, 1), "set_safety_mode_transition_hardness's type")


def set_tool_digital_input_action(port: Any, action: Any) -> None:
    """Assign an action to an input of the tool flange, without effect: no input is connected here."""
    _one_of(port, (0, 1), "set_tool_digital_input_action's port")


def set_standard_digital_input_action(port: Any, action: Any) -> None:
    """Assign an action to an input, without effect: no input is connected here."""
    _one_of(port, tuple(range(8)), "set_standard_digital_input_action's port")


def set_configurable_digital_input_action(port: Any, action: Any) -> None:
    """Assign an action to a configurable input, without effect: no input is connected here."""
    _one_of(port, tuple(range(8)), "set_configurable_digital_input_action's port")


def set_gp_boolean_input_action(port: Any, action: Any) -> None:
    """Accept the action, such as freedrive, that a Boolean register should trigger; here it triggers nothing.

    RTDE clients that set the register change nothing else.
    """
    real(port, "set_gp_boolean_input_action's port")


def set_runstate_standard_digital_outputs(outputs: Any) -> None:
    """Accept the list of outputs that show whether a program runs, without effect: no output is connected here."""


def set_runstate_standard_digital_output_to_value(outputId: Any, state: Any) -> None:
    """Accept the value of a standard output when a program starts or ends, without effect: no output is
    connected here."""
    _one_of(outputId, tuple(range(8)), "set_runstate_standard_digital_output_to_value's output")


def set_runstate_configurable_digital_output_to_value(outputId: Any, state: Any) -> None:
    """Accept the value of a configurable output when a program starts or ends, without effect: no output is
    connected here."""
    _one_of(outputId, tuple(range(8)), "set_runstate_configurable_digital_output_to_value's output")


def set_runstate_tool_digital_output_to_value(outputId: Any, state: Any) -> None:
    """Accept the value of a tool output when a program starts or ends, without effect: no output is connected here."""
    _one_of(outputId, (0, 1), "set_runstate_tool_digital_output_to_value's output")


def tool_wrench_limit_disable() -> None:
    """Do nothing: PolyScope's programs begin by switching off a wrench limit of the tool, which the
    controller model does not have."""


def motion_version_set(version: Any) -> None:
    """Accept a version number of PolyScope's motion laws; the controller model has one version only."""
    real(version, "motion_version_set's version")


def modbus_add_signal(
    IP: Any, slave_number: Any, signal_address: Any, signal_type: Any, signal_name: Any, sequential_mode: Any = False,
    register_count: Any = 1,
) -> None:
    """Declare a signal of a Modbus device, as an installation does; to read or write one is not modelled."""
    _one_of(signal_type, (0, 1, 2, 3), "modbus_add_signal's type")


def modbus_delete_signal(signal_name: Any) -> None:
    """Do nothing: declared signals of Modbus devices are not kept, so that none has to be removed."""


def modbus_set_signal_update_frequency(signal_name: Any, update_frequency: Any) -> None:
    """Accept the update rate of a Modbus signal [Hz], without effect."""
    real(update_frequency, "modbus_set_signal_update_frequency")


def modbus_set_runstate_dependent_choice(signal_name: Any, runstate_choice: Any) -> None:
    """Accept the choice of a Modbus signal's value when a program starts or ends, without effect."""


def modbus_set_digital_input_action(signal_name: Any, action: Any) -> None:
    """Accept an action for a Modbus input signal, without effect: the signal never changes here."""


def rpc_factory(type: Any, url: Any) -> str:
    """Return a handle for remote procedure calls; a call on it is not modelled."""
    return f"rpc handle of {show(url)}"


def _one_of(value: Any, valid: tuple[int, ...], where: str) -> None:
    if real(value, where) not in valid:
        raise ScriptError(f"{where} is one of {', '.join(map(str, valid))}, not {show(value)}")


_FUNCTIONS = (
    set_standard_analog_input_domain, set_tool_analog_input_domain, set_analog_outputdomain, set_input_actions_to_default,
    set_tool_voltage, set_tool_communication, set_tool_output_mode, set_tool_digital_output_mode,
    set_safety_mode_transition_hardness, set_tool_digital_input_action, set_standard_digital_input_action,
    set_configurable_digital_input_action, set_gp_boolean_input_action, set_runstate_standard_digital_outputs,
    set_runstate_standard_digital_output_to_value, set_runstate_configurable_digital_output_to_value,
    set_runstate_tool_digital_output_to_value, tool_wrench_limit_disable, motion_version_set, modbus_add_signal,
    modbus_delete_signal, modbus_set_signal_update_frequency, modbus_set_runstate_dependent_choice,
    modbus_set_digital_input_action, rpc_factory,
)  # fmt: skip

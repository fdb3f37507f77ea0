"""The Real-Time Data Exchange protocol, version 2: packets, recipes and types.

Source: Universal Robots, "Real-Time Data Exchange (RTDE) Guide": header (uint16 size, uint8 type), big endian; the
tables of outputs and inputs with their types.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cramlite.model import Value

FORMATS = {
    "BOOL": "?", "UINT8": "B", "UINT32": "I", "UINT64": "Q", "INT32": "i", "DOUBLE": "d",
    "VECTOR3D": "3d", "VECTOR6D": "6d", "VECTOR6INT32": "6i", "VECTOR6UINT32": "6I",
}  # fmt: skip
HEADER = struct.Struct(">HB")
LARGEST = 4096  # bytes of a packet that a client may send; recipes of all fields stay below
REGISTERS = 48  # integer and double registers in each direction

_OUTPUTS = {
    "DOUBLE": "timestamp actual_execution_time speed_scaling target_speed_fraction actual_momentum actual_main_voltage "
    "actual_robot_voltage actual_robot_current io_current tool_output_current tool_temperature tcp_force_scalar payload "
    "standard_analog_input0 standard_analog_input1 standard_analog_output0 standard_analog_output1 tool_analog_input0 "
    "tool_analog_input1",
    "VECTOR6D": "target_q target_qd target_qdd target_current target_moment actual_q actual_qd actual_current "
    "joint_control_output actual_TCP_pose actual_TCP_speed actual_TCP_force target_TCP_pose target_TCP_speed "
    "joint_temperatures actual_joint_voltage ft_raw_wrench payload_inertia tcp_offset actual_current_as_torque",
    "VECTOR3D": "actual_tool_accelerometer elbow_position elbow_velocity payload_cog",
    "UINT64": "actual_digital_input_bits actual_digital_output_bits",
    "UINT32": "runtime_state robot_status_bits safety_status_bits analog_io_types tool_analog_input_types "
    "output_bit_registers0_to_31 output_bit_registers32_to_63 script_control_line",
    "INT32": "robot_mode safety_mode safety_status tool_output_voltage tool_mode",
    "VECTOR6INT32": "joint_mode",
}
_INPUTS = {
    "UINT32": "speed_slider_mask input_bit_registers0_to_31 input_bit_registers32_to_63",
    "DOUBLE": "speed_slider_fraction standard_analog_output_0 standard_analog_output_1",
    "UINT8": "standard_digital_output_mask standard_digital_output configurable_digital_output_mask "
    "configurable_digital_output tool_digital_output_mask tool_digital_output standard_analog_output_mask "
    "standard_analog_output_type",
    "VECTOR6D": "external_force_torque",
}
_REGISTER = re.compile(r"(input|output)_(int|double|bit)_register_(\d{1,3})")


def _by_name(table: Mapping[str, str]) -> dict[str, str]:
    return {name: kind for kind, names in table.items() for name in names.split()}


OUTPUTS, INPUTS = _by_name(_OUTPUTS), _by_name(_INPUTS)


def type_of(name: str, *, output: bool) -> str:
    """Return the data type of an RTDE field, such as "DOUBLE"; "NOT_FOUND" for a field that the controller
    does not have."""
    found = _REGISTER.fullmatch(name)
    if found and (output or found[1] == "input"):
        number = int(found[3])
        if found[2] == "bit":
            return "BOOL" if 64 <= number < 128 else "NOT_FOUND"
        return {"int": "INT32", "double": "DOUBLE"}[found[2]] if number < REGISTERS else "NOT_FOUND"
    return (OUTPUTS if output else INPUTS).get(name, "NOT_FOUND")


class Recipe(Value):
    """An RTDE recipe: the fields that are sent together in one data packet.

    Args:
        number: of the recipe, on this connection.
        names, types: of its fields, in their order.
    """

    number: int
    names: tuple[str, ...]
    types: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """Check whether the controller knows every field of this RTDE recipe."""
        return "NOT_FOUND" not in self.types

    @property
    def layout(self) -> struct.Struct:
        """Return the binary layout of a data packet's content."""
        return struct.Struct(">B" + "".join(FORMATS[t] for t in self.types))

    def pack(self, values: Mapping[str, Any]) -> bytes:
        """Pack values as a data packet's content; a field that has no value is zero."""
        flat: list[Any] = [self.number]
        for name, kind in zip(self.names, self.types, strict=True):
            flat += _flat(values.get(name), kind)
        return self.layout.pack(*flat)

    def unpack(self, content: bytes) -> dict[str, Any]:
        """Unpack the values of a data packet.

        Raises:
            struct.error: it has another size.
        """
        flat = iter(self.layout.unpack(content)[1:])
        values: dict[str, Any] = {}
        for name, kind in zip(self.names, self.types, strict=True):
            count = _count(kind)
            values[name] = next(flat) if count == 1 else [next(flat) for _ in range(count)]
        return values


def recipe(number: int, names: str, *, output: bool) -> Recipe:
    """Parse an RTDE recipe that a client sent: names of fields, separated by commas; a comma at the end is
    permitted."""
    wanted = tuple(n.strip() for n in names.split(",") if n.strip())
    return Recipe(number, wanted, tuple(type_of(n, output=output) for n in wanted))


def packet(kind: str, content: bytes) -> bytes:
    """Make an RTDE packet: the header, then the content."""
    return HEADER.pack(HEADER.size + len(content), ord(kind)) + content


def _count(kind: str) -> int:
    return int(FORMATS[kind][0]) if FORMATS[kind][0].isdigit() else 1


def _flat(value: Any, kind: str) -> Iterable[Any]:
    count = _count(kind)
    if count == 1:
        return [0 if value is None else value]
    return [0] * count if value is None else _sequence(value)


def _sequence(value: Sequence[Any]) -> list[Any]:
    return [float(v) if isinstance(v, float) else v for v in value]

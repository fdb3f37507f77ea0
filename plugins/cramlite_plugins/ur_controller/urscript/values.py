"""Values of URScript: literals, elements, fields and their text.

Booleans, integers (32 bits), floats and strings are Python's; lists are Python lists, poses the subclass ``PoseValue``,
structs ``StructValue``. All are values: assigning one copies it. Wrong operands raise ``ScriptError``.
"""

from __future__ import annotations

from typing import Any

from cramlite.model import Pose

LONGEST = 1023  # characters of a string (URScript manual, "Types")
LARGEST, DEEPEST = 10_000, 10  # elements of a list or struct and their nesting: far above real programs, so that none fills the memory


class ScriptError(Exception):
    """A run-time error of a program, with its reason; the line is added where the error is caught."""


class PoseValue(list[float]):
    """A pose in URScript, p[x, y, z, rx, ry, rz]: position [m] and rotation vector [rad]."""

    def __repr__(self) -> str:
        return "p" + super().__repr__()


class StructValue(dict[str, Any]):
    """A struct: its fields by name, in their order."""

    def __repr__(self) -> str:
        return "struct(" + ", ".join(f"{name} = {show(value)}" for name, value in self.items()) + ")"


def copied(value: Any) -> Any:
    """Copy a value for an assignment."""
    if isinstance(value, StructValue):
        sized(value)
        return StructValue((name, copied(v)) for name, v in value.items())
    return type(value)(copied(v) for v in value) if isinstance(value, list) else value


def sized(value: Any) -> int:
    """Count the elements of a value, including those of nested lists and structs, and check that they are not
    too many."""
    size = _size(value, 0)
    if size > LARGEST:
        raise ScriptError(f"a list or struct has more than {LARGEST} elements")
    return size


def _size(value: Any, depth: int) -> int:
    if not isinstance(value, StructValue | list):
        return 1
    if depth > DEEPEST:
        raise ScriptError(f"structs and lists are nested more than {DEEPEST} deep")
    parts = value.values() if isinstance(value, StructValue) else value
    return len(value) + sum(_size(v, depth + 1) - 1 for v in parts if isinstance(v, StructValue | list))


def struct_value(fields: dict[str, Any]) -> StructValue:
    """Make the value of a literal struct(...)."""
    sized(StructValue(fields))
    return StructValue((name, copied(v)) for name, v in fields.items())


def member(value: Any, name: str) -> Any:
    """Return value.name, a field of a struct."""
    return _struct(value, name)[name]


def set_member(value: Any, name: str, new: Any) -> None:
    """Set value.name = new; a struct keeps the fields that it was made with."""
    _struct(value, name)[name] = copied(new)


def _struct(value: Any, name: str) -> StructValue:
    if not isinstance(value, StructValue):
        raise ScriptError(f"only structs have fields such as '.{name}', not {show(value)}")
    if name not in value:
        raise ScriptError(f"a struct with the fields {', '.join(value) or 'none'} has no field '{name}'")
    return value


def list_value(*items: Any) -> list[Any]:
    """Make the value of a literal [...]: a list, or a list of lists (a matrix), and no deeper."""
    sized(list(items))
    return [_element(v) for v in items]


def _element(value: Any) -> Any:
    if isinstance(value, list) and any(isinstance(v, list) for v in value):
        raise ScriptError("lists may hold lists, but no deeper")
    return copied(value)


def item(value: Any, index: Any) -> Any:
    """Return value[index]; indices count from 0 and are never negative."""
    return value[_position(value, index)]


def set_item(value: Any, index: Any, new: Any) -> None:
    """Set value[index] = new."""
    place: Any = _position(value, index)
    value[place] = real(new, "a pose") if isinstance(value, PoseValue) else _element(new)


def _position(value: Any, index: Any) -> Any:
    """Check an index of a list or struct; return the index in a list, and the field's name in a struct."""
    if type(index) is int and isinstance(value, list) and 0 <= index < len(value):
        return index
    if not isinstance(value, list | StructValue):
        raise ScriptError(f"only lists, poses and structs have elements, not {show(value)}")
    if type(index) is not int or not 0 <= index < len(value):
        raise ScriptError(f"a list with {len(value)} elements has no index {show(index)}")
    return list(value)[index]


def pose_value(*numbers: Any) -> PoseValue:
    """Make the value of a literal p[...]."""
    return PoseValue(real(n, "a pose") for n in numbers)


def real(value: Any, where: str) -> float:
    """Check that a value is a finite number; the error says where one is needed."""
    if type(value) not in (int, float) or not abs(value) < 1e300:
        raise ScriptError(f"{where} needs a number, not {show(value)}")
    return float(value)


def as_pose(value: Any, where: str) -> Pose:
    """Convert a pose value to a ``Pose``."""
    if not isinstance(value, PoseValue):
        raise ScriptError(f"{where} needs a pose p[...], not {show(value)}")
    v = [real(n, where) for n in value]
    return Pose.from_rotvec(v[:3], v[3:])


def from_pose(pose: Pose) -> PoseValue:
    """Convert a ``Pose`` to a pose value."""
    return PoseValue((*pose.position, *pose.rotvec))


def numbers(value: Any, count: int, where: str) -> list[float]:
    """Check that a value is a list of exactly ``count`` numbers."""
    if not isinstance(value, list) or len(value) != count:
        raise ScriptError(f"{where} needs a list of {count} numbers, not {show(value)}")
    return [real(n, where) for n in value]


def truth(value: Any) -> bool:
    """Check that a value is a Boolean, as conditions need."""
    if type(value) is not bool:
        raise ScriptError(f"a condition needs True or False, not {show(value)}")
    return value


def whole(value: Any) -> Any:
    """Check that an integer fits into 32 bits."""
    if type(value) is int and not -(2**31) <= value < 2**31:
        raise ScriptError(f"the integer {value} does not fit into 32 bits")
    return value


def text(value: str) -> str:
    """Check that a string is not too long."""
    if len(value) > LONGEST:
        raise ScriptError(f"a string of {len(value)} characters; {LONGEST} is the longest")
    return value


def show(value: Any) -> str:
    """Format a value as textmsg and to_str print it."""
    if isinstance(value, bool) or value is None:
        return str(value)
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list):
        return ("p[" if isinstance(value, PoseValue) else "[") + ", ".join(map(show, value)) + "]"
    return str(value)[:LONGEST]

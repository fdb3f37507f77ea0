"""Values and arithmetic of URScript.

Booleans, integers (32 bits), floats and strings are Python's; lists are Python lists, poses the
subclass ``PoseValue``. Lists and poses are values: assigning one copies it. Wrong operands raise ``ScriptError``.
"""

from __future__ import annotations

from typing import Any

from cramlite.model import Pose

LONGEST = 1023  # characters of a string (URScript manual, "Types")


class ScriptError(Exception):
    """A run-time error of a program: a clause with its reason; the line is added where it is caught."""


class PoseValue(list[float]):
    """p[x, y, z, rx, ry, rz] [m, rotation vector in rad]."""

    def __repr__(self) -> str:
        return "p" + super().__repr__()


def copied(value: Any) -> Any:
    """Copy a value for an assignment."""
    return type(value)(copied(v) for v in value) if isinstance(value, list) else value


def list_value(*items: Any) -> list[Any]:
    """Make the value of a literal [...]: a list, or a list of lists (a matrix), and no deeper."""
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
    place = _position(value, index)
    value[place] = real(new, "a pose") if isinstance(value, PoseValue) else _element(new)


def _position(value: Any, index: Any) -> int:
    if not isinstance(value, list):
        raise ScriptError(f"only lists and poses have elements, not {show(value)}")
    if type(index) is not int or not 0 <= index < len(value):
        raise ScriptError(f"index {show(index)} of a list with {len(value)} elements")
    return index


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


def add(a: Any, b: Any) -> Any:
    """Return a + b."""
    return a + b if type(a) is float and type(b) is float else whole(_number(a, "+") + _number(b, "+"))


def subtract(a: Any, b: Any) -> Any:
    """Return a - b."""
    return a - b if type(a) is float and type(b) is float else whole(_number(a, "-") - _number(b, "-"))


def multiply(a: Any, b: Any) -> Any:
    """Return a * b."""
    return a * b if type(a) is float and type(b) is float else whole(_number(a, "*") * _number(b, "*"))


def divide(a: Any, b: Any) -> Any:
    """Return a / b."""
    if _number(b, "/") == 0:
        raise ScriptError("division by zero")
    return _number(a, "/") / b


def modulo(a: Any, b: Any) -> Any:
    """Return a % b."""
    if _number(b, "%") == 0:
        raise ScriptError("division by zero")
    return _number(a, "%") % b


def negative(a: Any) -> Any:
    """Return -a."""
    return whole(-_number(a, "-"))


def less(a: Any, b: Any) -> bool:
    """Check whether a < b."""
    return bool(_number(a, "<") < _number(b, "<"))


def greater(a: Any, b: Any) -> bool:
    """Check whether a > b."""
    return bool(_number(a, ">") > _number(b, ">"))


def _number(value: Any, operator: str) -> Any:
    if type(value) not in (int, float):
        raise ScriptError(f"'{operator}' needs numbers, not {show(value)}")
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

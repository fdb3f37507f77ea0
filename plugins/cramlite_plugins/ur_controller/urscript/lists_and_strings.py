"""URScript's functions on lists, matrices and strings.

Names, parameters and meanings: the URScript manual (Universal Robots, e-Series 5.x), chapter "Module urmath" and, for strings,
"Module internals". Wrong arguments raise ``ScriptError``.
"""

from __future__ import annotations

import math
from typing import Any

from .arithmetic import divide, matrix
from .values import LONGEST, ScriptError, real, show

BITS = 32


def get_list_length(v: Any) -> int:
    """Return the length of a list."""
    if not isinstance(v, list):
        raise ScriptError(f"get_list_length needs a list, not {show(v)}")
    return len(v)


def size(v: Any) -> Any:
    """Return the length of a list or a string; of a matrix its rows and columns."""
    if isinstance(v, str) or (isinstance(v, list) and not any(isinstance(row, list) for row in v)):
        return len(v)
    rows = matrix(v, "size")
    return [len(rows), len(rows[0])]


def normalize(v: Any) -> Any:
    """Return a list of numbers with the same direction and norm 1."""
    if not isinstance(v, list) or not (norm := math.hypot(*(real(n, "normalize") for n in v))):
        raise ScriptError(f"normalize needs a list of numbers that are not all 0, not {show(v)}")
    return divide(list(v), norm)


def transpose(m: Any) -> list[list[Any]]:
    """Return a matrix with rows and columns exchanged."""
    return [list(column) for column in zip(*matrix(m, "transpose"), strict=True)]


def integer_to_binary_list(x: Any) -> list[bool]:
    """Return the 32 bits of an integer, the lowest first."""
    if type(x) is not int:
        raise ScriptError(f"integer_to_binary_list needs an integer, not {show(x)}")
    return [bool(x >> i & 1) for i in range(BITS)]


def binary_list_to_integer(l: Any) -> int:  # noqa: E741 (the manual's name)
    """Convert a list of at most 32 bits, the lowest first, to an integer; the highest of 32 bits is the sign."""
    if not isinstance(l, list) or len(l) > BITS or any(type(bit) is not bool for bit in l):
        raise ScriptError(f"binary_list_to_integer needs a list of at most {BITS} truth values, not {show(l)}")
    value: int = sum(bit << i for i, bit in enumerate(l))
    return value - (1 << BITS) if len(l) == BITS and l[-1] else value


def str_len(str: Any) -> int:
    """Return the length of a string."""
    return len(_string(str, "str_len"))


def str_empty(str: Any) -> bool:
    """Check whether a string has no characters."""
    return not _string(str, "str_empty")


def str_at(src: Any, index: Any) -> str:
    """Return the character at an index, counted from 0."""
    return _string(src, "str_at")[_index(index, len(src) - 1, "str_at")]


def str_find(src: Any, target: Any, start_from: Any = 0) -> int:
    """Return the index of the first occurrence of a string in another one; -1 if there is none."""
    where = _string(src, "str_find")
    return where.find(_string(target, "str_find"), _index(start_from, len(where), "str_find"))


def str_sub(src: Any, index: Any, len: Any = None) -> str:
    """Return the part of a string from an index on: at most ``len`` characters, or all that follow if ``len``
    is None."""
    first = _index(index, str_len(src), "str_sub")
    return src[first:] if len is None else src[first : first + _index(len, LONGEST, "str_sub")]  # type: ignore[no-any-return]


def _string(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise ScriptError(f"{where} needs a string, not {show(value)}")
    return value


def _index(value: Any, last: int, where: str) -> int:
    if type(value) is not int or not 0 <= value <= last:
        raise ScriptError(f"{where}: {show(value)} is no whole number in 0 .. {last}")
    return value


LISTS_AND_STRINGS = {
    f.__name__: f
    for f in (
        get_list_length, size, normalize, transpose, integer_to_binary_list, binary_list_to_integer, str_len, str_empty,
        str_at, str_find, str_sub,
    )
}  # fmt: skip

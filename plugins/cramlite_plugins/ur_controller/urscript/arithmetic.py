"""Arithmetic of URScript: numbers, arrays (lists of numbers), matrices (lists of arrays) and strings.

Operators on arrays and matrices: the URScript manual (e-Series 5.x), "Matrix and Array Expressions". Wrong operands raise
``ScriptError``. Two floats, the most frequent case, are computed without a further call.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

from .values import PoseValue, ScriptError, show, text, whole

NUMBERS = (int, float)
MATRIX = 1_000  # elements of a matrix: a product of two takes their number to the power 3/2
Operation = Callable[[Any, Any], Any]


def add(a: Any, b: Any) -> Any:
    """Return a + b; strings are joined."""
    if type(a) is float and type(b) is float:
        return a + b
    if type(a) in NUMBERS and type(b) in NUMBERS:
        return whole(a + b)
    return text(a + b) if type(a) is type(b) is str else _spread(add, "+", a, b)


def subtract(a: Any, b: Any) -> Any:
    """Subtract b from a; with a list on either side, element by element."""
    if type(a) is float and type(b) is float:
        return a - b
    return whole(a - b) if type(a) in NUMBERS and type(b) in NUMBERS else _spread(subtract, "-", a, b)


def multiply(a: Any, b: Any) -> Any:
    """Return a * b: with a matrix on either side the matrix product, else element by element."""
    if type(a) is float and type(b) is float:
        return a * b
    if type(a) in NUMBERS and type(b) in NUMBERS:
        return whole(a * b)
    both = type(a) is type(b) is list
    return _product(a, b) if both and (_is_matrix(a) or _is_matrix(b)) else _spread(multiply, "*", a, b)


def divide(a: Any, b: Any) -> Any:
    """Return a / b."""
    if type(a) not in NUMBERS or type(b) not in NUMBERS:
        return _spread(divide, "/", a, b)
    if b == 0:
        raise ScriptError("division by zero")
    return a / b


def modulo(a: Any, b: Any) -> Any:
    """Return a % b."""
    if type(a) not in NUMBERS or type(b) not in NUMBERS:
        return _spread(modulo, "%", a, b)
    if b == 0:
        raise ScriptError("division by zero")
    return a % b


def negative(a: Any) -> Any:
    """Return -a."""
    return [negative(v) for v in a] if type(a) is list else whole(-_number(a, "-"))


def less(a: Any, b: Any) -> bool:
    """Check whether a < b."""
    if type(a) is float and type(b) is float:
        return a < b
    return bool(_number(a, "<") < _number(b, "<"))


def greater(a: Any, b: Any) -> bool:
    """Check whether a > b."""
    if type(a) is float and type(b) is float:
        return a > b
    return bool(_number(a, ">") > _number(b, ">"))


def matrix(value: Any, where: str) -> list[list[Any]]:
    """Check that a value is a matrix: rows of one length, of numbers."""
    rows = value if type(value) is list else []
    if not rows or not all(type(row) is list and row and len(row) == len(rows[0]) for row in rows):
        raise ScriptError(f"{where} needs a matrix [[...], [...]] with rows of one length, not {show(value)}")
    if len(rows) * len(rows[0]) > MATRIX:
        raise ScriptError(f"{where} takes matrices of up to {MATRIX} elements, not of {len(rows)} rows with {len(rows[0])}")
    return [[_number(v, where) for v in row] for row in rows]


def _is_matrix(value: list[Any]) -> bool:
    return any(type(v) is list for v in value)


def _spread(operation: Operation, sign: str, a: Any, b: Any) -> list[Any]:
    """Apply an operation to each element of a list, or each pair of elements."""
    if type(a) is type(b) is list:
        if len(a) != len(b):
            raise ScriptError(f"'{sign}' needs lists of one length, not of {len(a)} and {len(b)}")
        return [operation(v, w) for v, w in zip(a, b, strict=True)]
    if type(a) is list and _number(b, sign) is b:
        return [operation(v, b) for v in a]
    return [operation(_number(a, sign), v) for v in (b if type(b) is list else [_number(b, sign)])]


def _product(a: list[Any], b: list[Any]) -> list[Any]:
    """Multiply two matrices, or a matrix and an array: an array is a row if it is the first factor, a column
    if it is the second."""
    rows = matrix(a if _is_matrix(a) else [a], "'*'")
    columns = list(zip(*matrix(b if _is_matrix(b) else [[v] for v in b], "'*'"), strict=True))
    if len(rows[0]) != len(columns[0]):
        raise ScriptError(f"'*' needs as many columns on its left as rows on its right, not {len(rows[0])} and {len(columns[0])}")
    if len(rows) * len(columns) > MATRIX:
        raise ScriptError(f"'*' makes matrices of up to {MATRIX} elements, not of {len(rows)} rows with {len(columns)}")
    product = [[reduce(add, map(multiply, row, column)) for column in columns] for row in rows]
    if not _is_matrix(a):
        return product[0]
    return product if _is_matrix(b) else [row[0] for row in product]


def _number(value: Any, operator: str) -> Any:
    if type(value) in NUMBERS:
        return value
    hint = ": pose_add, pose_sub and pose_trans take poses" if isinstance(value, PoseValue) else ""
    hint = ": to_str makes a string of a number, str_cat joins any two values" if type(value) is str else hint
    raise ScriptError(f"'{operator}' needs numbers, not {show(value)}{hint}")

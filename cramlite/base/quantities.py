"""Physical quantities with units, as people write them in YAML: "50 mm", "20 deg", "0.3 kg", or plain SI numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "angle": {"rad": 1.0, "deg": math.pi / 180},
    "mass": {"kg": 1.0, "g": 0.001},
    "force": {"N": 1.0},
    "time": {"s": 1.0, "ms": 0.001},
}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\s\d]*)\s*")


def parse_quantity(value: Any, kind: str) -> float:
    """Convert a quantity, a number or text with a unit, to SI units.

    Args:
        value: a number (already SI) or text such as "50 mm".
        kind: "length", "angle", "mass", "force" or "time".

    Raises:
        ValueError: not a finite number, or a unit of another kind; says which units are right.
    """
    units = UNITS[kind]
    right = (
        f"a {kind} is a number in {next(iter(units))}, or text such as '{_EXAMPLES[kind]}' (units: {', '.join(units)})"
    )
    match = _NUMBER.fullmatch(str(value)) if not isinstance(value, bool) else None
    if match is None:
        raise ValueError(f"'{value}' is not {_A[kind]}: {right}")
    number, unit = float(match[1]), match[2]
    if unit and unit not in units:
        raise ValueError(f"'{unit}' is not a unit of {kind}: {right}")
    if not math.isfinite(number):
        raise ValueError(f"'{value}' is not finite: {right}")
    return number * units.get(unit, 1.0)


_A = {"length": "a length", "angle": "an angle", "mass": "a mass", "force": "a force", "time": "a time"}
_EXAMPLES = {"length": "50 mm", "angle": "20 deg", "mass": "0.3 kg", "force": "10 N", "time": "5 s"}


def _parser(kind: str) -> Callable[[Any], float]:
    return lambda value: parse_quantity(value, kind)


def _schema(kind: str) -> WithJsonSchema:
    """What an editor should accept: a number, or text with a unit of this kind."""
    units = "|".join(u for u in UNITS[kind])
    pattern = rf"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*({units})?\s*$"
    text = f"{_A[kind]}: a number in {next(iter(UNITS[kind]))}, or text such as '{_EXAMPLES[kind]}'"
    return WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string", "pattern": pattern}], "description": text})


Length = Annotated[float, BeforeValidator(_parser("length")), _schema("length")]
"""Length [m] as a pydantic field; text such as "50 mm" is converted."""
Angle = Annotated[float, BeforeValidator(_parser("angle")), _schema("angle")]
"""Angle [rad] as a pydantic field; text such as "20 deg" is converted."""
Mass = Annotated[float, BeforeValidator(_parser("mass")), _schema("mass")]
"""Mass [kg] as a pydantic field; text such as "300 g" is converted."""
Force = Annotated[float, BeforeValidator(_parser("force")), _schema("force")]
Time = Annotated[float, BeforeValidator(_parser("time")), _schema("time")]

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
MOST = {"length": 1e3, "angle": 1e3, "mass": 1e4, "force": 1e4, "time": 1e5, "speed": 1e3, "acceleration": 1e4}
"""Largest plausible magnitude of each kind of quantity, in SI units. A larger one is a typing error or a wrong unit, on which simulator
and planners would work for minutes before they fail. Ours: ten times and more what any arm here reaches, lifts or lasts."""
LONGEST = 40
"""Largest number of characters that a message quotes of a quantity as it was written."""
_ENDINGS = (
    ("_m_s2", "acceleration"), ("_rad_s2", "acceleration"), ("_m_s", "speed"), ("_rad_s", "speed"), ("_m", "length"),
    ("_rad", "angle"), ("_kg", "mass"), ("_n", "force"), ("_s", "time"),
)  # fmt: skip
"""Ending of a parameter's name -> kind of the quantity, longer endings first."""
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\s\d]*)\s*")


def parse_quantity(value: Any, kind: str) -> float:
    """Convert a quantity, a number or text with a unit, to SI units.

    Args:
        value: a number (already SI) or text such as "50 mm".
        kind: "length", "angle", "mass", "force" or "time".

    Raises:
        ValueError: not a finite number, a unit of another kind, or more than means anything; says what would be right.
    """
    units = UNITS[kind]
    said = str(value) if len(str(value)) <= LONGEST else f"{str(value)[:LONGEST]}..."
    right = (
        f"{_A[kind]} is a number in {next(iter(units))}, or text such as '{_EXAMPLES[kind]}' (units: {', '.join(units)})"
    )
    match = _NUMBER.fullmatch(str(value)) if not isinstance(value, bool) else None
    if match is None:
        raise ValueError(f"'{said}' is not {_A[kind]}: {right}")
    number, unit = float(match[1]), match[2]
    if unit and unit not in units:
        raise ValueError(f"'{unit}' is not a unit of {kind}: {right}")
    if not math.isfinite(number):
        raise ValueError(f"'{said}' is not finite: {right}")
    if beyond := beyond_reason(number * units.get(unit, 1.0), kind):
        raise ValueError(f"'{said}' is {beyond}")
    return number * units.get(unit, 1.0)


def beyond_reason(value: float, kind: str) -> str:
    """Say why a number in SI units is implausible; empty if it is plausible."""
    if abs(value) <= MOST[kind]:
        return ""
    return f"beyond reason: {_A[kind]} here is at most {MOST[kind]:g} {_SI[kind]}, so a unit or a power of ten is wrong"


def beyond_reason_by_name(name: str, value: float) -> str:
    """Say why a parameter's value is implausible; empty if it is plausible.

    The limit is that of the unit with which the name ends, such as "speed_m_s"; a name without a unit has no
    limit.
    """
    kind = next((kind for ending, kind in _ENDINGS if name.endswith(ending)), None)
    return beyond_reason(value, kind) if kind is not None else ""


_A = {"length": "a length", "angle": "an angle", "mass": "a mass", "force": "a force", "time": "a time", "speed": "a speed",
      "acceleration": "an acceleration"}  # fmt: skip
_SI = {**{kind: next(iter(units)) for kind, units in UNITS.items()}, "speed": "m/s or rad/s", "acceleration": "m/s2 or rad/s2"}
_EXAMPLES = {"length": "50 mm", "angle": "20 deg", "mass": "0.3 kg", "force": "10 N", "time": "5 s"}


def _parser(kind: str) -> Callable[[Any], float]:
    return lambda value: parse_quantity(value, kind)


def _schema(kind: str) -> WithJsonSchema:
    """Return the JSON Schema of a quantity, for editors: a number, or text with a unit of its kind."""
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

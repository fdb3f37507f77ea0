"""How values are written in URScript: fixed digits, so that the same program is the same text."""

from __future__ import annotations

from cramlite.geometry import Pose


def number(value: float) -> str:
    """A float with six digits, never "-0.000000"."""
    return f"{value + 0.0 if abs(value) >= 5e-7 else 0.0:.6f}"


def vector(values: tuple[float, ...]) -> str:
    """A URScript list."""
    return "[" + ", ".join(map(number, values)) + "]"


def pose(value: Pose) -> str:
    """A URScript pose p[x, y, z, rx, ry, rz]."""
    return "p" + vector((*value.position, *value.rotvec))


def plain(text: str) -> str:
    """Text for a comment: one line."""
    return " ".join(text.split())


def label(text: str) -> str:
    """Text for a string literal: no quotes, one line, short enough for URScript."""
    return plain(text).replace('"', "'")[:120]

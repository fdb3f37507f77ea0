"""How values are written in URScript: at most six digits, so that the same program is the same text."""

from __future__ import annotations

from collections.abc import Sequence

from cramlite.model import Pose


def number(value: float) -> str:
    """A float with at most six digits after the point and at least one, never "-0.0"."""
    short = f"{value if abs(value) >= 5e-7 else 0.0:.6f}".rstrip("0")
    return f"{short}0" if short.endswith(".") else short


def vector(values: Sequence[float]) -> str:
    """A list."""
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

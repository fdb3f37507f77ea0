"""URScript literals: numbers, lists, poses and strings; at most six digits, so that the same program
always gives the same text."""

from __future__ import annotations

from collections.abc import Sequence

from cramlite.model import Pose


def number(value: float) -> str:
    """Format a float with one to six digits after the point, never "-0.0"."""
    short = f"{value if abs(value) >= 5e-7 else 0.0:.6f}".rstrip("0")
    return f"{short}0" if short.endswith(".") else short


def vector(values: Sequence[float]) -> str:
    """Format numbers as a list."""
    return "[" + ", ".join(map(number, values)) + "]"


def pose(value: Pose) -> str:
    """Format a pose as p[x, y, z, rx, ry, rz] [m, rad]."""
    return "p" + vector((*value.position, *value.rotvec))


def plain(text: str) -> str:
    """Reduce a text to one line, for a comment."""
    return " ".join(text.split())


def label(text: str) -> str:
    """Reduce a text to a string literal: no quotes, one line, short enough for URScript."""
    return plain(text).replace('"', "'")[:120]

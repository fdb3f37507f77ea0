"""Extents of features: points in a cavity, or over an area of a surface."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cramlite.model import Floats, Vector3, vector3

from ..shapes.surfaces import SUNK

PEG, SURFACE, CAVITY = "vrps:Peg", "vrps:SurfaceFeature", "cram:Cavity"
REGIONS = (SURFACE, CAVITY)
"""Features that a goal may name as a place of their own."""


def in_cavity(point: Vector3, size: Mapping[str, float], over: float = 0.0, below: float = 0.0) -> bool:
    """Check whether a point is in a cavity, whose frame is in the middle of its opening, z out of it.

    Args:
        over: height above the opening up to which a point counts as inside [m].
        below: depth below the floor down to which it does [m].
    """
    if "height" not in size or not {"radius", "width"} & set(size):
        return False
    return not _beside(point, size) and -size["height"] - below <= point[2] <= over


def in_extent(type_: str, size: Mapping[str, float], point: Floats) -> bool:
    """Check whether a point, in the feature's frame, is in a cavity, or over a surface between its lowest and
    greatest height."""
    at = vector3(point)
    if type_ == CAVITY:
        return in_cavity(at, size)
    return not _beside(at, size) and size.get("lowest", -SUNK) <= at[2] <= size.get("height", math.inf)


def _beside(point: Vector3, size: Mapping[str, float]) -> bool:
    """Whether a point is beside an extent, seen along the extent's z axis."""
    x, y, _ = point
    wide, deep = (size.get(name, 0.0) / 2 for name in ("width", "depth"))
    return math.hypot(x, y) > size["radius"] if "radius" in size else abs(x) > wide or abs(y) > deep

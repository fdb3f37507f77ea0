"""Extents of features: points in a cavity, or over an area of a surface."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cramlite.model import Floats

from ..shapes.surfaces import SUNK

PEG, SURFACE, CAVITY = "vrps:Peg", "vrps:SurfaceFeature", "cram:Cavity"
REGIONS = (SURFACE, CAVITY)
"""Features that a goal may name as a place of their own."""


def in_cavity(point: tuple[float, float, float], size: Mapping[str, float]) -> bool:
    """Check whether a point is in a cavity, whose frame is in the middle of its opening, z out of it."""
    x, y, z = point
    if "height" not in size or not {"radius", "width"} & set(size):
        return False
    beside = math.hypot(x, y) > size["radius"] if "radius" in size else abs(x) > size["width"] / 2 or abs(y) > size["depth"] / 2
    return not beside and -size["height"] <= z <= 0.0


def in_extent(type_: str, size: Mapping[str, float], point: Floats) -> bool:
    """Check whether a point, in the feature's frame, is in a cavity, or over a surface between its lowest and
    greatest height."""
    x, y, z = map(float, point)
    if type_ == CAVITY:
        return in_cavity((x, y, z), size)
    wide, deep = (size.get(name, 0.0) / 2 for name in ("width", "depth"))
    beside = math.hypot(x, y) > size["radius"] if "radius" in size else abs(x) > wide or abs(y) > deep
    return not beside and size.get("lowest", -SUNK) <= z <= size.get("height", math.inf)

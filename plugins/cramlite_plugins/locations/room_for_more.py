"""Room for what else goes into a container: the first of several things is put into a corner, the last into the largest room that is left.

Each is put where the largest disc stays free beside it, which keeps room for the rest, whatever its shape.
"""

from __future__ import annotations

import math
from typing import Any

import shapely

from .free_area import Offset

ALIKE = 0.002  # radii of discs that are as good as one another [m]
TRIED = 32  # corners that are looked at, of a round opening evenly spaced ones


def roomiest(area: Any) -> Offset:
    """Return the middle of the largest disc in an area [m], or in its largest part."""
    largest = max(shapely.get_parts(area), key=lambda p: float(p.area))
    x, y = shapely.maximum_inscribed_circle(largest).coords[0]
    return x, y


def corner(area: Any, left: Any, sides: tuple[float, float], near: Offset) -> Offset:
    """Return where a rectangle, along the axes of an area or across them, leaves the largest disc free beside it; of places alike the
    nearest to a point.

    Args:
        area: convex, that it has to be in.
        left: what of that is free.
        sides: of the rectangle [m].
        near: x and y in the same frame [m].
    """
    x, y = sides
    found = [(*p, *turned) for turned in dict.fromkeys(((x, y), (y, x))) for p in _corners(area, turned)]
    boxes = {f: shapely.box(f[0] - f[2] / 2, f[1] - f[3] / 2, f[0] + f[2] / 2, f[1] + f[3] / 2) for f in found}
    discs = {f: _largest(left.difference(box)) for f, box in boxes.items() if box.intersection(left).area > 0.9 * box.area}
    if not discs:
        return roomiest(left)
    best = max(discs.values())
    return min((f[:2] for f in discs if discs[f] >= best - ALIKE), key=lambda p: (round(math.dist(p, near), 3), p))


def _corners(area: Any, sides: tuple[float, float]) -> list[Offset]:
    """Where the middle of a rectangle may be at most, so that its corners are in a convex area."""
    x, y = sides[0] / 2, sides[1] / 2
    moved = [shapely.affinity.translate(area, a * x, b * y) for a in (-1, 1) for b in (-1, 1)]
    points = shapely.get_coordinates(shapely.intersection_all(moved)).round(4).tolist()
    found = list(dict.fromkeys((float(a), float(b)) for a, b in points))
    return found[:: max(1, len(found) // TRIED)]


def _largest(area: Any) -> float:
    """Radius of the largest disc in an area [m]."""
    return max((float(shapely.maximum_inscribed_circle(p).length) for p in shapely.get_parts(area) if p.area > 0), default=0.0)

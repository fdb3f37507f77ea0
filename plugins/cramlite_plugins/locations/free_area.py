"""Free area of a surface or an opening, given the outlines of what stands there, and an endless stream of positions in it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import shapely
from scipy.stats import qmc

from cramlite.model import Floats

Offset = tuple[float, float]
"""x and y in the frame of a surface [m]."""
FIRST = 16
"""How many positions the first round has; each further one has twice as many."""
SMALL = 1e-6
"""Of parts of an area that are smaller only the middle is tried [m2]."""


def free_area(core: Any, obstacles: Iterable[Any], radius: float) -> Any:
    """Return where the middle of a disc may be, in a core of a surface and apart from obstacles.

    Args:
        core, obstacles: shapely areas [m].
        radius: of the largest disc in the outline of what is put there, so that any turn of it needs as much [m].
    """
    grown = [o.buffer(radius) for o in obstacles if not o.is_empty]
    return core.difference(shapely.union_all(grown)) if grown else core


def beside(area: Any, axis: Offset, least: float) -> Any:
    """Return the part of an area [m] whose points p have p . axis of at least ``least``."""
    along, far = np.asarray(axis, dtype=float), 100.0
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return area
    along = along / length
    across, start = np.array([-along[1], along[0]]), along * least / length
    half = [start + across * far, start - across * far, start - across * far + along * far, start + across * far + along * far]
    return area.intersection(shapely.Polygon(half))


def positions(area: Any, anchor: Offset) -> Iterator[Offset]:
    """Generate positions in an area without end: the one nearest to an anchor, the middles of its parts, then a Halton
    sequence (J. H. Halton, On the efficiency of certain quasi-random sequences, Numerische Mathematik 2, 1960), which leaves
    ever smaller gaps and comes nowhere twice; in rounds of doubling size, each from the anchor outwards.
    """
    if area.is_empty:
        return
    nearest = shapely.shortest_line(shapely.Point(anchor), area).coords[-1]
    middles = [shapely.maximum_inscribed_circle(p).coords[0] for p in shapely.get_parts(area) if p.area > 0]
    yield from dict.fromkeys([_rounded(nearest), *sorted(map(_rounded, middles), key=lambda p: (math.dist(p, anchor), p))])
    rounds = [_rounds(p) for p in shapely.get_parts(area) if p.area > SMALL]
    for parts in zip(*rounds, strict=True) if rounds else ():
        points = [_rounded(p) for part in parts for p in part.tolist()]
        yield from sorted(points, key=lambda p: (round(math.dist(p, anchor), 4), p))


def around(area: Any, middle: Offset, distance: float, to: Offset) -> Iterator[Offset]:
    """Generate the positions in an area that are at a distance from a point [m], in eight directions, the one to another point first."""
    first = math.atan2(to[1] - middle[1], to[0] - middle[0])
    for turn in (0, 1, -1, 2, -2, 3, -3, 4):
        angle = first + turn * math.pi / 4
        point = _rounded((middle[0] + distance * math.cos(angle), middle[1] + distance * math.sin(angle)))
        if area.covers(shapely.Point(point)):
            yield point


def _rounded(point: Iterable[float]) -> Offset:
    x, y = (round(float(v), 4) + 0.0 for v in point)
    return x, y


def _rounds(area: Any) -> Iterator[Floats]:
    """Points (n, 2) of a Halton sequence over the box around an area that are in it, round by round."""
    low, high = np.reshape(area.bounds, (2, 2))
    sequence = qmc.Halton(2, scramble=False)
    sequence.fast_forward(1)  # its first point is a corner
    for k in itertools.count():
        points = low + sequence.random(FIRST * 2 ** min(k, 10)) * (high - low)
        yield points[shapely.contains_xy(area, points)]

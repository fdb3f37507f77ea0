"""Resting place of a thing on a support that is not level: a bowl in a bowl, a mug within the rim of a plate.

Both are seen from above on a grid: the lower one's upper side, and the upper one's lower side. Let down
straight, the thing stops where the two first meet. Beside that place it may get lower, as a bowl slides into
the middle of another; it is put where it cannot, and stands on all that is then within ``SETTLES``.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import shapely

from cramlite.model import Floats, Pose, Thing

from .bounds import centre_of_mass, corners
from .cavities import heights
from .surfaces import Surface

STEP = 0.0015
"""Side of a cell of the height grids [m]."""
CELLS = 8
"""Largest horizontal shift, in grid cells, by which a thing may be put aside to rest lower on its support."""
LOWER = 1e-4
"""Least gain of height for which a thing is put farther aside [m]."""
SETTLES = 0.004
"""Gap at the first contact below which further parts of a thing come to touch its support as it settles [m]:
a bowl of 100 mm that meets another on one side leans over by 2 deg, until it does on the other. Bowls made of
boxes fit into one another no better."""
OVERTURNED = Pose.from_rotvec((0, 0, 0), (math.pi, 0, 0))


def nested(thing: Thing, pose: Pose, below: Thing, at: Pose) -> Surface | None:
    """Find the support on which a thing comes to rest when it is let down; None if it would pass beside it.

    Args:
        pose: of the thing in a frame whose z is up: its height does not matter.
        below: what is under it.
        at: its pose in the same frame.

    Returns:
        A level surface, as high as the thing's lowest point will be, under its centre of mass: the hull of
        where the two touch.
    """
    xs, ys, own, under = _seen(thing, pose, below, at)
    low = float(corners(thing, pose)[:, 2].min())
    i, j = _lowest(own, under)
    gap = _gap(own, under, i, j)
    rise = float(gap.max())
    if not math.isfinite(rise):
        return None
    x, y, _ = pose.apply(centre_of_mass(thing)).tolist()
    rows, columns = np.nonzero(gap > rise - SETTLES)
    touching: Floats = np.column_stack([xs[rows] - x, ys[columns] - y])
    there = Pose((x + (i - CELLS) * STEP, y + (j - CELLS) * STEP, low + rise))
    return Surface(there, shapely.MultiPoint(touching).convex_hull)


def touching(thing: Thing, pose: Pose, below: Thing, at: Pose) -> Any:
    """Return the hull of the contacts, or near contacts, of a thing with its support, seen from above.

    It is empty if the thing is beside the support.
    """
    xs, ys, own, under = _seen(thing, pose, below, at)
    gap = _gap(own, under, CELLS, CELLS)
    rise = float(gap.max())
    rows, columns = np.nonzero(gap > rise - SETTLES) if math.isfinite(rise) else ((), ())
    return (
        shapely.MultiPoint(np.column_stack([xs[rows], ys[columns]])).convex_hull
        if len(rows)
        else shapely.Point()
    )


def room_under(thing: Thing, pose: Pose, below: Thing, at: Pose) -> float:
    """Return how far a thing could be let down straight before it meets another one [m].

    The distance is negative if the two overlap, and inf if the thing would pass beside the other one.

    The arguments are those of ``nested``.
    """
    _, _, own, under = _seen(thing, pose, below, at)
    return -float(_gap(own, under, CELLS, CELLS).max())


def _seen(thing: Thing, pose: Pose, below: Thing, at: Pose) -> tuple[Floats, Floats, Floats, Floats]:
    """Heights on a grid of cells: the cells' centres (n,) and (m,), and the heights of a thing's lower side
    and of its support (n, m) [m]."""
    points = corners(thing, pose)
    (left, near, _), (right, far, _) = points.min(axis=0), points.max(axis=0)
    xs, ys = np.arange(left, right, STEP) + STEP / 2, np.arange(near, far, STEP) + STEP / 2
    return (
        xs,
        ys,
        heights(thing.geoms, OVERTURNED * pose, xs, -ys),
        heights(below.geoms, at, _wider(xs), _wider(ys)),
    )


def _wider(cells: Floats) -> Floats:
    found: Floats = cells[0] + STEP * np.arange(-CELLS, len(cells) + CELLS)
    return found


def _gap(own: Floats, under: Floats, i: int, j: int) -> Floats:
    """Return the height of the support above a thing's underside in each grid cell (n, m) [m], with the thing
    shifted by whole cells.

    The thing is not shifted for i = j = ``CELLS``.
    """
    gap: Floats = own + under[i : i + own.shape[0], j : j + own.shape[1]]
    return gap


def _lowest(own: Floats, under: Floats) -> tuple[int, int]:
    """Horizontal shift of a thing in grid cells at which it comes to lie lowest on the thing below it,
    found by descent from zero shift."""
    at = (CELLS, CELLS)
    rise = float(_gap(own, under, *at).max())
    while True:
        beside = [(at[0] + i, at[1] + j) for i, j in product((-1, 0, 1), repeat=2) if (i, j) != (0, 0)]
        found = [
            (float(_gap(own, under, *b).max()), b) for b in beside if min(b) >= 0 and max(b) <= 2 * CELLS
        ]
        lower = min((f for f in found if math.isfinite(f[0])), default=(math.inf, at))
        if lower[0] > rise - LOWER:
            return at
        rise, at = lower

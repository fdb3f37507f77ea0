"""Where a thing comes to rest on another that is not level: a bowl in a bowl, a mug within the rim of a plate.

Both are seen from above on a grid: the lower one's upper side, and the upper one's lower side. Let down straight, it stops where
the two first meet, and stands on all that is then within ``FLAT``.
"""

from __future__ import annotations

import math

import numpy as np
import shapely

from cramlite.model import Floats, Pose, Thing

from .bounds import centre_of_mass, corners
from .cavities import heights
from .surfaces import FLAT, Surface

STEP = 0.0015
"""Side of a cell [m]: less than ``FLAT``, so that the foot of a bowl is found on a slope of 45 deg."""
OVERTURNED = Pose.from_rotvec((0, 0, 0), (math.pi, 0, 0))


def nested(thing: Thing, pose: Pose, below: Thing, at: Pose) -> Surface | None:
    """Find what would carry a thing that is let down straight onto another; None where it would pass beside it.

    Args:
        pose: of the thing in a frame whose z is up: its height does not matter.
        below: what is under it.
        at: its pose in the same frame.

    Returns:
        A level surface, as high as the thing's lowest point will be, under its centre of mass: the hull of where the two touch.
    """
    points, under = corners(thing, pose), corners(below, at)
    low, high = (f(g(points[:, :2], axis=0), g(under[:, :2], axis=0)) for f, g in ((np.maximum, np.min), (np.minimum, np.max)))
    if (high - low < STEP).any():
        return None
    xs, ys = (np.arange(low[k] + STEP / 2, high[k], STEP) for k in (0, 1))
    gap = heights(below.geoms, at, xs, ys) + heights(thing.geoms, OVERTURNED * pose, xs, -ys)
    rise = float(gap.max())
    if not math.isfinite(rise):
        return None
    rows, columns = np.nonzero(gap > rise - FLAT)
    x, y, _ = pose.apply(centre_of_mass(thing)).tolist()
    touching: Floats = np.column_stack([xs[rows] - x, ys[columns] - y])
    return Surface(Pose((x, y, float(points[:, 2].min()) + rise)), shapely.MultiPoint(touching).convex_hull)

"""Cavities of things, found from their shape: the parts that would hold water, and the largest box in
each.

The thing is seen from above on a grid. Water is poured over it and runs off (priority flood: Barnes, Lehman,
Mulla, Computers and Geosciences 62, 2014); what stays is as deep as the lowest place of the rim around it.
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from cramlite.model import Feature, Floats, Geom, Pose, Thing

from .bounds import box_around
from .convex import hull_planes

CELLS = 72
"""Number of cells along the longer side of a height map."""
DEEP, WIDE = 0.01, 0.015
"""Least depth and width of a cavity [m]."""
ROUND = 32
"""Sides of a prism that stands for a cylinder."""


def cavity(thing: Thing, pose: Pose) -> Feature | None:
    """Find the largest cavity of a thing that opens upwards; None if it has none.

    Args:
        pose: of the thing in a frame whose z is up.

    Returns:
        A ``cram:Cavity``: its pose is at the rim, z up; width, depth and height [m] of a box that fits into
        it.
    """
    up = np.round(pose.inverse().rotate((0.0, 0.0, 1.0)), 6)
    frame = Pose.from_axes((0, 0, 0), up, (1.0, 0.0, 0.0) if abs(up[0]) < 0.9 else (0.0, 1.0, 0.0))
    turned = frame.inverse()
    low, high = box_around(g for g in _placed(thing.geoms, turned))
    step = max(float((high - low)[:2].max()) / CELLS, 0.001)
    xs, ys = (np.arange(low[k] + step / 2, high[k], step) for k in (0, 1))
    top = heights(thing.geoms, turned, xs, ys)
    pool = _largest_pool(top, step)
    if pool is None:
        return None
    level, floor, (i, j, m, n) = pool
    width, depth = (m - i) * step, (n - j) * step
    if min(width, depth) < WIDE:
        return None
    at = frame * Pose((float(xs[i] + xs[m - 1]) / 2, float(ys[j] + ys[n - 1]) / 2, level))
    size = {"width": round(width, 4), "depth": round(depth, 4), "height": round(level - floor, 4)}
    return Feature("cavity", "cram:Cavity", at, size)


def _placed(geoms: tuple[Geom, ...], turned: Pose) -> tuple[Geom, ...]:
    from msgspec.structs import replace

    return tuple(replace(g, pose=turned * g.pose) for g in geoms)


def heights(geoms: tuple[Geom, ...], turned: Pose, xs: Floats, ys: Floats) -> Floats:
    """Return the height of the highest point of geoms over each cell of a grid; slits of one or two cells are
    filled.

    Args:
        turned: pose of the geoms' thing in a frame whose z is up.
        xs, ys: middles of the cells in that frame, (n,) and (m,) [m].

    Returns:
        (n, m) [m]; -inf where there is nothing.
    """
    from scipy.ndimage import grey_closing

    x, y = np.meshgrid(xs, ys, indexing="ij")
    top = np.full(x.shape, -math.inf)
    for geom in geoms:
        planes = hull_planes(
            tuple(map(tuple, np.round((turned * geom.pose).apply(_points(geom)), 7).tolist()))
        )
        low, high = np.full(x.shape, -math.inf), np.full(x.shape, math.inf)
        for a, b, c, d in planes:
            rest = -(a * x + b * y + d)
            if abs(c) < 1e-9:
                high = np.where(rest < 0, -math.inf, high)
            elif c > 0:
                high = np.minimum(high, rest / c)
            else:
                low = np.maximum(low, rest / c)
        top = np.where((high >= low) & (high > top), high, top)
    bottom = float(top[np.isfinite(top)].min(initial=0.0)) - 1.0
    closed: Floats = grey_closing(np.where(np.isfinite(top), top, bottom), size=(3, 3), mode="nearest")
    return np.where(closed < bottom + 0.5, -math.inf, closed)


def _points(geom: Geom) -> Floats:
    """Points whose hull is the geom, or for round geoms a prism around it."""
    if geom.shape == "convex":
        return np.asarray(geom.corners)
    half = np.asarray(geom.half_extents)
    if geom.shape == "box":
        ends: Floats = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
        return ends
    turns = np.linspace(0.0, math.tau, ROUND, endpoint=False)
    ring = np.column_stack([np.cos(turns), np.sin(turns), np.ones(ROUND)])
    prism: Floats = np.vstack([ring, ring * (1, 1, -1)]) * half
    return prism


def _largest_pool(top: Floats, step: float) -> tuple[float, float, tuple[int, int, int, int]] | None:
    """Hollow of a height map that would hold the most water: its water level, floor height, and largest box
    as row and column ranges; None if there is no hollow."""
    from scipy.ndimage import label

    water = _flooded(top)
    there = np.isfinite(top)
    depth = np.where(there, water - np.where(there, top, 0.0), 0.0)
    pools, count = label(depth > DEEP)
    if not count:
        return None
    volumes = [float(depth[pools == k].sum()) for k in range(1, count + 1)]
    mask = pools == 1 + int(np.argmax(volumes))
    deepest = float(depth[mask].max())
    level = float(water[mask].max())
    return level, level - deepest, _largest_box(mask & (depth > 0.5 * deepest))


def _flooded(top: Floats) -> Floats:
    """Level of the water above each cell: the least height to which water must rise to run off over the
    edge of the grid."""
    level = np.full(top.shape, math.inf)
    rows, columns = top.shape
    edge = [
        (i, j) for i in range(rows) for j in range(columns) if i in (0, rows - 1) or j in (0, columns - 1)
    ]
    heap = [(float(top[c]), c) for c in edge]
    for height, cell in heap:
        level[cell] = height
    heapq.heapify(heap)
    while heap:
        height, (i, j) = heapq.heappop(heap)
        for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if 0 <= cell[0] < rows and 0 <= cell[1] < columns and math.isinf(level[cell]) and level[cell] > 0:
                level[cell] = max(height, float(top[cell]))
                heapq.heappush(heap, (float(level[cell]), cell))
    return level


def _largest_box(mask: Floats) -> tuple[int, int, int, int]:
    """The largest rectangle of cells that are all set, as row and column ranges (row, column, end row, end
    column), ends excluded."""
    best, area = (0, 0, 0, 0), 0
    heights = np.zeros(mask.shape[1], dtype=int)
    for i, row in enumerate(mask):
        heights = np.where(row, heights + 1, 0)
        for j in range(len(heights)):
            lowest = heights[j]
            for k in range(j, len(heights)):
                lowest = min(lowest, heights[k])
                if lowest == 0:
                    break
                if lowest * (k + 1 - j) > area:
                    best, area = (i + 1 - int(lowest), j, i + 1, k + 1), int(lowest) * (k + 1 - j)
    return best

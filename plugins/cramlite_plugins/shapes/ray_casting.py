"""Ray casting against a body of convex primitives: exact intervals of many lines and segments inside it at
once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache

import numpy as np

from cramlite.model import Floats, Geom, Pose, Value

from .segment_casting import SKIN, crosses, planes

Span = tuple[Floats, Floats]


class Body(Value):
    """Geoms with their bounding spheres, centres (n, 3) and radii (n,) [m], since most geoms are far from
    any ray."""

    geoms: tuple[Geom, ...]
    centres: Floats
    radii: Floats


def body(geoms: Iterable[Geom]) -> Body:
    """Compute the bounding spheres of geoms, for ray casting."""
    found = tuple(geoms)
    centres = np.array([g.pose.position for g in found]).reshape(-1, 3)
    return Body(found, centres, np.array([g.bounding_radius for g in found]) + SKIN)


def spans(body: Body, point: Floats, way: Floats) -> Iterator[tuple[float, float, Geom]]:
    """Compute where a line through a point, along a unit vector, enters and leaves each geom [m from the
    point]."""
    low, high = intervals(body, np.reshape(point, (1, 3)), np.reshape(way, (1, 3)))
    for k in np.flatnonzero(low[0] < high[0]).tolist():
        yield float(low[0, k]), float(high[0, k]), body.geoms[k]


def intervals(body: Body, points: Floats, ways: Floats) -> tuple[Floats, Floats]:
    """Compute where lines through points (n, 3) along unit vectors (n, 3) enter and leave each geom.

    Returns:
        Two arrays (n, geoms) [m from the points]; inf and -inf where a line misses a geom, or is in it for no
        more than ``SKIN``.
    """
    shape = len(points), len(body.geoms)
    low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
    off = body.centres - points[:, None, :]
    near = np.einsum("nij,nij->ni", off, off) - np.einsum("nij,nj->ni", off, ways) ** 2 <= body.radii**2
    for k in np.flatnonzero(near.any(axis=0)).tolist():
        rows, geom = np.flatnonzero(near[:, k]), body.geoms[k]
        back = inverse(geom.pose)
        one, two = _span(geom, back.apply(points[rows]), back.rotate(ways[rows]))
        met = two - one > SKIN
        low[rows[met], k], high[rows[met], k] = one[met], two[met]
    return low, high


def crossed(shape: Body, starts: Floats, ends: Floats) -> bool:
    """Check whether any segment between points (n, 3) passes through the body."""
    middle = (starts.min(axis=0) + starts.max(axis=0)) / 2
    reach = max(float(np.linalg.norm(p - middle, axis=1).max()) for p in (starts, ends))
    near = np.flatnonzero(np.linalg.norm(shape.centres - middle, axis=1) < reach + shape.radii)
    ways = ends - starts
    for k in near.tolist():
        off = shape.centres[k] - starts
        along = np.clip(np.einsum("ij,ij->i", off, ways) / np.einsum("ij,ij->i", ways, ways), 0.0, 1.0)
        meets = np.linalg.norm(off - along[:, None] * ways, axis=1) < shape.radii[k]
        if meets.any() and crosses(shape.geoms[k], starts[meets], ends[meets]):
            return True
    return False


@lru_cache(maxsize=256)
def inverse(pose: Pose) -> Pose:
    """Return the inverse of a pose."""
    return pose.inverse()


def _span(geom: Geom, p: Floats, d: Floats) -> Span:
    """Intervals of lines p + t d (n, 3) inside a geom, in its frame, as (t at entry, t at exit); (inf, -inf)
    for lines that miss it."""
    if geom.shape in ("box", "convex"):
        return _between(p, d, planes(geom))
    if geom.shape == "sphere":
        return _ball(p, d, geom.size[0])
    radius, half = geom.size
    ends = np.array([(0.0, 0.0, 1.0, -half), (0.0, 0.0, -1.0, -half)])
    tube, slab = _ball(p * (1, 1, 0), d * (1, 1, 0), radius), _between(p, d, ends)
    low, high = np.maximum(tube[0], slab[0]), np.minimum(tube[1], slab[1])
    low, high = np.where(low < high, low, np.inf), np.where(low < high, high, -np.inf)
    for z in (half, -half) if geom.shape == "capsule" else ():
        cap = _ball(p - (0, 0, z), d, radius)
        low, high = np.minimum(low, cap[0]), np.maximum(high, cap[1])
    return low, high


def _between(p: Floats, d: Floats, faces: Floats) -> Span:
    """Intervals of lines p + t d that are below all planes n x + o = 0, as (t at entry, t at exit)."""
    slope, height = d @ faces[:, :3].T, p @ faces[:, :3].T + faces[:, 3]
    level = np.abs(slope) < 1e-9
    at = -height / np.where(level, 1.0, slope)
    low = np.where(~level & (slope < 0), at, -np.inf).max(axis=1)
    high = np.where(~level & (slope > 0), at, np.inf).min(axis=1)
    missed = (low >= high) | (level & (height > 0)).any(axis=1)
    return np.where(missed, np.inf, low), np.where(missed, -np.inf, high)


def _ball(p: Floats, d: Floats, radius: float) -> Span:
    """Intervals of lines p + t d inside a sphere of a radius: the roots of |p + t d| = r."""
    a, b, c = (
        np.einsum("ij,ij->i", d, d),
        np.einsum("ij,ij->i", p, d),
        np.einsum("ij,ij->i", p, p) - radius * radius,
    )
    along, safe = a < 1e-9, np.where(a < 1e-9, 1.0, a)
    root = b * b - a * c
    met, way = np.where(along, c < 0, root > 0), np.sqrt(np.maximum(root, 0.0))
    low, high = np.where(along, -np.inf, (-b - way) / safe), np.where(along, np.inf, (-b + way) / safe)
    return np.where(met, low, np.inf), np.where(met, high, -np.inf)

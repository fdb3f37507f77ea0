"""Ray casting against a body of convex primitives: exact intervals of lines and segments inside it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from functools import lru_cache

import numpy as np

from cramlite.model import Floats, Geom, Pose, Value

from .convex import hull_planes
from .segment_casting import SKIN, crosses


class Body(Value):
    """Geoms with their bounding spheres: centres (n, 3) and radii (n,) [m]; most are far from any ray."""

    geoms: tuple[Geom, ...]
    centres: Floats
    radii: Floats


def body(geoms: Iterable[Geom]) -> Body:
    """Compute the bounding spheres of geoms, for ray casting."""
    found = tuple(geoms)
    centres = np.array([g.pose.position for g in found]).reshape(-1, 3)
    return Body(found, centres, np.array([g.bounding_radius for g in found]) + SKIN)


def spans(body: Body, point: Floats, way: Floats) -> Iterator[tuple[float, float, Geom]]:
    """Compute where a line (unit vector ``way``) enters and leaves each geom [m from the point]."""
    off = body.centres - point
    away = np.einsum("ij,ij->i", off, off) - (off @ way) ** 2
    for k in np.flatnonzero(away <= body.radii**2).tolist():
        geom = body.geoms[k]
        back = inverse(geom.pose)
        found = _span(geom, back.apply(point), back.rotate(way))
        if found is not None and found[1] - found[0] > SKIN:
            yield (*found, geom)


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


def _span(geom: Geom, p: Floats, d: Floats) -> tuple[float, float] | None:
    if geom.shape == "box":
        return _slabs(p, d, np.asarray(geom.size))
    if geom.shape == "sphere":
        return _ball(p, d, geom.size[0])
    if geom.shape == "convex":
        return _between(p, d, hull_planes(geom.corners))
    radius, half = geom.size
    tube = _meet(_ball(p * (1, 1, 0), d * (1, 1, 0), radius), _slabs(p[2:], d[2:], np.array([half])))
    caps = [_ball(p - (0, 0, z), d, radius) for z in (half, -half)] if geom.shape == "capsule" else []
    met = [s for s in (tube, *caps) if s is not None]
    return (min(s[0] for s in met), max(s[1] for s in met)) if met else None


def _between(p: Floats, d: Floats, planes: Floats) -> tuple[float, float] | None:
    """Where a line is inside all planes n x + o <= 0."""
    slope, height = planes[:, :3] @ d, planes[:, :3] @ p + planes[:, 3]
    out, into = slope > 1e-9, slope < -1e-9
    if (height[~out & ~into] > 0).any():
        return None
    low = float((-height[into] / slope[into]).max(initial=-np.inf))
    high = float((-height[out] / slope[out]).min(initial=np.inf))
    return (low, high) if low < high else None


def _slabs(p: Floats, d: Floats, half: Floats) -> tuple[float, float] | None:
    low, high = -np.inf, np.inf
    for x, v, h in zip(p, d, half, strict=True):
        if abs(v) < 1e-9:
            if abs(x) > h:
                return None
            continue
        one, two = sorted(((-h - x) / v, (h - x) / v))
        low, high = max(low, one), min(high, two)
    return (float(low), float(high)) if low < high else None


def _ball(p: Floats, d: Floats, radius: float) -> tuple[float, float] | None:
    """Roots of |p + t d| = r."""
    a, b, c = float(d @ d), float(p @ d), float(p @ p) - radius * radius
    if a < 1e-9:
        return (-np.inf, np.inf) if c < 0 else None
    root = b * b - a * c
    return ((-b - math.sqrt(root)) / a, (-b + math.sqrt(root)) / a) if root > 0 else None


def _meet(a: tuple[float, float] | None, b: tuple[float, float] | None) -> tuple[float, float] | None:
    if a is None or b is None or min(a[1], b[1]) <= max(a[0], b[0]):
        return None
    return max(a[0], b[0]), min(a[1], b[1])

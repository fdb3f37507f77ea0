"""How far primitives and things reach in a direction (support function), and the space that they take: boxes,
corners, volume.

The support function of a convex shape says how far it reaches in a direction, max over its points x of x .
way (Ericson: Real-Time Collision Detection, 2005, section 9.5); boxes around shapes follow from it. Radii and
half-lengths are those of ``cramlite.model.Geom``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from cramlite.model import Floats, Geom, Pose, Thing, Vector3, vector3

from .convex import hull_volume
from .itself import Itself

FLAT_FACED = frozenset({"box", "convex"})
"""Shapes of geoms with flat faces only: each is the convex hull of its corners."""

_CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
"""Corners of the box whose half side lengths are 1."""


def support(thing: Thing, pose: Pose, way: ArrayLike) -> float:
    """Largest coordinate of any point of a thing at a pose along a unit vector (3,) [m]: its support
    function, in the frame of the pose."""
    direction = np.asarray(way, dtype=float)
    points, round_ = _parts(Itself(thing.geoms))
    along = (
        [float((points @ (pose.rotation.T @ direction)).max() + np.asarray(pose.position) @ direction)]
        if len(points)
        else []
    )
    return max([*along, *(_support(geom, pose, direction) for geom in round_)])


@lru_cache(maxsize=256)
def _parts(geoms: Itself[tuple[Geom, ...]]) -> tuple[Floats, tuple[Geom, ...]]:
    """Corners (n, 3) of all boxes and hulls of a thing in its frame [m], and the thing's round shapes."""
    flat = [g for g in geoms.it if g.shape in FLAT_FACED]
    points = np.concatenate([_corners(g, Pose()) for g in flat]) if flat else np.zeros((0, 3))
    return points, tuple(g for g in geoms.it if g.shape not in FLAT_FACED)


def lowest(thing: Thing, pose: Pose) -> float:
    """Height of a thing's lowest point above its own origin [m], turned as in a pose whose parent frame's
    z is up."""
    return -support(thing, Pose((0.0, 0.0, 0.0), pose.quaternion), (0.0, 0.0, -1.0))


def height(thing: Thing, pose: Pose) -> float:
    """Height of a thing [m], from its lowest point to its highest, turned as in a pose whose parent
    frame's z is up."""
    return support(thing, pose, (0.0, 0.0, 1.0)) + support(thing, pose, (0.0, 0.0, -1.0))


def bounds(geom: Geom) -> tuple[Floats, Floats]:
    """Lowest and highest corner (3,) of the axis-aligned box around a primitive [m], in its thing's frame."""
    if geom.shape == "convex":
        points = geom.pose.apply(geom.corners)
        return points.min(axis=0), points.max(axis=0)
    half, middle = _reach(geom, geom.pose.rotation), np.asarray(geom.pose.position)
    return middle - half, middle + half


def box_around(geoms: Iterable[Geom]) -> tuple[Floats, Floats]:
    """Lowest and highest corner (3,) of the axis-aligned box around primitives [m], in their thing's frame.

    Raises:
        ValueError: there are none.
    """
    low, high = zip(*(bounds(g) for g in geoms), strict=True)
    return np.min(low, axis=0), np.max(high, axis=0)


def extents(geoms: Iterable[Geom]) -> Vector3:
    """Side lengths of the axis-aligned box around primitives [m], in their thing's frame.

    Raises:
        ValueError: there are none.
    """
    low, high = box_around(geoms)
    size = high - low
    return (float(size[0]), float(size[1]), float(size[2]))


def corners(thing: Thing, pose: Pose) -> Floats:
    """Points (n, 3) whose convex hull holds a thing at a pose [m]: corners of hulls and boxes, and of the
    boxes around round primitives along their own axes."""
    return np.concatenate([_corners(geom, pose) for geom in thing.geoms])


def near(thing: Thing, pose: Pose, area: tuple[float, float, float, float]) -> bool:
    """Check whether a thing's bounding ball about its origin is over, in or under a rectangle; if not, no
    point of the thing is.

    Args:
        pose: of the thing in the frame of the rectangle.
        area: lowest and highest x and y of the rectangle, as (x, y, x, y) [m].
    """
    (x, y, _), far = pose.position, radius(thing)
    return area[0] - far <= x <= area[2] + far and area[1] - far <= y <= area[3] + far


def radius(thing: Thing) -> float:
    """Radius of the smallest ball around a thing's origin that contains the thing [m]."""
    return _radius(Itself(thing.geoms))


@lru_cache(maxsize=512)
def _radius(geoms: Itself[tuple[Geom, ...]]) -> float:
    """Distance of the farthest corner of a body from its origin [m]."""
    return max(float(np.linalg.norm(_corners(geom, Pose()), axis=1).max()) for geom in geoms.it)


def volume(geom: Geom) -> float:
    """Volume of a primitive [m3]."""
    size = geom.size
    if geom.shape == "convex":
        return hull_volume(geom.corners)
    if geom.shape == "box":
        return 8 * size[0] * size[1] * size[2]
    ball = 4 / 3 * math.pi * size[0] ** 3
    if geom.shape == "sphere":
        return ball
    return 2 * math.pi * size[0] ** 2 * size[1] + (ball if geom.shape == "capsule" else 0.0)


def _support(geom: Geom, pose: Pose, way: Floats) -> float:
    """Support function of a primitive (not a hull) at a pose along a unit vector [m]."""
    there = pose * geom.pose
    return float(np.asarray(there.position) @ way + _reach(geom, there.rotation.T @ way))


def _reach(geom: Geom, ways: Floats) -> Floats:
    """Support function (...) of a primitive (not a hull) from its own origin, along unit vectors (..., 3)
    of its own frame [m]."""
    if geom.shape == "box":
        return np.asarray(np.abs(ways) @ np.asarray(geom.size))
    if geom.shape == "sphere":
        return np.full(ways.shape[:-1], geom.size[0])
    radius, half = geom.size
    across = 1.0 if geom.shape == "capsule" else np.hypot(ways[..., 0], ways[..., 1])
    return np.asarray(np.abs(ways[..., 2]) * half + radius * across)


def _corners(geom: Geom, pose: Pose) -> Floats:
    if geom.shape == "convex":
        return pose.apply(geom.pose.apply(geom.corners))
    return (pose * geom.pose).apply(_CORNERS * geom.half_extents)


def centre_of_mass(thing: Thing) -> Vector3:
    """Centre of mass in the thing's frame [m]: the stated one, else of the body's geoms with an even
    density."""
    if thing.inertia is not None:
        return thing.inertia.centre
    body = [g for g in thing.geoms if not g.part] or list(thing.geoms)
    volumes = np.array([volume(g) for g in body])
    return vector3(volumes @ np.array([g.pose.position for g in body]) / volumes.sum())

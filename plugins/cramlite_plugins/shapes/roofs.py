"""Roofs: parts of a thing over a surface of the same thing, which keep things from being put there from
above."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cramlite.model import Floats, Pose, Thing, Vector3

from . import ray_casting as rays
from .bounds import box_around, corners
from .surfaces import FLAT, Surface, surfaces

LEAST = 0.03  # of room between a surface and what is over it [m]: a slit holds nothing
COVERED = ((0.0, 0.0), (0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5))
"""Points of a cavity, as shares of its half sides, all of which must be under the roof of a covered cavity:
the handle of a basket is over the middle alone."""
UP = np.array([0.0, 0.0, 1.0])
AXES = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0))


def roofed(thing: Thing, pose: Pose, part: str = "") -> Iterator[tuple[Surface, float]]:
    """Find the surfaces of a thing that are under a part of itself, with the room over their middle [m].

    Args:
        pose: of the thing in a frame whose z is up.
        part: a feature: only its own surface.
    """
    for surface in surfaces(thing, pose, part):
        over = _first(thing, pose, np.asarray(surface.pose.position), UP)
        if LEAST < over < np.inf:
            yield surface, over


def has_a_roof(thing: Thing, pose: Pose) -> bool:
    """Check whether some surface of a thing, or of one of its regions, is under another part of the same
    thing.

    Args:
        pose: of the thing in a frame whose z is up.
    """
    parts = ("", *(f.name for f in thing.features if f.name)) if len(thing.geoms) > 1 else ()
    return any(any(True for _ in roofed(thing, pose, part)) for part in parts)


def has_own_roof(thing: Thing, pose: Pose, part: str = "") -> bool:
    """Check whether the whole cavity of a thing (the named one, else the first) is under parts of the thing,
    as the room under a shelf is.

    Args:
        pose: of the thing in a frame whose z is up.
    """
    cavity = next((f for f in thing.features if f.type == "cram:Cavity" and part in ("", f.name)), None)
    if cavity is None:
        return False
    half = [cavity.size.get("radius", cavity.size.get(name, 0.0) / 2) for name in ("width", "depth")]
    low = -cavity.size["height"] / 2
    points = (pose * cavity.pose).apply(np.array([(x * half[0], y * half[1], low) for x, y in COVERED]))
    return all(_first(thing, pose, point, UP) < np.inf for point in points)


def stands_under(thing: Thing, pose: Pose, other: Thing, at: Pose) -> bool:
    """Check whether a thing is inside the box around another thing, its middle and half of it under parts
    of that thing.

    Args:
        pose: of the thing in a frame whose z is up.
        at: of the other one.
    """
    points = corners(thing, pose)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    least, most = box_around(other.geoms)
    local = at.inverse().apply(middle)
    if not ((least <= local) & (local <= most)).all():
        return False
    covered = [_first(other, at, middle + half * (x, y, 0.0), UP) < np.inf for x, y in COVERED]
    return covered[0] and sum(covered[1:]) >= len(covered[1:]) / 2


def roof_over(thing: Thing, pose: Pose, point: Vector3) -> float:
    """Return the distance straight up from a point to the first shape of a thing [m]; inf if there is none.

    Args:
        pose: of the thing in a frame whose z is up.
    """
    return _first(thing, pose, np.asarray(point), UP)


def open_sides(thing: Thing, pose: Pose, surface: Surface, height: float) -> list[Floats]:
    """Return the level directions (3,) in which a ray from a point over a surface's middle meets no part of
    the thing.

    The point is at a height [m] over the surface. The direction to the nearest edge comes first.
    """
    middle = np.asarray(surface.pose.apply((0.0, 0.0, height)))
    ways = (surface.pose.rotate(axis) for axis in AXES)
    free = [way for way in ways if _first(thing, pose, middle, way) == np.inf]
    return sorted(free, key=lambda way: (round(_edge(surface, way), 3), -round(float(way @ -middle), 3)))


def _edge(surface: Surface, way: Floats) -> float:
    """Distance from the middle of a surface to the end of the box around its area, along one of its axes
    [m]."""
    low, high = np.reshape(surface.area.bounds, (2, 2))
    x, y = surface.pose.inverse().rotate(way)[:2].tolist()
    return float((abs(x), abs(y)) @ (high - low) / 2)


def _first(thing: Thing, pose: Pose, point: Floats, way: Floats) -> float:
    """Distance from a point along a unit vector to the first place where it meets a thing's shapes [m]; inf
    if it meets none."""
    back = pose.inverse()
    met = rays.spans(rays.body(thing.geoms), back.apply(point), back.rotate(way))
    return min((low for low, high, _ in met if low > FLAT or high > FLAT), default=np.inf)

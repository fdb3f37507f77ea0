"""A shape of a link that is the convex hull of circles, as MuJoCo collides a mesh."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Floats, Value, Vector3

SIDES = 12
"""Of the polygon about each circle: it sticks out of it by 3.5 % of the radius."""


class Circle(Value):
    """A circle across an axis of a link's body frame.

    Args:
        axis: "x", "y" or "z".
        centre: [m].
        radius: [m].
    """

    axis: str
    centre: Vector3
    radius: float


class Hull(Value):
    """A convex hull of circles, for what a cylinder does not follow."""

    circles: tuple[Circle, ...]
    rgba: str = "0.82 0.83 0.85 1"


def corners(hull: Hull) -> Floats:
    """Return the corners (n, 3) of polygons about the circles, in the link's body frame [m]."""
    return np.vstack([_polygon(c) for c in hull.circles])


def _polygon(circle: Circle) -> Floats:
    """The corners (SIDES, 3) of the regular polygon about a circle, two sides of it along each of the other axes."""
    one, other = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[circle.axis]
    turns, radius = (np.arange(SIDES) + 0.5) * math.tau / SIDES, circle.radius / math.cos(math.pi / SIDES)
    found = np.tile(np.asarray(circle.centre, dtype=float), (SIDES, 1))
    found[:, one] += radius * np.cos(turns)
    found[:, other] += radius * np.sin(turns)
    return found

"""Shape of a robot's link as the convex hull of circles; MuJoCo, too, replaces a link's mesh by its convex
hull in collision checks."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Floats, Value, Vector3

SIDES = 12
"""Default number of sides of the polygon around a circle: with 12 sides it sticks out by 3.5 % of the radius, with 24 by 0.9 %."""


class Circle(Value):
    """A circle in a plane perpendicular to an axis of a link's body frame.

    Args:
        axis: "x", "y" or "z".
        centre: [m].
        radius: [m].
        sides: of the polygon about it.
    """

    axis: str
    centre: Vector3
    radius: float
    sides: int = SIDES


class Hull(Value):
    """Convex hull of circles, for a robot link whose shape no cylinder matches."""

    circles: tuple[Circle, ...]
    rgba: str = "0.82 0.83 0.85 1"


def corners(hull: Hull) -> Floats:
    """Return the corners (n, 3) of the polygons around the circles of a hull, in the link's body frame [m]."""
    return np.vstack([_polygon(c) for c in hull.circles])


def _polygon(circle: Circle) -> Floats:
    """Corners (sides, 3) of the regular polygon around a circle, with sides parallel to both axes of the
    circle's plane."""
    one, other = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[circle.axis]
    turns, radius = (np.arange(circle.sides) + 0.5) * math.tau / circle.sides, circle.radius / math.cos(math.pi / circle.sides)
    found = np.tile(np.asarray(circle.centre, dtype=float), (circle.sides, 1))
    found[:, one] += radius * np.cos(turns)
    found[:, other] += radius * np.sin(turns)
    return found

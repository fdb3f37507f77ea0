"""Boxes around things: along the world's axes for each geom, along the thing's own for its sides."""

from __future__ import annotations

import math

import pytest

from cramlite.model import Geom, Pose, Thing
from cramlite.model.world.thing_boxes import boxes, extents

TURNED = Pose.from_rotvec((1.0, 2.0, 3.0), (0.0, 0.0, math.pi / 2))
GEOMS = (
    Geom("box", (0.1, 0.2, 0.3), Pose((0.05, 0.1, 0.15))),
    Geom("box", (0.1, 0.1, 0.1), Pose((0.25, 0.5, 0.95))),
)
ANGLE = Thing("angle", "shop:Thing", TURNED, GEOMS)


def test_sides_are_along_the_axes_of_the_thing() -> None:
    assert extents(ANGLE) == pytest.approx((0.4, 0.7, 1.2))


def test_corners_are_along_the_axes_of_the_world() -> None:
    (low, high), other = boxes(ANGLE)
    assert low == pytest.approx((0.7, 1.95, 2.85)) and high == pytest.approx((1.1, 2.15, 3.45))
    assert other[0] == pytest.approx((0.4, 2.15, 3.85)) and other[1] == pytest.approx((0.6, 2.35, 4.05))

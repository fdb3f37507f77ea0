"""Where things come to rest on what is not level."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.shapes.nesting import SETTLES, STEP, nested, room_under

RIM = 0.008
PLATE = Thing(
    "plate", "soma:Plate", Pose(), (
        Geom("box", (0.06, 0.06, 0.002), Pose((0, 0, 0.002))),
        *(Geom("box", (0.004, 0.06, 0.004), Pose((s * 0.064, 0, 0.004 + RIM / 2))) for s in (-1, 1)),
        *(Geom("box", (0.06, 0.004, 0.004), Pose((0, s * 0.064, 0.004 + RIM / 2))) for s in (-1, 1)),
    ), mass=0.2,
)  # fmt: skip
"""A floor of 120 mm, 4 mm high, and a rim that ends 12 mm above the origin."""


def block(half: float) -> Thing:
    return Thing("block", "cram:Product", Pose(), (Geom("box", (half, half, 0.03)),), mass=0.1)


@given(st.floats(0.01, 0.055), st.floats(-0.004, 0.004), st.floats(-math.pi / 2, math.pi / 2))
def test_what_fits_within_a_rim_stands_on_the_floor(half: float, off: float, yaw: float) -> None:
    turned = Pose.from_rotvec((off, 0, 1.0), (0, 0, yaw))
    within = (abs(math.cos(yaw)) + abs(math.sin(yaw))) * half + abs(off) < 0.06 - 2 * STEP
    found = nested(block(half), turned, PLATE, Pose())
    assert found is not None
    assert (abs(found.pose.position[2] - 0.004) < 1e-6) or not within
    if within:
        assert math.isclose(found.area.area, (2 * half) ** 2, rel_tol=0.25, abs_tol=1e-4)


def test_what_is_wider_stands_on_the_rim() -> None:
    found = nested(block(0.066), Pose(), PLATE, Pose())
    assert found is not None and math.isclose(found.pose.position[2], 0.004 + RIM, abs_tol=1e-6)
    assert found.area.bounds == pytest.approx((-0.066, -0.066, 0.066, 0.066), abs=2 * STEP)


def test_it_is_put_where_it_cannot_get_lower() -> None:
    """Between two slopes of 45 deg, 6 mm beside their middle."""
    slopes = tuple(Geom("box", (0.05, 0.05, 0.005), Pose.from_rotvec((s * 0.05, 0, 0.05), (0, -s * math.pi / 4, 0))) for s in (-1, 1))
    groove = Thing("groove", "cram:Product", Pose(), slopes)
    beside, middle = (nested(block(0.02), Pose((x, 0, 0)), groove, Pose()) for x in (0.006, 0.0))
    assert beside is not None and middle is not None
    assert abs(beside.pose.position[0]) < 2 * STEP
    assert abs(beside.pose.position[2] - middle.pose.position[2]) < SETTLES


def test_beside_it_nothing_carries() -> None:
    assert nested(block(0.02), Pose((0.2, 0, 0)), PLATE, Pose()) is None


@given(st.floats(-0.02, 0.02), st.floats(0.0, 0.1))
def test_room_under_a_thing_is_how_far_it_can_be_let_down(off: float, over: float) -> None:
    assert room_under(block(0.02), Pose((off, 0, 0.034 + over)), PLATE, Pose()) == pytest.approx(over, abs=1e-6)


def test_beside_it_there_is_room_without_end() -> None:
    assert room_under(block(0.02), Pose((0.2, 0, 0.5)), PLATE, Pose()) == math.inf

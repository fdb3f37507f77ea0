"""Cavities that are found in shapes."""

from __future__ import annotations

import math

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.shapes.cavities import CELLS, cavity

WALL = 0.006
SIDE = st.floats(0.06, 0.4)


def _vessel(width: float, depth: float, height: float, sides: int = 4) -> Thing:
    """A floor with walls around it; inner measures."""
    w, d, h, half = width / 2, depth / 2, height / 2, WALL / 2
    floor = Geom("box", (w + WALL, d + WALL, half), Pose((0, 0, -half)))
    walls = [Geom("box", (half, d + WALL, h), Pose((s * (w + half), 0, h))) for s in (1, -1)]
    walls += [Geom("box", (w, half, h), Pose((0, s * (d + half), h))) for s in (1, -1)]
    return Thing("it", "cram:Product", Pose(), (floor, *walls[:sides]), mass=0.1)


@examples(25)
@given(SIDE, SIDE, st.floats(0.02, 0.2), st.floats(-math.pi, math.pi))
def test_a_vessel_of_walls_has_the_cavity_between_them(width: float, depth: float, height: float, yaw: float) -> None:
    thing, turned = _vessel(width, depth, height), Pose.from_rotvec((1.0, 2.0, 3.0), (0, 0, yaw))
    found = cavity(thing, turned)
    assert found is not None
    step = max((max(width, depth) + 2 * WALL) / CELLS, 0.001)
    assert found.pose.position == pytest.approx((0, 0, height), abs=2 * step)
    assert found.size["height"] == pytest.approx(height, abs=1e-4)
    for name, inner in (("width", width), ("depth", depth)):
        assert inner - 4 * step <= found.size[name] <= inner + 2 * step


def test_a_vessel_without_one_wall_or_upside_down_holds_nothing() -> None:
    assert cavity(_vessel(0.1, 0.1, 0.05, sides=3), Pose()) is None
    assert cavity(_vessel(0.1, 0.1, 0.05), Pose.from_rotvec((0, 0, 0), (math.pi, 0, 0))) is None


def test_a_vessel_on_its_side_holds_nothing_and_a_low_rim_sets_the_level() -> None:
    assert cavity(_vessel(0.1, 0.1, 0.05), Pose.from_rotvec((0, 0, 0), (math.pi / 2, 0, 0))) is None
    high, low = _vessel(0.1, 0.1, 0.05), _vessel(0.1, 0.1, 0.02)
    found = cavity(Thing("it", "cram:Product", Pose(), (*high.geoms[:4], low.geoms[4]), mass=0.1), Pose())
    assert found is not None and found.size["height"] == pytest.approx(0.02, abs=1e-4)

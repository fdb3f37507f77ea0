"""What tips over about its lowest edge: onto which side, by which edge, and what stands there instead."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.shapes.bounds import corners
from cramlite_plugins.shapes.tipping_over import tipped_over

BOOK = Thing("book", "", Pose(), (Geom("box", (0.05, 0.012, 0.06), Pose((0.0, 0.0, 0.06))),))
BALL = Thing("ball", "", Pose(), (Geom("sphere", (0.05,)),))


def _leaning(degrees: float) -> Pose:
    """Towards -y."""
    return Pose.from_rotvec((0.3, 0.2, 0.1), (math.radians(degrees), 0.0, 0.0))


@pytest.mark.parametrize(("lean", "way"), [(30.0, -1.0), (60.0, -1.0), (-30.0, 1.0)])
def test_it_comes_to_lie_the_way_it_leans_and_its_edge_stays(lean: float, way: float) -> None:
    before = corners(BOOK, _leaning(lean))
    found = tipped_over(BOOK, _leaning(lean))
    assert found is not None
    after = corners(BOOK, found[0])
    assert np.ptp(after, axis=0) == pytest.approx((0.1, 0.12, 0.024), abs=1e-9)  # on its broad side
    assert after[:, 2].min() == pytest.approx(before[:, 2].min())
    edge = before[before[:, 2] < before[:, 2].min() + 1e-6][:, 1].mean()
    assert (way * (after[:, 1] - edge)).min() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("lean", [20.0, 55.0])
def test_how_far_its_middle_is_beyond_the_edge(lean: float) -> None:
    found, angle = tipped_over(BOOK, _leaning(lean)), math.radians(lean)
    assert found is not None
    assert found[1] == pytest.approx(0.06 * math.sin(angle) - 0.012 * math.cos(angle))


def test_what_leans_less_than_it_balances_falls_back_onto_its_foot() -> None:
    found = tipped_over(BOOK, _leaning(8.0))
    assert found is not None
    assert np.ptp(corners(BOOK, found[0]), axis=0)[2] == pytest.approx(0.12)


@pytest.mark.parametrize("thing", [BALL, BOOK])
def test_what_is_balanced_over_the_middle_of_what_is_lowest_tips_over_onto_none(thing: Thing) -> None:
    assert tipped_over(thing, Pose((0.0, 0.0, 0.2))) is None
    assert tipped_over(BOOK, _leaning(0.1)) is not None

"""A declared turn of a thing in the hand: its ends, its way, its parts."""

from __future__ import annotations

import math

import pytest

from cramlite.model import Pose, Swing

TURN = Swing(Pose((0.0, 0.05, 0.03)), Pose.from_rotvec((0.0, 0.01, 0.07), (1.0, 0.0, 0.0)), (0.0, -0.06, 0.0))


def test_it_leads_from_its_start_to_its_end() -> None:
    assert TURN.at(0.0).distance(TURN.start) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert TURN.at(1.0).distance(TURN.end) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_the_pivot_goes_straight_while_the_thing_turns_evenly() -> None:
    first, half, last = (TURN.at(share).apply(TURN.pivot) for share in (0.0, 0.5, 1.0))
    assert half == pytest.approx((first + last) / 2)
    assert math.hypot(*(TURN.start.inverse() * TURN.at(0.25)).rotvec) == pytest.approx(0.25)


def test_a_part_of_it_backwards_is_on_its_way() -> None:
    back = TURN.part(1.0, 0.5)
    assert back.start.distance(TURN.end) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert back.at(0.5).distance(TURN.at(0.75)) == pytest.approx((0.0, 0.0), abs=1e-6)

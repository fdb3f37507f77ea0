"""What turns in the hand: on its declared way and nowhere else, during its motion and at no other time."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite.model import Floats, Pose, Swing
from cramlite_plugins.validators.physics import SLIP
from cramlite_plugins.validators.swings import Turn, off

DOWN = Swing(Pose((0.0, 0.05, 0.03)), Pose.from_rotvec((0.0, 0.01, 0.07), (1.0, 0.0, 0.0)), (0.0, -0.06, 0.0))
UP = DOWN.part(1.0, 0.0)
FIRST = 7
"""The sample that the grip begins with; then 10 lying, 20 on which it swings down, 10 hanging, 20 back, and 10 lying."""
TURNS = [Turn(DOWN, FIRST + 10, FIRST + 29), Turn(UP, FIRST + 40, FIRST + 59)]
SHARES = np.concatenate([np.zeros(10), np.linspace(0, 1, 20), np.ones(10), np.linspace(1, 0, 20), np.zeros(10)])


def way(shares: Floats, swing: Swing = DOWN) -> Floats:
    return np.array([swing.at(share).position for share in shares])


def test_what_turns_as_declared_does_not_slip() -> None:
    assert off(way(SHARES), FIRST, TURNS).max() < 0.001


def test_without_the_declaration_it_slips() -> None:
    assert off(way(SHARES), FIRST, []).max() > 3 * SLIP
    assert off(way(SHARES), FIRST, TURNS[:1]).max() > 3 * SLIP  # declared to hang until it is let go


@pytest.mark.parametrize("when", [slice(0, 10), slice(30, 40), slice(60, 70)])
def test_it_may_not_turn_before_between_or_after(when: slice) -> None:
    shares = SHARES.copy()
    shares[when][5:] = 0.5
    assert off(way(shares), FIRST, TURNS).max() > SLIP


def test_what_does_not_turn_although_it_is_declared_slips() -> None:
    assert off(way(np.zeros(70)), FIRST, TURNS).max() > 3 * SLIP


@pytest.mark.parametrize("turn", [(-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, 0.0)])
def test_what_turns_otherwise_or_less_far_slips(turn: tuple[float, float, float]) -> None:
    other = Swing(DOWN.start, DOWN.start * Pose((0.0, -0.06, 0.0)) * Pose.from_rotvec((0.0, 0.06, 0.0), turn), DOWN.pivot)
    assert off(way(SHARES, other), FIRST, TURNS).max() > SLIP


def test_what_slides_out_sideways_while_it_turns_slips() -> None:
    slid = way(SHARES) + np.linspace(0.0, 0.02, 70)[:, None] * (1.0, 0.0, 0.0)
    assert off(slid, FIRST, TURNS).max() > SLIP


def test_a_grip_that_begins_amid_a_turn_is_on_its_way() -> None:
    assert off(way(SHARES)[15:], FIRST + 15, TURNS).max() < 0.001

"""What turns in the hand: on its declared way and nowhere else, during its motion and at no other time."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_runs import LINES, good
from msgspec.structs import replace

from cramlite.model import AnyStep, Floats, MoveLinear, Pose, Swing
from cramlite.plugin import Candidate
from cramlite_plugins.validators.physics import SLIP
from cramlite_plugins.validators.swings import Turn, declared, off

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


def test_a_turn_of_an_earlier_grip_counts_for_no_later_one() -> None:
    """The grip begins after the turn: it is held to where it began, and what turns then slips."""
    later = TURNS[0].last + 1
    assert off(way(np.zeros(9)), later, TURNS[:1]).max() == 0.0
    assert off(way(np.ones(9)), later, [Turn(DOWN, 0, later - 1), Turn(UP, later + 9, later + 20)]).max() == 0.0
    assert off(way(np.linspace(0, 1, 20)), later, TURNS[:1]).max() > 3 * SLIP
    assert off(way(SHARES), FIRST, [Turn(UP, 0, FIRST - 1), *TURNS]).max() < 0.001  # and its own count all the same


def test_a_turn_of_a_later_grip_counts_for_no_earlier_one() -> None:
    assert off(way(np.linspace(0, 1, 20)), 5, [Turn(DOWN, 25, 44)]).max() > 3 * SLIP
    assert off(way(np.zeros(20)), 5, [Turn(UP, 25, 44)]).max() == 0.0


def test_a_turn_that_touches_a_grip_with_one_sample_counts() -> None:
    """With its last sample, and then for what follows; with its first."""
    ended = way(np.ones(9))
    ended[0] = way(np.array([0.5]))[0]
    assert off(ended, 20, [Turn(DOWN, 1, 20)]).max() < 0.001
    begun = way(np.array([*np.zeros(8), 0.3]))
    assert off(begun, 20, [Turn(DOWN, 28, 40)]).max() < 0.001
    assert off(begun, 20, [Turn(DOWN, 29, 40)]).max() > SLIP


def test_it_is_held_to_where_it_was_at_first() -> None:
    moved = np.tile([0.0, 0.0, 0.02], (9, 1))
    moved[0] = 0.0
    assert off(moved, 5, []) == pytest.approx([0.0, *[0.02] * 8])


@pytest.mark.parametrize("by", [(0.0, 0.03, 0.0), (0.0, 0.0, 0.03), (0.03, 0.0, 0.0)])
def test_what_leaves_its_way_while_it_turns_slips_also_where_it_comes_back(by: tuple[float, float, float]) -> None:
    left = way(SHARES)
    left[12:28] += by
    assert off(left, FIRST, TURNS).max() > SLIP


def test_its_way_begins_where_the_turn_does() -> None:
    back = way(np.concatenate([np.zeros(10), np.linspace(0, -0.5, 10), np.linspace(-0.5, 1.0, 10), np.ones(10)]))
    assert off(back, FIRST, TURNS[:1]).max() > SLIP


def swinging(*swings: tuple[str, Swing]) -> Candidate:
    """The hand-written candidate, whose motions of some origins declare turns."""
    at, made = Pose((0.5, 0.2, 0.3)), good()
    steps: list[AnyStep] = [MoveLinear(at, 0.1, 0.5, (), origin=origin, swing=swing) for origin, swing in swings]
    return replace(made, program=replace(made.program, steps=(MoveLinear(at, 0.1, 0.5, (), origin="1.Grasping/close"), *steps)))


def test_declared_are_the_turns_of_motions_that_ran_in_the_order_in_which_they_did() -> None:
    first, second, third = DOWN.part(0.0, 0.4), replace(DOWN.part(0.4, 1.0), pivot=(0.0, 0.0, 1.0)), UP
    made = swinging(
        ("3.Placing/PuttingDown/lower", third), ("2.PickingUp/lift", first), ("2.PickingUp/lift", second), ("9.Never/ran", UP)
    )
    ran = {line: np.flatnonzero(line == LINES) for line in (3, 5)}
    lifted, lowered = declared(made)
    assert lifted == Turn(Swing(first.start, second.end, first.pivot), int(ran[3][0]), int(ran[3][-1]))
    assert lowered == Turn(Swing(UP.start, UP.end, UP.pivot), int(ran[5][0]), int(ran[5][-1]))


def test_a_program_without_turns_declares_none() -> None:
    assert declared(swinging()) == []

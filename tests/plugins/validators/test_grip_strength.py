"""A grip that is too weak for what it lost: which force was commanded, which would do, and what counts as lost."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.short_runs import (
    COUNT,
    LEFT,
    OPENED,
    RIGHT,
    STEP,
    TAKEN,
    WEIGHT,
    candidate,
    good,
    only,
    said,
    shifted,
    track,
)
from msgspec.structs import replace

from cramlite.model import Pose, SetGripper, pair_friction
from cramlite.plugin import Candidate
from cramlite_plugins.motions.grip_force import GripLoad
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.validators.grip_strength import GripStrength, explained
from cramlite_plugins.validators.grips import OPENED as WIDER
from cramlite_plugins.validators.physics import SLIP

JUST = WEIGHT / (2 * pair_friction(0.9, 0.6))  # that carries the block [N]
VALIDATOR = GripStrength()


def closing(of: Candidate, **forces: float) -> Candidate:
    """The candidate whose program closes the fingers with forces [N], by the step that it does so in."""
    origins = {"close": "1.Grasping/close", "lift": "2.PickingUp/lift"}
    steps = tuple(SetGripper(0.0, 0.05, force, origin=origins[name]) for name, force in forces.items())
    return replace(of, program=replace(of.program, steps=steps))


def slipping(by: float = SLIP + 0.001) -> Candidate:
    return shifted((0, 0, -by), "block", 40, OPENED)


def lost(narrower: float, after: float) -> Candidate:
    """The candidate whose fingers close further, some time after the pads last pressed [s]."""
    base = good().rollout
    assert base is not None
    opening, first = base.opening.copy(), OPENED - 1 + round(after / STEP)
    opening[OPENED - 1 :] = 0.06
    opening[first : first + 3] -= narrower
    return good(opening=opening)


def test_what_slipped_from_a_grip_that_was_too_weak_is_an_objection_with_numbers() -> None:
    found = only(VALIDATOR, closing(slipping(), close=JUST - 0.01))
    assert not found.passed and found.things and found.origin == "1.Grasping/close" and found.unit == "N"
    assert found.value == pytest.approx(WEIGHT - 0.01 * 2 * 0.72) and found.limit == pytest.approx(WEIGHT)
    assert "'block' slipped" in found.reason


def test_a_grip_that_carries_the_weight_is_not_to_blame() -> None:
    assert said(VALIDATOR, closing(slipping(), close=JUST)) == []


@pytest.mark.parametrize(("by", "objects"), [(SLIP * 0.99, False), (SLIP * 1.01, True)])
def test_what_moves_in_the_hand_by_more_than_the_limit_slipped(by: float, objects: bool) -> None:
    assert bool(said(VALIDATOR, closing(slipping(by), close=1.0))) is objects


@pytest.mark.parametrize(("narrower", "after", "objects"), [
    (WIDER * 1.05, 0.5, True), (WIDER * 0.95, 0.5, False), (WIDER * 1.05, 0.5 + STEP, False), (WIDER * 1.05, STEP, True),
])  # fmt: skip
def test_fingers_that_close_further_soon_after_lost_what_was_between_them(narrower: float, after: float, objects: bool) -> None:
    assert bool(said(VALIDATOR, closing(lost(narrower, after), close=1.0))) is objects


@pytest.mark.parametrize(("by", "objects"), [(0.0, False), (1e-5, True), (-1e-5, False)])
def test_what_the_fingers_close_further_than_is_the_middle_of_how_wide_they_held(by: float, objects: bool) -> None:
    base = good().rollout
    assert base is not None
    opening = base.opening.copy()
    opening[TAKEN:OPENED] = np.linspace(0.060, 0.066, OPENED - TAKEN)
    opening[OPENED:] = 0.085
    opening[OPENED + 2] = float(np.median(opening[TAKEN:OPENED])) - WIDER - by
    assert bool(said(VALIDATOR, closing(good(opening=opening), close=1.0))) is objects


def test_a_thing_that_moved_in_the_hand_by_the_limit_did_not_slip() -> None:
    base = good().rollout
    assert base is not None
    still = track((0, (0.0, 0.0, 0.0)))
    moved = still.copy()
    moved[40:OPENED, 2] = -SLIP
    assert said(VALIDATOR, closing(good(poses={**base.poses, "effector": still, "block": moved}), close=1.0)) == []


def test_fingers_that_were_wider_for_a_moment_while_they_held_lost_nothing() -> None:
    base = good().rollout
    assert base is not None
    opening = base.opening.copy()
    opening[TAKEN : TAKEN + 5] = 0.064
    opening[OPENED - 1 :] = 0.06
    assert said(VALIDATOR, closing(good(opening=opening), close=1.0)) == []


def test_the_last_step_that_moved_the_fingers_before_the_grip_counts() -> None:
    base = slipping().rollout
    assert base is not None
    lines = base.lines.copy()
    lines[TAKEN - 3 : OPENED - 5] = 3
    other = candidate(replace(base, lines=lines))
    assert said(VALIDATOR, closing(other, close=10.0, lift=1.0)) != [] and said(VALIDATOR, closing(other, close=1.0, lift=10.0)) == []
    lines[TAKEN - 3 : TAKEN + 1] = 1
    lines[TAKEN + 1 :] = 3  # the fingers move again once they hold
    assert said(VALIDATOR, closing(candidate(replace(base, lines=lines)), close=10.0, lift=1.0)) == []
    assert said(VALIDATOR, closing(candidate(replace(base, lines=np.zeros(COUNT))), close=1.0)) == []
    lines[:] = np.where(np.arange(COUNT) == TAKEN - 1, 1, 3)  # a step of one sample
    assert said(VALIDATOR, closing(candidate(replace(base, lines=lines)), close=1.0)) != []


def test_only_steps_that_move_the_fingers_count_and_each_grip_is_asked() -> None:
    assert said(VALIDATOR, closing(slipping(), lift=1.0)) == []
    base = slipping().rollout
    assert base is not None
    rows = tuple(tuple(t for t in row if not (k < 20 and {LEFT, RIGHT} & {t.a, t.b})) for k, row in enumerate(base.touches))
    opening = base.opening.copy()
    opening[18:20] = 0.085
    early = tuple(tuple(replace(t, b="cup") if t.a == LEFT else replace(t, a="cup") if t.b == RIGHT else t for t in base.touches[12])
                  if 10 <= k < 16 else row for k, row in enumerate(rows))  # fmt: skip
    two = candidate(replace(base, touches=early, opening=opening))
    assert len(said(VALIDATOR, closing(two, close=1.0))) == 1  # the cup was not lost, the block was


def test_the_force_that_would_do_is_said_with_its_margin() -> None:
    grip = GripLoad(block("block", Pose(), mass=0.5), 0.5, 0.9, 0.6, 0.0, UR5E.gripper)
    assert explained(grip, 2.0) == (
        "2 N on each pad carry 2.9 N of 0.5 kg (4.9 N) on friction 0.72 (pads 0.9, 'block' 0.6); 3 N just carry it, 10 N with a margin"
        " of 2.5 and 1.2 m/s2 of the arm (gripper 'robotiq_2f85': 20 .. 235 N)"
    )
    assert explained(replace(grip, surface=0.0), 2.0).endswith("; no force does")
    assert math.isinf(replace(grip, surface=0.0).least)

"""What the hand takes along: of a thing's way what points where the hand leads it, while the two touch, and no more than the hand went."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from helpers.short_runs import COUNT, LEFT, OPENED, STEP, TAKEN, good, posed, said, shifted, track
from msgspec.structs import replace

from cramlite.model import Floats, JudgingLimits, Pose, Rollout, Touch
from cramlite.plugin import Allowance, Candidate
from cramlite_plugins.validators.carries import Carry, carries
from cramlite_plugins.validators.explained import EARLY
from cramlite_plugins.validators.slides import GAP
from cramlite_plugins.validators.tracks import SLIDES, Tracks

ALL = range(COUNT)


def way(*knots: tuple[int, float, float]) -> Floats:
    """(COUNT, 7) poses: sample, x and height between them [m]."""
    return track(*((k, (x, 0.0, z)) for k, x, z in knots))


def run(thing: Floats, hand: Floats, touches: Iterable[int], touch: Touch | None = None) -> Rollout:
    """A run in which the cup and the hand go their ways, and touch at some samples; nothing else touches anything."""
    made, rows = posed(cup=thing, effector=hand).rollout, set(touches)
    assert made is not None
    contact = (touch or Touch(LEFT, "cup", 1.0, 0.0), Touch("cup", "shelf", 1.0, 0.0))
    return replace(made, touches=tuple(contact if k in rows else contact[1:] for k in ALL))


def found(rollout: Rollout, within: range = ALL) -> list[Carry]:
    return list(carries(rollout, "cup", within))


LEAD = way((20, 0.0, 0.0), (40, 0.2, 0.0))


def test_a_carry_is_from_the_first_touch_to_the_farthest_point() -> None:
    there_and_back = way((20, 0.0, 0.0), (30, 0.1, 0.0), (40, 0.02, 0.0))
    assert found(run(there_and_back, there_and_back, range(22, 41))) == [Carry(pytest.approx(0.08), 22, 30)]
    assert found(run(there_and_back, there_and_back, ())) == []
    assert found(run(there_and_back, there_and_back, (25,))) == [Carry(0.0, 25, 25)]


@pytest.mark.parametrize("touch", [Touch("cup", "effector/right", 1.0, 0.0), Touch("effector/body", "cup/wall", 1.0, 0.0)])
def test_any_part_of_the_hand_takes_along(touch: Touch) -> None:
    assert found(run(LEAD, LEAD, range(20, 41), touch)) == [Carry(pytest.approx(0.2), 20, 40)]


@pytest.mark.parametrize("touch", [Touch("cup", "block", 1.0, 0.0), Touch("effector/left", "block", 1.0, 0.0)])
def test_what_others_touch_is_not_taken_along(touch: Touch) -> None:
    assert found(run(LEAD, LEAD, range(20, 41), touch)) == []


def test_only_some_samples_count() -> None:
    assert found(run(LEAD, LEAD, ALL), range(25, 31)) == [Carry(pytest.approx(0.05), 25, 30)]


def test_a_hand_at_rest_takes_nothing_along() -> None:
    assert found(run(LEAD, way((0, 0.0, 0.0)), range(20, 41)))[0].way == pytest.approx(0.0)
    assert found(run(way((0, 0.0, 0.0)), LEAD, range(20, 41)))[0].way == pytest.approx(0.0)


def test_no_more_is_taken_along_than_the_hand_went() -> None:
    falls, sinks = way((20, 0.0, 0.2), (30, 0.0, 0.0)), way((20, 0.0, 0.2), (30, 0.0, 0.19))
    assert found(run(falls, sinks, range(20, 31))) == [Carry(pytest.approx(0.01), 20, 30)]


def test_only_what_points_where_the_hand_leads_counts() -> None:
    up, aside = way((20, 0.0, 0.0), (40, 0.0, 0.1)), way((20, 0.0, 0.0), (40, 0.1, 0.0))
    assert found(run(aside, up, range(20, 41)))[0].way == pytest.approx(0.0)
    both = way((20, 0.0, 0.0), (40, 0.1, 0.1))
    assert found(run(aside, both, range(20, 41)))[0].way == pytest.approx(0.1 / np.sqrt(2))
    away = way((20, 0.0, 0.0), (40, -0.1, 0.0))
    assert found(run(aside, away, range(20, 41)))[0].way <= 0.0


def test_a_thing_that_the_hand_turns_is_taken_along_at_its_corners() -> None:
    turned = way((0, 0.0, 0.0))
    for k in range(COUNT):
        angle = float(np.interp(k, [20, 40], [0.0, 0.5]))
        turned[k, 3:] = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, angle)).quaternion
    corner = 2 * np.sin(0.25) * 0.03 * np.sqrt(2)
    (one,) = found(run(turned, turned, range(20, 41)))
    assert one == Carry(pytest.approx(corner), 20, 40)
    assert found(run(turned, way((0, 0.0, 0.0)), range(20, 41)))[0].way == pytest.approx(0.0)


@pytest.mark.parametrize(("pause", "count"), [(round(GAP / STEP) - 1, 1), (round(GAP / STEP) + 2, 2)])
def test_a_touch_that_is_lost_for_long_is_another_one(pause: int, count: int) -> None:
    ways = found(run(LEAD, LEAD, [*range(20, 30), *range(29 + pause, 41)]))
    assert [c.first for c in ways] == ([20] if count == 1 else [20, 29 + pause])
    assert [c.last for c in ways] == ([40] if count == 1 else [29, 40])


# Validator


def taken_along(by: float, first: int, last: int, *, hand_too: bool = True) -> Candidate:
    """The candidate, whose block goes aside between two samples, the hand with it, which is where it is and touches it all the while."""
    made = good().rollout
    assert made is not None
    aside = np.interp(ALL, [first, last], [0.0, by])
    poses = {name: made.poses["block"].copy() for name in ("block", "effector")}
    poses["block"][:, 0] += aside
    if hand_too:
        poses["effector"][:, 0] += aside
    touch = Touch(LEFT, "block", 5.0, 0.0)
    rows = tuple((*row, touch) if first <= k <= last and not TAKEN <= k < OPENED else row for k, row in enumerate(made.touches))
    return good(poses={**made.poses, **poses}, touches=rows)


def objections(of: Candidate) -> list[str]:
    return [why for why in said(Tracks(), of) if "taken along" in why]


@pytest.mark.parametrize(("limit", "passes"), [(0.0201, True), (0.0199, False)])
def test_what_was_let_go_is_not_taken_along(limit: float, passes: bool) -> None:
    made = replace(taken_along(0.02, OPENED - 1, OPENED + 4), limits=JudgingLimits(bystander_motion=limit))
    assert (objections(made) == []) is passes
    if not passes:
        (one,) = (f for f in Tracks().check(made) if not f.passed)
        assert one.reason == "'block' was taken along by the hand by 20 mm from 3.5 to 3.7 s, after its release, limit 19.9 mm"
        assert one.value == pytest.approx(0.02) and (one.limit, one.unit, one.things) == (limit, "m", True)
        assert one.origin == "3.Placing/Releasing"


def test_what_is_taken_along_to_the_end_is_measured_there() -> None:
    (one,) = (f for f in Tracks().check(taken_along(0.5, OPENED - 1, COUNT - 1)) if "taken along" in f.reason)
    assert one.value == pytest.approx(0.5)


def test_what_is_held_may_jump() -> None:
    """The finger that closes on it touches it before both do."""
    made = taken_along(0.03, TAKEN, TAKEN + 1).rollout
    assert made is not None
    touch = Touch(LEFT, "block", 5.0, 0.0)
    rows = tuple((*row, touch) if k in (TAKEN - 1, TAKEN, TAKEN + 1) else row for k, row in enumerate(made.touches))
    assert objections(good(poses=made.poses, touches=rows)) == []


def test_what_rolls_away_from_open_fingers_is_not_taken_along() -> None:
    assert objections(taken_along(0.1, OPENED - 1, 80, hand_too=False)) == []


def test_what_rests_after_its_release_is_left_to_the_validator_of_bystanders() -> None:
    assert objections(taken_along(0.1, OPENED + 10, 95)) == []


def test_who_moves_a_thing_may_take_it_along() -> None:
    made = taken_along(0.1, OPENED - 1, OPENED + 4)
    for task, free in (("3.Placing/Releasing", True), ("4.ParkingArms", False)):
        allowed = {**made.allowances, task: Allowance(moves=frozenset({"block"}))}
        assert (objections(replace(made, allowances=allowed)) == []) is free


def test_what_is_to_be_held_is_taken_along_by_as_much_as_fingers_centre() -> None:
    for by, passes in ((SLIDES - 0.001, True), (SLIDES + 0.001, False)):
        why = objections(taken_along(by, TAKEN - 8, TAKEN))
        assert (why == []) is passes
    assert why == ["'block' was taken along by the hand by 16 mm from 0.1 to 0.5 s, before it was held, limit 15 mm"]
    first = TAKEN - round(EARLY / STEP)
    assert objections(taken_along(0.1, first - 0, TAKEN)) != []


def test_the_release_of_a_grip_that_nobody_explains_is_not_judged() -> None:
    unknown = replace(taken_along(0.1, OPENED - 1, 80), handovers=())
    assert objections(unknown) == []
    assert any("in the hand" in why for why in said(Tracks(), unknown))
    assert objections(shifted((0.1, 0.0, 0.0), "cup", 40)) == []

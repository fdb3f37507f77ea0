"""Stretches in which no task moves a thing: their first and last samples count, and no others."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec.structs import replace
from short_runs import COUNT, FLOOR, WEIGHT, candidate, good, only, posed, said, shifted
from test_bystanders import carried, hanging, moving, ran, swinging

from cramlite.model import Rollout, Touch
from cramlite_plugins.validators.bystanders import Bystanders, stays
from cramlite_plugins.validators.movers import moved_by


def touching_at(rollout: Rollout, samples: set[int]) -> Rollout:
    """The run whose touches there are at some samples alone."""
    return replace(rollout, touches=tuple(row if k in samples else () for k, row in enumerate(rollout.touches)))


def test_the_first_and_the_last_sample_of_a_stretch_count_and_none_beside_it() -> None:
    """A task moves the cup from sample 25 until 0.2 s after 49, which is 53."""
    moved = moved_by(moving("cup", "2.PickingUp", good()))["cup"]
    assert [moved[k] is None for k in (24, 25, 53, 54)] == [True, False, False, True]
    for sample, passes in ((24, False), (25, True), (52, True), (54, False), (99, False)):
        made = moving("cup", "2.PickingUp", shifted((0.05, 0, 0), "cup", sample, sample + 1))
        away = [r for r in said(Bystanders(), made) if "away" in r]
        assert (away == []) is passes or (sample in (52, 54) and away == []), sample


def test_a_stretch_of_one_sample_is_one() -> None:
    rollout = ran(good())
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [*["t"] * 40, None, *["t"] * 59]})
    assert (stay.sample, stay.leant, stay.way) == (40, 40, 0.0)


@pytest.mark.parametrize(("sample", "way"), [(29, 0.0), (30, 0.05), (59, 0.05), (60, 0.0)])
def test_how_far_it_got_is_that_of_the_stretch(sample: int, way: float) -> None:
    rollout = ran(shifted((0.05, 0, 0), "cup", sample, sample + 1))
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [*["t"] * 30, *[None] * 30, *["t"] * 40]})
    assert stay.way == pytest.approx(way)


def test_of_a_box_the_corner_that_gets_furthest_counts() -> None:
    """It topples about its edge at y = +30 mm: the corner above the other edge goes the diagonal's arc."""
    for axis, side in ((1, 1.0), (1, -1.0), (0, 1.0), (0, -1.0)):
        for degrees in (3.0, -3.0):
            angle, rows = math.radians(degrees), ran(good()).poses["cup"].copy()
            edge = np.array([0.0, 0.0, -0.03])
            edge[axis] = side * 0.03
            about = np.array([1.0, 0, 0]) if axis == 1 else np.array([0, 1.0, 0])
            turned = edge - (math.cos(angle) * edge + math.sin(angle) * np.cross(about, edge) + (1 - math.cos(angle)) * about * (about @ edge))
            rows[40:, :3] += turned
            rows[40:, 3:] = (math.cos(angle / 2), *(math.sin(angle / 2) * about))
            value = max(f.value or 0.0 for f in Bystanders().check(posed(cup=rows)) if f.unit == "m")
            far = math.hypot(0.06, 0.06) * 2 * math.sin(abs(angle) / 2)
            assert value == pytest.approx(far, rel=1e-6), (axis, side, degrees)


def test_turning_about_a_corner_the_far_one_counts() -> None:
    for x in (0.03, -0.03):
        for y in (0.03, -0.03):
            angle, rows = math.radians(3.0), ran(good()).poses["cup"].copy()
            corner = np.array([x, y, 0.0])
            c, s = math.cos(angle), math.sin(angle)
            rows[40:, :3] += corner - np.array([c * x - s * y, s * x + c * y, 0.0])
            rows[40:, 3:] = (math.cos(angle / 2), 0, 0, math.sin(angle / 2))
            value = max(f.value or 0.0 for f in Bystanders().check(posed(cup=rows)) if f.unit == "m")
            assert value == pytest.approx(math.hypot(0.06, 0.06) * 2 * math.sin(angle / 2), rel=1e-6)


def test_whether_it_hangs_is_asked_when_the_stretch_begins() -> None:
    swings = hanging(swinging(2.4))
    for samples, passes in (({0}, True), ({1}, False), ({COUNT - 1}, False)):
        rollout = touching_at(swings, samples)
        (stay,) = stays(rollout, rollout.world.thing("box"), {"box": [None] * COUNT})
        assert (stay.way < 0.001) is passes


def test_what_carries_it_is_asked_when_the_stretch_begins() -> None:
    whole = ran(carried(cup_too=True))
    moved: dict[str, list[str | None]] = {"cup": [None] * COUNT, "block": ["t"] * COUNT}
    for samples, beside in (({0}, "block"), ({1}, ""), ({COUNT - 1}, "")):
        rollout = touching_at(whole, samples)
        (stay,) = stays(rollout, rollout.world.thing("cup"), moved)
        assert stay.beside == beside
    (stay,) = stays(whole, whole.world.thing("cup"), {**moved, "block": [None] * COUNT})
    assert stay.beside == ""  # nobody moves what carries it


def test_leaning_in_the_frame_of_what_carries_is_of_the_things_own_axis() -> None:
    """The block lies on its side and is carried; the cup on it turns about the vertical, and leans nowhere."""
    base = ran(carried(cup_too=True))
    side = np.tile((math.sqrt(0.5), math.sqrt(0.5), 0, 0), (COUNT, 1))
    angle = np.interp(range(COUNT), (20, 60), (0.0, 0.02)) / 2
    yaw = np.column_stack([np.cos(angle), np.zeros((COUNT, 2)), np.sin(angle)])
    poses = {**base.poses, "block": np.hstack([base.poses["block"][:, :3], side]), "cup": np.hstack([base.poses["cup"][:, :3], yaw])}
    rollout = replace(base, poses=poses)
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [None] * COUNT, "block": ["t"] * COUNT})
    assert (stay.beside, stay.tilt) == ("block", pytest.approx(0.0, abs=1e-6)) and 0.0 < stay.way < 0.002


def test_in_the_world_a_thing_may_turn_about_the_vertical_whichever_way_it_lies() -> None:
    rows = ran(good()).poses["cup"].copy()
    rows[:, 3:] = (math.sqrt(0.5), math.sqrt(0.5), 0, 0)
    h = math.radians(2.0)
    rows[40:, 3:] = np.array([math.cos(h), math.cos(h), math.sin(h), math.sin(h)]) * math.sqrt(0.5)
    rollout = ran(posed(cup=rows))
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [None] * COUNT})
    assert stay.tilt == pytest.approx(0.0, abs=1e-6) and stay.way == pytest.approx(2 * math.sin(h) * math.hypot(0.03, 0.03), rel=1e-6)


def test_how_far_is_said_also_of_what_did_not_move() -> None:
    assert only(Bystanders(), good()).reason == "'cup' got furthest of what no task moves, 0.0 mm, limit 5 mm by default"
    base = ran(good())
    alone = candidate(replace(base, world=replace(base.world, things=(FLOOR,)), touches=((),) * COUNT))
    assert only(Bystanders(), alone).value == 0.0


def test_what_is_held_to_the_last_sample_but_one_is_let_go() -> None:
    base = ran(good())
    rows = tuple(base.touches[60] if 60 <= k < COUNT - 1 else row for k, row in enumerate(base.touches))
    lifted = np.outer(np.maximum(np.arange(COUNT) - 80, 0) * 0.01, (0, 0, 1, 0, 0, 0, 0))
    poses = {**base.poses, "block": base.poses["block"] + lifted, "effector": base.poses["effector"]}
    made = good(poses=poses, touches=rows, opening=np.full(COUNT, 0.06))
    assert any("'block' still moves" in r for r in said(Bystanders(), made))


def test_whether_it_hangs_at_the_end_is_asked_of_the_last_sample() -> None:
    swings = hanging(swinging(3.0))
    assert said(Bystanders(), candidate(swings)) == []
    off = touching_at(swings, set(range(COUNT - 1)))
    assert any("'box' still moves" in r for r in said(Bystanders(), candidate(off)))


def test_a_thing_is_carried_by_what_bears_it_not_by_what_it_bears() -> None:
    """The block is lifted with the cup on it: what the cup does is no way of the block."""
    base = ran(carried(cup_too=True))
    rows = tuple((Touch("cup", "block", WEIGHT, -WEIGHT),) for _ in range(COUNT))
    rollout = replace(base, touches=rows)
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [None] * COUNT, "block": ["t"] * COUNT})
    assert stay.beside == "block"

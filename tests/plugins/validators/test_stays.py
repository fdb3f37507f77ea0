"""Stretches in which no task moves a thing: their first and last samples count, and no others."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.short_runs import COUNT, FLOOR, LEFT, STEP, WEIGHT, candidate, good, only, posed, said, shifted
from msgspec.structs import replace
from test_bystanders import carried, hanging, moving, ran, swinging

from cramlite.model import Floats, Pose, Rollout, Touch
from cramlite_plugins.validators.bystanders import Bystanders, _carriers, stays
from cramlite_plugins.validators.movers import moved_by
from cramlite_plugins.validators.rest import at_the_end, borne_by, restless


def touching_at(rollout: Rollout, samples: set[int]) -> Rollout:
    """The run whose touches there are at some samples alone."""
    return replace(rollout, touches=tuple(row if k in samples else () for k, row in enumerate(rollout.touches)))


def test_the_first_and_the_last_sample_of_a_stretch_count_and_none_beside_it() -> None:
    """A task moves the cup from sample 25 until 0.2 s after 49, which is 53."""
    moved = moved_by(moving("cup", "2.PickingUp", good()))["cup"]
    assert [moved[k] is None for k in (24, 25, 53, 54)] == [True, False, False, True]
    for sample, passes in ((24, False), (25, True), (52, True), (54, False), (99, False)):
        made = moving("cup", "2.PickingUp", shifted((0.05, 0, 0), "cup", sample, sample + 1))
        away = [r for r in said(Bystanders(), made) if "from its place" in r]
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
            around = (1 - math.cos(angle)) * about * (about @ edge)  # Rodrigues' formula
            turned = edge - (math.cos(angle) * edge + math.sin(angle) * np.cross(about, edge) + around)
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
    assert only(Bystanders(), good()).reason == "'cup' moved furthest of all things that no task moves, 0.0 mm, limit 5 mm by default"
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


# What small differences make


def test_a_stay_is_measured_from_its_first_sample() -> None:
    rows = ran(good()).poses["cup"].copy()
    rows[1:, 0] += 0.03
    rows[2:, 0] -= 0.06
    for k, angle in ((1, 0.02), (2, -0.02)):
        rows[k:, 3:] = (math.cos(angle), math.sin(angle), 0, 0)
    rollout = ran(posed(cup=rows))
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [None] * COUNT})
    assert stay.way < 0.033 and stay.tilt == pytest.approx(0.04)


def test_what_leans_on_what_carries_it_leans() -> None:
    base = ran(carried(cup_too=True))
    cup = base.poses["cup"].copy()
    cup[40:, 3:] = (math.cos(0.035), math.sin(0.035), 0, 0)
    rollout = replace(base, poses={**base.poses, "cup": cup})
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [None] * COUNT, "block": ["t"] * COUNT})
    assert (stay.beside, stay.leant) == ("block", 40) and stay.tilt == pytest.approx(0.07)


def test_upside_down_is_further_than_on_its_side() -> None:
    rows = ran(good()).poses["cup"].copy()
    rows[40:, 3:] = (math.cos(1.5), math.sin(1.5), 0, 0)
    rollout = ran(posed(cup=rows))
    (stay,) = stays(rollout, rollout.world.thing("cup"), {"cup": [None] * COUNT})
    assert stay.tilt == pytest.approx(3.0)


def moved_at(step: float, rows: Floats, start: float = 0.0) -> list[str | None]:
    """Who moves the cup, in a run of other times and of its poses."""
    times = start + np.arange(COUNT) * step
    return moved_by(good(times=times, poses={**ran(good()).poses, "cup": rows}))["cup"]


def test_at_rest_is_asked_over_a_fifth_of_a_second_whatever_the_clock_says_and_the_rate_is() -> None:
    falls = ran(good()).poses["cup"].copy()
    falls[:6, 2] += 0.02 * np.arange(6, 0, -1)
    assert moved_at(0.05, falls, start=30.0)[:7] == [""] * 6 + [None]
    bounces = falls.copy()
    bounces[2:4, 2] = bounces[2, 2]  # two samples of the same height: it turns round
    assert moved_at(0.05, bounces, start=30.0)[:7] == [""] * 6 + [None]
    fast = ran(good()).poses["cup"].copy()
    fast[0, 2] += 0.1  # at two samples a second two make a fifth
    assert moved_at(0.5, fast)[:2] == ["", None]
    twice = fast.copy()
    twice[3, 2] += 0.1
    assert moved_at(0.5, twice)[:2] == ["", None]


@pytest.mark.parametrize(("count", "settles"), [(1, [""]), (2, ["", ""]), (5, [None] * 5)])
def test_a_run_too_short_to_tell_is_settling_all_along(count: int, settles: list[str | None]) -> None:
    base = ran(good())
    short = replace(base, times=base.times[:count], poses={n: p[:count] for n, p in base.poses.items()}, touches=base.touches[:count],
                    lines=base.lines[:count], opening=base.opening[:count])  # fmt: skip
    assert moved_by(candidate(short))["cup"] == settles


def test_a_turn_beside_the_middle_counts_as_far_as_its_points_get() -> None:
    """About a point 50 mm to its right: 25 mrad are 1.8 mm at the farther of the two points, and 2.5 mm on the other side."""
    for turn, rests in ((0.025, True), (0.031, False)):
        angle, rows = np.arange(COUNT) * turn / 4, ran(good()).poses["cup"].copy()
        rows[:, :2] += 0.05 * np.column_stack([1 - np.cos(angle), -np.sin(angle)])
        rows[:, 3:] = np.column_stack([np.cos(angle / 2), np.zeros((COUNT, 2)), np.sin(angle / 2)])
        assert (moved_at(0.05, rows)[0] is None) is rests


@pytest.mark.parametrize(("way", "rests"), [(0.002, True), (math.nextafter(0.002, 1.0), False)])
def test_at_rest_are_two_millimetres_in_a_fifth_of_a_second_and_no_more(way: float, rests: bool) -> None:
    rows = ran(good()).poses["cup"].copy()
    rows[:, 2] = way * (np.arange(COUNT) % 2)
    assert (moved_at(0.05, rows)[0] is None) is rests


@pytest.mark.parametrize(("degrees", "rests"), [(3.1, True), (3.4, False)])
def test_a_turn_about_a_diagonal_counts_as_far_as_its_points_get(degrees: float, rests: bool) -> None:
    """Points on both sides of the axis, 45 deg off it: 2 mm of their 50 mm are 3.24 deg."""
    angle, rows = np.radians(np.arange(COUNT) * degrees / 4) / 2, ran(good()).poses["cup"].copy()
    rows[:, 3], rows[:, 4], rows[:, 5] = np.cos(angle), np.sin(angle) * math.sqrt(0.5), np.sin(angle) * math.sqrt(0.5)
    assert (moved_at(0.05, rows)[0] is None) is rests


def test_from_the_last_sample_of_a_task_on_it_is_asked_whether_its_things_rest() -> None:
    rows = ran(good()).poses["cup"].copy()
    rows[53:60, 0] += np.arange(1, 8) * 0.01
    rows[60:, 0] += 0.07
    made = moving("cup", "2.PickingUp", posed(cup=rows))
    moved = moved_by(made)["cup"]
    assert moved[54:59] == ["2.PickingUp"] * 5 and moved[60] is None


def test_the_last_half_second_begins_with_the_sample_half_a_second_before_the_end() -> None:
    base = ran(good(times=np.arange(COUNT) / 16))
    for jump, still in ((COUNT - 9, True), (COUNT - 8, False)):
        rows = base.poses["cup"].copy()
        rows[jump:, 0] += 0.1
        assert (restless(replace(base, poses={**base.poses, "cup": rows}), "cup", hanging=False) == "") is still


def spinning(axis: int, speed: float) -> Rollout:
    """The cup turns about one of its axes, its middle where it was [rad/s]."""
    half, rows = np.arange(COUNT) * STEP * speed / 2, ran(good()).poses["cup"].copy()
    rows[:, 3], rows[:, 3 + axis] = np.cos(half), np.sin(half)
    return ran(posed(cup=rows))


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_what_spins_in_place_is_not_at_rest(axis: int) -> None:
    assert restless(spinning(axis, 0.099), "cup", hanging=False) == ""
    assert restless(spinning(axis, -0.099), "cup", hanging=False) == ""
    said = "'cup' still turns at 0.12 rad/s at the end, limit 0.1 rad/s"
    assert restless(spinning(axis, 0.12), "cup", hanging=False) == said
    assert "turns at 25 rad/s" in restless(spinning(axis, 25.0), "cup", hanging=False)  # twice round in the half second


def test_what_rocks_in_place_is_not_at_rest() -> None:
    for amplitude, rests in ((0.030, True), (0.036, False)):
        half, rows = amplitude / 2 * np.sin(np.arange(COUNT) * STEP * 2 * np.pi / 0.5), ran(good()).poses["cup"].copy()
        rows[:, 3], rows[:, 4] = np.cos(half), np.sin(half)
        assert (restless(ran(posed(cup=rows)), "cup", hanging=False) == "") is rests


def test_a_bystander_that_spins_is_an_objection() -> None:
    rows = spinning(3, 0.2).poses["cup"]
    rows[:-8, 3:] = rows[-8, 3:]  # it began to in the last 0.4 s
    (wrong,) = said(Bystanders(), posed(cup=rows))
    assert wrong.startswith("'cup' still turns at 0.")


@pytest.mark.parametrize(("speed", "says"), [(0.79, ""), (0.82, "'box' still turns at 0.82 rad/s at the end, limit 0.8 rad/s")])
def test_what_hangs_may_turn_a_little_about_the_vertical(speed: float, says: str) -> None:
    still = hanging(np.zeros(COUNT))
    hole = still.world.thing("box").feature("vrps:Hole")
    assert hole is not None
    rows, start = [], Pose(tuple(still.poses["box"][0, :3]), tuple(still.poses["box"][0, 3:]))
    pivot = np.array(start.apply(hole.pose.position))
    for half in np.arange(COUNT) * STEP * speed / 2:
        new = Pose((0, 0, 0), (math.cos(half), 0, 0, math.sin(half))) * Pose((0, 0, 0), start.quaternion)
        rows.append([*(pivot - np.array(new.apply(hole.pose.position))), *new.quaternion])
    assert restless(replace(still, poses={**still.poses, "box": np.array(rows)}), "box", hanging=True) == says


def test_a_run_of_one_sample_is_at_rest() -> None:
    base = ran(good())
    one = replace(base, times=base.times[:1], poses={n: p[:1] for n, p in base.poses.items()})
    assert restless(one, "cup", hanging=False) == ""


def test_what_weighs_nothing_is_borne_by_what_pushes_it_at_all() -> None:
    base = ran(good())
    light = replace(base.world, things=tuple(replace(t, mass=None) if t.name == "cup" else t for t in base.world.things))
    leant_on = tuple((*row, Touch("block", "cup", 1.0, 0.0)) for row in base.touches)
    assert borne_by(replace(base, world=light, touches=leant_on), "cup", 30) == ["shelf"]


EXACT = np.arange(COUNT) / 64
"""Times of which the last half second is exactly that [s]."""


@pytest.mark.parametrize(("way", "says"), [(0.005, ""), (math.nextafter(0.005, 1.0), "'cup' still moves at 10 mm/s at the end")])
def test_at_rest_is_up_to_ten_millimetres_in_a_second(way: float, says: str) -> None:
    rows = ran(good()).poses["cup"].copy()
    rows[:, 2] = way * (np.arange(COUNT) % 2)
    assert restless(ran(good(times=EXACT, poses={**ran(good()).poses, "cup": rows})), "cup", hanging=False) == says


@pytest.mark.parametrize(("way", "says"), [(0.01, ""), (math.nextafter(0.01, 1.0), "'box' still swings at 40 mm/s at the end")])
def test_what_hangs_may_swing_by_forty(way: float, says: str) -> None:
    """To and fro about its hole."""
    still = hanging(np.zeros(COUNT))
    hole = still.world.thing("box").feature("vrps:Hole")
    assert hole is not None and hole.pose.position[:2] == (0.0, 0.0)
    side = np.where(np.arange(COUNT) % 2, 1.0, -1.0)
    angle = side * math.asin(way / hole.pose.position[2])
    rows = np.column_stack([np.zeros(COUNT), side * way, np.zeros(COUNT), np.cos(angle / 2), np.sin(angle / 2), np.zeros((COUNT, 2))])
    assert restless(replace(still, times=EXACT, poses={**still.poses, "box": rows}), "box", hanging=True) == says


def test_two_samples_in_the_last_half_second_are_enough_to_see_it_turn() -> None:
    assert restless(replace(spinning(2, 0.099), times=np.arange(COUNT) * 0.4), "cup", hanging=False) == ""
    assert "still turns" in restless(replace(spinning(2, 2.0), times=np.arange(COUNT) * 0.4), "cup", hanging=False)


def test_a_thing_at_the_end_stands_where_the_last_sample_has_it() -> None:
    rollout = ran(good())
    rows = rollout.poses["cup"].copy()
    rows[-1] = [0.1, 0.2, 0.3, 0.5, -0.5, 0.5, -0.5]
    left = at_the_end(replace(rollout, poses={**rollout.poses, "cup": rows}), "cup")
    assert left.name == "cup" and left.pose == Pose((0.1, 0.2, 0.3), (0.5, -0.5, 0.5, -0.5))


def test_what_a_hand_bears_is_carried_by_no_thing() -> None:
    base = ran(good())
    borne = replace(base, touches=(*base.touches[:-1], (Touch(LEFT, "cup", WEIGHT, WEIGHT),)))
    assert borne_by(borne, "cup", -1) == ["effector"]
    assert _carriers(borne, base.world.thing("cup"), -1, {}) == []


def test_a_scenario_may_take_its_word_as_advice() -> None:
    assert Bystanders().may_advise

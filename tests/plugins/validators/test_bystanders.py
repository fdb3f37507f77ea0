"""What no task moves stays where it is, upright and still; what a task moves is its own until it rests."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.properties import examples
from helpers.short_runs import (
    COUNT,
    FLOOR,
    LANDED,
    OPENED,
    ORIGINS,
    STEP,
    TAKEN,
    WEIGHT,
    candidate,
    good,
    lying,
    only,
    posed,
    said,
    shifted,
    track,
)
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from scipy.spatial.transform import Rotation

from cramlite.model import Floats, JudgingLimits, Pose, Rollout, Touch, World
from cramlite.plugin import PADDING, Allowance, Candidate
from cramlite_plugins.objects.products_and_fixtures import hanger, hung, product
from cramlite_plugins.validators.bystanders import Bystanders, Stay, _measured, stays
from cramlite_plugins.validators.explained import EARLY
from cramlite_plugins.validators.movers import moved_by
from cramlite_plugins.validators.rest import borne_by, hangs, restless

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def ran(of: Candidate) -> Rollout:
    assert of.rollout is not None
    return of.rollout


def leaning(degrees: float, first: int = 40) -> Candidate:
    """The run in which the cup leans over by an angle, about its middle."""
    poses = ran(good()).poses["cup"].copy()
    half = math.radians(degrees) / 2
    poses[first:, 3:] = (math.cos(half), math.sin(half), 0.0, 0.0)
    return posed(cup=poses)


def turning(degrees: float, first: int = 40) -> Candidate:
    poses = ran(good()).poses["cup"].copy()
    half = math.radians(degrees) / 2
    poses[first:, 3:] = (math.cos(half), 0.0, 0.0, math.sin(half))
    return posed(cup=poses)


def moving(name: str, task: str, of: Candidate) -> Candidate:
    return replace(of, allowances={**of.allowances, task: Allowance(moves=frozenset({name}))})


# Validator


def test_the_run_as_it_is_passes_and_says_who_got_furthest() -> None:
    found = only(Bystanders(), good())
    assert found.passed and (found.value, found.limit, found.unit) == (0.0, 0.005, "m")
    found = only(Bystanders(), shifted((0, 0.004, 0), "cup", 40))
    assert found.passed and found.reason == "'cup' moved furthest of all things that no task moves, 4.0 mm, limit 5 mm by default"
    assert found.value == pytest.approx(0.004)


def test_of_nothing_that_can_be_moved_nothing_is_said_to_have_moved() -> None:
    bare = ran(good())
    alone = candidate(replace(bare, world=replace(bare.world, things=(FLOOR,)), touches=((),) * COUNT))
    assert only(Bystanders(), alone).reason == "nothing to move, limit 5 mm by default"


@pytest.mark.parametrize(("way", "passes"), [(0.0049, True), (0.0051, False)])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_bystander_moves_no_further_than_the_limit(way: float, passes: bool, axis: int) -> None:
    pushed = shifted(np.eye(3)[axis] * way, "cup", 40)
    found = list(Bystanders().check(pushed))
    assert all(f.passed for f in found) is passes
    if not passes:
        (one,) = found
        assert one.reason == "'cup', which no task moved then, was 5 mm from its place at 2.0 s; limit 5 mm by default"
        assert one.value == pytest.approx(way) and (one.limit, one.origin) == (0.005, "2.PickingUp")
        assert str(one.remedy).endswith("'limits: {bystander_motion: 6 mm}' in the scenario")
        let = JudgingLimits(bystander_motion=0.006, of_scenario=("bystander_motion",))
        assert all(f.passed for f in Bystanders().check(replace(pushed, limits=let))), "what it says, does"


@pytest.mark.parametrize(("way", "passes"), [(0.0009, True), (0.0011, False)])
def test_what_must_keep_its_place_has_a_limit_of_its_own(way: float, passes: bool) -> None:
    """Wider limits for all others are none for it; and none of its own leaves it to theirs."""
    wide = JudgingLimits(bystander_motion=1.0, keep=(("cup", 0.001),), of_scenario=("bystander_motion", "keep"))
    pushed = replace(shifted((way, 0, 0), "cup", 40), limits=wide)
    found = [f for f in Bystanders().check(pushed) if not f.passed]
    assert not found if passes else found
    assert all(f.passed for f in Bystanders().check(replace(pushed, limits=replace(wide, keep=()))))
    for one in found:
        assert one.reason == "'cup', which must keep its place, was 1 mm from its place at 2.0 s; limit 1 mm of the scenario"
        assert str(one.remedy).endswith("'limits: {keep: {cup: 2 mm}}' in the scenario")
        let = replace(wide, keep=(("cup", 0.002),))
        assert all(f.passed for f in Bystanders().check(replace(pushed, limits=let))), "what it says, does"


def test_no_task_may_move_what_must_keep_its_place() -> None:
    """The block of the good run is carried, which is a task's business but where it must stay."""
    kept = JudgingLimits(keep=(("block", 0.005),), of_scenario=("keep",))
    assert any("must keep its place" in r for r in said(Bystanders(), replace(good(), limits=kept)))


def test_no_limit_is_advised_for_a_payload_of_the_plan() -> None:
    """Its grasp is at fault; the cup beside it may be let move, and what must keep its place may be let go."""
    slid = shifted((0.05, 0, 0), "block", COUNT - 5)
    (one, *_) = (f for f in Bystanders().check(slid) if not f.passed)
    assert one.reason.startswith("'block', which no task moved then, was 50 mm from its place") and one.remedy is None
    kept = replace(good(), limits=JudgingLimits(keep=(("block", 0.005),), of_scenario=("keep",)))
    assert any("{keep: {block: " in str(f.remedy) for f in Bystanders().check(kept) if not f.passed)


def test_the_limit_that_would_let_it_is_named_to_the_next_millimetre() -> None:
    (one,) = (f for f in Bystanders().check(shifted((0, 0, 1.6004), "cup", 40)) if not f.passed)
    assert one.remedy is not None and one.remedy.missing == pytest.approx(1600.4)
    assert str(one.remedy).endswith("'limits: {bystander_motion: 1601 mm}' in the scenario")


def test_one_that_comes_back_was_moved_all_the_same() -> None:
    assert "was 50 mm from its place at 2.0 s" in said(Bystanders(), shifted((0.05, 0, 0), "cup", 40, 45))[0]


def test_the_limits_of_a_scenario_hold_to_the_last_digit() -> None:
    pushed = shifted((0, 0, 0.03125), "cup", 40)
    (way,) = [f.value for f in Bystanders().check(pushed) if not f.passed]
    assert way is not None
    exact = JudgingLimits(bystander_motion=way, of_scenario=("bystander_motion",))
    assert only(Bystanders(), replace(pushed, limits=exact)).passed
    tighter = replace(exact, bystander_motion=way * (1 - 1e-12))
    assert "of the scenario" in said(Bystanders(), replace(pushed, limits=tighter))[0]


@pytest.mark.parametrize(("degrees", "passes"), [(4.9, True), (5.1, False)])
def test_a_bystander_leans_no_further_than_the_limit(degrees: float, passes: bool) -> None:
    wide = replace(leaning(degrees), limits=JudgingLimits(bystander_motion=1.0))
    found = list(Bystanders().check(wide))
    assert all(f.passed for f in found) is passes
    if not passes:
        assert found[0].reason == "'cup', which no task moved then, leant over by 5 deg at 2.0 s; limit 5 deg by default"
        assert str(found[0].remedy).endswith("'limits: {bystander_tilt: 6 deg}' in the scenario")
        assert found[0].value == pytest.approx(math.radians(degrees)) and (found[0].unit, found[0].origin) == ("rad", "2.PickingUp")
        exact = replace(wide, limits=replace(wide.limits, bystander_tilt=found[0].value))
        assert all(f.passed for f in Bystanders().check(exact))


def test_a_bystander_that_turns_leans_nowhere_though_its_corners_move() -> None:
    (reason,) = said(Bystanders(), turning(20.0))
    corner = math.hypot(0.03, 0.03) * 2 * math.sin(math.radians(10))
    assert f"was {1000 * corner:.0f} mm from its place" in reason
    assert said(Bystanders(), turning(6.0)) == []


@pytest.mark.parametrize("top", [0.03, -0.03])
def test_the_corner_that_got_furthest_counts_on_whichever_side_it_is(top: float) -> None:
    poses = ran(leaning(30.0)).poses["cup"].copy()
    poses[40:, 1:3] += (top * math.sin(math.radians(30)), top * (1 - math.cos(math.radians(30))))  # it turns about an edge's height
    (stay,) = stays(ran(posed(cup=poses)), ran(good()).world.thing("cup"), {"cup": [None] * COUNT})
    assert stay.way == pytest.approx(2 * math.sin(math.radians(15)) * math.hypot(0.03, 0.06))


def test_what_is_turned_over_leans_by_half_a_turn() -> None:
    for k, start in enumerate(Rotation.random(200, random_state=0)):
        poses = ran(good()).poses["cup"].copy()
        axis = (math.cos(k), math.sin(k), 0.0)
        poses[:, 3:] = start.as_quat(scalar_first=True)
        poses[40:, 3:] = (Rotation.from_rotvec(math.pi * np.array(axis)) * start).as_quat(scalar_first=True)
        (stay,) = stays(ran(posed(cup=poses)), ran(good()).world.thing("cup"), {"cup": [None] * COUNT})
        assert stay.tilt == pytest.approx(math.pi, abs=1e-6)


def test_both_are_said_of_one_that_topples() -> None:
    first, second = said(Bystanders(), leaning(90.0))
    assert "was 60 mm from its place" in first and "leant over by 90 deg" in second


def test_of_each_thing_the_first_stretch_that_objects_is_said() -> None:
    twice = moving("cup", "2.PickingUp", shifted((0.05, 0, 0), "cup", 80))
    poses = ran(twice).poses["cup"].copy()
    poses[21:24, 0] += 0.03
    both = candidate(replace(ran(twice), poses={**ran(twice).poses, "cup": poses}))
    both = replace(both, allowances=twice.allowances)
    assert ["was 30 mm from its place" in r for r in said(Bystanders(), both)] == [True]
    assert ["was 50 mm from its place" in r for r in said(Bystanders(), twice)] == [True]


def test_what_still_moves_at_the_end_is_an_objection_and_the_rest_is_said_too() -> None:
    poses = ran(good()).poses["cup"].copy()
    poses[80:, 1] += np.arange(20) * STEP * 0.011
    found = list(Bystanders().check(replace(posed(cup=poses), limits=JudgingLimits(bystander_motion=1.0))))
    assert [f.passed for f in found] == [False, True]
    assert found[0].reason == "'cup' still moves at 11 mm/s at the end"


def test_what_is_held_at_the_end_may_move_with_the_hand() -> None:
    base = ran(good())
    rows = tuple(base.touches[60] if k >= 60 else row for k, row in enumerate(base.touches))
    lifted = {n: p + np.outer(np.maximum(np.arange(COUNT) - 80, 0) * 0.01, (0, 0, 1, 0, 0, 0, 0)) for n, p in base.poses.items()}
    poses = {**base.poses, "block": lifted["block"], "effector": lifted["effector"]}
    held = good(poses=poses, touches=rows, opening=np.full(COUNT, 0.06))
    assert said(Bystanders(), held) == []
    let_go = good(poses=poses)
    assert any("'block' still moves" in r for r in said(Bystanders(), let_go))


# Who moves what


def test_a_thing_is_moved_from_when_its_task_begins_until_it_rests() -> None:
    moved = moved_by(good())
    assert set(moved) == {"block", "cup"} and moved["cup"] == [None] * COUNT
    block = moved["block"]
    assert block[:2] == [None] * 2 and block[2:25] == ["1.Grasping"] * 23
    assert block[25:50] == ["2.PickingUp"] * 25 and block[50:70] == ["3.Placing/PuttingDown"] * 20
    # the pads open as Releasing begins: the block is no longer its own, and rests 0.2 s after the end of what it did move with
    assert block[70:74] == ["3.Placing/PuttingDown"] * 4 and block[74:] == [None] * 26


@pytest.mark.parametrize(("speed", "still"), [(0.0095, True), (0.0105, False)])
def test_at_rest_is_slower_than_a_limit_over_a_fifth_of_a_second(speed: float, still: bool) -> None:
    poses = ran(good()).poses["cup"].copy()
    poses[:, 0] += np.arange(COUNT) * STEP * speed
    moved = moved_by(posed(cup=poses))["cup"]
    assert moved[0] is None if still else moved[:21] == [""] * 21


def test_things_settle_for_a_second_at_most_and_no_longer_than_they_move() -> None:
    for falls, settled in ((6, 6), (30, 21)):
        poses = ran(good()).poses["cup"].copy()
        poses[:falls, 2] += 0.02 * (falls - np.arange(falls)) / 1.0
        moved = moved_by(posed(cup=poses))["cup"]
        assert moved[:settled] == [""] * settled and moved[settled] is None


def test_what_only_turns_is_not_at_rest() -> None:
    """By half the size of what hands take a turn counts as way: 2 mm are 2.3 deg."""
    for degrees, still in ((2.2, True), (2.4, False)):
        for axis in (1, 2, 3):
            angle = np.radians(np.arange(COUNT) * degrees / 4) / 2
            poses = ran(good()).poses["cup"].copy()
            poses[:, 3], poses[:, 3 + axis] = np.cos(angle), np.sin(angle)
            moved = moved_by(posed(cup=poses))["cup"]
            assert (moved[0] is None) is still, (degrees, axis)


def test_what_a_task_declares_is_its_own_all_through_and_until_effects_have_appeared() -> None:
    moved = moved_by(moving("cup", "2.PickingUp", good()))["cup"]
    after = 49 + int(PADDING / STEP) + 1
    assert moved == [None] * 25 + ["2.PickingUp"] * (after - 25) + [None] * (COUNT - after)


def test_what_was_let_go_of_is_its_tasks_until_it_rests() -> None:
    base = ran(good())
    rolls = base.poses["block"].copy()
    rolls[OPENED:85, 0] += np.arange(15) * 0.01
    rolls[85:, 0] += 0.14
    moved = moved_by(posed(block=rolls))["block"]
    assert set(moved[OPENED:84]) == {"3.Placing/PuttingDown"} and moved[85] is None


def test_what_rests_is_nobodys_though_the_task_that_let_go_of_it_runs_on() -> None:
    """The hand that let go of it shoves it at sample 85, in the same task."""
    for by, count in ((0.0, 0), (0.004, 0), (0.02, 1)):
        shoved = shifted((by, 0.0, 0.0), "block", 85)
        assert shoved.code is not None
        longer = {**ORIGINS, 7: ORIGINS[5], 9: ORIGINS[5]}
        found = said(Bystanders(), replace(shoved, code=replace(shoved.code, origins=longer)))
        assert len(found) == count
    assert "'block', which no task moved then, was 20 mm from its place at 4.2 s" in found[0]
    freely = moving("block", "3.Placing/PuttingDown", replace(shoved, code=replace(shoved.code, origins=longer)))
    assert said(Bystanders(), freely) == []


def test_a_thing_is_nobodys_until_the_fingers_close_on_it() -> None:
    """Its task begins 0.8 s before, and owns it for the last half second of these."""
    slow = np.arange(COUNT) * 0.1
    first = TAKEN - round(EARLY / 0.1)
    block = moved_by(good(times=slow))["block"]
    assert block[:first] == [None] * first and set(block[first + 1 : 25]) == {"1.Grasping"}
    for sample, count in ((first - 1, 1), (first + 2, 0)):
        poses = ran(good()).poses["block"].copy()
        poses[:sample, 0] -= 0.03  # open fingers take it along
        assert len(said(Bystanders(), good(poses={**ran(good()).poses, "block": poses}, times=slow))) == count


def test_what_never_rests_is_its_tasks_to_the_end() -> None:
    rolls = ran(good()).poses["block"].copy()
    rolls[OPENED:, 0] += np.arange(COUNT - OPENED) * 0.01
    assert moved_by(posed(block=rolls))["block"][-1] == "3.Placing/PuttingDown"


@given(first=st.integers(26, 60), length=st.integers(1, 20), way=st.floats(0.006, 1.0))
@examples(30)
def test_a_bystander_that_is_away_at_any_time_is_an_objection(first: int, length: int, way: float) -> None:
    (reason,) = said(Bystanders(), shifted((way, 0, 0), "cup", first, first + length))
    assert f"was {1000 * way:.0f} mm from its place at {first * STEP:.1f} s" in reason


# In whose frame


def carried(cup_too: bool, lift: float = WEIGHT) -> Candidate:
    """A run in which the cup stands on the block, and is carried along or stays."""
    base = ran(good())
    cup = base.poses["block"].copy()
    cup[:, 2] += 0.06
    if not cup_too:
        cup[:] = cup[0]
    rows = tuple((*(t for t in row if "cup" not in (t.a, t.b)), Touch("block", "cup", lift, lift)) for row in base.touches)
    return good(poses={**base.poses, "cup": cup}, touches=rows)


def test_what_stands_on_what_is_carried_is_measured_in_its_frame() -> None:
    assert said(Bystanders(), carried(cup_too=True)) == []
    assert said(Bystanders(), carried(cup_too=False)) == []  # nor is it wrong that it stays
    aside = ran(carried(cup_too=True)).poses["cup"].copy()
    aside[40:, 0] += 0.02
    slid = ran(carried(cup_too=True))
    (reason,) = said(Bystanders(), good(poses={**slid.poses, "cup": aside}, touches=slid.touches))
    assert "was 20 mm from its place on 'block', which carries it, at 2.0 s" in reason


@pytest.mark.parametrize(("share", "bears"), [(0.51, True), (0.5, False), (0.49, False)])
def test_what_bears_half_of_a_things_weight_carries_it(share: float, bears: bool) -> None:
    rollout = ran(carried(cup_too=True, lift=share * WEIGHT))
    assert (borne_by(rollout, "cup", 30) == ["block"]) is bears
    turned = replace(rollout, touches=tuple(tuple(replace(t, a=t.b, b=t.a, lift=-t.lift) for t in row) for row in rollout.touches))
    assert (borne_by(turned, "cup", 30) == ["block"]) is bears
    assert (said(Bystanders(), carried(cup_too=True, lift=share * WEIGHT)) == []) is bears


def test_what_is_borne_does_not_bear() -> None:
    rollout = ran(carried(cup_too=True))
    assert borne_by(rollout, "block", 0) == ["floor"] and borne_by(rollout, "cup", 0) == ["block"]
    assert borne_by(ran(good()), "block", 45) == ["effector", "effector"] or borne_by(ran(good()), "block", 45) == []


def test_what_stands_beside_what_is_carried_is_measured_in_the_world() -> None:
    base = ran(good())
    along = base.poses["block"].copy()
    along[:, 0] += 0.2
    loose = good(poses={**base.poses, "cup": along})
    assert "from its place" in said(Bystanders(), loose)[0]


def test_leaning_is_measured_in_the_frame_of_what_carries() -> None:
    """A tray that is tipped tips its cup, which does not lean on it."""
    base = ran(carried(cup_too=True))
    tipped = np.interp(range(COUNT), (0, 60), (0.0, math.radians(30)))
    about = np.column_stack([np.cos(tipped / 2), np.sin(tipped / 2), np.zeros((COUNT, 2))])
    block = np.column_stack([base.poses["block"][:, :3], about])
    up = np.column_stack([np.zeros(COUNT), -np.sin(tipped), np.cos(tipped)])
    cup = np.column_stack([block[:, :3] + 0.06 * up, about])
    with_it = good(poses={**base.poses, "block": block, "effector": block, "cup": cup}, touches=base.touches)
    assert [r for r in said(Bystanders(), with_it) if "leant" in r] == []
    upright = np.column_stack([cup[:, :3], np.tile(UPRIGHT, (COUNT, 1))])
    (stay,) = stays(ran(with_it), ran(with_it).world.thing("cup"), {"cup": [None] * COUNT, "block": ["t"] * COUNT})
    assert (stay.beside, stay.way, stay.tilt) == ("block", pytest.approx(0.0, abs=1e-9), pytest.approx(0.0, abs=1e-6))
    other = replace(ran(with_it), poses={**ran(with_it).poses, "cup": upright})
    found = {s.beside for s in stays(other, other.world.thing("cup"), {"cup": [None] * COUNT, "block": ["t"] * COUNT})}
    assert found == {"block"} or found == {""}


def about(axis: str, degrees: Floats) -> Rotation:
    return Rotation.from_euler(axis, degrees[:, None], degrees=True)


def in_frame(block: Rotation, cup: Rotation) -> Stay:
    """The stay of the cup in the frame of the block, which stay in one place, from their attitudes at the samples."""
    base = ran(carried(cup_too=True))
    poses = {name: np.column_stack([np.tile(base.poses["block"][0, :3], (COUNT, 1)), turn.as_quat(scalar_first=True)])
             for name, turn in (("block", block), ("cup", cup))}  # fmt: skip
    run = replace(base, poses={**base.poses, **poses})
    return _measured(run, "cup", np.zeros((1, 3)), 0, COUNT, "block")


def test_what_lies_on_what_carries_it_may_turn_about_the_vertical() -> None:
    flat, turn, still = about("x", np.full(COUNT, 90.0)), np.linspace(0, 60, COUNT), Rotation.identity(COUNT)
    assert in_frame(still, about("z", turn) * flat).tilt == pytest.approx(0.0, abs=1e-6)
    assert in_frame(still, about("y", turn) * flat).tilt == pytest.approx(math.radians(60))


def test_the_vertical_on_what_carries_is_that_of_the_beginning() -> None:
    tipped = about("x", np.where(np.arange(COUNT) < 1, 20.0, 0.0))
    turned = about("z", np.where(np.arange(COUNT) < COUNT - 1, 0.0, 90.0))
    between = math.acos(math.cos(math.radians(20)) ** 2)
    assert in_frame(tipped, tipped * turned).tilt == pytest.approx(between)


def test_a_stay_says_when_it_was_furthest_and_leant_most() -> None:
    poses = ran(good()).poses["cup"].copy()
    poses[30:34, 0] += 0.1
    poses[50:54, 3:] = (math.cos(0.2), 0.0, math.sin(0.2), 0.0)
    rollout = ran(posed(cup=poses))
    moved = {"cup": ["t"] * 20 + [None] * 60 + ["t"] * 20}
    (stay,) = stays(rollout, rollout.world.thing("cup"), moved)
    assert (stay.sample, stay.leant, stay.beside) == (30, 50, "") and stay.way == pytest.approx(0.1) and stay.tilt == pytest.approx(0.4)


# At rest, hanging


def hanging(swing: Floats, along: Floats | float = 0.0, *, hook: bool = True) -> Rollout:
    """A product on a peg that swings about its hole by angles [rad], its hole moved along the peg [m]."""
    peg = hanger("hook", Pose((0.87, 0, 0.45)))
    box = product("box", Pose(), size=(0.06, 0.05, 0.10), hole_diameter=0.009)
    start = hung(box, peg, depth=0.07)
    feature = box.feature("vrps:Hole")
    assert feature is not None
    pivot, rows = np.array(start.apply(feature.pose.position)), []
    for angle, way in zip(swing, np.broadcast_to(along, COUNT), strict=True):
        turn = Pose((0, 0, 0), (math.cos(angle / 2), math.sin(angle / 2), 0, 0))
        new = turn * Pose((0, 0, 0), start.quaternion)
        place = np.add(pivot, (way, 0, 0)) - np.array(new.apply(feature.pose.position))
        rows.append([*place, *new.quaternion])
    weight = 9.81 * (box.mass or 0.0)
    base = ran(good())
    world = World((peg, replace(box, pose=start)) if hook else (FLOOR, replace(box, pose=start)), base.world.robots)
    by = "hook/peg" if hook else "floor"
    touch = (Touch(by, "box", weight, weight),)
    poses = {"box": np.array(rows), "hook": track((0, (0.87, 0, 0.45))), "effector": base.poses["effector"]}
    return replace(base, world=world, poses=poses, touches=(touch,) * COUNT, opening=np.full(COUNT, 0.085))


def test_what_a_peg_bears_by_its_hole_hangs() -> None:
    still = hanging(np.zeros(COUNT))
    assert hangs(still, "box", 50) and not hangs(hanging(np.zeros(COUNT), hook=False), "box", 50)
    loose = replace(still, touches=(*still.touches[:50], (), *still.touches[51:]))
    assert not hangs(loose, "box", 50) and hangs(loose, "box", 49)
    solid = replace(still, world=replace(still.world, things=(still.world.things[0], lying("box", (0, 0, 0), mass=0.3))))
    assert not hangs(solid, "box", 50)  # it has no hole


def swinging(degrees: float) -> Floats:
    return np.radians(degrees) * np.sin(np.arange(COUNT) * STEP * 2 * np.pi / 0.5)


@pytest.mark.parametrize(("degrees", "says"), [(6.0, ""), (12.0, "'box' still swings at")])
def test_what_hangs_may_swing_a_little(degrees: float, says: str) -> None:
    assert restless(hanging(swinging(degrees)), "box", hanging=True).startswith(says or "")
    assert bool(restless(hanging(swinging(degrees)), "box", hanging=True)) is bool(says)
    assert "'box' still moves" in restless(hanging(swinging(degrees)), "box", hanging=False)


@pytest.mark.parametrize(("speed", "says"), [(0.0099, ""), (0.0102, "the hole of 'box' still moves at 10 mm/s at the end")])
def test_its_hole_is_at_rest(speed: float, says: str) -> None:
    assert restless(hanging(np.zeros(COUNT), np.arange(COUNT) * STEP * speed), "box", hanging=True) == says


@pytest.mark.parametrize(("speed", "says"), [(0.0099, ""), (0.0102, "'cup' still moves at 10 mm/s at the end")])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_what_stands_is_at_rest(speed: float, says: str, axis: int) -> None:
    poses = ran(good()).poses["cup"].copy()
    poses[:, axis] += np.arange(COUNT) * STEP * speed
    assert restless(ran(posed(cup=poses)), "cup", hanging=False) == says


def test_at_rest_is_asked_of_the_last_half_second() -> None:
    assert restless(ran(shifted((0.1, 0, 0), "cup", COUNT - 12)), "cup", hanging=False) == ""
    assert restless(ran(shifted((0.1, 0, 0), "cup", COUNT - 9)), "cup", hanging=False) != ""


def test_a_bystander_that_hangs_may_swing_and_its_hole_may_not_move() -> None:
    assert said(Bystanders(), candidate(hanging(swinging(2.0)))) == []
    crept = np.where(np.arange(COUNT) > 40, 0.006, 0.0)
    assert "'box', which no task moved then, was 6 mm from its place" in said(Bystanders(), candidate(hanging(np.zeros(COUNT), crept)))[0]
    assert "still swings" in said(Bystanders(), replace(candidate(hanging(swinging(12.0))), limits=JudgingLimits(0.1, 1.0)))[0]
    on_floor = candidate(hanging(swinging(2.0), hook=False))
    assert said(Bystanders(), on_floor) != []  # what does not hang does not swing


def test_landed_is_before_the_pads_open() -> None:
    assert TAKEN < LANDED < OPENED  # what these runs are about

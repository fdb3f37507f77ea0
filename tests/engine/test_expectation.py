"""The expectation of a proof: which samples a reading is compared with, and how far a thing is off."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.properties import examples
from helpers.short_runs import LANDED, LEFT, OPENED, ORIGINS, RIGHT, TAKEN, good, posed, touching
from helpers.watched_runs import COUNT, SIDE, STANDS, proof, readings, seen, track, twice
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.engine.recovery.expectation import Expectation, RunWatch, expectation
from cramlite.model import Deviation, Joint, Pose, Touch
from cramlite.model.world.thing_boxes import boxes
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.robots.ur5e_mobile import UR5E_MOBILE


@pytest.fixture
def expected() -> Expectation:
    return proof()


# Which samples of the proof a reading is compared with


def test_a_step_is_that_of_the_last_line_that_begins_one(expected: Expectation) -> None:
    assert [expected.step(k) for k in range(5)] == [
        "",
        "1.Reaching/move",
        "1.Reaching/move",
        "2.Grasping/close",
        "2.Grasping/close",
    ]


def test_a_line_is_compared_with_its_samples_and_those_a_fifth_of_a_second_around(
    expected: Expectation,
) -> None:
    times = np.arange(COUNT) * 0.0625  # exact in binary
    lines = np.repeat([1.0, 2.0, 3.0], [20, 11, 20])
    three = replace(expected, lines=lines, times=times)
    assert three.own(2) == list(range(20, 31)) and three.own(7) == []
    assert three.rows(2) == list(range(17, 34)) and three.rows(1) == list(range(23))
    assert three.rows(7) == list(range(COUNT))
    assert replace(three, times=np.arange(COUNT) * 0.2).rows(2) == list(range(19, 32))


@pytest.mark.parametrize(("sample", "passes"), [(32, True), (36, False)])
def test_what_the_proof_shows_shortly_after_a_line_may_be_read_in_it(
    sample: int, passes: bool, expected: Expectation
) -> None:
    """The block is led away at 3 m/s after the line, and read where it is at that sample."""
    way = track(STANDS)
    way[:, 0] += np.maximum(0.0, (np.arange(COUNT) - 25) * 0.06)
    led = replace(expected, lines=np.repeat([1.0, 2.0], [25, 26]), poses={"block": way})
    there = Pose(tuple(way[sample, :3].tolist()))
    assert (twice(led, block=there) is None) is passes


# Things that stand about


@pytest.mark.parametrize(
    ("at", "off"),
    [
        ((0.05, 0.03, 0.0), 0.03), ((-0.04, 0.0, 0.0), 0.04), ((0.1, -0.03, 0.0), 0.03),
        ((0.1, 0.24, 0.0), 0.04), ((0.02, 0.0, 0.05), 0.05),
        ((0.06, 0.1, 0.0), 0.04),
    ],
)  # fmt: skip
def test_a_thing_that_moves_in_the_proof_is_as_far_off_as_it_is_from_its_way(
    at: tuple[float, float, float], off: float, expected: Expectation
) -> None:
    """It is led 0.1 m along x, then 0.2 m along y, and stands at each end for a while."""
    ends = np.arange(COUNT)
    way = track(Pose())
    way[:, 0], way[:, 1] = np.interp(ends, (10, 15), (0.0, 0.1)), np.interp(ends, (15, 40), (0.0, 0.2))
    coarse = way[[0, 0, 10, 15, 15, 40, 40]]
    for path in (way, coarse):
        short = replace(
            expected, poses={"block": path}, lines=np.ones(len(path)), times=np.arange(len(path)) * 0.1
        )
        short = replace(
            short, held=("",) * len(path), opening=np.full(len(path), 0.08), force=np.zeros(len(path))
        )
        short = replace(short, joints=short.joints[: len(path)])
        found = seen(RunWatch(short), readings(0.0, block=Pose(at)), readings(0.02, block=Pose(at)))
        assert found is not None and found.kind is Deviation.MOVED and found.measured == pytest.approx(off)
        assert (found.limit, found.unit, found.thing) == (pytest.approx(0.015), "m", "block")


@pytest.mark.parametrize(("off", "passes"), [(0.014, True), (0.016, False)])
def test_a_proof_of_one_sample_has_things_at_one_place(
    off: float, passes: bool, expected: Expectation
) -> None:
    one = replace(
        expected, lines=np.ones(1), times=np.zeros(1), poses={"block": track(STANDS)[:1]}, held=("",),
        opening=np.full(1, 0.08),
        force=np.zeros(1), joints=np.zeros((1, 1)), in_hand={"block": np.zeros((1, 3))},
    )  # fmt: skip
    assert (twice(one, block=Pose((0.5, off, 0.05))) is None) is passes


def test_what_was_never_read_is_not_missed_and_what_was_is(expected: Expectation) -> None:
    assert seen(RunWatch(expected), *(readings(0.02 * k, block=None) for k in range(10))) is None
    found = twice(expected, block=None)
    assert found is not None and (found.kind, found.thing) == (Deviation.MISSING, "block")


def test_what_nobody_knew_of_is_told(expected: Expectation) -> None:
    found = twice(expected, poses={"block": STANDS, "zebra": Pose(), "mug": Pose()})
    assert found is not None and (found.kind, found.thing) == (Deviation.ADDED, "mug")
    known = replace(expected, known=frozenset({"block", "mug", "zebra"}))
    assert twice(known, poses={"block": STANDS, "zebra": Pose(), "mug": Pose()}) is None


vectors = st.tuples(*[st.floats(-1.5, 1.5)] * 3)


@given(
    turn=vectors,
    spin=st.floats(-3.0, 3.0),
    lean=st.sampled_from([0.0, 14.0, 16.0, 90.0, 170.0]),
    about=st.floats(0.0, 6.2),
)
@examples(20)
def test_a_thing_leans_by_the_angle_of_its_axis_however_it_stood(
    turn: Any, spin: float, lean: float, about: float
) -> None:
    """Turned about its own axis it leans by nothing."""
    stood = Pose.from_rotvec(STANDS.position, turn)
    tilt = math.radians(lean)
    tilted = stood * Pose.from_rotvec((0, 0, 0), (tilt * math.cos(about), tilt * math.sin(about), 0.0))
    read = tilted * Pose.from_rotvec((0, 0, 0), (0.0, 0.0, spin))
    watch = RunWatch(replace(proof(), poses={"block": track(stood)}))
    found = seen(watch, readings(0.0, block=stood), *(readings(k, block=read) for k in (0.02, 0.04)))
    if lean < 15.0:
        assert found is None
    else:
        assert (
            found is not None
            and found.kind is Deviation.FALLEN
            and found.measured == pytest.approx(tilt, abs=1e-6)
        )
        assert (found.limit, found.unit, found.thing) == (pytest.approx(math.radians(15.0)), "rad", "block")


def test_what_leans_in_the_proof_may_lean(expected: Expectation) -> None:
    way = track(STANDS)
    tipped = Pose.from_rotvec(STANDS.position, (1.0, 0.0, 0.0))
    way[40:] = [*tipped.position, *tipped.quaternion]
    assert twice(replace(expected, poses={"block": way}), block=tipped) is None


def test_rounding_does_not_hide_that_a_thing_is_upside_down(expected: Expectation) -> None:
    way = track(STANDS)
    way[:, 3:] = (0.0, 1.0 + 1e-9, 0.0, 0.0)
    found = seen(RunWatch(replace(expected, poses={"block": way})), readings(0.0), readings(0.02))
    assert found is not None and (found.kind, found.measured) == (Deviation.FALLEN, pytest.approx(math.pi))


# What a proof gives


def test_a_proof_says_what_is_loose_and_what_the_hand_holds_when() -> None:
    run = good().rollout
    assert run is not None
    found = expectation(run, ORIGINS)
    assert (
        found.loose == ("block", "cup")
        and found.known == {"floor", "shelf", "block", "cup"}
        and found.steps == ORIGINS
    )
    assert found.held == tuple("block" if TAKEN <= k < OPENED else "" for k in range(len(run.times)))
    assert found.poses.keys() == {"block", "cup", "effector"}
    assert np.allclose(found.in_hand["block"][TAKEN:OPENED], 0.0) and np.allclose(
        found.in_hand["cup"][LANDED], (-0.1, 0.0, 0.0)
    )
    things = tuple(
        replace(t, joint=Joint("slide", Pose(), 0.0, 1.0)) if t.name == "cup" else t for t in run.world.things
    )
    assert expectation(replace(run, world=replace(run.world, things=things)), {}).loose == ("block",)


def test_a_proof_says_how_far_the_arm_and_what_it_holds_get() -> None:
    run = good().rollout
    assert run is not None
    found, size = expectation(run, ORIGINS, UR5E), 2 * max(
        math.dist(c, t.pose.position) for t in run.world.things if not t.furniture for b in boxes(t) for c in b
    )
    hand = math.hypot(*UR5E.gripper.tcp.position)
    assert found.base == run.world.robots[0].base.position and found.reach == pytest.approx(UR5E.reach + hand + size, abs=0.02)
    assert math.isinf(expectation(run, ORIGINS).reach) and math.isinf(expectation(run, ORIGINS, UR5E_MOBILE).reach)


def test_places_in_the_hand_are_in_the_frame_of_the_tool() -> None:
    tool = np.tile([*SIDE.position, *SIDE.quaternion], (100, 1))
    at = SIDE * Pose((0.01, 0.02, -0.1))
    run = posed(effector=tool, cup=np.tile([*at.position, *at.quaternion], (100, 1))).rollout
    assert run is not None
    assert np.allclose(expectation(run, {}).in_hand["cup"], (0.01, 0.02, -0.1))


def test_held_is_what_both_pads_press_and_can_be_carried() -> None:
    def held(*more: Touch) -> str:
        run = touching([90], *more).rollout
        assert run is not None
        return expectation(run, {}).held[90]

    assert held(Touch(LEFT, "cup", 5.0, 0.0), Touch("cup/rim", RIGHT, 5.0, 0.0)) == "cup"
    assert (
        held(Touch(LEFT, "cup", 5.0, 0.0))
        == held(Touch(LEFT, "cup", 5.0, 0.0), Touch("block", RIGHT, 5.0, 0.0))
        == ""
    )
    assert held(Touch(LEFT, "shelf", 5.0, 0.0), Touch("shelf", RIGHT, 5.0, 0.0)) == ""
    both = [Touch(side, thing, 5.0, 0.0) for side in (LEFT, RIGHT) for thing in ("cup", "block")]
    assert held(*both) == "block"


def test_an_expectation_is_itself_alone() -> None:
    """Its arrays are not compared."""
    one = proof()
    assert one == one and one != proof()

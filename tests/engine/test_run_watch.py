"""What is noticed of a run: how far readings may differ from its proof, and after how many of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from helpers.watched_runs import COUNT, PERIOD, SIDE, STANDS, TOOL, kind, proof, readings, seen, track, twice
from msgspec.structs import replace

from cramlite.engine.recovery.expectation import EXACT, Expectation, Noise, RunWatch
from cramlite.model import Deviation, Notice, Pose


@pytest.fixture
def expected() -> Expectation:
    return proof()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, None),
        ({"block": Pose((0.514, 0.0, 0.05))}, None),
        ({"block": Pose((0.516, 0.0, 0.05))}, Deviation.MOVED),
        ({"block": Pose.from_rotvec((0.5, 0.0, 0.05), (math.radians(14), 0, 0))}, None),
        ({"block": Pose.from_rotvec((0.5, 0.0, 0.05), (math.radians(16), 0, 0))}, Deviation.FALLEN),
        ({"block": None}, Deviation.MISSING),
        ({"opening": 0.0781}, None),
        ({"opening": 0.0775}, Deviation.GRIPPER),
        ({"opening": 0.0825}, Deviation.GRIPPER),
        ({"force": 9.9}, None),
        ({"force": 10.1}, Deviation.CONTACT),
        ({"goal": ()}, Deviation.CANCELLED),
        ({"goal": ("x on y",)}, Deviation.GOAL_CHANGED),
        ({"poses": None}, Deviation.READINGS_LOST),
    ],
)
def test_limits_are_where_the_docs_say(
    changed: dict[str, Any], said: Deviation | None, expected: Expectation
) -> None:
    watch = RunWatch(expected)
    assert watch.see(readings(0.0)) is None
    asked = said in (Deviation.CANCELLED, Deviation.GOAL_CHANGED)
    assert (watch.see(readings(0.04, **changed)) is not None) is asked, "one measurement is none"
    found = watch.see(readings(0.08, **changed))
    assert kind(found) is said and watch.notice == found
    assert found is None or found.step == "1.Reaching/move"


@pytest.mark.parametrize(("start", "now", "said"), [
    (3.0, 4.0, None), (3.0, 0.8, Deviation.MOVED), (0.5, 4.0, Deviation.MOVED), (0.5, 0.8, Deviation.MOVED),
])  # fmt: skip
def test_what_the_arm_can_meet_neither_then_nor_now_stops_no_run(
    start: float, now: float, said: Deviation | None, expected: Expectation
) -> None:
    far = replace(expected, base=(0.0, 0.0, 0.0), reach=1.5, poses=expected.poses | {"block": track(Pose((start, 0.0, 0.05)))})
    there, here = (Pose((x, 0.0, 0.05)) for x in (start, now))
    assert kind(seen(RunWatch(far), readings(0.0, block=there), *(readings(k, block=here) for k in (0.02, 0.04)))) is said


def test_it_is_noticed_in_a_tenth_of_a_second(expected: Expectation) -> None:
    assert 0.0 < 2 * RunWatch(expected).period < 0.1


def test_only_the_same_twice_in_a_row_is_noticed(expected: Expectation) -> None:
    moved, felt = {"block": Pose((0.6, 0.0, 0.05))}, {"force": 50.0}
    turns = [readings(0.02 * k, **(moved if k % 2 else felt)) for k in range(8)]
    assert seen(RunWatch(expected), *turns) is None
    assert kind(seen(RunWatch(expected), *turns, replace(turns[-1], time=0.16))) is Deviation.MOVED
    now_and_then = [readings(0.02 * k, **({} if k % 2 else felt)) for k in range(8)]
    assert seen(RunWatch(expected), *now_and_then) is None


def test_what_deviates_by_two_is_told_by_the_more_important(expected: Expectation) -> None:
    both = {"block": Pose((0.6, 0.0, 0.05)), "force": 50.0}
    assert kind(twice(expected, opening=0.07, **both)) is Deviation.GRIPPER
    assert kind(twice(expected, **both)) is Deviation.MOVED


# What is in the hand


def carried(expected: Expectation, held: Sequence[str] = ("block",) * COUNT) -> Expectation:
    """The proof, in which a block hangs 100 mm below the tool, and is elsewhere in the world."""
    local = np.tile([0.0, 0.0, -0.1], (COUNT, 1))
    return replace(
        expected, held=tuple(held), in_hand={"block": local}, poses={"block": track(Pose((2.0, 2.0, 2.0)))}
    )




@pytest.mark.parametrize(
    ("off", "said"),
    [(0.014, None), (0.016, Deviation.SLIP), (0.049, Deviation.SLIP), (0.051, Deviation.GRASP_LOST)],
)
def test_what_is_held_is_compared_in_the_hand(
    off: float, said: Deviation | None, expected: Expectation
) -> None:
    there = SIDE * Pose((off, 0.0, -0.1))
    first = readings(0.0, tool=SIDE, block=SIDE * Pose((0.0, 0.0, -0.1)))
    found = seen(
        RunWatch(carried(expected)), first, *(readings(k, tool=SIDE, block=there) for k in (0.02, 0.04))
    )
    assert kind(found) is said
    assert found is None or (found.thing, found.measured, found.unit) == ("block", pytest.approx(off), "m")


def test_it_is_said_from_where_a_thing_moved(expected: Expectation) -> None:
    there = TOOL * Pose((0.02, 0.0, -0.1))
    held = seen(RunWatch(carried(expected)), *(readings(k, block=there) for k in (0.02, 0.04)))
    assert held is not None and held.reason == "'block' is 20 mm from its place in the hand, more than 15 mm"
    stood = twice(expected, block=Pose((0.5, 0.02, 0.05)))
    assert stood is not None and stood.reason == "'block' is 20 mm from where it should be, more than 15 mm"


@pytest.mark.parametrize(("off", "said"), [(0.0, None), (0.02, Deviation.MOVED)])
def test_a_thing_at_a_corrected_pose_is_expected_as_far_from_its_reading(
    expected: Expectation, off: float, said: Deviation | None
) -> None:
    """It lies on its side where it was read, 40 mm from where it is believed to stand."""
    read = Pose.from_rotvec((0.54, 0.0, 0.05), (1.2, 0.0, 0.0))
    watch = RunWatch(expected, offsets={"block": read.inverse() * STANDS})
    assert kind(seen(watch, *(readings(0.02 * k, block=Pose((0.0, 0.0, off)) * read) for k in range(2)))) is said


def test_what_is_held_may_lean_in_the_hand(expected: Expectation) -> None:
    """Where it is in the hand is asked, not how it is turned."""
    tilted = SIDE * Pose.from_rotvec((0.0, 0.0, -0.1), (0.5, 0.0, 0.0))
    assert (
        seen(RunWatch(carried(expected)), *(readings(0.02 * k, tool=SIDE, block=tilted) for k in range(4)))
        is None
    )


def test_what_is_held_for_a_while_may_be_in_the_hand_or_where_it_stood(expected: Expectation) -> None:
    half = carried(expected, ("",) * 25 + ("block",) * 26)
    stood = Pose((2.0, 2.0, 2.0))
    for pose, passes in (
        (stood, True),
        (TOOL * Pose((0.0, 0.0, -0.1)), True),
        (TOOL * Pose((0.02, 0.0, -0.1)), False),
    ):
        found = seen(RunWatch(half), *(readings(0.02 * k, block=pose) for k in range(2)))
        assert kind(found) is (None if passes else Deviation.MOVED)


def test_a_line_of_one_sample_with_a_thing_in_the_hand_holds_it(expected: Expectation) -> None:
    one = replace(carried(expected), lines=np.repeat([2.0, 1.0, 3.0], [25, 1, 25]))
    far = TOOL * Pose((0.06, 0.0, -0.1))
    assert (
        kind(seen(RunWatch(one), *(readings(k * 0.02, block=far) for k in range(2)))) is Deviation.GRASP_LOST
    )


def test_in_a_line_that_the_proof_does_not_show_nothing_is_held_all_through(expected: Expectation) -> None:
    shown = carried(expected)
    assert (
        seen(RunWatch(shown), *(readings(0.02 * k, line=9, block=Pose((2.0, 2.0, 2.0))) for k in range(4)))
        is None
    )
    assert kind(twice(expected, line=9, opening=0.07)) is Deviation.GRIPPER


# The fingers


def test_fingers_that_are_too_near_hold_nothing_where_the_proof_held_something(expected: Expectation) -> None:
    """They are compared with what of the proof is nearest: open at first, and 50 mm apart then."""
    closes = replace(expected, held=("",) * 25 + ("block",) * 26, opening=np.repeat([0.08, 0.05], [25, 26]))
    for wide, said, thing in (
        (0.04, Deviation.NO_GRASP, "block"), (0.058, Deviation.GRIPPER, ""),
        (0.072, Deviation.NO_GRASP, "block"),
        (0.09, Deviation.GRIPPER, ""), (0.0485, None, ""), (0.0515, None, ""),
    ):  # fmt: skip
        found = twice(closes, opening=wide)
        assert kind(found) is said
        if found is not None:
            near = min((0.08, 0.05), key=lambda w: abs(w - wide))
            assert (found.thing, found.unit, found.limit) == (thing, "m", pytest.approx(0.002))
            assert (
                found.measured == pytest.approx(abs(wide - near))
                and f"{1000 * near:.1f} mm in the proof" in found.reason
            )


def test_before_the_first_line_fingers_may_be_anywhere(expected: Expectation) -> None:
    assert twice(expected, line=0, opening=0.0) is None


@pytest.mark.parametrize(
    ("at", "thing"), [(0.12, "zebra"), (0.485, "zebra"), (0.495, "apple"), (0.88, "apple")]
)
@pytest.mark.parametrize("began", [0.0, 7.0])
def test_a_lost_thing_is_the_one_that_was_held_then(
    expected: Expectation, at: float, thing: str, began: float
) -> None:
    def lost(held: tuple[str, ...], line: int = 1) -> Notice | None:
        watch = RunWatch(replace(expected, held=held))
        assert not any(watch.see(readings(began + 0.02 * k, line=line)) for k in range(4))
        gone = (0.005, 0.0) if thing == "zebra" else (0.0, -0.03)
        found = [watch.see(readings(began + at - by, line=line, opening=0.07)) for by in gone]
        return found[1]

    found = lost(("zebra",) * 25 + ("apple",) * 26)
    assert found is not None and (found.kind, found.thing) == (Deviation.GRASP_LOST, thing)
    found = lost(("zebra",) * 10 + ("",) * 15 + ("apple",) * 26)
    nearer = "zebra" if at < (9 + 25) * PERIOD / 2 else "apple"
    assert found is not None and (found.kind, found.thing) == (Deviation.NO_GRASP, nearer)


def test_a_thing_lost_as_a_line_begins_is_what_that_held_first(expected: Expectation) -> None:
    late = replace(
        expected, held=("",) * 20 + ("zebra",) * 5 + ("apple",) * 26, lines=np.repeat([1.0, 2.0], [20, 31])
    )
    found = seen(
        RunWatch(late), readings(7.0), *(readings(7.02 + 0.02 * k, line=2, opening=0.07) for k in range(2))
    )
    assert found is not None and (found.kind, found.thing) == (Deviation.GRASP_LOST, "zebra")


def test_a_thing_missed_as_a_line_begins_is_not_one_that_was_held_before(expected: Expectation) -> None:
    held = ("",) * 15 + ("mug",) * 5 + ("zebra",) * 5 + ("",) * 26
    late = replace(expected, held=held, lines=np.repeat([1.0, 2.0], [20, 31]))
    closed = (readings(k, line=2, opening=0.07) for k in (7.02, 7.04))
    found = seen(RunWatch(late), readings(7.0), *closed)
    assert found is not None and (found.kind, found.thing) == (Deviation.NO_GRASP, "zebra")


def test_in_a_line_that_the_proof_does_not_show_the_time_says_what_was_held(expected: Expectation) -> None:
    both = replace(expected, held=("zebra",) * 10 + ("",) * 15 + ("apple",) * 26)
    for began, thing in ((0.1, "zebra"), (0.8, "apple")):
        found = twice(both, began=began, line=9, opening=0.07)
        assert found is not None and (found.kind, found.thing) == (Deviation.NO_GRASP, thing)


# What is felt, and how long it lasts


@pytest.mark.parametrize(("most", "limit"), [(0.0, 10.0), (4.0, 14.0), (40.0, 60.0)])
def test_what_is_felt_is_ten_newtons_or_half_of_it_more_than_in_the_proof(
    most: float, limit: float, expected: Expectation
) -> None:
    force = np.zeros(COUNT)
    force[30] = most
    pressed = replace(expected, force=force)
    assert twice(pressed, force=limit - 0.1) is None
    found = twice(pressed, force=limit + 0.1)
    assert found is not None and (found.kind, found.unit) == (Deviation.CONTACT, "N")
    assert (found.measured, found.limit) == (pytest.approx(limit + 0.1), pytest.approx(limit))


@pytest.mark.parametrize(("line", "limit"), [(1, 3.5), (9, 2.0)])
@pytest.mark.parametrize("began", [0.0, 7.0])
def test_a_line_may_take_half_as_long_again_and_two_seconds_more(
    line: int, limit: float, began: float, expected: Expectation
) -> None:
    on_time = [readings(began + k, line=line) for k in (0.0, limit - 0.04, limit - 0.02)]
    assert seen(RunWatch(expected), *on_time) is None
    found = seen(
        RunWatch(expected), *on_time, *(readings(began + limit + k, line=line) for k in (0.02, 0.04))
    )
    assert found is not None and (found.kind, found.unit) == (Deviation.STUCK, "s")
    assert (found.measured, found.limit) == (pytest.approx(limit + 0.04), pytest.approx(limit))


def test_each_line_has_its_own_time_and_before_the_first_there_is_none(expected: Expectation) -> None:
    lines = [readings(1.9 * k, line=8 + k) for k in range(5)]
    assert seen(RunWatch(expected), *lines) is None
    assert seen(RunWatch(expected), *(readings(3.0 * k, line=0) for k in range(5))) is None


# Readings that are wrong


FROZEN = {"joints": (0.3,)}


def test_the_same_for_half_a_second_is_frozen_while_the_arm_should_move(expected: Expectation) -> None:
    """Times are exact in binary: it is frozen at 7.5 s, and noticed by the reading after that."""
    said = [readings(7.0 + k, **FROZEN) for k in (0.0, 0.25, 0.46875, 0.484375)]
    assert seen(RunWatch(expected), *said) is None
    found = seen(RunWatch(expected), *(readings(7.0 + k, **FROZEN) for k in (0.0, 0.25, 0.5, 0.75)))
    assert found is not None and found.kind is Deviation.READINGS_FROZEN
    assert (found.measured, found.limit, found.unit) == (0.75, 0.5, "s")


def test_the_time_of_frozen_readings_begins_with_the_last_change(expected: Expectation) -> None:
    moved = [
        readings(k, joints=(joint,))
        for k, joint in ((0.0, 0.3), (0.25, 0.3), (0.375, 0.4), (0.5, 0.4), (0.625, 0.4), (0.75, 0.4))
    ]
    assert seen(RunWatch(expected), *moved) is None


@pytest.mark.parametrize(("way", "frozen"), [(0.019, False), (0.021, True)])
def test_an_arm_that_should_stand_still_is_not_frozen(
    way: float, frozen: bool, expected: Expectation
) -> None:
    joints = np.column_stack([np.full(COUNT, 2.0), np.linspace(1.0, 1.0 + way, COUNT)])
    found = [RunWatch(replace(expected, joints=joints))]
    assert (
        kind(seen(found[0], *(readings(k, joints=(2.0, 1.0)) for k in (0.0, 0.25, 0.5, 0.75)))) is not None
    ) is frozen
    unknown = [readings(k, line=9, **FROZEN) for k in (0.0, 0.25, 0.5, 0.75)]
    assert seen(RunWatch(expected), *unknown) is None


def test_lost_readings_are_not_frozen_ones(expected: Expectation) -> None:
    watch = RunWatch(expected, Noise(0.001, 0.001, 0.1))
    found = [watch.see(readings(0.125 * k, poses=None, **FROZEN)) for k in range(10)]
    assert [kind(f) for f in found] == [None] + [Deviation.READINGS_LOST] * 9
    back = [watch.see(readings(1.25 + 0.125 * k, **FROZEN)) for k in range(3)]
    assert not any(back), "they count from when they are back"


def test_a_goal_that_is_followed_already_is_no_other(expected: Expectation) -> None:
    followed = RunWatch(expected, asked=("x on y",))
    assert not any(followed.see(readings(0.04 * k, goal=("x on y",))) for k in range(3))
    found = followed.see(readings(0.2, goal=()))
    assert found is not None and (found.kind, found.reason) == (Deviation.CANCELLED, "the task was cancelled")
    other = RunWatch(expected).see(readings(0.0, goal=("x on y", "y in z")))
    assert other is not None and (other.kind, other.reason) == (Deviation.GOAL_CHANGED, "x on y and y in z")


# Noise


def test_noise_raises_no_alarm(expected: Expectation) -> None:
    watch = RunWatch(expected, Noise(0.004, 0.03, 2.0), seed=3)
    assert not any(watch.see(readings(0.04 * k)) for k in range(25))


def test_noise_widens_each_limit_by_five_of_its_deviations(expected: Expectation) -> None:
    noise = Noise(0.001, 0.002, 0.3)
    tilted = Pose.from_rotvec(STANDS.position, (0.6, 0.0, 0.0))
    for changed, limit in (
        ({"block": Pose((0.6, 0.0, 0.05))}, 0.015 + 0.005), ({"block": tilted}, math.radians(15.0) + 0.01),
        ({"force": 30.0}, 10.0 + 1.5),
    ):  # fmt: skip
        found = twice(expected, noise, **changed)
        assert found is not None and found.limit == pytest.approx(limit)


@pytest.mark.parametrize("noise", [Noise(position=0.001), Noise(turn=0.001), Noise(force=0.1)])
def test_noise_is_drawn_for_what_has_some_about_what_is_so(noise: Noise, expected: Expectation) -> None:
    watch, exact = (
        RunWatch(expected, noise),
        readings(0.0, force=5.0, block=Pose.from_rotvec(STANDS.position, (0.3, 0.1, 0.2))),
    )
    drawn = []
    for _ in range(20):
        watch.rest(exact)
        assert watch.last is not None and watch.last.poses is not None and exact.poses is not None
        turn = (exact.poses["block"].inverse() * watch.last.poses["block"]).rotvec
        way = np.subtract(watch.last.poses["block"].position, exact.poses["block"].position)
        drawn.append([*way, *turn, watch.last.force - 5.0])
    sizes = np.repeat([noise.position, noise.turn, noise.force], [3, 3, 1])
    spread = np.std(drawn, axis=0)
    assert np.allclose(spread[sizes == 0], 0.0, atol=1e-8) and np.all(
        spread[sizes > 0] > 0.4 * sizes[sizes > 0]
    )
    assert np.all(np.abs(np.mean(drawn, axis=0)) < sizes + 1e-8)


def test_what_is_read_at_rest_is_kept(expected: Expectation) -> None:
    one, lost = readings(0.0), readings(1.0, poses=None)
    for noise in (EXACT, Noise(0.001, 0.001, 0.1)):
        watch = RunWatch(expected, noise)
        watch.rest(lost)
        assert watch.last is lost
        watch.rest(one)
        assert (watch.last == one) is (noise is EXACT)



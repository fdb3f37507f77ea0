"""What is in the hand: two pads, one thing that can be moved, long enough, between fingers that are not closed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from helpers.short_runs import COUNT, LEFT, OPENED, RIGHT, STEP, TAKEN, good, touching
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Rollout, Swing, Touch
from cramlite.plugin import Candidate
from cramlite_plugins.validators.grips import Grip, grips, held_at, pressed_at, slip
from cramlite_plugins.validators.swings import Turn


def ran(candidate: Candidate) -> Rollout:
    assert candidate.rollout is not None
    return candidate.rollout


def pads(touch: Touch) -> bool:
    return bool({LEFT, RIGHT} & {touch.a, touch.b})


def pressed_for(samples: int, *touches: Touch) -> Rollout:
    """A run in which the pads press for some samples alone."""
    base = ran(touching(range(COUNT), without=pads))
    rows = tuple((*row, *touches) if 20 <= k < 20 + samples else row for k, row in enumerate(base.touches))
    return replace(base, touches=rows, opening=np.full(COUNT, 0.06))


BOTH = (Touch(LEFT, "cup", 5.0, 0.0), Touch("cup", RIGHT, 5.0, 0.0))


def test_a_grip_is_from_the_first_to_the_last_sample_of_both_pads() -> None:
    rollout = ran(good())
    assert grips(rollout) == [Grip("block", TAKEN, OPENED - 1)]
    assert held_at(rollout) == [""] * TAKEN + ["block"] * (OPENED - TAKEN) + [""] * (COUNT - OPENED)


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_one_pad_is_no_grip(side: str) -> None:
    assert grips(ran(touching(range(COUNT), without=lambda t: side in (t.a, t.b)))) == []


def test_pads_that_press_from_the_first_sample_or_for_one_sample_alone_are_a_pressing() -> None:
    base = pressed_for(10, *BOTH)
    first = replace(base, touches=(*base.touches[20:], *base.touches[:20]))
    assert grips(first) == [Grip("cup", 0, 9)]
    rows = ((*base.touches[0], *BOTH), *((t for t in row if not pads(t)) for row in base.touches[1:]))
    alone = replace(base, touches=tuple(tuple(row) for row in rows), times=np.arange(COUNT) * 1.0)
    assert grips(alone) == []
    then = replace(alone, touches=(alone.touches[0], *base.touches[20:30], *alone.touches[11:]))
    assert grips(then) == [Grip("cup", 0, 10)]


def test_a_short_press_of_another_thing_late_in_a_run_is_no_grip() -> None:
    base = ran(touching(range(90, 92), *BOTH))
    assert [g.thing for g in grips(base)] == ["block"]


def test_pads_that_press_different_things_grip_neither() -> None:
    other = touching(range(COUNT), Touch(RIGHT, "cup", 5.0, 0.0), without=lambda t: RIGHT in (t.a, t.b))
    assert grips(ran(other)) == []


def test_pads_that_press_each_other_hold_nothing() -> None:
    assert grips(pressed_for(10, Touch(LEFT, RIGHT, 5.0, 0.0))) == []


def test_parts_of_a_thing_are_that_thing() -> None:
    assert grips(pressed_for(10, Touch(LEFT, "cup/rim", 5.0, 0.0), Touch("cup/wall", RIGHT, 5.0, 0.0))) == [Grip("cup", 20, 29)]


@pytest.mark.parametrize(("samples", "grip"), [(5, True), (4, False)])
def test_a_brush_in_passing_is_shorter(samples: int, grip: bool) -> None:
    quarter = replace(pressed_for(samples, *BOTH), times=(np.arange(COUNT) - 20) / 20.0)  # 0.2 s are four steps
    assert bool(grips(quarter)) is grip and pressed_at(quarter)[20] == "cup"


@pytest.mark.parametrize(("opening", "holds"), [(0.0011, True), (0.001, False)])
def test_closed_fingers_hold_nothing(opening: float, holds: bool) -> None:
    thin = replace(pressed_for(10, *BOTH), opening=np.full(COUNT, opening))
    assert bool(grips(thin)) is holds and (pressed_at(thin)[25] == "cup") is holds


def test_what_is_fixed_to_the_world_is_not_held() -> None:
    assert grips(pressed_for(10, Touch(LEFT, "shelf", 5.0, 0.0), Touch("shelf", RIGHT, 5.0, 0.0))) == []


def test_a_drawer_is_held_though_it_is_fixed_to_its_cabinet() -> None:
    from cramlite.model import Pose
    from cramlite_plugins.objects.furniture import cabinet, drawer

    pulled = pressed_for(10, Touch(LEFT, "d", 5.0, 0.0), Touch("d", RIGHT, 5.0, 0.0))
    things = (cabinet("c", Pose((0.7, 0, 0.3))), drawer("d", Pose((0.7, 0, 0.3)), "c"))
    assert [g.thing for g in grips(replace(pulled, world=replace(pulled.world, things=things)))] == ["d"]


def lost(opening: Callable[[Floats], None], thing: str = "block", first: int = 40, last: int = 45) -> list[Grip]:
    """The grips of a run whose pads lose the thing for some samples, and press one again."""
    base = ran(touching(range(first, last), without=pads))
    opened = base.opening.copy()
    opening(opened)
    rows = tuple(
        tuple(replace(t, a=t.a.replace("block", thing), b=t.b.replace("block", thing)) if pads(t) else t for t in row) if k >= last else row
        for k, row in enumerate(base.touches)
    )
    return grips(replace(base, touches=rows, opening=opened))


@pytest.mark.parametrize(("wider", "one"), [(0.0019, True), (0.0021, False)])
def test_what_slips_is_one_grip_until_the_fingers_open(wider: float, one: bool) -> None:
    def opened(opening: Floats) -> None:
        opening[42] += wider

    assert (lost(opened) == [Grip("block", TAKEN, OPENED - 1)]) is one
    assert one or lost(opened) == [Grip("block", TAKEN, 39), Grip("block", 45, OPENED - 1)]


@pytest.mark.parametrize("sample", [39, 45])
def test_they_have_opened_also_at_the_last_and_first_sample_of_the_grips(sample: int) -> None:
    def opened(opening: Floats) -> None:
        opening[sample] += 0.01

    assert len(lost(opened)) == 2


@pytest.mark.parametrize("sample", [38, 46])
def test_what_the_fingers_do_while_they_hold_is_no_opening(sample: int) -> None:
    def opened(opening: Floats) -> None:
        opening[sample] += 0.01

    assert len(lost(opened)) == 1


def test_another_thing_is_another_grip() -> None:
    assert lost(lambda _: None, "cup") == [Grip("block", TAKEN, 39), Grip("cup", 45, OPENED - 1)]


def test_a_touch_after_a_grip_belongs_to_it_however_short() -> None:
    assert lost(lambda _: None, first=40, last=69) == [Grip("block", TAKEN, OPENED - 1)]


def test_a_grip_that_lasts_to_the_end_is_one() -> None:
    base = pressed_for(80, *BOTH)
    assert grips(base) == [Grip("cup", 20, COUNT - 1)]


@pytest.mark.parametrize(("first", "last", "rows"), [(TAKEN, OPENED - 1, 56), (20, 24, 3), (20, 26, 3), (20, 27, 4)])
def test_a_tenth_of_a_second_at_each_end_of_a_grip_is_left_out_and_no_more_than_a_third(first: int, last: int, rows: int) -> None:
    assert STEP == 0.05 and len(slip(ran(good()), Grip("block", first, last))) == rows


def test_slip_is_from_where_the_grip_began() -> None:
    rollout = ran(good())
    poses = {**rollout.poses, "block": rollout.poses["block"] + np.outer(np.arange(COUNT) * 0.001, (1, 0, 0, 0, 0, 0, 0))}
    moved = slip(replace(rollout, poses=poses), Grip("block", TAKEN, OPENED - 1))
    assert np.allclose(moved, np.arange(56) * 0.001)


@pytest.mark.parametrize(("first", "still"), [(28, True), (30, True), (31, False)])
def test_a_turn_excuses_what_moves_in_the_hand_from_its_first_sample_on(first: int, still: bool) -> None:
    """The block leaps by 30 mm at sample 30, as far as the declared turn leads it."""
    rollout = ran(good())
    block = rollout.poses["block"].copy()
    held = block[30, :3] - rollout.poses["effector"][30, :3]
    block[30:, 0] += 0.03
    swing = Swing(Pose(tuple(held)), Pose((held[0] + 0.03, held[1], held[2])), (0.0, 0.0, 0.0))
    moved = slip(replace(rollout, poses={**rollout.poses, "block": block}), Grip("block", TAKEN, OPENED - 1), [Turn(swing, first, 32)])
    assert bool(moved.max() < 0.001) is still


# Fingers between two pressings


def pressed_twice(*openings: float, thing: str = "cup") -> list[Grip]:
    """The grips of a run of a sample a second: two samples pressed, one lost, two pressed; with these openings."""
    base = replace(pressed_for(0, *BOTH), times=np.arange(COUNT) * 1.0)
    rows = tuple(BOTH if k in (20, 21, 23, 24) else row for k, row in enumerate(base.touches))
    opening = np.full(COUNT, 0.06)
    opening[20 : 20 + len(openings)] = openings
    return grips(replace(base, touches=rows, opening=opening))


@pytest.mark.parametrize(
    ("openings", "one"),
    [
        ((0.060, 0.060, 0.090, 0.060, 0.060), False),
        ((0.060, 0.063, 0.063, 0.060, 0.060), True),  # the middle of both samples counts: 61.5 mm
        ((0.060, 0.0612, 0.0627, 0.060, 0.060), False),  # and not of the one after them: 60.6 mm
        ((0.002, 0.002, 0.004, 0.002, 0.002), True),  # exactly as far is not further
    ],
)
def test_fingers_have_opened_against_the_middle_of_what_they_held_at(openings: tuple[float, ...], one: bool) -> None:
    assert pressed_twice(*openings) == ([Grip("cup", 20, 24)] if one else [Grip("cup", 20, 21), Grip("cup", 23, 24)])


def test_what_is_pressed_again_belongs_to_the_last_grip() -> None:
    base = ran(touching(range(80, 96), *BOTH))
    rows = tuple(tuple(t for t in row if not pads(t)) if k == 88 else row for k, row in enumerate(base.touches))
    assert grips(replace(base, touches=rows)) == [Grip("block", TAKEN, OPENED - 1), Grip("cup", 80, 95)]

"""How hard a thing may be gripped: by what the gripper is told, and by what its pads press for longer than they chatter."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_runs import COUNT, LEFT, OPENED, RIGHT, TAKEN, good, said, touching
from msgspec.structs import replace

from cramlite.model import Finding, Touch
from cramlite.plugin import Candidate
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.validators.grip_limits import GripLimits, half_a_step, pressed_with, validators

ROUNDED = half_a_step(UR5E.gripper)


def bearing(newtons: float | None, candidate: Candidate, known: bool = True, real: bool = True) -> Candidate:
    """The candidate, whose block bears so much, as is believed or as it is."""
    assert candidate.rollout is not None
    things = tuple(replace(t, max_grip_force=newtons) if t.name == "block" else t for t in candidate.world.things)
    world = replace(candidate.world, things=things)
    return replace(
        candidate, world=world if known else candidate.world,
        rollout=replace(candidate.rollout, world=world if real else candidate.world),
    )  # fmt: skip


def ordered(newtons: float, first: int = TAKEN, end: int = OPENED) -> Candidate:
    """The run in which the gripper is told to press with so much; its pads press with 50 N."""
    grip = np.zeros(COUNT)
    grip[first:end] = newtons
    return good(grip=grip)


def pressing(newtons: float, count: int, *more: Touch) -> Candidate:
    """The run in which the left pad presses the block with so much at a few samples, the first at 30."""
    rows = range(30, 30 + count)
    return touching(rows, Touch(LEFT, "block", newtons, 1.0), *more, without=lambda t: t.a == LEFT)


def findings(candidate: Candidate) -> tuple[Finding, Finding]:
    told, pressed = GripLimits().check(candidate)
    return told, pressed


def test_it_is_asked() -> None:
    assert [v.name for v in validators()] == ["grip_limits"]


def test_what_bears_anything_is_gripped_with_anything() -> None:
    assert list(GripLimits().check(ordered(235.0))) == []


@pytest.mark.parametrize(("newtons", "passes"), [(80.0, True), (80.0 + ROUNDED, True), (80.01 + ROUNDED, False), (235.0, False)])
def test_no_more_is_told_than_a_thing_bears(newtons: float, passes: bool) -> None:
    told, pressed = findings(bearing(80.0, ordered(newtons)))
    assert told.passed is passes and pressed.passed and (told.limit, told.unit, told.origin) == (80.0, "N", "1.Grasping")
    assert told.reason == f"the gripper was told to press 'block' with {newtons:.1f} N at 0.5 s, limit 80 N (the max_grip_force of 'block')"


@pytest.mark.parametrize("known", [True, False])
def test_a_limit_that_is_believed_or_real_holds(known: bool) -> None:
    assert not findings(bearing(80.0, ordered(90.0), known=known, real=not known))[0].passed


def test_a_limit_of_its_class_holds_too() -> None:
    fragile = ordered(31.0)
    things = tuple(replace(t, type="soma:Glass") if t.name == "block" else t for t in fragile.world.things)
    glass = replace(fragile, world=replace(fragile.world, things=things))
    told, _ = findings(glass)
    assert not told.passed and told.limit == 30.0 and "cram:FragileObject" in told.reason
    for own, lower in ((25.0, 25.0), (35.0, 30.0)):
        assert findings(bearing(own, glass, known=False))[0].limit == lower


def test_what_is_told_while_nothing_is_between_the_pads_presses_nothing() -> None:
    assert findings(bearing(80.0, ordered(235.0, OPENED, COUNT)))[0].value == 0.0


def test_a_register_rounds_by_half_a_step() -> None:
    """Of 255 between 20 and 235 N."""
    assert pytest.approx(215 / 510, abs=1e-6) == ROUNDED > 215 / 510


@pytest.mark.parametrize(("newtons", "passes"), [(71.9, True), (72.1, False)])
def test_what_a_pad_presses_may_be_a_fifth_more(newtons: float, passes: bool) -> None:
    told, pressed = findings(bearing(60.0, pressing(newtons, 5)))
    assert told.passed and pressed.passed is passes and pressed.limit == pytest.approx(72.0)
    assert pressed.reason == f"a pad pressed 'block' with {newtons:.1f} N at 1.5 s, limit 72 N (the max_grip_force of 'block')" or passes


@pytest.mark.parametrize(("count", "passes"), [(1, True), (2, True), (3, False)])
def test_fingers_that_close_may_hit_it_harder_for_a_moment(count: int, passes: bool) -> None:
    """Three samples last 0.1 s."""
    assert findings(bearing(60.0, pressing(200.0, count)))[1].passed is passes


def test_points_that_face_apart_press_no_harder_than_their_sum() -> None:
    wedge = Touch(LEFT, "block", 100.0, 1.0, press=50.0)
    assert findings(bearing(50.0, touching(range(30, 40), wedge, without=lambda t: t.a == LEFT)))[1].passed


def test_each_pad_counts_for_itself_with_all_that_it_presses() -> None:
    run = touching(range(30, 31), Touch("block/rim", RIGHT, 30.0, 0.0)).rollout
    assert run is not None
    assert pressed_with(run, "block")[29:32].tolist() == [50.0, 80.0, 50.0] and pressed_with(run, "block")[0] == 0.0


def test_where_no_controller_ran_only_what_was_pressed_is_judged() -> None:
    assert said(GripLimits(), bearing(60.0, good(grip=None))) == [] and said(GripLimits(), bearing(30.0, good(grip=None))) != []

"""What the arm is told that it carries: just inside what it may be off by and just outside, in time and late."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_runs import COUNT, LIFTED, OPENED, TAKEN, good, lying, only, posed, track
from msgspec.structs import replace

from cramlite.model import Floats, Joint, Thing, Touch
from cramlite.plugin import Candidate
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.validators.payload import Payload, validators

EMPTY, BLOCK = UR5E.gripper.mass, 0.2
LIMIT = 0.1 * (EMPTY + BLOCK)


def told(*changes: tuple[int, float]) -> Floats:
    """(COUNT,) what is told from samples on [kg]; before the program begins nothing."""
    payload = np.zeros(COUNT)
    for sample, mass in ((2, EMPTY), *changes):
        payload[sample:] = mass
    return payload


def telling(mass: float, grasped: int = TAKEN + 3, opened: int = OPENED + 6) -> Candidate:
    """The run in which a mass is told once the block is grasped, and the gripper's when it was let go."""
    return good(payload=told((grasped, mass), (opened, EMPTY)))


def weighing(mass: float, candidate: Candidate, thing: str = "block") -> Candidate:
    """The candidate, whose thing is believed to weigh so much."""
    things = tuple(replace(t, mass=mass) if t.name == thing else t for t in candidate.world.things)
    return replace(candidate, world=replace(candidate.world, things=things))


def test_it_is_asked() -> None:
    assert [v.name for v in validators()] == ["payload"]


def test_what_is_told_in_time_passes() -> None:
    found = only(Payload(), telling(EMPTY + BLOCK))
    assert found.passed and found.reason == "the arm was told what hangs on it: off by 0.00 kg, limit 0.10 kg"


@pytest.mark.parametrize(("off", "passes"), [(0.99, True), (-0.99, True), (1.01, False), (-1.01, False)])
def test_it_may_be_off_by_a_tenth(off: float, passes: bool) -> None:
    found = only(Payload(), telling(EMPTY + BLOCK + off * LIMIT))
    assert found.passed is passes and found.value == pytest.approx(abs(off) * LIMIT) and found.limit == pytest.approx(LIMIT)


@pytest.mark.parametrize("share", [0.95, 1.05])
def test_five_percent_off_is_harmless(share: float) -> None:
    assert only(Payload(), weighing(1.1, telling(share * (EMPTY + 1.1)))).passed


def test_four_kilograms_for_one_are_not() -> None:
    found = only(Payload(), weighing(1.1, telling(EMPTY + 4.0)))
    assert not found.passed and found.origin == "1.Grasping" and not found.places
    assert "told that 4.92 kg hang on it at 0.7 s, and still 1 s later" in found.reason
    assert "instead of 2.03 kg of the gripper and 'block'" in found.reason


@pytest.mark.parametrize(("late", "passes"), [(6, True), (20, True), (21, False)])
def test_it_is_told_in_time(late: int, passes: bool) -> None:
    """20 samples are a second; what stands on the floor hangs with any part of its weight."""
    assert only(Payload(), telling(EMPTY + BLOCK, grasped=LIFTED + late)).passed is passes
    assert only(Payload(), telling(EMPTY + BLOCK, opened=OPENED + late)).passed is passes


def test_what_is_lifted_without_being_told_is_an_objection() -> None:
    found = only(Payload(), good(payload=told()))
    assert not found.passed and f"{EMPTY + BLOCK:.2f} kg of the gripper and 'block'" in found.reason
    assert only(Payload(), weighing(0.05, good(payload=told()))).passed, "nobody feels what is lighter"


def test_what_is_told_for_an_empty_hand_is_an_objection_too() -> None:
    found = only(Payload(), telling(EMPTY + BLOCK, opened=COUNT))
    assert not found.passed and f"the gripper's {EMPTY:.2f} kg" in found.reason


def test_a_text_that_tells_nothing_leaves_it_to_the_controller() -> None:
    found = only(Payload(), good(payload=np.zeros(COUNT)))
    assert found.passed and found.reason.endswith("the controller uses the payload of its own settings")
    base = good(payload=np.zeros(COUNT))
    found = only(Payload(), replace(base, program=replace(base.program, mass=EMPTY)))
    assert not found.passed and found.reason.endswith(f"the program that was proven begins with {EMPTY:.2f} kg") and not found.places


def test_where_no_controller_ran_nothing_is_said() -> None:
    assert list(Payload().check(good(payload=None))) == []


def with_tin(carried: bool) -> Candidate:
    """The run in which a tin of 0.5 kg stands on the block, and turns with it, or stays where it was; 1.6 kg are told."""
    base = telling(EMPTY + BLOCK + 0.5)
    assert base.rollout is not None
    tin, on, half = lying("tin", (0.55, 0.2, 0.09), mass=0.5), Touch("block", "tin", 4.9, 4.9), np.sqrt(0.5)
    touches = tuple((*row, on) if 35 < k < 45 else row for k, row in enumerate(base.rollout.touches))
    block = base.rollout.poses["block"].copy()
    block[50:, 3:] = (half, 0.0, 0.0, half)
    beside = np.where(np.arange(COUNT)[:, None] < 50, (0.05, 0.0, 0.06), (0.0, 0.05, 0.06))
    track_ = np.hstack([block[:, :3] + beside, block[:, 3:]]) if carried else track((0, tin.pose.position))
    world = replace(base.world, things=(*base.world.things, tin))
    poses = {**base.rollout.poses, "block": block, "tin": track_}
    return replace(base, world=world, rollout=replace(base.rollout, world=world, touches=touches, poses=poses))


def test_what_a_thing_carries_hangs_there_with_it() -> None:
    assert only(Payload(), with_tin(carried=True)).passed
    found = only(Payload(), with_tin(carried=False))
    assert not found.passed and "of the gripper and 'block'" in found.reason


def test_what_stands_elsewhere_does_not_hang_there() -> None:
    """The hand closes on a block that stays where it is, as do the cup and the floor under it."""
    still = posed(block=track((0, (0.5, 0.2, 0.03))))
    assert still.rollout is not None
    floor = Touch("floor", "block", 2.0, 2.0)
    touches = tuple((*row, floor) for row in still.rollout.touches)
    for more, passes in ((0.0, True), (0.2, False)):
        payload = told((TAKEN, EMPTY + BLOCK + more), (OPENED + 6, EMPTY))
        ran = replace(still, rollout=replace(still.rollout, payload=payload, touches=touches))
        assert only(Payload(), weighing(0.2, ran, "floor")).passed is passes


def test_before_a_program_has_begun_nothing_is_told() -> None:
    payload = told((OPENED + 6, EMPTY))
    payload[: OPENED + 6] = 0.0
    assert only(Payload(), good(payload=payload)).value == 0.0


def test_what_a_joint_carries_does_not_hang_on_the_hand() -> None:
    base = telling(EMPTY)
    assert base.rollout is not None

    def mounted(thing: Thing) -> Thing:
        joint = Joint("slide", (1.0, 0.0, 0.0), (0.0, 0.3), "floor")
        return replace(thing, joint=joint, mass=3.0) if thing.name == "block" else thing

    world = replace(base.world, things=tuple(map(mounted, base.world.things)))
    assert only(Payload(), replace(base, world=world, rollout=replace(base.rollout, world=world))).passed


def test_what_is_pushed_between_the_fingers_stands_on_its_floor() -> None:
    """It need not be told, and may be."""
    base = posed(block=track((0, (0.5, 0.2, 0.03)), (LIFTED, (0.5, 0.2, 0.03)), (OPENED, (0.5, 0.0, 0.03))))
    assert base.rollout is not None
    floor = Touch("floor", "block", 2.0, 2.0)
    standing = tuple((*row, floor) for row in base.rollout.touches)
    for mass, passes in ((EMPTY, True), (EMPTY + BLOCK, True), (EMPTY - 0.5, False)):
        payload = told((TAKEN, mass), (OPENED + 6, EMPTY))
        assert only(Payload(), replace(base, rollout=replace(base.rollout, touches=standing, payload=payload))).passed is passes


def test_what_has_no_mass_weighs_nothing() -> None:
    for mass, off in ((EMPTY, 0.0), (EMPTY - 0.5, 0.5)):
        base = good(payload=told((TAKEN, mass), (OPENED, EMPTY)))
        things = tuple(replace(t, mass=None) if t.name == "block" else t for t in base.world.things)
        assert only(Payload(), replace(base, world=replace(base.world, things=things))).value == pytest.approx(off)



"""Joint targets and joint speeds: inside the limit, at it, and outside."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.properties import examples
from helpers.short_runs import COUNT, STEP, good, only, posed
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import AnyStep, Fallback, Joints, MoveJoints, MoveLinear, Pose, SetGripper, Wait
from cramlite.plugin import Candidate
from cramlite_plugins.kinematics.forward import smallest_singular_value
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.validators import speeds
from cramlite_plugins.validators.limits import JointLimits, Singularities, validators
from cramlite_plugins.validators.speeds import JointSpeeds, ToolSpeed

LOW, HIGH = UR5E.limits[3]


def having(*steps: AnyStep) -> Candidate:
    candidate = good()
    return replace(candidate, program=replace(candidate.program, steps=steps))


def at(value: float, joint: int = 3) -> Joints:
    """The home position with another value of one joint."""
    return (*UR5E.home[:joint], value, *UR5E.home[joint + 1 :])


def to(*path: Joints) -> MoveJoints:
    return MoveJoints(path, 1.0, 1.4, origin="2.PickingUp/move")


def turned(speed: float, joint: int = 0, sample: int = 40) -> Candidate:
    """The run in which a joint turns for two periods, at a speed [rad/s]."""
    joints = np.tile(UR5E.home, (COUNT, 1))
    joints[sample, joint] += speed * STEP
    joints[sample + 1 :, joint] += 2 * speed * STEP
    return good(joints=joints)


def led(speed: float) -> Candidate:
    """The run in which the tool goes on for two periods while it lifts, at a speed [m/s]."""
    base = good().rollout
    assert base is not None
    hand = base.poses["effector"].copy()
    hand[:, :3] = hand[0, :3]
    hand[40, 0] += speed * STEP
    hand[41:, 0] += 2 * speed * STEP
    return posed(effector=hand)


def test_all_of_them_are_asked() -> None:
    assert [v.name for v in validators()] == ["joint_limits", "singularities"]
    assert [v.name for v in speeds.validators()] == ["joint_speeds", "tool_speed"]


@pytest.mark.parametrize(("value", "passes"), [(HIGH - 1e-6, True), (HIGH, True), (HIGH + 1e-6, False), (LOW, True), (LOW - 1e-6, False)])
def test_a_target_lies_within_the_limits(value: float, passes: bool) -> None:
    line = MoveLinear(Pose(), 0.1, 0.5, at(value), origin="1.A/line")
    for step in (to(at(value)), to(UR5E.home, at(value), UR5E.home), line, Fallback(((Wait(1.0),), (line,)))):
        found = only(JointLimits(), having(SetGripper(0.0, 0.1, 50.0, "any"), step))
        assert found.passed is passes
        if not passes:
            assert found.reason == f"wrist_1 {value:.2f} rad is outside {LOW:.2f} to {HIGH:.2f} rad"
            assert (found.value, found.limit, found.unit) == (value, max(LOW, min(value, HIGH)), "rad")
            assert found.origin in {"2.PickingUp/move", "1.A/line"}


@given(values=st.lists(st.floats(-7.0, 7.0), min_size=6, max_size=6))
@examples(50)
def test_the_nearest_limit_is_said(values: list[float]) -> None:
    margins = [min(v - low, high - v) for v, (low, high) in zip(values, UR5E.limits, strict=True)]
    found = only(JointLimits(), having(to(UR5E.home, tuple(values))))
    assert found.passed == (min(margins) >= 0)
    home = min(min(v - low, high - v) for v, (low, high) in zip(UR5E.home, UR5E.limits, strict=True))
    if found.passed:
        assert found.value == pytest.approx(min(*margins, home)) and found.limit == 0.0
        assert found.reason == f"the nearest joint limit is {min(*margins, home):.2f} rad away"


def test_the_first_that_is_outside_is_said_and_no_other() -> None:
    assert only(JointLimits(), having(to(at(9.0)), to(at(8.0)))).value == 9.0


@pytest.mark.parametrize(("share", "passes"), [(1.04, True), (1.06, False), (40.0, False)])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_joint_turns_no_faster_than_it_can(share: float, passes: bool, way: float) -> None:
    most = UR5E.velocity[0]
    found = only(JointSpeeds(), turned(way * share * most))
    assert found.passed is passes and found.value == pytest.approx(share * most) and found.limit == most
    assert found.reason == f"shoulder_pan reached {share * most:.2f} rad/s, limit {most:.2f} rad/s"


def test_at_its_speed_with_what_a_servo_overshoots_it_passes() -> None:
    """Halves of a second and of a radian, so that no digit is lost."""
    robot = replace(UR5E, velocity=(1.0, 8.0, 8.0, 8.0, 8.0, 8.0))
    joints = np.zeros((COUNT, 6))
    joints[40, 0], joints[41:, 0] = 1.05, 2.10
    base = good(joints=joints, times=np.arange(COUNT) * 1.0)
    assert only(JointSpeeds(), replace(base, robot=robot)).passed


def test_each_joint_has_its_own_speed() -> None:
    robot = replace(UR5E, velocity=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    joints = np.tile(UR5E.home, (COUNT, 1))
    joints[40] += np.array([0.5, 0.5, 2.9, 0.5, 5.1, 0.5]) * STEP
    joints[41:] += np.array([0.5, 0.5, 2.9, 0.5, 5.1, 0.5]) * 2 * STEP
    found = only(JointSpeeds(), replace(good(joints=joints), robot=robot))
    assert found.passed and found.reason.startswith(f"{UR5E.joints[4]} reached 5.10 rad/s, limit 5.00")
    joints[40:] = np.array(UR5E.home) + np.array([0.95, 0.5, 0.5, 0.5, 0.5, 3.0]) * STEP * np.array([[1.0], *[[2.0]] * (COUNT - 41)])
    found = only(JointSpeeds(), replace(good(joints=joints), robot=robot))
    assert found.passed and found.reason.startswith(f"{UR5E.joints[0]} reached 0.95 rad/s, limit 1.00"), "the share counts, not the speed"


def test_a_run_of_one_sample_has_no_speed() -> None:
    base = good().rollout
    assert base is not None
    for count, findings in ((1, 0), (2, 1)):
        poses = {name: rows[:count] for name, rows in base.poses.items()}
        force = np.zeros(count)
        short = replace(base, times=base.times[:count], joints=base.joints[:count], poses=poses, lines=base.lines[:count], force=force)
        for validator in (JointSpeeds(), ToolSpeed()):
            assert len(list(validator.check(replace(good(), rollout=short)))) == findings
            assert list(validator.check(replace(good(), rollout=None))) == []


@pytest.mark.parametrize(("speed", "passes"), [(1.49, True), (1.51, False), (20.0, False)])
def test_the_tool_is_no_faster_than_a_controller_lets_it(speed: float, passes: bool) -> None:
    found = only(ToolSpeed(), led(speed))
    assert found.passed is passes and found.value == pytest.approx(speed) and (found.limit, found.unit) == (1.5, "m/s")
    assert found.reason == f"the tool reached {speed:.2f} m/s, limit 1.5 m/s (factory preset)" and found.origin == "2.PickingUp"


def test_a_sample_that_is_a_cycle_late_is_no_speed() -> None:
    """Samples of 20 ms of an arm that is moved every 8 ms: 2 and 3 cycles in turn, at 0.1 rad/s and 1.4 m/s."""
    base = good().rollout
    assert base is not None
    times = np.arange(COUNT) * 0.02
    late = np.ceil(times / 0.008 - 1e-9) * 0.008
    hand = base.poses["effector"].copy()
    hand[:, :3] = np.outer(1.4 * late, (1.0, 0.0, 0.0))
    moved = replace(posed(effector=hand), rollout=replace(base, times=times, poses={**base.poses, "effector": hand}))
    assert only(ToolSpeed(), moved).value == pytest.approx(1.4)


@pytest.mark.parametrize(("elbow", "passes"), [(1.6, True), (0.02, False)])
def test_an_arm_that_is_led_by_its_tool_keeps_away_from_being_stretched(elbow: float, passes: bool) -> None:
    joints = np.tile(at(elbow, 2), (COUNT, 1))
    led = replace(good(joints=joints), robot=replace(UR5E, conditioning=0.08))
    found = only(Singularities(), led)
    assert found.passed is passes and "0.08 is kept" in found.reason
    assert list(Singularities().check(good(joints=joints))) == []  # one whose joints are commanded may


@pytest.mark.parametrize(("joints", "passes"), [
    ((-0.164, 0.138, -0.245, -2.926, 0.106, 3.062, 0.274), False), ((-0.229, -0.053, -0.245, -2.931, -0.078, 2.876, 0.387), True),
])  # fmt: skip
def test_an_arm_that_may_move_beside_its_tool_keeps_away_wherever_that_leaves_it(joints: tuple[float, ...], passes: bool) -> None:
    """Near the base, and 43 mm higher; commanded by its joints it may be there."""
    for posture, found in ((FR3.home, passes), (None, True)):
        robot = replace(FR3, conditioning=0.08, posture=posture)
        assert only(Singularities(), replace(good(joints=np.tile(joints, (COUNT, 1))), robot=robot)).passed is found


@pytest.mark.parametrize("start", [0.0, 3.0])
def test_the_arm_is_looked_at_each_tenth_of_a_second_to_the_last_sample(start: float) -> None:
    """A run of 1.06 s: eleven tenths, whatever time it begins at; it may begin near a singularity, and leave it."""
    robot, seen = replace(UR5E, conditioning=0.08), set[int]()
    for k in range(COUNT):
        joints = np.tile(at(1.6, 2), (COUNT, 1))
        joints[k] = at(0.02, 2)
        found = only(Singularities(), replace(good(joints=joints, times=start + np.arange(COUNT) * 0.0107), robot=robot))
        if not found.passed:
            assert found.value == pytest.approx(smallest_singular_value(UR5E, at(0.02, 2)))
            seen.add(k)
    assert seen == {*range(9, COUNT, 9)}


@pytest.mark.parametrize(
    ("elbows", "passes"), [((0.5, 1.6), True), ((0.5, 0.46, 1.6), False), ((0.46, 0.5), False), ((0.5, 1.6, 0.5), False)],
    ids=["leaves", "comes nearer first", "stays", "comes back"],
)  # fmt: skip
def test_an_arm_that_begins_near_a_singularity_may_leave_it(elbows: tuple[float, ...], passes: bool) -> None:
    way = np.interp(np.linspace(0.0, len(elbows) - 1, COUNT), range(len(elbows)), elbows)
    led = replace(good(joints=np.array([at(float(e), 2) for e in way])), robot=replace(UR5E, conditioning=0.08))
    assert only(Singularities(), led).passed is passes


@pytest.mark.parametrize(("share", "passes"), [(0.81, True), (0.79, False)])
def test_an_arm_that_is_led_may_come_a_fifth_nearer_to_a_singularity_than_it_stops(share: float, passes: bool) -> None:
    least = smallest_singular_value(UR5E, UR5E.home)
    led = replace(good(), robot=replace(UR5E, conditioning=least / share))
    assert only(Singularities(), led).passed is passes

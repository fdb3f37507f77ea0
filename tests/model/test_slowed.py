"""A program at a share of its speed: the same shape, later; and the peaks of a run."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import (
    Drive,
    Fallback,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Pose,
    Program,
    Rollout,
    SetGripper,
    Wait,
    World,
    walk,
)
from cramlite.model.program.slowed import slowed
from cramlite.model.run.run_peaks import peaks_of

HOME = (0.0,) * 6
GRIP = SetGripper(0.05, 0.1, 40.0, origin="1.Grasping/close")
MOVE, LINE = MoveJoints((HOME,), 1.0, 1.4, origin="a"), MoveLinear(Pose(), 0.2, 0.8, HOME, origin="b")
FEEL = MoveUntilContact((0.0, 0.0, -1.0), 0.01, 5.0, 0.05, 10.0, "any", HOME, origin="c")
DRIVE = Drive(((1.0, 0.0, 0.0),), 0.5, 0.4, 0.6, 0.7, origin="d")


def program(*steps: object) -> Program:
    return Program("p", "arm", "ur5e", Pose(), HOME, steps, ())  # type: ignore[arg-type]


@given(st.floats(0.01, 1.0))
def test_ways_keep_their_shape_and_take_as_much_longer(share: float) -> None:
    """From rest to rest a way takes v/a + s/v: with v times k and a times k squared, 1/k times as long."""
    nested = Monitor((Fallback(((MOVE, GRIP), (LINE,)), origin="f"),), time=4.0, origin="m")
    made = slowed(program(nested, FEEL, DRIVE, Wait(0.3, origin="w")), share)
    monitor, fallback, move, grip, line, feel, drive, wait = walk(made.steps)
    assert (grip, wait) == (GRIP, Wait(0.3, origin="w"))
    assert isinstance(move, MoveJoints) and isinstance(line, MoveLinear)
    assert (move.path, line.target, fallback.origin) == (MOVE.path, LINE.target, "f")
    for fast, slow in ((MOVE, move), (LINE, line)):
        assert slow.speed / slow.acceleration == pytest.approx(fast.speed / fast.acceleration / share)
        assert slow.speed == pytest.approx(fast.speed * share)
    assert isinstance(feel, MoveUntilContact) and isinstance(drive, Drive) and isinstance(monitor, Monitor)
    assert (feel.speed, feel.timeout) == pytest.approx((0.01 * share, FEEL.timeout / share))
    assert (drive.turn_speed, drive.turn_acceleration) == pytest.approx((0.6 * share, 0.7 * share**2))
    assert monitor.time == pytest.approx(4.0 / share)


def test_at_its_own_speed_a_program_stays_as_it_is() -> None:
    assert slowed(program(MOVE, FEEL, GRIP), 1.0) == program(MOVE, FEEL, GRIP)


def test_peaks_are_measured_where_they_are() -> None:
    times = np.arange(5) * 0.1
    tool = np.zeros((5, 7))
    tool[:, 0] = [0, 0.01, 0.05, 0.06, 0.06]
    joints = np.zeros((5, 6))
    joints[:, 2] = [0, -0.1, -0.1, 0.2, 0.2]
    wrench = np.zeros((5, 6))
    wrench[3, :3] = (3, 0, 4)
    run = Rollout(World(()), "arm", times, {"effector": tool}, ((),) * 5, joints, wrench, np.zeros(5), np.array([1, 2, 3, 4, 0]))
    found = peaks_of(run)
    assert found is not None
    assert (found.tool_speed, found.tool_speed_line) == (pytest.approx(0.25), 2)
    assert found.joint_speeds[2] == pytest.approx(1.5)
    assert (found.lowest[2], found.highest[2]) == pytest.approx((-0.1, 0.2))
    assert (found.force, found.force_line, found.seconds) == (pytest.approx(5.0), 4, pytest.approx(0.3))


def test_a_hand_without_joints_has_no_peaks() -> None:
    times = np.arange(3) * 0.1
    empty = Rollout(World(()), "hand", times, {}, ((),) * 3, np.zeros((3, 0)), np.zeros((3, 6)), np.zeros(3), np.zeros(3))
    assert peaks_of(empty) is None

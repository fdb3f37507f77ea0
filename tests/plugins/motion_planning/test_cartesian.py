"""Straight lines of the tool, and where they stop."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from helpers.scenes import TABLE, WALL, down, make, stance
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Pose
from cramlite.plugin import Refused
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.motion_planning.cartesian import JointPath, interpolate, plan_straight_line, sampled
from cramlite_plugins.robots.ur5e import UR5E

START = down(0.5, -0.25, 0.2)
numbers = st.floats(-1, 1)
poses = st.builds(
    lambda p, r: Pose.from_rotvec(p, r), st.tuples(numbers, numbers, numbers), st.tuples(numbers, numbers, numbers)
)


def test_the_tool_stays_on_the_line() -> None:
    place = make(TABLE)
    q = stance(place, START)
    path = plan_straight_line(place, UR5E, q, [down(0.5, -0.25, 0.1), down(0.6, -0.25, 0.1)], speed=0.1)
    assert isinstance(path, JointPath), path
    assert path.points[0] == q
    assert path.length == pytest.approx(0.2)
    assert len(path.points) == 41
    assert max(forward(UR5E, path.points[-1]).distance(down(0.6, -0.25, 0.1))) < 1e-6
    for joints, way in zip(path.points[:21], path.ways, strict=False):
        assert max(forward(UR5E, joints).distance(down(0.5, -0.25, 0.2 - way))) < 1e-5


def test_an_arm_that_is_turned_around_is_led_alike() -> None:
    q = stance(make(), START)
    turned = (*q[:5], q[5] - 2 * math.pi if q[5] > 0 else q[5] + 2 * math.pi)
    straight, other = (plan_straight_line(None, UR5E, at, down(0.6, -0.25, 0.1)) for at in (q, turned))
    assert isinstance(straight, JointPath) and isinstance(other, JointPath)
    assert other.points[0] == turned
    off = np.subtract(other.points, straight.points)
    assert np.abs(off - off[0]).max() < 1e-9 and abs(off[0][5]) == pytest.approx(2 * math.pi)


def test_it_stops_at_the_wall_and_says_so() -> None:
    place = make(TABLE, WALL)
    answer = plan_straight_line(place, UR5E, stance(place, START), down(0.5, 0.25, 0.2))
    assert isinstance(answer, Refused)
    assert "'wall'" in answer.reason
    assert 0.1 < answer.numbers["fraction"] < 0.5
    assert isinstance(plan_straight_line(None, UR5E, stance(place, START), down(0.5, 0.25, 0.2)), JointPath)


def test_it_stops_out_of_reach_at_a_singularity_and_at_the_base() -> None:
    q = stance(make(), START)
    far = plan_straight_line(None, UR5E, q, down(1.2, -0.25, 0.2))
    assert isinstance(far, Refused)
    assert "singularity" in far.reason or "wrist centre" in far.reason
    near = plan_straight_line(None, UR5E, q, down(0.0, -0.05, 0.2))
    assert isinstance(near, Refused)
    assert "singularity" in near.reason


def test_it_stops_at_a_joint_limit() -> None:
    q = stance(make(), START)
    turned = (*q[:5], 6.2)
    target = forward(UR5E, turned) * Pose.from_rotvec((0, 0, 0), (0, 0, 0.5))
    answer = plan_straight_line(None, UR5E, turned, target)
    assert isinstance(answer, Refused)
    assert "'wrist_3'" in answer.reason


def test_a_speed_that_a_joint_cannot_follow_is_refused() -> None:
    q = stance(make(), START)
    assert isinstance(plan_straight_line(None, UR5E, q, down(0.5, 0.25, 0.2), speed=0.25), JointPath)
    answer = plan_straight_line(None, UR5E, q, down(0.5, 0.25, 0.2), speed=4.0)
    assert isinstance(answer, Refused)
    assert "rad/s >" in answer.reason


@given(poses, poses, st.floats(0, 1))
def test_interpolation_divides_the_way(a: Pose, b: Pose, part: float) -> None:
    middle, whole = interpolate(a, b, part), a.distance(b)
    assert a.distance(middle) == pytest.approx([part * v for v in whole], abs=1e-6)
    assert middle.distance(b) == pytest.approx([(1 - part) * v for v in whole], abs=1e-6)


@given(poses, poses)
def test_samples_keep_their_steps(a: Pose, b: Pose) -> None:
    way = [a, *sampled(a, [b], 0.05, 0.1)]
    assert way[-1] == b
    assert all(p.distance(n)[0] < 0.0501 and p.distance(n)[1] < 0.1001 for p, n in itertools.pairwise(way))

"""The movej law."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite_plugins.kinematics import timing as t
from cramlite_plugins.robots.ur5e import UR5E

positive = st.floats(0.01, 10)


def test_known_durations() -> None:
    assert t.trapezoid(2.0, 1.0, 2.0) == pytest.approx(2.5)
    assert t.trapezoid(0.5, 1.0, 2.0) == pytest.approx(1.0)
    assert t.trapezoid(0.02, 1.0, 2.0) == pytest.approx(0.2)
    assert t.segment_times([(0, 0), (2, 1), (2, 1.5)], 1.0, 2.0) == pytest.approx((2.5, 1.0))


@given(positive, positive, positive)
def test_profile_starts_and_ends_and_keeps_its_limits(way: float, speed: float, acceleration: float) -> None:
    total = t.trapezoid(way, speed, acceleration)
    times = [total * k / 200 for k in range(201)]
    s = [t.profile_position(x, way, speed, acceleration) for x in times]
    assert s[0] == 0
    assert s[-1] == pytest.approx(way)
    rates = [(b - a) / (total / 200) for a, b in itertools.pairwise(s)]
    assert max(rates) <= speed * (1 + 1e-6)
    gains = [abs(b - a) / (total / 200) for a, b in itertools.pairwise(rates)]
    assert max(gains) <= acceleration * (1 + 1e-5)


@given(st.floats(0.01, 3), st.floats(0.1, 10), st.floats(0.1, 10))
def test_a_given_duration_is_kept(way: float, time: float, acceleration: float) -> None:
    speed, gain = t.profile_for_duration(way, time, acceleration)
    assert t.trapezoid(way, speed, gain) == pytest.approx(time, rel=1e-6)
    assert gain == acceleration or gain > acceleration


def test_a_linear_motion_that_is_too_fast_names_the_joint() -> None:
    path, ways = [(0.0,) * 6, (0.1, 0, 0, 0, 0, 0)], [0.0, 0.01]
    assert t.joint_speed_excess(UR5E, path, ways, 0.1) == ""
    assert "'shoulder_pan' at 5.00 rad/s > 3.14 rad/s" in t.joint_speed_excess(UR5E, path, ways, 0.5)


def test_nonsense_is_refused() -> None:
    with pytest.raises(ValueError, match="speed 0"):
        t.trapezoid(1.0, 0.0, 1.0)


@given(st.lists(st.tuples(*[st.floats(-0.2, 0.2)] * 6), min_size=2, max_size=8), st.floats(0.01, 0.5), st.floats(0.05, 1.0))
def test_a_steady_line_keeps_a_share_from_every_joints_limit(turns: list[tuple[float, ...]], way: float, speed: float) -> None:
    path = [[0.0] * 6, *turns]
    steady = t.steady_speed(UR5E, path, way, speed, least=0.0)
    ways = [way * k / (len(path) - 1) for k in range(len(path))]
    assert steady <= speed
    assert not t.joint_speed_excess(UR5E, path, ways, steady / t.STEADY * (1 - 1e-9))
    if steady < speed:  # it is slowed down for a joint that is at its share, and no further
        assert t.joint_speed_excess(UR5E, path, ways, steady / t.STEADY * (1 + 1e-6))


def test_a_steady_line_is_not_slower_than_asked() -> None:
    assert t.steady_speed(UR5E, [[0.0] * 6, [3.0] * 6], 0.01, 0.25, least=0.05) == 0.05

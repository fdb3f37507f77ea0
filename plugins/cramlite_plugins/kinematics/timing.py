"""Durations of motions under the trapezoidal velocity profile that the controller model executes.

A ``MoveJoints`` stops at each of its points that is not rounded (``blends``). Between two points all joints
start and stop together: the leading axis, the one with the longest way D = max |dq|, follows a trapezoid of
speed v and acceleration a, and every other joint the same profile scaled to its own way. That is the
documented behaviour of movej without blends (The URScript Programming Language, movej: "v: joint speed of
leading axis", "a: joint acceleration of leading axis"):

    D >= v^2 / a (trapezoid): T = D / v + v / a
    D <  v^2 / a (triangle):  T = 2 sqrt(D / a)

A linear motion follows the same law along the line of the tcp, in metres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from operator import sub

import numpy as np

from cramlite.model import Floats, Robot


def trapezoid(way: float, speed: float, acceleration: float) -> float:
    """Compute the duration of a trapezoidal velocity profile from rest to rest [s].

    Args:
        way: [m or rad], not negative; speed and acceleration in the same unit per s and s2.

    Raises:
        ValueError: a speed or acceleration that is not positive, or a negative way.
    """
    if way < 0 or speed <= 0 or acceleration <= 0:
        raise ValueError(
            f"way {way}, speed {speed}, acceleration {acceleration}: need way >= 0 and the others > 0"
        )
    if way >= speed**2 / acceleration:
        return way / speed + speed / acceleration
    return 2 * math.sqrt(way / acceleration)


def profile_position(time: float, way: float, speed: float, acceleration: float) -> float:
    """Compute the distance covered by a trapezoidal profile after ``time`` [s], clamped to 0 .. ``way`` [m
    or rad]."""
    total = trapezoid(way, speed, acceleration)
    if time <= 0 or way == 0:
        return 0.0
    if time >= total:
        return way
    top = min(speed, math.sqrt(way * acceleration))
    ramp = top / acceleration
    if time < ramp:
        return acceleration * time**2 / 2
    if time > total - ramp:
        return way - acceleration * (total - time) ** 2 / 2
    return top * (time - ramp / 2)


def profile_for_duration(way: float, time: float, acceleration: float) -> tuple[float, float]:
    """Compute the speed and acceleration of a velocity profile that covers a distance from rest to rest in a
    given time.

    The acceleration is kept if it suffices: T = D / v + v / a gives v = (a T - sqrt(a^2 T^2 - 4 a D)) / 2.
    Otherwise it is a triangle with a = 4 D / T^2.
    """
    root = (acceleration * time) ** 2 - 4 * acceleration * way
    if root < 0:
        return 2 * way / time, 4 * way / time**2
    return (acceleration * time - math.sqrt(root)) / 2, acceleration


def leading(a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> float:
    """Return the distance of the axis that moves farthest between two joint positions, max |b - a| [rad]."""
    return float(max(map(abs, map(sub, b, a))))


def segment_times(path: Sequence[Sequence[float]], speed: float, acceleration: float) -> tuple[float, ...]:
    """Compute the duration of each segment of a path that stops at every point [s].

    Args:
        path: joint positions, the start included [rad].
        speed, acceleration: of the leading axis [rad/s, rad/s2].
    """
    return tuple(trapezoid(leading(a, b), speed, acceleration) for a, b in pairwise(path))


def duration(path: Sequence[Sequence[float]], speed: float, acceleration: float) -> float:
    """Compute the duration of a path that stops at every point [s], start included."""
    return sum(segment_times(path, speed, acceleration))


def joint_speed_excess(
    robot: Robot, path: Sequence[Sequence[float]], ways: Sequence[float], speed: float
) -> str:
    """Name the joint that exceeds its speed limit on a straight tcp motion.

    Between two samples the tcp moves ds, so joint i runs at |dq_i| / ds * speed.

    Args:
        path: joint positions along the line, start included [rad].
        ways: how far the tcp has come at each of them [m]; the same length as ``path``.
        speed: of the tcp [m/s].

    Returns:
        A clause such as "joint 'elbow_joint' at 4.10 rad/s > 3.14 rad/s"; empty when all are within limits.
    """
    worst, clause = 1.0, ""
    for (a, b), (s, t) in zip(pairwise(path), pairwise(ways), strict=True):
        if t - s < 1e-9:
            continue
        for name, limit, x, y in zip(robot.joints, robot.velocity, a, b, strict=True):
            rate = abs(y - x) / (t - s) * speed
            if rate / limit > worst:
                worst, clause = rate / limit, f"joint '{name}' at {rate:.2f} rad/s > {limit:.2f} rad/s"
    return clause


STEADY = 0.8
"""Share of a joint's speed limit that motions are planned with: an arm with streamed targets catches up in
steps, and was seen at 2.63 rad/s where 2.17 rad/s were commanded."""


def steady_speed(
    robot: Robot, path: Sequence[Sequence[float]], way: float, speed: float, least: float
) -> float:
    """Compute the speed of a straight tcp motion at which no joint comes near its limit.

    Args:
        path: joint positions at even distances along the line, start included [rad].
        way: of the tcp [m].
        speed: that is wanted [m/s].
        least: that is not gone below [m/s].
    """
    most = float(np.max(np.abs(np.diff(np.array(path), axis=0)) / np.array(robot.velocity), initial=1e-9))
    return max(least, min(speed, STEADY * way / (len(path) - 1) / most))

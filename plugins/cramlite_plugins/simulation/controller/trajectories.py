"""Trajectories of the virtual UR controller: joint positions or TCP poses over time.

All start and end at rest. Joint motions may round their corners (kinematics/blends.py), those of movep, too (``movep``); a blend
radius of a movel is told, and not taken: the arm stops at its target, which is the slower and safer of the two.
Law: kinematics/timing.py, and its sources.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from cramlite.model import Floats, Pose, Value, Vector3, quaternion_product, rotvec_quaternion, vector3

from ...kinematics.blends import Section, Tcp, rounded, zone
from ...kinematics.timing import profile_position, trapezoid

# A tool that turns on the spot or nearly so: one radian takes as long as this way [m]. UR's manual leaves it open.
RADIAN = 0.25
STRAIGHT = 1e-6  # the sine of an angle below which three points of a circle are on one line


class Motion(Protocol):
    """A trajectory: ``at(time)`` is a joint position (n,) or a TCP pose in the base frame; ``rate`` in m/s or rad/s."""

    @property
    def duration(self) -> float:
        """Return the duration of the motion [s]."""
    def at(self, time: float) -> Floats | Pose:
        """Return the joint position (n,) [rad] or the TCP pose in the base frame at a time since the start [s]."""
    def rate(self, time: float) -> float:
        """Return the speed of the motion at a time since its start: of the leading joint [rad/s] or the TCP [m/s]."""


class TrapezoidalProfile(Value):
    """A trapezoidal velocity profile over a length or an angle ``way``; speed and acceleration in the same unit."""

    way: float
    speed: float
    acceleration: float

    @property
    def duration(self) -> float:
        """Return the duration of the motion [s]."""
        return trapezoid(self.way, self.speed, self.acceleration)

    def share(self, time: float) -> float:
        """Return the share of the way that is done at a time, 0 to 1."""
        return profile_position(time, self.way, self.speed, self.acceleration) / self.way if self.way > 0 else 1.0

    def rate(self, time: float) -> float:
        """Return the speed at a time since the start [s], in the unit of ``speed``."""
        rest = self.duration - time
        if time <= 0 or rest <= 0:
            return 0.0
        return min(self.speed, self.acceleration * time, self.acceleration * rest)


class JointMotion(TrapezoidalProfile):
    """The trajectory of a movej: all joints start and stop together; speed and acceleration are the leading axis's."""

    start: Floats
    goal: Floats

    def at(self, time: float) -> Floats:
        """Return the joint position (n,) [rad] at a time since the start [s]."""
        return self.start + self.share(time) * (self.goal - self.start)


class BlendedMotion(Value):
    """The trajectory of several movej with blended corners."""

    sections: Sequence[Section]
    duration: float

    def at(self, time: float) -> Floats:
        """Return the joint position (n,) [rad] at a time since the start [s]."""
        section, since = self._now(time)
        return section.at(since)

    def rate(self, time: float) -> float:
        """Return the speed of the leading axis at a time since the start [rad/s]."""
        section, since = self._now(time)
        return max(section.rate(since), 0.0)

    def _now(self, time: float) -> tuple[Section, float]:
        for section in self.sections[:-1]:
            if time < section.length:
                return section, time
            time -= section.length
        return self.sections[-1], min(time, self.sections[-1].length)


class LinearMotion(TrapezoidalProfile):
    """The trajectory of a movel: the TCP on a straight line, its rotation about a constant axis (slerp)."""

    start: Pose
    goal: Pose
    turn: Vector3

    def at(self, time: float) -> Pose:
        """Return the TCP pose in the base frame at a time since the start [s]."""
        share = self.share(time)
        if share >= 1.0:
            return self.goal
        (x, y, z), (u, v, w) = self.start.position, self.goal.position
        position = (x + share * (u - x), y + share * (v - y), z + share * (w - z))
        turned = rotvec_quaternion([share * v for v in self.turn])
        return Pose(position, quaternion_product(self.start.quaternion, turned))


class CircularMotion(TrapezoidalProfile):
    """The trajectory of a movec: the TCP on an arc by ``angle`` [rad] about ``axis``, a unit vector through ``centre``."""

    start: Pose
    goal: Pose
    centre: Floats
    axis: Floats
    angle: float
    turn: Vector3
    fixed: bool

    def at(self, time: float) -> Pose:
        """Return the TCP pose in the base frame at a time since the start [s]."""
        share = self.share(time)
        along = Pose.from_rotvec((0, 0, 0), [share * self.angle * v for v in self.axis])
        place = vector3(self.centre + along.rotate(np.array(self.start.position) - self.centre))
        if self.fixed:  # the tool turns with the tangent
            return Pose(place, quaternion_product(along.quaternion, self.start.quaternion))
        turned = rotvec_quaternion([share * v for v in self.turn])
        return Pose(place, quaternion_product(self.start.quaternion, turned))


class StoppingMotion(Value):
    """Motion that stops on its own path: its time slows down evenly until it stands still after ``duration`` [s]."""

    motion: Motion
    since: float
    duration: float

    def at(self, time: float) -> Floats | Pose:
        """Return the joint position (n,) [rad] or the TCP pose at a time since the stop began [s]."""
        t = min(time, self.duration)
        passed = t - t * t / (2 * self.duration) if self.duration > 0 else 0.0
        return self.motion.at(self.since + passed)

    def rate(self, time: float) -> float:
        """Return 0: the motion is being stopped already."""
        return 0.0


def joint_motion(start: Floats, goal: Floats, speed: float, acceleration: float) -> JointMotion:
    """Plan a movej between two joint positions (n,) [rad, rad/s, rad/s2]."""
    return JointMotion(float(np.abs(goal - start).max()), speed, acceleration, start.copy(), goal)


def blended_motion(points: Sequence[Floats], radii: Sequence[float], rates: Sequence[tuple[float, float]], tcp: Tcp) -> BlendedMotion:
    """Plan several movej, each but the last with a blend radius.

    Args:
        points: joint positions (n,), the start included [rad].
        radii: of the tcp around each inner point [m]; 0 stops there.
        rates: speed and acceleration of each movej [rad/s, rad/s2].
        tcp: its position at a joint position.

    Raises:
        ValueError: a radius takes more than half of a line.
    """
    zones = []
    for before, corner, after, radius in zip(points, points[1:], points[2:], radii, strict=False):
        found = [zone(tcp, corner, other, radius) if radius > 0 else 0.0 for other in (before, after)]
        if None in found:
            side = "before" if found[0] is None else "after"
            raise ValueError(f"a blend radius of {radius:.3f} m takes more than half of the motion {side} the corner")
        zones.append((float(found[0] or 0.0), float(found[1] or 0.0)))
    sections = rounded(points, zones, rates)
    return BlendedMotion(sections, sum(s.length for s in sections))


def linear_motion(start: Pose, goal: Pose, speed: float, acceleration: float) -> LinearMotion:
    """Plan a movel between two TCP poses [m/s, m/s2]."""
    turn = (start.inverse() * goal).rotvec
    way = max(math.dist(start.position, goal.position), RADIAN * float(np.linalg.norm(turn)))
    return LinearMotion(way, speed, acceleration, start, goal, turn)


def circular_motion(start: Pose, via: Vector3, goal: Pose, speed: float, acceleration: float, fixed: bool) -> CircularMotion:
    """Plan a movec: an arc from a TCP pose through a position to a pose, at a speed [m/s] and an acceleration [m/s2].

    ``fixed`` keeps the tool's orientation relative to the arc's tangent.

    Raises:
        ValueError: the three positions are on one line, or two of them are one.
    """
    a, b, c = (np.array(p) for p in (start.position, via, goal.position))
    normal = np.cross(b - a, c - a)
    size = float(np.linalg.norm(normal))
    if size <= STRAIGHT * float(np.linalg.norm(b - a) * np.linalg.norm(c - a)):
        raise ValueError("start, via point and goal are on one line: no circle goes through them")
    axis = normal / size
    # The circumcentre of three points: https://en.wikipedia.org/wiki/Circumcircle, "Circumcenter coordinates", 3D.
    u, v = b - a, c - a
    centre = a + np.cross((u @ u) * v - (v @ v) * u, normal) / (2 * size**2)
    out, end = a - centre, c - centre
    angle = math.atan2(float(axis @ np.cross(out, end)), float(out @ end)) % (2 * math.pi)
    turn = (start.inverse() * goal).rotvec
    return CircularMotion(angle * float(np.linalg.norm(out)), speed, acceleration, start, goal, centre, axis, angle, turn, fixed)


def stopping_motion(motion: Motion, time: float, deceleration: float) -> StoppingMotion:
    """Stop a motion that has run for ``time`` [s], with a deceleration in the motion's unit, m/s2 or rad/s2."""
    return StoppingMotion(motion, time, motion.rate(time) / deceleration)

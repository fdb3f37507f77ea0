"""Process motion (movep): straight tool paths with circular blends at one constant speed.

URScript manual (e-Series 5.x), movep: "Blend circular (in tool-space) and move linear (in tool-space) to position.
Accelerates to and moves with constant tool speed v." A corner is rounded by the circle that touches both lines at the blend
radius from it; the turn goes on in proportion to the way along each line, the halves of a circle counting as the ends of theirs.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import Protocol

import numpy as np

from cramlite.model import Floats, Pose, Value

from .trajectories import TrapezoidalProfile

STRAIGHT = 1e-6  # directions that differ by less make no corner [rad]


class PathSegment(Protocol):
    """A segment of a tool path, a line or an arc."""

    @property
    def length(self) -> float:
        """Return the length of the segment [m]."""
    def at(self, share: float) -> tuple[Floats, float]:
        """Return the position (3,) [m] at a share (0 to 1) of the segment, and the progress there in movep
        commands: 2.5 is halfway through the third."""


class LineSegment(Value):
    """Straight segment of a movep path between two positions; ``legs`` are the path's progress, in movep
    commands, at the start and end of the segment."""

    start: Floats
    goal: Floats
    legs: tuple[float, float]

    @property
    def length(self) -> float:
        """Return the length of the straight segment [m]."""
        return math.dist(self.start, self.goal)

    def at(self, share: float) -> tuple[Floats, float]:
        """Return the position (3,) [m] at a share (0 to 1) of the segment, and the number of movep commands
        done there, as a decimal number."""
        return self.start + share * (self.goal - self.start), self.legs[0] + share * (self.legs[1] - self.legs[0])


class ArcSegment(LineSegment):
    """An arc around ``centre`` from ``start``, along the unit vector ``along`` at first, by ``angle`` [rad]."""

    centre: Floats
    along: Floats
    angle: float

    @property
    def length(self) -> float:
        """Return the length of the arc [m]."""
        return math.dist(self.start, self.centre) * self.angle

    def at(self, share: float) -> tuple[Floats, float]:
        """Return the position (3,) [m] at a share (0 to 1) of the segment, and the progress there in movep
        commands: 2.5 is halfway through the third."""
        out, turned = self.start - self.centre, share * self.angle
        place = self.centre + math.cos(turned) * out + math.sin(turned) * math.dist(self.start, self.centre) * self.along
        middle = round(self.legs[1])  # the corner: both halves of the circle stand for the ends of their lines
        before, after = middle - self.legs[0], self.legs[1] - middle
        return place, middle + ((2 * share - 1) * (before if share < 0.5 else after))


class ProcessMotion(TrapezoidalProfile):
    """A movep path from rest to rest, in between at one speed; ``ends`` are path lengths [m] to each part's end."""

    poses: Sequence[Pose]
    parts: Sequence[PathSegment]
    ends: Sequence[float]

    def at(self, time: float) -> Floats | Pose:
        """Return the TCP pose in the base frame at a time since the start [s]."""
        gone = self.share(time) * self.way
        k = min(bisect_right(self.ends, gone), len(self.parts) - 1)
        length = self.parts[k].length
        share = 1.0 if length == 0 else min(1.0, (gone - (self.ends[k] - length)) / length)
        place, legs = self.parts[k].at(share)
        leg = min(int(legs), len(self.poses) - 2)
        before, after = self.poses[leg], self.poses[leg + 1]
        turn = [(legs - leg) * v for v in (before.inverse() * after).rotvec]
        turned = Pose((0, 0, 0), before.quaternion) * Pose.from_rotvec((0, 0, 0), turn)
        return Pose.at(place, turned)


def process_motion(poses: Sequence[Pose], radii: Sequence[float], speed: float, acceleration: float) -> ProcessMotion:
    """Plan several movep as one motion.

    Args:
        poses: of the tcp, the start included.
        radii: around each inner pose [m].
        speed, acceleration: along the way [m/s, m/s2].

    Raises:
        ValueError: a line has no length, a radius takes more than half of one, or the way turns straight back.
    """
    places = [np.array(p.position) for p in poses]
    lengths = [math.dist(a, b) for a, b in pairwise(places)]
    if min(lengths) < 1e-6:
        raise ValueError("a movep needs a path of some length: turn on the spot with movel")
    parts: list[PathSegment] = []
    start, done = places[0], 0.0
    for k, (corner, after, radius) in enumerate(zip(places[1:], places[2:], radii, strict=False), 1):
        shorter = min(lengths[k - 1], lengths[k])
        if radius > shorter / 2:
            raise ValueError(f"a blend radius of {radius:.3f} m takes more than half of a motion of {shorter:.3f} m")
        into, out = _unit(corner - places[k - 1]), _unit(after - corner)
        legs = (k - radius / lengths[k - 1], k + radius / lengths[k])
        parts += [LineSegment(start, corner - radius * into, (done, legs[0])), _blend(corner, into, out, radius, legs)]
        start, done = corner + radius * out, legs[1]
    parts.append(LineSegment(start, places[-1], (done, len(places) - 1.0)))
    ends = tuple(accumulate(p.length for p in parts))
    return ProcessMotion(ends[-1], speed, acceleration, tuple(poses), tuple(parts), ends)


def _blend(corner: Floats, into: Floats, out: Floats, radius: float, legs: tuple[float, float]) -> PathSegment:
    """Round a corner by an arc that touches the two lines at a distance ``radius`` from their corner."""
    start, goal = corner - radius * into, corner + radius * out
    angle = math.atan2(float(np.linalg.norm(np.cross(into, out))), float(into @ out))
    if angle < STRAIGHT:
        return LineSegment(start, goal, legs)
    if angle > math.pi - 1e-3:
        raise ValueError("the path turns straight back: no blend circle touches both of its lines")
    inward = _unit(out - float(out @ into) * into)
    return ArcSegment(start, goal, legs, start + radius / math.tan(angle / 2) * inward, into, angle)


def _unit(way: Floats) -> Floats:
    return np.asarray(way / np.linalg.norm(way))

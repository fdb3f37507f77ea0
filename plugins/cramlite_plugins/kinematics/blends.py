"""Blended joint-space paths: straight lines with parabolic corners, one law for planner and controller model.

Within its blend radius, the distance of the tcp from the corner, a path leaves the straight joint-space lines
for a parabola that touches both of them (linear segments with parabolic blends: Craig, Introduction to
Robotics, 2005, section 7.3). UR documents that the arm does not stop in the zone and where the zone is (The
URScript Programming Language, movej: "r: blend radius"), not the curve in it: this one is the model's.

The parabola is run through evenly in its parameter: the acceleration is constant, and the speeds at its ends
are those of the lines there. In between, the leading axis of each line follows a trapezoid from one speed to
the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from cramlite.model import Floats, Value

from .timing import leading

LARGEST = 0.5  # share of a line that the zone at either end may take: zones never overlap
LOOKS = 16  # places along that half at which the tcp's distance is looked at before the radius is bisected
ROUNDS = 20  # bisections of a line's fraction: to 1e-7

Joints = Sequence[float] | Floats
Tcp = Callable[[Floats], Floats]


class Straight(Value):
    """A straight joint-space line that begins and ends at given speeds: accelerate, cruise, brake.

    Speeds and acceleration are those of the leading joint, which moves farthest [rad/s, rad/s2].
    """

    start: Floats
    goal: Floats
    first: float
    top: float
    last: float
    acceleration: float
    way: float
    length: float

    def at(self, time: float) -> Floats:
        """Return the joint position (n,) at a time since the start of the line [s]."""
        if time >= self.length or self.way <= 0:
            return self.goal
        a, up = self.acceleration, (self.top - self.first) / self.acceleration
        rest = self.length - time
        if time < up:
            gone = self.first * time + a * time * time / 2
        elif rest < (self.top - self.last) / a:
            gone = self.way - self.last * rest - a * rest * rest / 2
        else:
            gone = (self.first + self.top) / 2 * up + self.top * (time - up)
        place: Floats = self.start + gone / self.way * (self.goal - self.start)
        return place

    def rate(self, time: float) -> float:
        """Return the speed of the leading (farthest moving) joint at a time since the start of the line
        [rad/s]."""
        rest = self.length - time
        return min(self.top, self.first + self.acceleration * time, self.last + self.acceleration * rest)


class Corner(Value):
    """Parabolic blend from one straight line in joint space to the next; it takes ``length`` seconds.

    Args:
        start, corner, goal: where it leaves one line, the corner, where it meets the other.
    """

    start: Floats
    corner: Floats
    goal: Floats
    length: float

    def at(self, time: float) -> Floats:
        """Return the joint position (n,) at a time since the start of the blend [s]."""
        u = min(time / self.length, 1.0) if self.length > 0 else 1.0
        place: Floats = (1 - u) ** 2 * self.start + 2 * u * (1 - u) * self.corner + u * u * self.goal
        return place

    def rate(self, time: float) -> float:
        """Return the largest joint speed at a time since the start of the blend [rad/s]."""
        u = min(time / self.length, 1.0)
        return (
            2
            * float(np.abs((1 - u) * (self.corner - self.start) + u * (self.goal - self.corner)).max())
            / self.length
        )

    @property
    def bend(self) -> Floats:
        """Return half of the second derivative of the parabola by its parameter (n,) [rad]: start - 2
        corner + goal."""
        return np.asarray(self.start - 2 * self.corner + self.goal)

    def sampled(self, deviation: float) -> list[Floats]:
        """Sample the parabola, start included; its chords deviate by at most ``deviation`` in any joint
        [rad]."""
        count = max(1, math.ceil(math.sqrt(float(np.abs(self.bend).max()) / (4 * deviation))))
        return [self.at(k / count * self.length) for k in range(count + 1)]


# A part of a motion: ``length`` [s], where it is after a time (n,) [rad], its leading axis's speed [rad/s].
Section = Straight | Corner


def zone(tcp: Tcp, corner: Joints, other: Joints, radius: float) -> float | None:
    """Compute the fraction of a joint-space line from a corner at which the tcp is ``radius`` [m] away from
    the corner.

    Args:
        tcp: position (3,) [m] of the tcp at a joint position.

    Returns:
        None where it is nearer than that over half of the line: the zone would be too large for the line.
    """
    start, way = np.asarray(corner, dtype=float), np.subtract(other, corner)
    centre = tcp(start)

    def beyond(part: float) -> bool:
        return math.dist(tcp(start + part * way), centre) > radius

    parts = [LARGEST * k / LOOKS for k in range(LOOKS + 1)]
    found = next(((low, high) for low, high in pairwise(parts) if beyond(high)), None)
    if found is None:
        return None
    low, high = found
    for _ in range(ROUNDS):
        middle = (low + high) / 2
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return low


def rounded(
    points: Sequence[Joints], zones: Sequence[tuple[float, float]], rates: Sequence[tuple[float, float]]
) -> list[Section]:
    """Compute the sections of a blended path from rest to rest.

    Args:
        points: joint positions (n,), start included [rad].
        zones: for each point but the first and last, the fraction of the line before it and of the line after
            it that its blend takes; (0, 0) is a stop. The fractions of one line must not add up to more than
            1.
        rates: speed and acceleration of the leading axis on each line [rad/s, rad/s2].
    """
    q = [np.asarray(p, dtype=float) for p in points]
    ends = [(0.0, 0.0), *zones, (0.0, 0.0)]
    corners = [
        Corner(
            b + i * (a - b), b, b + o * (c - b), _least(b + i * (a - b), b, b + o * (c - b), before, after)
        )
        for (a, b, c), (i, o), before, after in zip(_triples(q), zones, rates, rates[1:], strict=False)
    ]
    free = [
        leading(a, b) * max(0.0, 1 - o - i)
        for (a, b), (_, o), (i, _) in zip(pairwise(q), ends, ends[1:], strict=False)
    ]
    corners = _reachable(corners, free, [a for _, a in rates])
    result: list[Section] = []
    for k, (speed, acceleration) in enumerate(rates):
        first = _speed(corners[k - 1].corner, corners[k - 1].goal, corners[k - 1].length) if k else 0.0
        last = _speed(corners[k].start, corners[k].corner, corners[k].length) if k < len(corners) else 0.0
        start = corners[k - 1].goal if k else q[0]
        goal = corners[k].start if k < len(corners) else q[-1]
        result.append(_straight(start, goal, first, last, speed, acceleration))
        if k < len(corners) and corners[k].length > 0:
            result.append(corners[k])
    return result


def _triples(q: list[Floats]) -> list[tuple[Floats, Floats, Floats]]:
    return list(zip(q, q[1:], q[2:], strict=False))


def _least(
    start: Floats, corner: Floats, goal: Floats, before: tuple[float, float], after: tuple[float, float]
) -> float:
    """The shortest time of a blend: speeds at both ends and the acceleration of each joint stay within the
    limits."""
    into, out = leading(start, corner), leading(corner, goal)
    if into == 0 or out == 0:
        return 0.0
    acceleration = min(before[1], after[1])
    bend = float(np.abs(start - 2 * corner + goal).max())
    return max(2 * into / before[0], 2 * out / after[0], math.sqrt(2 * bend / acceleration))


def _speed(a: Floats, b: Floats, length: float) -> float:
    """Return the speed [rad/s] of the joint that moves farthest, where a line meets a blend."""
    return 2 * leading(a, b) / length if length > 0 else 0.0


def _reachable(corners: list[Corner], free: list[float], accelerations: list[float]) -> list[Corner]:
    """Slow down the blends of a path so that the arm can speed up or brake from each to the next on the line
    between them."""
    lengths = [c.length for c in corners]

    def slow(k: int, near: Floats, speed: float, way: float, acceleration: float) -> None:
        most = math.sqrt(speed**2 + 2 * acceleration * way)
        if lengths[k] > 0:
            lengths[k] = max(lengths[k], 2 * leading(near, corners[k].corner) / most) if most > 0 else 0.0

    speed = 0.0
    for k, c in enumerate(corners):
        slow(k, c.start, speed, free[k], accelerations[k])
        speed = _speed(c.corner, c.goal, lengths[k])
    speed = 0.0
    for k in reversed(range(len(corners))):
        slow(k, corners[k].goal, speed, free[k + 1], accelerations[k + 1])
        speed = _speed(corners[k].start, corners[k].corner, lengths[k])
    return [Corner(c.start, c.corner, c.goal, t) for c, t in zip(corners, lengths, strict=True)]


def _straight(
    start: Floats, goal: Floats, first: float, last: float, speed: float, acceleration: float
) -> Straight:
    """Fastest motion along a line with given speeds at its ends, a highest speed and an acceleration."""
    way = leading(start, goal)
    top = min(max(speed, first, last), math.sqrt(acceleration * way + (first**2 + last**2) / 2))
    top = max(top, first, last)  # rounding
    ramps = (2 * top**2 - first**2 - last**2) / (2 * acceleration)
    cruise = max(0.0, way - ramps) / top if top > 0 else 0.0
    return Straight(
        start, goal, first, top, last, acceleration, way, (2 * top - first - last) / acceleration + cruise
    )  # fmt: skip

"""Straight joint-space lines, and parabolas that round their corners, divided into parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from cramlite.model import Floats

# A line is cut into parts with less than this sum of joint differences [rad], for which levers are worked out
CHUNK = 0.6
PROBED = 0.05  # largest joint difference [rad] between two places at which a line is usually probed


Part = tuple[float, float]


class JointLine:
    """A straight line between two joint positions; ``way`` (n,) is how far each joint moves along it [rad].

    Of a curve (``JointBlend``) ``way`` is how far it would move at its highest speed.
    """

    def __init__(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> None:
        self.start, self.way = np.asarray(a, dtype=float), np.subtract(b, a)
        self.size = max(map(abs, self.way.tolist()))

    @property
    def bend(self) -> Floats:
        """Return the second derivative (n,) by the fraction, without sign [rad]: 0 on a straight line."""
        return np.zeros(len(self.way))

    def at(self, fraction: float) -> Floats:
        """Return the joint position (n,) at a fraction of the line."""
        q: Floats = self.start + fraction * self.way
        return q

    def parts(self) -> list[Part]:
        """Divide the line into equal parts (start, end), as fractions of the line."""
        count = math.ceil(float(np.abs(self.way).sum()) / CHUNK + 1e-9)
        return [(k / count, (k + 1) / count) for k in range(count)]

    def speed(self, fraction: float) -> Floats:
        """Return the derivative (n,) of the joint position by the fraction of the line [rad]."""
        del fraction
        return self.way

    def probes(self, apart: float) -> Floats:
        """Return joint positions (m, n) on the line, at most ``apart`` [rad] from one another, in an order in
        which already the first few leave no long gap."""
        at: Floats = self.start + _spread(int(self.size / apart))[:, None] * self.way
        return at


class JointBlend(JointLine):
    """Rounded corner of a path: a parabola in joint space from one straight line to the next.

    Fractions are those of the parabola's parameter, not of its length.

    Args:
        start, goal: where it leaves one line and meets the other [rad].
        corner: where the lines meet [rad].
    """

    def __init__(self, start: Floats, corner: Floats, goal: Floats) -> None:
        self.start, self.into, self.out = start, corner - start, goal - corner
        self.way = 2.0 * np.maximum(np.abs(self.into), np.abs(self.out))
        self.size = float(self.way.max())

    @property
    def bend(self) -> Floats:
        """Return the second derivative (n,) by the parabola's parameter, without sign [rad]."""
        found: Floats = 2.0 * np.abs(self.out - self.into)
        return found

    def at(self, fraction: float) -> Floats:
        """Return the joint position (n,) on the parabola at a fraction (0 to 1) of its parameter."""
        q: Floats = self.start + 2.0 * fraction * self.into + fraction * fraction * (self.out - self.into)
        return q

    def speed(self, fraction: float) -> Floats:
        """Return the derivative (n,) of the joint position by the parabola's parameter [rad]."""
        v: Floats = 2.0 * self.into + 2.0 * fraction * (self.out - self.into)
        return v


@lru_cache(maxsize=256)
def _spread(count: int) -> Floats:
    """``count`` evenly spaced fractions between 0 and 1, in van der Corput's order: already the first few are
    spread over the whole range."""
    bits = count.bit_length()
    order = (int(f"{k:0{bits}b}"[::-1], 2) for k in range(1 << bits))
    found: Floats = np.array([k for k in order if 0 < k <= count], dtype=float) / (count + 1)
    return found

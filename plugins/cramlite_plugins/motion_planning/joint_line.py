"""Straight joint-space lines divided into parts, with bounds on how far each part may move any two geoms
towards one another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from cramlite.model import Floats, Value

from .pairs import Movers

# A line is cut into parts with less than this sum of joint differences [rad], for which levers are worked out
CHUNK = 0.6
PROBED = 0.05  # largest joint difference [rad] between two places at which a line is probed


class Rates(Value):
    """Bounds on how much nearer two geoms can come while the arm moves along a whole line: for each pair
    (geoms, geoms) [m], and the largest."""

    between: Floats
    most: float


Part = tuple[float, float, Rates | None]


class JointLine:
    """A straight line between two joint positions; ``way`` (n,) is how far each joint moves along it [rad].

    Of a curve (``JointBlend``) ``way`` is how far it would move at its highest speed.
    """

    def __init__(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> None:
        self.start, self.way = np.asarray(a, dtype=float), np.subtract(b, a)
        self.size = float(np.abs(self.way).max())

    def at(self, fraction: float) -> Floats:
        """Return the joint position (n,) at a fraction of the line."""
        q: Floats = self.start + fraction * self.way
        return q

    def parts(self) -> list[Part]:
        """Divide the line into equal parts (start, end, None), start and end as fractions of the line; None
        means that the bounds of the part are not computed yet."""
        count = math.ceil(float(np.abs(self.way).sum()) / CHUNK + 1e-9)
        return [(k / count, (k + 1) / count, None) for k in range(count)]

    def probes(self) -> Floats:
        """Return joint positions (m, n) on the line, ``PROBED`` apart, in an order in which already the
        first few leave no long gap."""
        at: Floats = self.start + _spread(int(self.size / PROBED))[:, None] * self.way
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

    def at(self, fraction: float) -> Floats:
        """Return the joint position (n,) on the parabola at a fraction (0 to 1) of its parameter."""
        q: Floats = self.start + 2.0 * fraction * self.into + fraction * fraction * (self.out - self.into)
        return q


@lru_cache(maxsize=256)
def _spread(count: int) -> Floats:
    """``count`` evenly spaced fractions between 0 and 1, in van der Corput's order: already the first few are
    spread over the whole range."""
    bits = count.bit_length()
    order = (int(f"{k:0{bits}b}"[::-1], 2) for k in range(1 << bits))
    found: Floats = np.array([k for k in order if 0 < k <= count], dtype=float) / (count + 1)
    return found


def rates(line: JointLine, half: float, movers: Movers, data: Any, bounds: Floats, first: int) -> Rates:
    """Compute upper bounds on how far each joint moves any point of each geom over a whole line.

    They hold along the part of the line that is within the share ``half`` of it from the state in ``data``.

    The lever is the distance of the geom's centre p from the axis u through a, |p - a|^2 - ((p - a) u)^2
    under a root, and its bounding radius. It grows by no more than the way G that the geom itself moves: G =
    sum_j (lever_j + G) w_j for joints that turn by w_j.

    Args:
        bounds: bounding radius of each geom (geoms,) [m].
        first: id of the first joint.
    """
    way, turned = np.abs(line.way), movers.turned
    u, a, p = data.xaxis[first : first + len(way)], data.xanchor[first : first + len(way)], data.geom_xpos
    along = p @ u.T - np.vecdot(a, u)
    square = np.vecdot(p, p)[:, None] - 2.0 * (p @ a.T) + np.vecdot(a, a) - along * along
    lever = (np.sqrt(np.maximum(square, 0.0)) + bounds[:, None]) * turned
    grown = (lever @ (half * way)) / (1.0 - half * float(way.sum()))
    each: Floats = (lever + grown[:, None] * turned) * way
    alone = each @ movers.still.T  # joints that move both do not count
    return Rates(alone + alone.T, float(each.sum(axis=1).max()))

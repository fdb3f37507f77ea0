"""Straight joint-space lines in parts, and how far each part may move any two geoms towards one another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from cramlite.model import Floats, Value

from .pairs import Movers

CHUNK = 0.6  # a line is cut into parts with less than this sum of joint differences [rad], for which levers are worked out
PROBED = 0.05  # largest joint difference [rad] between two places at which a line is probed


class Rates(Value):
    """Bounds of the approach of each two geoms over a whole line [m].

    Args:
        moves: (geoms, joints + 1): of a geom as seen from the link before a joint; 0 beyond the last one.
        beyond: of each geom, the first joint that moves others as seen from it.
        most: of any two.
    """

    moves: Floats
    beyond: Sequence[int]
    most: float

    def between(self, g: int, h: int) -> float:
        """Return the bound for two geoms [m]."""
        bound: float = self.moves.item(g, self.beyond[h]) + self.moves.item(h, self.beyond[g])
        return bound


class JointLine:
    """A straight joint-space line."""

    def __init__(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> None:
        self.start, self.way = np.asarray(a, dtype=float), np.subtract(b, a)
        self.size = float(np.abs(self.way).max())

    def at(self, fraction: float) -> Floats:
        """Return the joint position (n,) at a fraction of the line."""
        q: Floats = self.start + fraction * self.way
        return q

    def parts(self) -> list[tuple[float, float]]:
        """Return the ends of equal parts, as fractions of the line."""
        count = math.ceil(float(np.abs(self.way).sum()) / CHUNK + 1e-9)
        return [(k / count, (k + 1) / count) for k in range(count)]

    def probes(self) -> Floats:
        """Return joint positions (m, n) ``PROBED`` apart between the ends, such that few of the first ones leave no long gap."""
        at: Floats = self.start + _spread(int(self.size / PROBED))[:, None] * self.way
        return at


@lru_cache(maxsize=256)
def _spread(count: int) -> Floats:
    """Even fractions between 0 and 1 in van der Corput's order."""
    bits = count.bit_length()
    order = (int(f"{k:0{bits}b}"[::-1], 2) for k in range(1 << bits))
    found: Floats = np.array([k for k in order if 0 < k <= count], dtype=float) / (count + 1)
    return found


class Part(NamedTuple):
    """Part of a line between two fractions of it, with the bounds of the larger part that it was cut from."""

    line: JointLine
    low: float
    high: float
    known: Rates

    def cut(self, count: int) -> list[Part]:
        """Return equal smaller parts."""
        step = (self.high - self.low) / count
        ends = [*(self.low + k * step for k in range(count)), self.high]
        return [Part(self.line, a, b, self.known) for a, b in pairwise(ends)]


class Middles:
    """Places in the middle of parts of lines, which bounds of the arm's motion on these parts come from.

    Args:
        lines: each with fractions of it between which a part lies.
        movers: which joints move which geoms.
        first: id of the arm's first joint.
    """

    def __init__(self, lines: Sequence[tuple[JointLine, float, float]], movers: Movers, first: int) -> None:
        self.lines, self.movers = lines, movers
        count, joints = len(lines), movers.moved.shape[1]
        self.joints = slice(first, first + joints)
        self.points = np.empty((count, len(movers.rows), 3))
        self.axes, self.anchors = np.empty((count, joints, 3)), np.empty((count, joints, 3))

    def note(self, number: int, data: Any) -> None:
        """Keep where geoms and joints are in the middle of a part."""
        self.points[number] = data.geom_xpos[self.movers.rows]
        self.axes[number], self.anchors[number] = data.xaxis[self.joints], data.xanchor[self.joints]

    def parts(self, bounds: Floats) -> list[Part]:
        """Return the parts, each with bounds of how far the joints from each one on move any point of each geom over a whole line.

        The lever is the distance of the geom's centre p from the axis u through a, |u x (p - a)|, and its bounding radius. It grows by
        no more than the way G that the geom itself moves: G = sum_j (lever_j + G) w_j for joints that turn by w_j.

        Args:
            bounds: bounding radius of each geom (geoms,) [m].
        """
        way, half = np.array([line.way for line, _, _ in self.lines]), np.array([(high - low) / 2 for _, low, high in self.lines])
        rows, size, half = self.movers.rows, np.abs(way)[:, None], half[:, None, None]
        turned, radius = self.movers.turned[rows], bounds[rows, None]
        off = _cross(self.axes.swapaxes(1, 2)[:, None], self.points[:, :, :, None] - self.anchors.swapaxes(1, 2)[:, None])
        lever = turned * (np.sqrt(np.einsum("ngkj,ngkj->ngj", off, off)) + radius) * size
        grown = half * lever.sum(axis=2, keepdims=True) / (1.0 - half * size.sum(axis=2, keepdims=True))
        moves = np.zeros((len(way), len(bounds), way.shape[1] + 1))
        moves[:, rows, :-1] = (lever + grown * turned * size) @ np.tri(way.shape[1])  # of each joint and those after it
        most = moves[:, :, 0].max(axis=1).tolist()
        return [Part(*line, Rates(m, self.movers.beyond, t)) for line, m, t in zip(self.lines, moves, most, strict=True)]


def _cross(a: Floats, b: Floats) -> Floats:
    """The cross products along the third axis."""
    one, other = [1, 2, 0], [2, 0, 1]
    found: Floats = a[:, :, one] * b[:, :, other] - a[:, :, other] * b[:, :, one]
    return found

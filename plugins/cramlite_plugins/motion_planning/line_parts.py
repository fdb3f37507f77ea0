"""A straight joint-space line in parts, and how far shapes move along it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cramlite.model import Floats, Value

CHUNK = 0.3  # a line is cut into parts with less than this sum of joint differences [rad], for which levers are worked out


class Rates(Value):
    """How far each two geoms (geoms, geoms) may move towards one another over a whole line, and any at most [m]."""

    between: Floats
    most: float


Part = tuple[float, float, Rates | None]


class Line:
    """A straight joint-space line."""

    def __init__(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> None:
        self.start, self.way = np.asarray(a, dtype=float), np.subtract(b, a)
        self.size = float(np.abs(self.way).max())

    def at(self, fraction: float) -> Floats:
        q: Floats = self.start + fraction * self.way
        return q

    def parts(self) -> list[Part]:
        """The line in equal parts."""
        count = math.ceil(float(np.abs(self.way).sum()) / CHUNK + 1e-9)
        return [(k / count, (k + 1) / count, None) for k in range(count)]

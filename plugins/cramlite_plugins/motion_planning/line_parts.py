"""Joint-space line segments in equal parts, and how far shapes move along them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cramlite.model import Floats, Value

CHUNK = 0.3  # a line is cut into parts with less than this sum of joint differences [rad], for which levers are worked out


class Rates(Value):
    """Upper bounds of the approach of each two geoms (geoms, geoms) over a whole line, and of any two [m]."""

    between: Floats
    most: float


Part = tuple[float, float, Rates | None]


class JointLine:
    """Straight joint-space line."""

    def __init__(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> None:
        self.start, self.way = np.asarray(a, dtype=float), np.subtract(b, a)
        self.size = float(np.abs(self.way).max())

    def at(self, fraction: float) -> Floats:
        """Return the joint position (joints,) at a fraction of the line [rad]."""
        q: Floats = self.start + fraction * self.way
        return q

    def parts(self) -> list[Part]:
        """Split the line into equal parts."""
        count = math.ceil(float(np.abs(self.way).sum()) / CHUNK + 1e-9)
        return [(k / count, (k + 1) / count, None) for k in range(count)]

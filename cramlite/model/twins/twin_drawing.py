"""Random numbers of a twin, and the values drawn with them: each source of error has a generator of its
own."""

from __future__ import annotations

import math
from typing import Any

from ...base.seeds import derive_seed
from ...base.value import Value
from ..geometry import Vector3, vector3

LEAST = 0.05
"""Smallest random factor on friction, mass, size or force, however large the errors of the error model are."""
MM, DEG, PERCENT = 1000.0, 180.0 / math.pi, 100.0


class Draw(Value):
    """Error that was drawn at random for one property of a twin.

    Args:
        source: of error, a key of ``SOURCES``.
        name: for people: of what, and which.
        value: in ``unit``.
        size: the largest that could have been drawn, in ``unit``.
    """

    source: str
    name: str
    value: float
    size: float
    unit: str

    @property
    def share(self) -> float:
        """Drawn value as a share of the largest possible one, -1 to 1."""
        return self.value / self.size if self.size else 0.0

    def __str__(self) -> str:
        return f"{self.name} {self.value:+.3g} {self.unit}"


class Drawing:
    """Random generators of a twin; ``draws`` lists the numbers that were drawn, in their order.

    Args:
        scale: multiplies all sizes.
        seed: of the twin.
    """

    def __init__(self, scale: float, seed: int) -> None:
        self.scale, self.seed, self.draws = scale, seed, list[Draw]()
        self._random: dict[str, Any] = {}

    def random(self, source: str) -> Any:
        """Return the random generator of a source of error; each source has its own."""
        import numpy as np

        if source not in self._random:
            self._random[source] = np.random.default_rng(derive_seed(self.seed, (), source))
        return self._random[source]

    def number(self, source: str, name: str, size: float, unit: str, per: float) -> float:
        """Draw a random number uniformly between minus and plus ``size``, and multiply it by the twin's scale.

        The trace shows the number in ``unit``, of which ``per`` are one SI unit.
        """
        return self._noted(source, name, float(self.random(source).uniform(-1, 1)), size, unit, per)

    def share(self, source: str, name: str, size: float) -> float:
        """Draw a random factor that differs from 1 by at most ``size`` times the twin's scale."""
        return max(LEAST, 1.0 + self.number(source, name, size, "%", PERCENT))

    def ball(self, source: str, name: str, radius: float, unit: str, per: float = 1.0) -> Vector3:
        """Draw a random vector uniformly in a ball."""
        x, y, z = self.sphere(source)
        far = float(self.random(source).uniform()) ** (1 / 3)
        return tuple(self._noted(source, f"{name} {a}", far * v, radius, unit, per) for a, v in zip("xyz", (x, y, z), strict=True))  # type: ignore[return-value]

    def disc(self, source: str, name: str, radius: float, unit: str, per: float) -> tuple[float, float]:
        """Draw a random horizontal vector uniformly in a disc."""
        way = float(self.random(source).uniform(0.0, math.tau))
        far = float(self.random(source).uniform()) ** 0.5
        x, y = far * math.cos(way), far * math.sin(way)
        return self._noted(source, f"{name} x", x, radius, unit, per), self._noted(source, f"{name} y", y, radius, unit, per)

    def sphere(self, source: str) -> Vector3:
        """Draw a random direction, a vector of length 1, uniformly."""
        way = self.random(source).normal(size=3)
        return vector3(way / (way @ way) ** 0.5)

    def between(self, source: str, name: str, ends: tuple[float, float], unit: str, per: float) -> float:
        """Draw a random number uniformly between two limits."""
        low, high = ends
        return self._noted(source, name, float(self.random(source).uniform(low, high)) / (high or 1.0), high, unit, per)

    def _noted(self, source: str, name: str, share: float, size: float, unit: str, per: float) -> float:
        size *= self.scale
        if size:
            self.draws.append(Draw(source, name, round(share * size * per, 6), round(size * per, 6), unit))
        return share * size

"""Lines are probed while a path is looked for: what is blocked between two probes is not in the path that comes of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import pytest

from cramlite.model import Collision, Floats
from cramlite.plugin import Refused
from cramlite_plugins.kinematics.blends import Corner
from cramlite_plugins.motion_planning.planner import Path, plan

Joints = tuple[float, ...]
HALF, GAP = 0.002, (1.0, 1.6)
PROBED = 0.05


def crossing(a: Joints, b: Joints) -> Joints:
    """Where a line meets the middle of the wall."""
    part = a[0] / (a[0] - b[0])
    return (0.0, a[1] + part * (b[1] - a[1]))


class Foil:
    """Joint space with a wall of 4 mrad across it that probes every 50 mrad mostly miss, and a gap in it, or none."""

    limits = ((-2.0, 2.0), (-2.0, 2.0))

    def __init__(self, gap: tuple[float, float]) -> None:
        self.gap = gap

    def free(self, q: Sequence[float]) -> bool:
        return abs(q[0]) > HALF or self.gap[0] < q[1] < self.gap[1]

    def line_free(self, a: Sequence[float], b: Sequence[float]) -> bool:
        if not (self.free(a) and self.free(b)):
            return False
        if a[0] == b[0]:
            return True
        inside = [a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) for x in (-HALF, HALF) if min(a[0], b[0]) <= x <= max(a[0], b[0])]
        return all(self.gap[0] < y < self.gap[1] for y in inside)

    def blend_free(self, start: Floats, corner: Floats, goal: Floats) -> bool:
        return all(self.line_free(a.tolist(), b.tolist()) for a, b in pairwise(Corner(start, corner, goal, 1.0).sampled(0.0005)))

    def where_blocked(self, lines: Sequence[tuple[Joints, Joints]]) -> list[Joints | None]:
        return [None if self.line_free(a, b) else crossing(a, b) for a, b in lines]

    def line_probed(self, a: Sequence[float], b: Sequence[float], apart: float = PROBED) -> bool:
        count = max(1, math.ceil(math.dist(a, b) / apart))
        places = ([x + k / count * (y - x) for x, y in zip(a, b, strict=True)] for k in range(1, count + 1))
        return all(map(self.free, places))

    def blocked(self, a: Sequence[float], b: Sequence[float]) -> float | None:
        return None if self.line_free(a, b) else 0.5

    def why(self, q: Sequence[float]) -> str:
        return "" if self.free(q) else "in the foil"

    def blocking(self, q: Sequence[float]) -> tuple[str, ...]:
        return ()

    def collision(self, q: Sequence[float]) -> Collision | None:
        return None

    def relaxed(self, anchors: Sequence[Sequence[float]]) -> Foil:
        return self

    def tip(self, q: Sequence[float]) -> Sequence[float]:
        return (*q, 0.0)


@pytest.mark.parametrize("seed", range(6))
def test_a_path_goes_through_the_gap_and_not_between_two_probes(seed: int) -> None:
    foil = Foil(GAP)
    path = plan(foil, (-1.0, 0.0), [(1.013, -0.5)], seed=seed)  # type: ignore[arg-type]
    assert isinstance(path, Path), path
    assert all(foil.line_free(a, b) for a, b in pairwise(path.points))


def test_where_there_is_no_gap_there_is_no_path() -> None:
    foil = Foil((5.0, 5.0))
    assert foil.line_probed((-1.01, 0.0), (1.02, 0.0))  # it would seem so
    answer = plan(foil, (-1.01, 0.0), [(1.02, 0.0)], seed=0, samples=400)  # type: ignore[arg-type]
    assert isinstance(answer, Refused) and "no path" in answer.reason

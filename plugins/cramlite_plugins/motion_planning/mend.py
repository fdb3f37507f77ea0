"""Making a path free whose lines were only probed.

Its lines are checked all along. Where one is blocked between two probes, later lines are probed beside that
joint position, too, so that none runs through it again; a way around is looked for between the ends of the
blocked line, and the path is shortened again. Lines that are new in it are checked in the next round.

Source: Bohlin and Kavraki, Path planning using lazy PRM, ICRA 2000, for checks that are put off.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np

from cramlite.plugin import checkpoint

from .rrt import connected
from .shorten import shortened
from .space import Joints, Probed, Space

Points = tuple[Joints, ...]
Line = tuple[Joints, Joints]
ROUNDS = 6  # checks of a path, before it is given up
AROUND, MENDED = 1.0, 100
"""Margin around the ends of a blocked line within which a way around is sampled [rad], and the number of
samples."""
AGAIN = 20  # attempts to shorten a path that such ways were put into


def made_free(
    scene: Space, lines: Probed, points: Points, law: tuple[float, float], seed: int, ends: float
) -> Points:
    """Return a path that is free all along, made of one whose lines were probed; empty if none is found.

    Args:
        lines: how lines are probed; what its probes missed is added to it.
        law: speed and acceleration of the leading axis [rad/s, rad/s2].
        seed: of OMPL's generator, above 0.
        ends: ``time.monotonic`` after which it is cut [s].
    """
    known: set[Line] = set()
    for number in range(ROUNDS):
        checked = [line for line in pairwise(points) if line not in known]
        blocked = {line: at for line, at in zip(checked, scene.where_blocked(checked), strict=True) if at}
        if not blocked:
            return points
        known.update(line for line in checked if line not in blocked)
        lines.missed.extend(blocked.values())
        points = _around(scene, lines, points, blocked, seed + number, ends)
        if not points:
            return ()
        points = shortened(lines, points, *law, seed=seed, attempts=AGAIN)
    return ()


def _around(
    scene: Space, lines: Probed, points: Points, blocked: Collection[Line], seed: int, ends: float
) -> Points:
    """Path with ways around in place of its blocked lines; empty if one of these is not found."""
    result = [points[0]]
    for a, b in pairwise(points):
        checkpoint()
        way: Points | None = (a, b)
        if (a, b) in blocked:
            way = connected(scene, lines, a, [b], box(scene, [a, b], AROUND), seed, MENDED, ends).points
        if way is None:
            return ()
        result += way[1:]
    return tuple(result)


def box(scene: Space, positions: Sequence[Joints], margin: float) -> list[tuple[float, float]]:
    """Return the bounds (lower, upper) of each joint within a margin around some joint positions, inside the
    limits [rad]."""
    low, high = np.min(positions, axis=0) - margin, np.max(positions, axis=0) + margin
    return [(max(a, c), min(b, d)) for (a, b), c, d in zip(scene.limits, low, high, strict=True)]

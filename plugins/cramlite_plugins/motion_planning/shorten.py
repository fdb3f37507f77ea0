"""Path shortening: fewer stops and shorter ways, on collision-checked lines only."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from cramlite.plugin import checkpoint

from ..kinematics.timing import duration, segment_times

if TYPE_CHECKING:
    from .space import FreeLines

Joints = tuple[float, ...]
Points = tuple[Joints, ...]
WORTH = 0.005  # a change must save this share of the duration: below, it only costs checks
STALE = 20  # attempts without a gain after which it ends


def shortened(
    scene: FreeLines, points: Points, speed: float, acceleration: float, *, seed: int, attempts: int
) -> Points:
    """Shorten a path by random shortcuts and corner moves that lower its duration with stops at corners.

    Geraerts and Overmars, Creating High-quality Paths for Motion Planning, IJRR 2007: a random
    part of the path is replaced by a straight line if that is free; here also a corner is
    pulled towards the line between its neighbours. Cheap duration first, collision check last.

    Args:
        seed: of numpy's PCG64 generator; no global state.
        attempts: counted tries.
    """
    rng = np.random.default_rng(seed)
    path, stale = _skip_corners(scene, points, speed, acceleration), 0
    lasts = duration(path, speed, acceleration)
    for attempt in range(attempts):
        checkpoint()
        if len(path) < 3 or stale >= STALE:
            break
        propose: Callable[..., tuple[Points, list[tuple[Joints, Joints]]]] = (_cut, _pull)[attempt % 2]
        candidate, edges = propose(path, rng, speed, acceleration)
        shorter = duration(candidate, speed, acceleration)
        stale += 1
        if shorter < lasts * (1 - WORTH) and all(scene.line_free(a, b) for a, b in edges):
            path, lasts, stale = candidate, shorter, 0
    return path


def _skip_corners(scene: FreeLines, path: Points, speed: float, acceleration: float) -> Points:
    """Path that goes from each point straight to the furthest later point that can be reached and saves
    time."""
    result, i = [path[0]], 0
    while i < len(path) - 1:
        for j in range(len(path) - 1, i, -1):
            gain = duration(path[i : j + 1], speed, acceleration) - duration(
                (path[i], path[j]), speed, acceleration
            )
            if j == i + 1 or (gain > 0 and scene.line_free(path[i], path[j])):
                result.append(path[j])
                i = j
                break
    return tuple(result)


def _at(path: Points, times: Sequence[float], when: float) -> tuple[int, Joints]:
    """Index of a path's segment at a time, and the position there, if each segment is run through at constant
    speed."""
    ends = list(accumulate(times))
    k = min(bisect_left(ends, when), len(times) - 1)
    part = 1 - (ends[k] - when) / times[k] if times[k] > 0 else 0.0
    return k, tuple(x + part * (y - x) for x, y in zip(path[k], path[k + 1], strict=True))


def _cut(
    path: Points, rng: np.random.Generator, speed: float, acceleration: float
) -> tuple[Points, list[tuple[Joints, Joints]]]:
    """Replace the part of a path between two random times by a straight line.

    Half of the time, an end of the line is the nearest corner of the path outside of that part.
    """
    times = segment_times(path, speed, acceleration)
    first, last = sorted(rng.uniform(0, sum(times), 2).tolist())
    (i, a), (j, b) = _at(path, times, first), _at(path, times, last)
    head = path[: i + 1] if rng.random() < 0.5 else (*path[: i + 1], a)
    tail = path[j + 1 :] if rng.random() < 0.5 else (b, *path[j + 1 :])
    return (*head, *tail), [(head[-1], tail[0])]


def _pull(
    path: Points, rng: np.random.Generator, speed: float, acceleration: float
) -> tuple[Points, list[tuple[Joints, Joints]]]:
    """Move one corner towards the line between its neighbours, each joint by a random share of the
    distance."""
    k = int(rng.integers(1, len(path) - 1))
    a, b, c = (np.asarray(p) for p in path[k - 1 : k + 2])
    line = a + (c - a) * rng.uniform(0.2, 0.8)
    corner = tuple((b + (line - b) * rng.uniform(0, 1, len(b))).tolist())
    return (*path[:k], corner, *path[k + 1 :]), [(path[k - 1], corner), (corner, path[k + 1])]

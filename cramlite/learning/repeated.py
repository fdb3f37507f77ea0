"""Repetition in a path: its periodic part, and the mean of the periods."""

from __future__ import annotations

import numpy as np

from ..base.value import Value
from ..model.geometry import Floats
from ..model.shown_path import resampled

SMOOTHED = 0.15
"""Time over which the positions of a path are averaged to remove tremor [s]; a round of stirring takes 1 to 2 s."""
STEP = 0.003
"""Distance between the resampled positions of a path [m]; while the hand keeps still, no position is added."""
SHORTEST = 0.06
"""Least path length of one round of a repeated motion [m]: that of a circle of 10 mm radius."""
ALIKE = 0.2
"""Largest distance between positions one round apart at which a path counts as repeated, as a share of the round's extent: more than
people's rounds differ."""
ROUND = 48
"""Number of positions of a resampled round, or of a path that is not repeated."""


class Rounds(Value, eq=False):
    """Periodic part of a path: the mean of its repetitions, and their number.

    Args:
        mean: (ROUND, 3) places of the mean round [m].
        count: of rounds.
        rows: first and last place of it, in the places that were asked about.
    """

    mean: Floats
    count: float
    rows: tuple[int, int]


def evenly(times: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Return times (M,) and positions (M, 3) at even distances along a smoothed path."""
    count = max(round(SMOOTHED / float(np.median(np.diff(times)))) | 1, 1) if len(times) > 2 else 1
    padded = np.pad(points, ((count // 2, count // 2), (0, 0)), mode="edge")
    smooth = np.stack([np.convolve(padded[:, k], np.ones(count) / count, mode="valid") for k in range(3)], axis=1)
    kept = [0]
    for k in range(1, len(smooth)):
        if np.linalg.norm(smooth[k] - smooth[kept[-1]]) >= STEP:
            kept.append(k)
    line, at = smooth[kept], times[kept]
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    even = np.arange(0.0, lengths[-1] + 1e-9, STEP)
    return np.interp(even, lengths, at), np.stack([np.interp(even, lengths, line[:, k]) for k in range(3)], axis=1)


def rounds(points: Floats) -> Rounds | None:
    """Return the longest part of a path that repeats itself at least once; None if there is none.

    Args:
        points: (M, 3) at even distances ``STEP``.
    """
    found = [r for lag in range(round(SHORTEST / STEP), len(points) // 2 + 1) if (r := _alike(points, lag)) is not None]
    if not found:
        return None
    longest = max(end - start for start, end, _, _ in found)
    enough = [f for f in found if f[1] - f[0] >= 0.9 * longest]
    shortest = min(lag for _, _, lag, _ in enough)
    start, end, lag, _ = min((f for f in enough if f[2] <= 1.3 * shortest), key=lambda f: (f[3], f[2]))
    count = (end - start) / lag
    whole = int(count + 1e-9)
    each = [resampled(points[start + k * lag : start + (k + 1) * lag + 1], ROUND + 1) for k in range(whole)]
    mean = np.mean(each, axis=0)
    closed = mean - np.linspace(0.0, 1.0, ROUND + 1)[:, None] * (mean[-1] - mean[0])
    return Rounds(closed[:-1], count, (start, end - 1))


def strokes(points: Floats, touched: np.ndarray, least: float) -> list[tuple[int, int]]:
    """Return the first and last index of each stretch of a path on which a tool touches a surface; gaps and
    stretches shorter than ``least`` are ignored.

    Args:
        points: (M, 3) at even distances ``STEP``.
        touched: (M,) where there is contact.
        least: length of a stroke, and of a way between two [m].
    """
    rows, few = np.flatnonzero(touched), round(least / STEP)
    parts = np.split(rows, np.flatnonzero(np.diff(rows) > few) + 1) if len(rows) else []
    return [(int(p[0]), int(p[-1])) for p in parts if p[-1] - p[0] >= few]


def _alike(points: Floats, lag: int) -> tuple[int, int, int, float] | None:
    """Return the longest part of a path that repeats itself with a given period; None if it is shorter than
    two periods.

    The result is the indices of its first and last position, the period as a number of positions, and the
    mean distance between repetitions [m].
    """
    apart = np.linalg.norm(points[lag:] - points[:-lag], axis=1)
    extents = _extents(points, lag)[: len(apart)]
    close = np.concatenate([[False], apart <= ALIKE * extents, [False]])
    edges = np.flatnonzero(close[1:] != close[:-1])
    runs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    if not runs:
        return None
    first, last = max(runs, key=lambda r: (r[1] - r[0], -r[0]))
    if last - first < lag:
        return None  # less than two rounds
    return first, last + lag, lag, round(float(apart[first:last].mean()), 5)


def _extents(points: Floats, lag: int) -> Floats:
    """Return for each position the longest side [m] of the box around the path's next ``lag`` positions."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    ahead = {"size": lag, "axis": 0, "mode": "nearest", "origin": -(lag // 2)}
    return np.asarray((maximum_filter1d(points, **ahead) - minimum_filter1d(points, **ahead)).max(axis=1))

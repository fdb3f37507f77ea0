"""To-and-fro strokes in a thing's track, recognised by the thing's own motion, whatever other things are near."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ..base.value import Value
from ..model.episode import Episode
from ..model.geometry import Floats
from ..model.shown_path import ShownPath, length

TREMOR = 0.1
"""Time over which positions are averaged [s]: a quarter of the shortest stroke of a hand."""
LEAST = 0.016
"""Least length of a stroke [m]: three times the error of a tracker."""
ALIKE = 2.0
"""Largest ratio of two strokes' lengths, or durations, in one motion: people's strokes differ by a third."""
SLOWER = 3.0
"""Largest ratio of a stroke's duration to that of the shown stroke, since an arm accelerates at a quarter of a hand's rate."""
EDGE = 0.1
"""Share of a stroke's length, at each of its ends, that is left out when its duration is measured, since the hand may rest there."""
HEADINGS = 12
"""Number of headings (rotations about z) at which a path is compared with a track."""


class Strokes(Value, eq=False):
    """Longest sequence of similar to-and-fro strokes of a thing along a direction.

    Args:
        turns: rows of the track at which the strokes begin and end.
        size: median length of a stroke [m].
        seconds: median duration of a stroke at the speed of its middle [s].
    """

    turns: tuple[int, ...]
    size: float
    seconds: float

    @property
    def rounds(self) -> float:
        """Number of rounds, of two strokes each."""
        return (len(self.turns) - 1) / 2


def tracked(episode: Episode, mover: str, span: tuple[float, float]) -> tuple[Floats, Floats] | None:
    """Return times (N,) [s] and smoothed positions (N, 3) [m] of a thing in a span of an episode; None if fewer than
    three poses were recorded."""
    track = episode.tracks.get(mover)
    rows = (track.times >= span[0]) & (track.times <= span[1]) if track is not None else np.zeros(0, dtype=bool)
    if track is None or rows.sum() < 3:
        return None
    times, points = track.times[rows], track.poses[rows, :3]
    count = max(round(TREMOR / float(np.median(np.diff(times)))) | 1, 1)
    padded = np.pad(points, ((count // 2, count // 2), (0, 0)), mode="edge")
    return times, np.stack([np.convolve(padded[:, k], np.ones(count) / count, mode="valid") for k in range(3)], axis=1)


def strokes_along(times: Floats, values: Floats, size: float | None = None, seconds: float | None = None) -> Strokes | None:
    """Return the longest sequence of similar to-and-fro strokes in a signal (N,) [m]; None if there is none.

    Args:
        size, seconds: length [m] and duration [s] that strokes should have; those of the median stroke by default.
    """
    least = max(LEAST, (size or 0.0) / ALIKE)
    turns = _turns(values, least)
    each = np.array([(abs(values[b] - values[a]), _took(times[a : b + 1], values[a : b + 1])) for a, b in pairwise(turns)])
    if not len(each):
        return None
    shown = size is not None and seconds is not None
    wanted = np.array([size, seconds]) if shown else np.median(each, axis=0)
    most = wanted * (ALIKE, SLOWER if shown else ALIKE)
    alike = [bool(one[0] >= least and np.all(one <= most) and np.all(one >= wanted / ALIKE)) for one in each]
    first, last = max(_rows(alike), key=lambda r: (r[1] - r[0], -r[0]), default=(0, 0))
    if last == first:
        return None
    mean = np.median(each[first:last], axis=0)
    return Strokes(tuple(turns[first : last + 1]), float(mean[0]), float(mean[1]))


def _took(times: Floats, values: Floats) -> float:
    """Return the duration that a stroke would have if all of it were at the mean speed of its middle part [s]."""
    share = (values - values[0]) / (values[-1] - values[0])
    first = int(np.flatnonzero(share <= EDGE)[-1])
    last = first + int(np.flatnonzero(share[first:] >= 1 - EDGE)[0])
    begun, ended = share[first : first + 2], share[last - 1 : last + 1]
    start = np.interp(EDGE, begun, times[first : first + 2])
    end = np.interp(1 - EDGE, ended, times[last - 1 : last + 1])
    return float(end - start) / (1 - 2 * EDGE)


def _turns(values: Floats, least: float) -> list[int]:
    """Return the indices at which a signal (N,) reverses by at least a given length; its start and end count as
    reversals."""
    from scipy.signal import find_peaks

    far = float(np.ptp(values)) + 1.0
    ends = (np.r_[[values.min() - far], values, [values.min() - far]], np.r_[[-values.max() - far], -values, [-values.max() - far]])
    return sorted({int(k) - 1 for one in ends for k in find_peaks(one, prominence=least)[0]})


def _rows(alike: list[bool]) -> Iterator[tuple[int, int]]:
    """Yield, for each unbroken sequence of true values, the index of its first value and the index after its last."""
    edges = np.flatnonzero(np.diff(np.r_[[False], alike, [False]].astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def direction(points: Floats) -> Floats:
    """Return the unit vector (3,) along which a series of points (N, 3) moves most; its largest component is
    positive."""
    axis = np.linalg.svd(np.diff(points, axis=0), full_matrices=False)[2][0]
    return np.asarray(axis if axis[int(np.argmax(abs(axis)))] > 0 else -axis)


def done_in_place(path: ShownPath, episode: Episode, mover: str, span: tuple[float, float]) -> float:
    """Return how many rounds of a shown to-and-fro path a thing makes in a span of an episode, wherever it is, with the
    path turned about z as fits best."""
    found = tracked(episode, mover, span)
    if found is None:
        return 0.0
    axis = direction(path.corners)
    size, seconds = float(np.ptp(path.corners @ axis)), length(path.corners) / path.speed / 2
    most = 0.0
    for angle in 2 * np.pi * np.arange(HEADINGS) / HEADINGS:
        across = np.array([np.cos(angle), np.sin(angle)]) * np.hypot(axis[0], axis[1])
        strokes = strokes_along(found[0], found[1] @ np.array([*across, axis[2]]), size, seconds)
        most = max(most, strokes.rounds if strokes else 0.0)
    return most

"""Window queries on sampled signals: the samples in an action or at an instant, found once for all
boundaries of a timeline."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from cramlite.model import Floats, Track


class Samples:
    """Sampled signal that holds between samples, cut where states and actions begin and end.

    Args:
        times: (N,) ascending [s]; at least one.
        cuts: the boundaries of the timeline, ascending [s].
    """

    def __init__(self, times: Floats, cuts: tuple[float, ...]) -> None:
        self.times = times
        at = np.array(cuts)
        self._rows = dict(zip(cuts, self._at(at).tolist(), strict=True))
        self._ends = dict(zip(cuts, times.searchsorted(at, side="left").tolist(), strict=True))
        self._cuts = cuts

    def _at(self, times: Floats) -> np.ndarray:
        return np.maximum(self.times.searchsorted(times, side="right") - 1, 0)

    def row(self, time: float) -> int:
        """Return the index of the last sample at or before a time, or of the first one."""
        found = self._rows.get(time)
        if found is None:
            found = self._rows[time] = max(int(self.times.searchsorted(time, side="right")) - 1, 0)
        return found

    def window(self, start: float, end: float) -> slice:
        """Return the slice of samples from the last one at or before ``start`` to the last one before ``end``."""
        first, last = self.row(start), self._ends.get(end)
        if last is None:
            last = self._ends[end] = int(self.times.searchsorted(end, side="left"))
        return slice(first, max(last, first + 1))

    @cached_property
    def spans(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the windows of the signal, each from one boundary of the timeline to the next, as three flat
        arrays of samples.

        They are: for every sample of each window its row, and the row of the window's first sample, one window after
        the other; and where each window begins in them.
        """
        firsts = np.array([self._rows[a] for a in self._cuts[:-1]], dtype=int)
        sizes = np.maximum(np.array([self._ends[b] for b in self._cuts[1:]], dtype=int), firsts + 1) - firsts
        begins = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(int)
        first_of = np.repeat(firsts, sizes)
        return first_of + np.arange(len(first_of)) - np.repeat(begins, sizes), first_of, begins

    @cached_property
    def _next(self) -> dict[float, float]:
        return dict(pairwise(self._cuts))

    def pieces(self, start: float, end: float) -> list[float]:
        """Return the start times of those of the signal's time windows that together fill [start, end)
        exactly; empty if none do."""
        if self._next.get(start) == end:
            return [start]
        found, at = [], start
        while at < end and at in self._next:
            found.append(at)
            at = self._next[at]
        return found if at == end else []

    def by_start(self, values: np.ndarray) -> dict[float, float]:
        """Return a dictionary from the start time of each time window to its value; ``values`` has one for each
        window, in order."""
        return dict(zip(self._cuts, values.tolist(), strict=False))


class Motion(Samples):
    """Displacement and rotation of a frame since the beginning of a window.

    Args:
        track: the frame's poses; at least one.
        cuts: see ``Samples``.
    """

    def __init__(self, track: Track, cuts: tuple[float, ...]) -> None:
        super().__init__(track.times, cuts)
        self.poses = track.poses

    @cached_property
    def _distances(self) -> dict[float, float]:
        """Largest distance of the frame from its position at the start of a window [m], by the start of each
        window."""
        rows, first, begins = self.spans
        offset = self.poses[rows, :3] - self.poses[first, :3]
        squares = np.einsum("ij,ij->i", offset, offset)
        return self.by_start(np.sqrt(np.maximum.reduceat(squares, begins)) if len(begins) else squares)

    @cached_property
    def _angles(self) -> dict[float, float]:
        """Return the largest turn of the frame [rad] in each window of the signal, by the start time of the window."""
        rows, first, begins = self.spans
        cosines = np.abs(np.einsum("ij,ij->i", self.poses[rows, 3:], self.poses[first, 3:]))
        least = np.minimum.reduceat(cosines, begins) if len(begins) else cosines
        return self.by_start(2 * np.arccos(np.minimum(least, 1.0)))

    def leaves(self, start: float, end: float, limit: float) -> bool:
        """Check whether a frame gets farther than a limit [m] from where it was at the start of a time
        window.

        Of a longer action, the first piece may already be enough, or all pieces together not enough (with 1 % to
        spare, so that rounding cannot matter); otherwise all samples are looked at.
        """
        pieces = self.pieces(start, end)
        if pieces:
            first, *others = [self._distances[p] for p in pieces]
            if first > limit or first + sum(others) < 0.99 * limit or not others:
                return first > limit
        positions = self.poses[self.window(start, end), :3]
        offset = positions - positions[:1]
        return bool(np.sqrt(np.einsum("ij,ij->i", offset, offset).max()) > limit)

    def turns(self, start: float, end: float, limit: float) -> bool:
        """Check whether a frame turns by more than a limit [rad] from its orientation at the start of a time
        window."""
        pieces = self.pieces(start, end)
        if len(pieces) == 1:
            return self._angles[start] > limit
        turned = self.poses[self.window(start, end), 3:]
        return bool(2 * np.arccos(min(1.0, np.abs(turned @ turned[0]).min())) > limit)


class Range(Samples):
    """Minimum and maximum of a signal in a window.

    Args:
        times, cuts: see ``Samples``.
        values: (N,), at the times.
    """

    def __init__(self, times: Floats, values: Floats, cuts: tuple[float, ...]) -> None:
        super().__init__(times, cuts)
        self.values = values

    @cached_property
    def _values(self) -> list[float]:
        found: list[float] = self.values.tolist()
        return found

    @cached_property
    def _lows(self) -> dict[float, float]:
        rows, _, begins = self.spans
        return self.by_start(np.minimum.reduceat(self.values[rows], begins) if len(begins) else self.values[:0])

    @cached_property
    def _highs(self) -> dict[float, float]:
        rows, _, begins = self.spans
        return self.by_start(np.maximum.reduceat(self.values[rows], begins) if len(begins) else self.values[:0])

    def over(self, start: float, end: float) -> tuple[float, float]:
        """Return the least and the greatest value of a signal in [start, end); if start is end, the value then, twice."""
        if start == end:
            value = self._values[self.row(start)]
            return value, value
        pieces = self.pieces(start, end)
        if pieces:
            return min([self._lows[p] for p in pieces]), max([self._highs[p] for p in pieces])
        values = self.values[self.window(start, end)]
        return float(values.min()), float(values.max())

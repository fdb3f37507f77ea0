"""Signal processing of sampled contacts and poses: hysteresis, debouncing, moving averages, speeds."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats

Flags = NDArray[np.bool_]
#: Gaps shorter than this belong to the contact around them [s]; half of RobCoG's longest flicker.
GAP = 0.15
#: States shorter than this are impacts, not states [s].
SHORT = 0.06


def rotate_into_frame(quaternions: Floats, vectors: Floats) -> Floats:
    """Rotate vectors (N, 3) of the world into frames with quaternions (N, 4), w first: v - 2w (u x v) + 2 u x (u x v)."""
    w, u = quaternions[:, :1], quaternions[:, 1:]
    turned = np.cross(u, vectors)
    return np.asarray(vectors - 2 * w * turned + 2 * np.cross(u, turned))


def speed(points: Floats, times: Floats) -> Floats:
    """Return the speed (N,) of points (N, 3) over a window of GAP [m/s]: tremor and contact noise average out."""
    n = max(round(GAP / sampling_period(times)), 1)
    if len(points) <= n:
        return np.zeros(len(points))
    moving = np.linalg.norm(points[n:] - points[:-n], axis=1) / (n * sampling_period(times))
    before = n // 2
    return np.concatenate([np.full(before, moving[0]), moving, np.full(n - before, moving[-1])])


def sampling_period(times: Floats) -> float:
    """Return the sampling period [s]."""
    return float(np.median(np.diff(times))) if len(times) > 1 else GAP


def moving_average(signal: Floats, times: Floats, window: float) -> Floats:
    """Return the centred moving average of a signal over ``window`` [s]."""
    n = max(min(round(window / sampling_period(times)), len(signal)), 1)
    return np.convolve(signal, np.ones(n) / n, mode="same")


def hysteresis(signal: Floats, high: float, low: float) -> Flags:
    """Apply hysteresis: on when above ``high``, off when not above ``low``, else as before."""
    decided = np.where(signal > high, 1, np.where(signal <= low, -1, 0))
    decided[0] = decided[0] or -1
    last = np.maximum.accumulate(np.where(decided != 0, np.arange(len(signal)), 0))
    return np.asarray(decided[last] == 1)


def close_gaps(on: Flags, times: Floats, gap: float = GAP) -> Flags:
    """Fill gaps shorter than ``gap`` [s] between stretches in which a signal is on."""
    filled = on.copy()
    for (_, end), (start, _) in pairwise(runs(on)):
        if times[start] - times[end - 1] < gap:
            filled[end:start] = True
    return filled


def drop_short(on: Flags, times: Floats) -> Flags:
    """Clear each stretch in which a signal is on for less than ``GAP``."""
    kept = np.zeros_like(on)
    for start, end in runs(on):
        kept[start:end] = np.ptp(span_of(start, end, times)) >= GAP
    return kept


def intervals(on: Flags, times: Floats) -> list[tuple[int, int]]:
    """Return the index ranges in which ``on`` is true for a time of at least SHORT."""
    return [(s, e) for s, e in runs(on) if float(np.ptp(span_of(s, e, times))) >= SHORT]


def spans(on: Flags, times: Floats) -> list[tuple[float, float]]:
    """Return the time intervals [s] in which ``on`` is true for at least SHORT, once its gaps shorter than
    GAP are closed."""
    return [span_of(s, e, times) for s, e in intervals(close_gaps(on, times), times)]


def runs(on: Flags) -> list[tuple[int, int]]:
    """Return the index ranges in which ``on`` is true: the first index, and the one after the last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return [(int(s), int(e)) for s, e in edges.reshape(-1, 2)]


def span_of(start: int, end: int, times: Floats) -> tuple[float, float]:
    """Return the time interval of an index range [s]."""
    return float(times[start]), float(times[end]) if end < len(times) else float(times[-1]) + sampling_period(times)

"""Flickering signals as intervals: hysteresis, gaps closed, moments dropped, moving averages, speeds."""

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


def rotate_back(quaternions: Floats, vectors: Floats) -> Floats:
    """Vectors (N, 3) of the world in frames with quaternions (N, 4), w first: v - 2w (u x v) + 2 u x (u x v)."""
    w, u = quaternions[:, :1], quaternions[:, 1:]
    turned = np.cross(u, vectors)
    return np.asarray(vectors - 2 * w * turned + 2 * np.cross(u, turned))


def speed(points: Floats, times: Floats) -> Floats:
    """Speed over GAP [m/s]: tremor and contact noise average out."""
    n = max(round(GAP / step(times)), 1)
    if len(points) <= n:
        return np.zeros(len(points))
    moving = np.linalg.norm(points[n:] - points[:-n], axis=1) / (n * step(times))
    before = n // 2
    return np.concatenate([np.full(before, moving[0]), moving, np.full(n - before, moving[-1])])


def step(times: Floats) -> float:
    return float(np.median(np.diff(times))) if len(times) > 1 else GAP


def smooth(signal: Floats, times: Floats, window: float) -> Floats:
    """Centred moving average over ``window`` seconds."""
    n = max(min(round(window / step(times)), len(signal)), 1)
    return np.convolve(signal, np.ones(n) / n, mode="same")


def hold(signal: Floats, high: float, low: float) -> Flags:
    """Hysteresis: on when above ``high``, off when not above ``low``, else as before."""
    decided = np.where(signal > high, 1, np.where(signal <= low, -1, 0))
    decided[0] = decided[0] or -1
    last = np.maximum.accumulate(np.where(decided != 0, np.arange(len(signal)), 0))
    return np.asarray(decided[last] == 1)


def closed(on: Flags, times: Floats) -> Flags:
    """Gaps shorter than GAP filled."""
    filled = on.copy()
    for (_, end), (start, _) in pairwise(runs(on)):
        if times[start] - times[end - 1] < GAP:
            filled[end:start] = True
    return filled


def lasting(on: Flags, times: Floats) -> Flags:
    """Only what holds for GAP at least."""
    kept = np.zeros_like(on)
    for start, end in runs(on):
        kept[start:end] = np.ptp(span_of(start, end, times)) >= GAP
    return kept


def intervals(on: Flags, times: Floats) -> list[tuple[int, int]]:
    """Index ranges in which a flag holds for SHORT at least."""
    return [(s, e) for s, e in runs(on) if float(np.ptp(span_of(s, e, times))) >= SHORT]


def spans(on: Flags, times: Floats) -> list[tuple[float, float]]:
    return [span_of(s, e, times) for s, e in intervals(closed(on, times), times)]


def runs(on: Flags) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return [(int(s), int(e)) for s, e in edges.reshape(-1, 2)]


def span_of(start: int, end: int, times: Floats) -> tuple[float, float]:
    return float(times[start]), float(times[end]) if end < len(times) else float(times[-1]) + step(times)

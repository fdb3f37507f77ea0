"""Swinging and tilting of a held thing, found in the thing's sampled poses, as no contact or support state
shows them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats

from ..tracks import compose
from .co_motion import STEP, Flags, Span
from .signals import runs

#: Shaking: this many swings to and fro, each of this amplitude [m] and shorter than this [s] (0.7 Hz and faster).
SWINGS, AMPLITUDE, SWING = 5, 0.008, 0.75
#: A thing is shaken at one place: its moving mean stays within this [m].
SHAKEN_AT = 0.05
#: Pouring: tilted this far [rad] from how it stood, for this long [s]; a full cup spills from about 60 degrees.
TILT, POURED = np.radians(60), 0.5


def shaking(poses: Floats, start: int, end: int) -> list[Span]:
    """Return the spans in which a thing swings to and fro about its moving mean, along the principal axis
    with most swings."""
    half = round(SWING / STEP)
    path = poses[start:end, :3]
    if len(path) <= 2 * half:
        return []
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    padded = np.pad(path, ((half, half), (0, 0)), mode="edge")
    mean = np.column_stack([np.convolve(padded[:, i], kernel, mode="valid") for i in range(3)])
    swing = path - mean
    axes = np.linalg.svd(swing, full_matrices=False)[2]
    chains = max((_chains(swing @ axis) for axis in axes), key=lambda found: sum(map(len, found)))
    return [(start + s, start + e) for s, e in (_arrived(mean, int(c[0]), int(c[-1])) for c in chains)]


def _arrived(mean: Floats, start: int, end: int) -> Span:
    """Shorten a span of shaking to the time at the place of shaking, without the ways there and back.

    The place follows from the moving average of the thing's position.
    """
    near = np.flatnonzero(np.linalg.norm(mean[start:end] - np.median(mean[start:end], axis=0), axis=1) < SHAKEN_AT)
    return (start + int(near[0]), start + int(near[-1]) + 1) if len(near) else (start, end)


def _chains(signal: Floats) -> list[NDArray[np.intp]]:
    """Groups of at least SWINGS sign changes of a signal, as indices; each change is at most SWING [s] after
    the one before."""
    turns = _crossings(signal)
    chains = np.split(turns, np.flatnonzero(np.diff(turns) > SWING / STEP) + 1)
    return [c for c in chains if len(c) >= SWINGS]


def _crossings(signal: Floats) -> NDArray[np.intp]:
    """Indices at which a signal exceeds AMPLITUDE in magnitude for the first time since it last did so with the
    opposite sign."""
    outside = np.flatnonzero(np.abs(signal) > AMPLITUDE)
    flips = np.flatnonzero(np.diff(np.sign(signal[outside])) != 0)
    return np.asarray(outside[flips + 1])


def tilting(poses: Floats, stood: int, start: int, end: int) -> list[Span]:
    """Return the spans in which a thing is tilted by more than TILT from its orientation at the sample ``stood``."""
    upright = poses[stood] * [1, 1, 1, 1, -1, -1, -1]
    axis = compose(upright[None] * [0, 0, 0, 1, 1, 1, 1], np.array([[0, 0, 1, 1, 0, 0, 0.0]]))[0, :3]
    turned = poses[start:end] * [0, 0, 0, 1, 1, 1, 1]
    up = compose(turned, np.tile([*axis, 1, 0, 0, 0], (end - start, 1)))[:, 2]
    tilted: Flags = np.arccos(np.clip(up, -1, 1)) > TILT
    return [(start + s, start + e) for s, e in _joined(runs(tilted)) if (e - s) * STEP >= POURED]


def _joined(spans: Sequence[Span]) -> list[Span]:
    """Join neighbouring spans that are less than POURED [s] apart."""
    found: list[Span] = []
    for start, end in spans:
        if found and (start - found[-1][1]) * STEP < POURED:
            found[-1] = (found[-1][0], end)
        else:
            found.append((start, end))
    return found

"""Plots over time as stretchable SVG paths; labels are HTML beside them, so that they stay readable when narrow."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cramlite.model import Value

if TYPE_CHECKING:
    from cramlite.model import Floats

POINTS = 360
"""Largest number of points of a curve."""


class Curve(Value):
    """Named curve of a plot: an SVG path in a box of 1000 x 100."""

    name: str
    path: str


class Plot(Value):
    """Plot of curves of one quantity.

    Args:
        title, unit: for people.
        low, high: of the vertical axis.
        curves: over the whole run.
        values: curve by curve, rounded, at the slider's positions.
    """

    title: str
    unit: str
    low: float
    high: float
    curves: tuple[Curve, ...]
    values: tuple[tuple[float, ...], ...]


def plot(title: str, unit: str, times: Floats, curves: dict[str, Floats], ticks: Floats, *, zero: bool = False) -> Plot:
    """Make a plot of arrays (N,) over times (N,) [s]; ``ticks`` are the samples whose values are listed as
    numbers."""
    everything = np.concatenate(list(curves.values()))
    low, high = _nice(float(everything.min()), float(everything.max()), zero)
    paths = tuple(Curve(name, _path(times, y, low, high)) for name, y in curves.items())
    values = tuple(tuple(round(float(v), 2) for v in y[ticks]) for y in curves.values())
    return Plot(title, unit, low, high, paths, values)


def _nice(low: float, high: float, zero: bool) -> tuple[float, float]:
    """Round limits of an axis: multiples of a 1-2-5 step around the values; a constant gets room on both
    sides."""
    low = min(low, 0.0) if zero else low
    span = max(high - low, 1e-3 * max(abs(low), abs(high), 1.0))
    power = 10.0 ** math.floor(math.log10(span / 2))
    step = next(s * power for s in (1, 2, 5, 10, 20) if s * power * 4 >= span)
    bottom = min(math.floor(low / step) * step, low)
    return bottom, max(math.ceil(high / step) * step, high, bottom + step)


def _path(times: Floats, values: Floats, low: float, high: float) -> str:
    """SVG path of a curve from the lowest and the highest value of each stretch, so that no peak is lost."""
    x = (times - times[0]) / max(float(times[-1] - times[0]), 1e-9) * 1000
    y = 100 - (values - low) / (high - low) * 100
    keep: set[int] = {0, len(x) - 1}
    for stretch in np.array_split(np.arange(len(x)), min(POINTS // 2, len(x))):
        keep |= {int(stretch[np.argmin(y[stretch])]), int(stretch[np.argmax(y[stretch])])}
    return "M" + "L".join(f"{x[k]:.1f} {y[k]:.1f}" for k in sorted(keep))

"""Least values of a measured signal in time windows: a short peak does not raise them."""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats


def lasting(values: Floats, times: Floats, seconds: float) -> Floats:
    """Return the least value in a time window (M,), for each sample at which one begins; one 0 if the run is
    shorter than the window.

    Args:
        values, times: (N,), evenly sampled.
    """
    from numpy.lib.stride_tricks import sliding_window_view

    if len(times) < 2 or times[-1] - times[0] < seconds:
        return np.zeros(1)
    count = 1 + round(seconds / float(times[1] - times[0]))
    least: Floats = sliding_window_view(values, count).min(axis=1)
    return least

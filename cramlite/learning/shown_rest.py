"""Pause at the end of a learned task: in all its demonstrations, the hand keeps still at the end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base.value import Value
from ..interpretation.path_predicate import rests
from .span import Span

LEAST = 1.5
"""Shortest pause at the end of a demonstration that belongs to the task [s]: people hesitate for up to 0.6 s, and recordings go on for a
moment."""
ENOUGH = 0.75
"""Share of the shortest demonstrated pause, from which a pause counts as the learned one."""


class ShownRest(Value):
    """Pause with which all examples end: the hand keeps still for a time.

    Args:
        duration_s: the median of the examples.
        least_s: from which it counts.
    """

    duration_s: float
    least_s: float


def shown_rest(spans: Sequence[Span]) -> ShownRest | None:
    """Return the pause with which all examples end (the hand keeps still); None if one has none."""
    times = []
    for span in spans:
        episode = span.timeline.episode
        found = list(rests(episode, span.effector, (span.start, span.end))) if span.effector else []
        times.append(found[-1][1] - found[-1][0] if found else 0.0)
    if min(times, default=0.0) < LEAST:
        return None
    return ShownRest(round(float(np.median(times)), 1), round(ENOUGH * min(times), 1))

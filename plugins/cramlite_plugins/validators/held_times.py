"""Times of a run at which a condition of a rule holds, for a message that it does not hold when it should."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from cramlite.plugin import Clause, Phase, Timeline

MOMENT = 0.1  # how often it is looked [s]: at 0.1 m/s the pads, 38 mm long, pass in 0.4 s
LISTED = 3  # times: a contact that chatters has dozens

Span = tuple[float, float]


def held_times(clause: Clause, bindings: Iterable[dict[str, Any]], timeline: Timeline) -> list[Span]:
    """Return the spans of the run [s] in which a condition holds for at least one of some bindings of its variables.

    Moments begin and end together.

    What is asked all through an action is asked of each piece between two changes of state, as for a demonstration; what is
    asked of a moment, of those changes and of every ``MOMENT``.
    """
    from cramlite.plugin import Phase

    def holds(phase: Phase) -> bool:
        return any(next(clause.condition.solve(phase, b), None) is not None for b in bindings)

    if clause.phase == "run":
        return _joined([(a, b, holds(Phase(timeline, a, b))) for a, b in pairwise(timeline.cuts)])
    first, last = timeline.cuts[0], timeline.cuts[-1]
    moments = sorted({*timeline.cuts, *np.arange(first, last, MOMENT).tolist()})
    return _joined([(t, t, holds(timeline.instant(t))) for t in moments])


def _joined(pieces: Iterable[tuple[float, float, bool]]) -> list[Span]:
    """Spans in which a condition holds, neighbouring ones united."""
    found: list[Span] = []
    before = False
    for start, end, held in pieces:
        if held:
            found[-1:] = [(found[-1][0], end)] if before else [*found[-1:], (start, end)]
        before = held
    return found


def said_times(spans: list[Span]) -> str:
    """Format spans as "it held from 16.34 to 17.00 s"; empty where it never did."""
    if not spans:
        return ""
    said = [f"at {a:.2f} s" if b - a < 0.005 else f"from {a:.2f} to {b:.2f} s" for a, b in spans[:LISTED]]
    more = len(spans) - LISTED
    return f"it held {', '.join(said)}" + (f" and {more} times more" if more > 1 else " and once more" if more == 1 else "")


def said_values(clause: Clause, bindings: Iterable[dict[str, Any]], phase: Phase) -> str:
    """Format the measured value of a comparison in a rule, as ": it is 2"; "" for other conditions, or
    without a value."""
    from cramlite.plugin import Compare

    if not isinstance(clause.condition, Compare):
        return ""
    found = {v for b in bindings for v in clause.condition.values(phase, b)}
    shown = sorted(v if isinstance(v, str) else f"{v:.4g}" for v in found)
    return f": it is {', '.join(shown[:LISTED])}" if shown else ""

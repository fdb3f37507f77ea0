"""Times at which the code of each task ran."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cramlite.model import enclosing_names
from cramlite.plugin import Candidate

from ..shapes.itself import remembered


class Span(NamedTuple):
    """First and last time [s] at which the code of an action ran, or a condition held."""

    start: float
    end: float


def task_at(candidate: Candidate, sample: int) -> str:
    """Return the task of the plan whose code ran at a sample."""
    return candidate.written.task_of(int(candidate.ran.lines[sample]))


@remembered
def origins(candidate: Candidate) -> list[str]:
    """Return for each sample the designator whose code ran then, e.g. "3.Placing/PuttingDown/lower"; "" before
    the first step, the last one after the end."""
    rollout, code = candidate.ran, candidate.written
    starts, lines = sorted(code.origins), rollout.lines.astype(int)
    running = np.flatnonzero(lines)
    last = int(running[-1]) if len(running) else -1
    lines = np.where(np.arange(len(lines)) > last, lines[last] if last >= 0 else 0, lines)
    before = np.searchsorted(starts, lines, side="right") - 1
    return [code.origins[starts[k]] if k >= 0 else "" for k in before]


@remembered
def inner_tasks(candidate: Candidate) -> list[str]:
    """Return for each sample the innermost action (one of the plan, or a part of such an action) whose code
    ran; "" if none."""
    known = {a.name for a in (*candidate.actions, *candidate.parts)}
    found = origins(candidate)
    inner = {o: next((n for n in enclosing_names(o) if n in known), "") for o in set(found)}
    return [inner[o] for o in found]


def span(candidate: Candidate, task: str) -> Span | None:
    """Span in which the code of an action (one of the plan, or a part of such an action) ran; None if it never ran."""
    rollout, code = candidate.ran, candidate.written
    starts = sorted(code.origins)
    inside = [task in enclosing_names(code.origins[k]) for k in starts]
    before = np.searchsorted(starts, rollout.lines.astype(int), side="right") - 1
    samples = [k for k, b in enumerate(before) if b >= 0 and inside[b]]
    return Span(float(rollout.times[samples[0]]), float(rollout.times[samples[-1]])) if len(samples) > 1 else None

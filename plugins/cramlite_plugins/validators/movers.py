"""Task that moves each thing, at each sample of a run: from the grip until the released thing has come to
rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from cramlite.model import Floats, Rollout, rotations
from cramlite.plugin import PADDING, Candidate

from ..shapes.itself import remembered
from .explained import EARLY, explained_at
from .task_times import inner_tasks

SETTLE = 1.0
"""Longest time for which things settle at the start of a run [s]: a perceived pose is some millimetres off, so that a thing that is
believed to float, or to be inside of its support, drops or rises by that."""
REST = 0.01  # a thing at rest moves slower than this [m/s] ...
OVER = 0.2  # ... over so long [s]: what bounces or rocks is slow at its turning points for less
LOOKED_AT = 64  # so many windows are looked at at once
LEVER = 0.05  # by this a turn counts as way [m]: half the size of the things that hands take


Moved = dict[str, list[str | None]]
"""Thing that can be moved -> the task that moves it at each sample; "" while it settles at the start, None while nobody does."""


@remembered
def moved_by(candidate: Candidate) -> Moved:
    """Return the task that moves each thing, at each sample.

    A task moves its payload, which a grip that the plan explains holds while the task runs, from when the fingers close on it until it
    has come to rest after its release, whatever runs meanwhile. It moves what it says that it moves, all through, until its effects
    have appeared. What rests again is nobody's, though the task that let go of it still runs.
    """
    rollout = candidate.ran
    tasks, held = inner_tasks(candidate), explained_at(candidate)
    loose = [t.name for t in rollout.world.things if t.movable or t.joint]
    moved: Moved = {name: [None] * len(tasks) for name in loose}
    for name in loose:
        _charge(moved[name], "", 0, min(rests(rollout, name, 0), _after(rollout, 0, SETTLE)))
    for task, rows in _stretches(tasks):
        declared = candidate.allowances[task].moves if task in candidate.allowances else frozenset()
        for name, own in (*_stretches(held, rows), *((name, rows) for name in sorted(declared))):
            if name in moved:
                first = own[0] if name in declared else max(rows[0], _after(rollout, own[0], -EARLY))
                until = max(_after(rollout, own[-1], PADDING), rests(rollout, name, own[-1]))
                _charge(moved[name], task, first, until)
    return moved


def _stretches(names: Sequence[str], rows: range | None = None) -> Iterator[tuple[str, range]]:
    """Yield each stretch of consecutive samples with the same entry in ``names``, with that entry; of the
    samples ``rows`` only, if given."""
    for name, same in groupby(rows or range(len(names)), key=lambda k: names[k]):
        own = list(same)
        yield name, range(own[0], own[-1] + 1)


def _charge(moved: list[str | None], task: str, first: int, end: int) -> None:
    moved[first:end] = [task] * (min(end, len(moved)) - first)


def _after(rollout: Rollout, sample: int, time: float) -> int:
    return int(np.searchsorted(rollout.times, rollout.times[sample] + time, side="right"))


def rests(rollout: Rollout, name: str, sample: int) -> int:
    """Return the first sample, from a given one on, from which a thing stays at rest for a while; the
    number of samples if it never does."""
    from numpy.lib.stride_tricks import sliding_window_view

    step = float(rollout.times[1] - rollout.times[0]) if len(rollout.times) > 1 else OVER
    count = max(2, round(OVER / step) + 1)
    track = rollout.poses[name][sample:]
    for first in range(0, len(track) - count + 1, LOOKED_AT):  # most things rest at once
        way = _way(track[first : first + LOOKED_AT + count - 1])
        spread = np.ptp(sliding_window_view(way, count, axis=0), axis=-1).reshape(-1, 3, 3)
        still = np.flatnonzero(np.linalg.norm(spread, axis=2).max(axis=1) <= REST * OVER)
        if len(still):
            return sample + first + int(still[0])
    return len(rollout.times)


def _way(track: Floats) -> Floats:
    """(N, 9) positions of three points of a thing [m], its origin and two beside it: a thing that only
    turns is not at rest."""
    arms = LEVER * rotations(track[:, 3:])
    return np.hstack([track[:, :3], track[:, :3] + arms[:, :, 0], track[:, :3] + arms[:, :, 1]])

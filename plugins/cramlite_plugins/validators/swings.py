"""Where a thing should be in the hand at each sample: where it was gripped, but for the turns that the program declares."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cramlite.model import Floats, MoveLinear, Swing, walk
from cramlite.plugin import Candidate

from .task_times import origins

FINE = 61  # poses of a turn that are looked at: 1 deg apart


class Turn(NamedTuple):
    """Turn of a held thing in the hand, as the program declares it, with the first and last sample of its
    motion."""

    swing: Swing
    first: int
    last: int


def declared(candidate: Candidate) -> list[Turn]:
    """Return the turns of the payload in the hand that a program declares and whose motions ran, in the
    order in which they ran."""
    steps: dict[str, list[Swing]] = {}
    for step in walk(candidate.program.steps):
        if isinstance(step, MoveLinear) and step.swing is not None:
            steps.setdefault(step.origin, []).append(step.swing)
    if not steps:
        return []
    came_from, found = np.array(origins(candidate)), []
    for origin, swings in steps.items():
        ran = np.flatnonzero(came_from == origin)
        if len(ran):
            found.append(Turn(Swing(swings[0].start, swings[-1].end, swings[0].pivot), int(ran[0]), int(ran[-1])))
    return sorted(found, key=lambda turn: turn.first)


def off(local: Floats, first: int, turns: Sequence[Turn]) -> Floats:
    """Return how far a held thing's positions (n, 3) in the effector's frame, from sample ``first`` on, are
    from where they should be [m].

    That is the first of them, during a turn the nearest on its way, and after it its end.
    """
    away = np.linalg.norm(local - local[0], axis=1)
    at = first + np.arange(len(local))
    for swing, begin, end in turns:
        if end < first or begin >= first + len(local):
            continue
        way = np.array([swing.at(share).position for share in np.linspace(0.0, 1.0, FINE)])
        turning, after = (at >= begin) & (at <= end), at > end
        away[turning] = np.linalg.norm(local[turning][:, None] - way, axis=2).min(axis=1)
        away[after] = np.linalg.norm(local[after] - way[-1], axis=1)
    return np.asarray(away)

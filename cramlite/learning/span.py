"""Spans of episodes with the facts that hold in them: one table over the things for each predicate and phase."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..interpretation.interpretation import ELSEWHERE
from ..interpretation.timeline import Phase, PhaseName, Predicate, Segment, Timeline

Truths = npt.NDArray[np.bool_]
"""Truth of a condition for each filling of its roles, one axis for each role over the things of a span."""


class Span:
    """Span of an episode that a task may fill, with the facts just before it, throughout it, and just after
    it.

    Args:
        timeline: of the episode.
        start, end: [s].
    """

    def __init__(self, timeline: Timeline, start: float, end: float) -> None:
        self.timeline, self.start, self.end = timeline, start, end
        self.effector = timeline.episode.effector
        self.things = tuple(n for n, e in timeline.entities.items() if e.part_of is None and n != self.effector)
        self.phases: dict[PhaseName, Phase] = dict(timeline.phases(Segment(start, end)))
        self._index = {n: k for k, n in enumerate((*self.things, *([self.effector] if self.effector else [])))}
        self._holds: dict[tuple[str, str], Truths] = {}
        self._values: dict[tuple[str, str], npt.NDArray[np.float64]] = {}

    def __str__(self) -> str:
        return f"{self.timeline.episode.name} ({self.start:.2f} to {self.end:.2f} s)"

    def elsewhere(self, thing: str) -> bool:
        """Check whether a thing's position at the end differs by more than ``ELSEWHERE`` from that at the
        start."""
        before, after = (self.timeline.episode.pose_at(thing, t) for t in (self.start, self.end))
        return before is not None and after is not None and math.dist(before.position, after.position) > ELSEWHERE

    def holds(self, predicate: Predicate, phase: PhaseName) -> Truths:
        """Return a table of the things for which a predicate holds, with one axis for each argument; the
        effector has the last index."""
        key = (predicate.name, phase)
        if key not in self._holds:
            table = np.zeros((len(self.things) + 1,) * predicate.arity, dtype=np.bool_)
            for row in self.phases[phase].rows(predicate, (None,) * predicate.arity):
                places = tuple(self._index.get(str(name), -1) for name in row)
                if -1 not in places:
                    table[places] = True
            self._holds[key] = table
        return self._holds[key]

    def of_class(self, predicate: Predicate, class_: str) -> Truths:
        """Return a mask of the things for which a predicate, whose arguments are a thing and a class, holds; the
        effector has the last index."""
        key = (predicate.name, class_)
        if key not in self._holds:
            phase, place = self.phases["pre"], predicate.classes[0]
            table = np.zeros(len(self.things) + 1, dtype=np.bool_)
            for name, k in self._index.items():
                arguments = (class_, name) if place == 0 else (name, class_)
                table[k] = bool(phase.rows(predicate, arguments))
            self._holds[key] = table
        return self._holds[key]

    def values(self, predicate: Predicate, phase: PhaseName) -> npt.NDArray[np.float64]:
        """Return the largest values of a predicate that is a number, as a table over its arguments; NaN
        without a value."""
        key = (predicate.name, phase)
        if key not in self._values:
            self._values[key] = self._valued(predicate, phase)
        return self._values[key]

    def _valued(self, predicate: Predicate, phase: PhaseName) -> npt.NDArray[np.float64]:
        table = np.full((len(self.things) + 1,) * predicate.arity, np.nan)
        rows = list(self.phases[phase].rows(predicate, (None,) * predicate.arity))
        if not rows and predicate.arity:  # some can be asked of known arguments only
            names = list(self._index)
            for places in np.ndindex(*(len(names),) * predicate.arity):
                if len(set(places)) == len(places):
                    rows += self.phases[phase].rows(predicate, tuple(names[k] for k in places))
        for *arguments, value in rows:
            places = tuple(self._index.get(str(name), -1) for name in arguments)
            if -1 not in places:
                table[places] = np.fmax(table[places], float(value))
        return table

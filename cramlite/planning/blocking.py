"""Blockings: tasks that geometry or physics refuse while things are as other tasks have left them, for the next symbolic plan.

This is how refusals of grasps, places, paths and proofs come back to the planner (Srivastava et al. 2014, "Combined task and motion
planning through an extensible planner-independent interface layer"). A blocking rules out what was shown to fail and no more: it ends
as soon as a task changes one of its things.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..base.value import Value
from ..interpretation.fluents import Fact
from ..model.entity_name import thing_of
from .handling import Done, Track, done, history, said
from .operators import Operator
from .refutation import Refutation


class Blocking(Value):
    """Task that is refused while things are as they are (a no-good over tasks).

    Args:
        task: that is refused.
        tracks: its things, each with what had been done to it.
    """

    task: Done
    tracks: tuple[Track, ...]

    def bars(self, before: Sequence[Operator], step: Operator) -> bool:
        """Check whether a task is refused behind others: whether they have left all its things as they were."""
        return done(step) == self.task and all(history(before, t.thing) == t.past for t in self.tracks)

    def __str__(self) -> str:
        left = [f"'{t.thing}' {'after ' + ', '.join(map(said, t.past)) if t.past else 'as it was'}" for t in self.tracks]
        return f"no {said(self.task)} with {' and '.join(left)}"


def blocking_of(
    found: Refutation, steps: Sequence[Operator], facts: Sequence[frozenset[Fact]], loose: frozenset[str]
) -> Blocking | None:
    """Return what a refuted task sequence says of all sequences: that its last refused task fails while all that its failure
    depends on is as it was.

    Args:
        facts: before each step.
        loose: things that tasks can change. With one of them goes what may carry it, or be carried by it.

    Returns:
        None where nothing was refused in a task of the sequence.
    """
    tasks = [k for k in found.tasks if k <= len(steps)]
    if not tasks:
        return None
    last = tasks[-1]
    about = {thing_of(e) for k in tasks for e in steps[k - 1].roles.values()}
    about = (about | set(found.things) if found.things is not None else set(loose)) & loose
    for names in [frozenset(map(thing_of, f[1:])) for f in facts[last - 1]]:
        about |= names & loose if names & about else set()
    return Blocking(done(steps[last - 1]), tuple(Track(t, history(steps[: last - 1], t)) for t in sorted(about)))

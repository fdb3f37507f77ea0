"""Blockings: tasks that geometry or physics refuse while things are as other tasks have left them, as facts for the planner.

This is how refusals of grasps, places, paths and proofs come back to the symbolic plan (Srivastava et al. 2014, "Combined task and
motion planning through an extensible planner-independent interface layer"). A blocking rules out what was shown to fail and no more:
it ends as soon as a task changes one of its things.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ..base.value import Value
from ..interpretation.fluents import EFFECTOR, Fact, Fluents, Pattern
from ..model.entity_name import thing_of
from .operators import Operator
from .refutation import Refutation

Done = tuple[str, tuple[tuple[str, str], ...]]
"""A task that was done: its class, and the entity of each role."""


class Blocking(Value):
    """Task that is refused while things are as they are (a no-good over tasks).

    Args:
        task: that is refused.
        since: thing -> the tasks, in order, that made it what it then was, of those that the refusal depends on; () for a thing
            that is still as it was at the start.
        reason: for people.
    """

    task: Done
    since: Mapping[str, tuple[Done, ...]]
    reason: str

    def bars(self, before: Sequence[Operator], step: Operator) -> bool:
        """Check whether a task is refused behind others: whether they have left all its things as they were."""
        return done(step) == self.task and all(history(before, t, set(past)) == past for t, past in self.since.items())

    def __str__(self) -> str:
        left = [f"'{t}' {'after ' + ', '.join(map(said, past)) if past else 'as it is'}" for t, past in self.since.items()]
        return f"not {said(self.task)} with {' and '.join(left)}"


def done(step: Operator) -> Done:
    """Return an operator as a task that was done."""
    return step.task, tuple(sorted(step.roles.items()))


def said(task: Done) -> str:
    """Format a task that was done for people: "Placing(tin, shelf)"."""
    return f"{task[0].split(':')[-1]}({', '.join(e for _, e in task[1] if e != EFFECTOR)})"


def history(steps: Iterable[Operator], thing: str, among: set[Done]) -> tuple[Done, ...]:
    """Return the tasks that made a thing what it is: all that take, let go of or actuate it, and those ``among`` that move it."""
    moving = ((done(s), changes(s.needs, s.adds, s.removes, s.fluents)) for s in steps)
    return tuple(one for one, moved in moving if thing in moved and (moved[thing] or one in among))


def changes(
    needs: Iterable[Fact], adds: Iterable[Fact], removes: Iterable[Pattern], fluents: Fluents
) -> dict[str, bool]:
    """Return what a task moves, by its preconditions and effects: entity, or parameter -> whether it is another one afterwards.

    What is taken or let go of is, and what a fact about it alone begins or ends for, such as a joint that is open now; what is in the
    hand before and after is only moved.
    """
    needs, adds, removes = frozenset(needs), frozenset(adds), frozenset(removes)
    held = {str(f[-1]) for f in needs | adds | removes if fluents[f[0]].in_hand and f[-1] is not None}
    changed = {p for p in removes | (adds - needs) if fluents[p[0]].in_hand or len(p) == 2}
    entities = {str(p[-1]) for p in changed if p[-1] is not None}
    return {e: e in entities for e in held | entities}


def blocking_of(
    found: Refutation, steps: Sequence[Operator], facts: Sequence[frozenset[Fact]], loose: Mapping[str, bool]
) -> Blocking | None:
    """Return what a refuted task sequence says of all sequences: that its last refused task fails while all that its failure
    depends on is as it was.

    Args:
        facts: before each step.
        loose: things that a task can change -> whether they have a joint.

    Returns:
        None where nothing was refused in a task of the sequence.
    """
    tasks = [k for k in found.tasks if k <= len(steps)]
    if not tasks:
        return None
    last, own = tasks[-1], {done(steps[k - 1]) for k in tasks}
    about = {thing_of(e) for k in tasks for e in steps[k - 1].roles.values()} | set(loose if found.things is None else found.things)
    about |= {c for f in facts[last - 1] for c in map(thing_of, f[1:]) if loose.get(c) and about & set(map(thing_of, f[1:]))}
    before = steps[: last - 1]
    since = {t: history(before, t, own) for t in sorted(about & loose.keys())}
    return Blocking(done(steps[last - 1]), since, found.reason)

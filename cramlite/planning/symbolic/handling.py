"""Handling of things by tasks: the tasks, found by their rules, that brought a thing to its place or into the
hand.

How the hand holds a thing is settled when it is taken, where it lies when it is let go of, and how far a joint is open by
the last task that changes it, whatever was before. What happens in between, while it is in the hand, makes no difference;
nor does a grasp that ends where it began.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from ...base.value import Value
from ...interpretation.fluents import EFFECTOR, Fact, Fluents, Pattern
from ..operators import Change, Operator

Done = tuple[str, tuple[tuple[str, str], ...]]
"""A task that was done: its class, and the entity of each role."""

Stage = tuple[int, Literal["", "taken", "other"]]
"""Progress of a thing along a task history: the number of tasks done, and whether the thing was grasped since and has not moved yet.
"taken" means grasped as the history says, "other" grasped otherwise, "" neither."""


class Handling(Value):
    """Effect of a task on a thing: whether it is grasped, held, moved or let go.

    Args:
        takes, lets_go: whether it begins, or ends, to be held.
        displaces: whether it is elsewhere, or its joint at another value, afterwards.
        holds: whether it is in the hand at some time of the task.
        settles: whether it is displaced in a way of its own, as a joint is, so that it no longer matters how it was before.
    """

    takes: bool
    lets_go: bool
    displaces: bool
    holds: bool
    settles: bool = False


def handled(
    needs: Iterable[Fact], adds: Iterable[Fact], removes: Iterable[Pattern], fluents: Fluents, moves: Iterable[str] = ()
) -> dict[str, Handling]:
    """Return what a task does to each thing, derived from its preconditions and effects: takes, moves, holds or releases it.

    For an action schema, parameters stand in the place of things.

    Held is what a fluent ``in_hand`` is about; it is displaced where a relation to anything but the hand begins or ends. What is
    not held is where a state of it alone ends, such as that a joint is closed, and what a task says that it moves, such as what is pushed.
    """
    needs, adds, removes = frozenset(needs), frozenset(adds), frozenset(removes)
    grips = {f for f in needs | adds | removes if fluents[f[0]].in_hand}
    holds = {str(f[-1]) for f in grips if f[-1] is not None}
    takes = {str(f[-1]) for f in grips & (adds - needs)}
    ends = {f[-1] for f in grips & removes}
    lets_go = (holds - takes) & {h for h in holds if h in ends or None in ends}
    new = [p for p in removes | (adds - fluents.implied(needs, holds)) if p not in grips and EFFECTOR not in p]
    settled = {str(p[1]) for p in new if len(p) == 2 and p[1] is not None and (p in removes or fluents[p[0]].excludes)}
    alone = settled | set(moves)
    moved = alone | {str(e) for p in new for e in p[1:] if e in holds}
    settled -= holds
    return {e: Handling(e in takes, e in lets_go, e in moved, e in holds, e in settled) for e in sorted(holds | alone)}


def moved_by(change: Change, fluents: Fluents) -> frozenset[str]:
    """Return the things, or terms of an action schema, that a task holds or displaces."""
    told = handled(change.needs, change.adds, change.removes, fluents, change.moves)
    return frozenset(t for t, how in told.items() if how.holds or how.displaces)


def done(step: Operator) -> Done:
    """Return the task of a planning action with the things in its roles, for a record of tasks that were
    done."""
    return step.doing, tuple(sorted(step.roles.items()))


def task_text(task: Done) -> str:
    """Format a task that was done for people: "Placing(tin, shelf)"."""
    return f"{task[0].split(':')[-1]}({', '.join(e for _, e in task[1] if e != EFFECTOR)})"


def history(steps: Iterable[Operator], thing: str) -> tuple[Done, ...]:
    """Return the tasks that changed a thing, in order; () while it is as at the start."""
    past, taken = list[Done](), list[Done]()
    for step in steps:
        how = handled(step.needs, step.adds, step.removes, step.fluents, step.moves).get(thing)
        if how is None:
            continue
        taken = [done(step)] if how.takes else taken
        if how.settles:
            past, taken = [done(step)], []
        elif how.displaces:
            past, taken = past + (taken if how.holds else [done(step)]), []
        if how.lets_go:
            past, taken = past + ([] if taken else [done(step)]), []
    return (*past, *taken)


class Track(Value):
    """Task history of a thing: the tasks of a plan that have changed the thing, to be compared one by one with the
    tasks of other plans.

    Args:
        thing: its name.
        past: the history, as ``history`` gives it.
    """

    thing: str
    past: tuple[Done, ...]

    def __str__(self) -> str:
        return f"'{self.thing}' " + (f"after {', '.join(map(task_text, self.past))}" if self.past else "as it was")

    def stages(self) -> list[Stage]:
        """List all stages of a thing's task history: how many of its tasks are done, and whether the history's next
        task, another task or none has grasped the thing since.
        """
        return [(k, how) for k in range(len(self.past) + 1) for how in ("", "taken", "other")]

    def after(self, stage: Stage | None, how: Handling, task: Done | None) -> Stage | None:
        """Return how far a thing has come along its known history of tasks after one more task; None if that
        task departs from the history.

        Args:
            stage: before it; None for another history, which may be forgotten.
            task: None for any that is not of this history.
        """
        if how.settles:
            return (1, "") if self.past[:1] == (task,) else None
        if stage is None:
            return None
        number, taken = stage
        if how.takes:
            taken = "taken" if self.past[number : number + 1] == (task,) else "other"
        if how.displaces and taken == "other":
            return None
        if how.displaces and (taken or not how.holds):
            if not taken and self.past[number : number + 1] != (task,):
                return None
            number, taken = number + 1, ""
        if how.lets_go and not taken:
            return (number + 1, "") if self.past[number : number + 1] == (task,) else None
        return (number, "" if how.lets_go else taken)

    def at_its_end(self) -> list[Stage]:
        """Return the stages at which the tasks that were done to a thing are exactly those of its task history."""
        ends: list[Stage] = [(len(self.past), "")]
        return [*ends, (len(self.past) - 1, "taken")] if self.past else ends

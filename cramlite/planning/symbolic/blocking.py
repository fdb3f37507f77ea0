"""Blockings: tasks that geometry or physics refuse while things are as other tasks have left them; later
plans avoid them.

This is how refusals of grasps, places, paths and proofs come back to the planner (Srivastava et al. 2014, "Combined task and motion
planning through an extensible planner-independent interface layer"). A blocking rules out what was shown to fail and no more: it ends
as soon as a task changes one of its things.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from ...base.value import Value
from ...interpretation.fluents import Fact
from ...model.entity_name import thing_of
from ..operators import Operator
from ..refutation import Refutation
from .handling import Done, Track, done, history, task_text

AnyOf = tuple[tuple[Track, ...], ...]
"""Set of things of which at least one is in the way: for each, its task history and those of its carriers."""


class Blocking(Value):
    """Blocking: a task is refused as long as certain things stay as they are (a no-good over tasks).

    Args:
        task: that is refused.
        sets: of things that are in the way, those of the task itself among them: while of each set one is as it was.
        shut: of the others those that are closed, where the task opens or closes something itself.
    """

    task: Done
    sets: tuple[AnyOf, ...]
    shut: frozenset[str] = frozenset()

    @property
    def tracks(self) -> tuple[Track, ...]:
        """Histories of the tasks done to each thing on which this blocking depends, without duplicates."""
        return tuple(dict.fromkeys(t for any_of in self.sets for tracks in any_of for t in tracks))

    def bars(self, before: Sequence[Operator], step: Operator) -> bool:
        """Check whether this blocking rules out the task ``step`` after the tasks ``before``.

        It does while at least one thing of each of its sets is as it was when the task failed.
        """
        if done(step) != self.task:
            return False
        same = {t for t in self.tracks if history(before, t.thing) == t.past}
        return all(any(same.issuperset(tracks) for tracks in any_of) for any_of in self.sets)

    def left_shut(self) -> Blocking:
        """Return this blocking so that it still forbids its task after a closed thing in the way, such as a drawer, was opened.

        It is without the sets of things in the way that name such a thing.

        A drawer or door takes the least room when it is closed.
        """
        return replace(self, sets=tuple(any_of for any_of in self.sets if all(tracks[0].thing not in self.shut for tracks in any_of)))

    def while_others_stay(self) -> Blocking:
        """Return the blocking without the blocked task's own things, so that it ends only when other things are moved.

        It is unchanged if it names no others.
        """
        own = {thing_of(e) for _, e in self.task[1]}
        others = tuple(any_of for any_of in self.sets if own.isdisjoint(tracks[0].thing for tracks in any_of))
        return replace(self, sets=others) if others else self

    def __str__(self) -> str:
        things = [[" with ".join(map(str, tracks)) for tracks in any_of] for any_of in self.sets]
        left = [one[0] if len(one) == 1 else f"any of {', '.join(one)}" for one in things]
        return f"no {task_text(self.task)} with {' and '.join(left)}"


def blocking_of(
    found: Refutation, steps: Sequence[Operator], facts: Sequence[frozenset[Fact]], loose: frozenset[str],
    same_room: frozenset[str] = frozenset(),
) -> Blocking | None:  # fmt: skip
    """Return the blocking that a refuted task sequence proves: its last refused task fails while certain
    things stay as they are.

    They are all that the failure depends on.

    Args:
        facts: before each step, those that rules ask about.
        loose: things that tasks can change. With one of them goes what may carry it, or be carried by it.
        same_room: of them those that take the same room whatever is done to them, as a knob: no task about one clears the way of another.

    Returns:
        None where nothing was refused in a task of the sequence.
    """
    tasks = [k for k in found.tasks if k <= len(steps)]
    if not tasks:
        return None
    before, last = steps[: tasks[-1] - 1], steps[tasks[-1] - 1]
    own = {thing_of(e) for k in tasks for e in steps[k - 1].roles.values()} & loose
    movable = loose - same_room | own
    sets: set[tuple[str, ...]] = {(t,) for t in (own if found.things is not None else movable)}
    sets |= {any_of for any_of in found.things or () if movable.issuperset(any_of)}  # else one that stays is in the way
    least = sorted((s for s in sets if not any(set(other) < set(s) for other in sets)), key=lambda s: (len(s), s))
    tracks = {t: _tracks(t, before, facts[len(before)], loose) for any_of in least for t in any_of}
    return Blocking(done(last), tuple(tuple(tracks[t] for t in any_of) for any_of in least))


def _tracks(thing: str, before: Sequence[Operator], facts: frozenset[Fact], loose: frozenset[str]) -> tuple[Track, ...]:
    """Return the tasks that were done so far with a thing, and those with each loose thing that some fact
    relates to it.

    The relation may lead through further things.
    """
    pairs = [frozenset(map(thing_of, f[1:])) & loose for f in facts]
    known = {thing}
    while more := {n for names in pairs if names & known for n in names} - known:
        known |= more
    return tuple(Track(t, history(before, t)) for t in (thing, *sorted(known - {thing})))

"""Choice of the reading of a demonstration that the report page shows, and the tasks that this reading gives to the actions."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cramlite import Finished, Interpretation
    from cramlite.plugin import Interpreted, Match, TaskSequence


def number_of(done: Finished) -> int:
    """Return the number of the candidate that the report shows, from 1: the one proven or run, else the first, whose reading is the
    best."""
    return done.shown.number if done.shown is not None else 1


def first_sequences(found: Interpretation | None, count: int) -> list[TaskSequence]:
    """Return the best readings, in the order in which they are tried."""
    return list(itertools.islice(found.sequences(), count)) if found is not None else []


def chosen_sequence(done: Finished) -> TaskSequence | None:
    """Return the reading that became the program."""
    number = number_of(done)
    sequences = first_sequences(done.interpretation, number)
    return sequences[number - 1] if len(sequences) >= number else None


def pair_up(found: Interpretation, sequence: TaskSequence | None) -> list[tuple[Interpreted, Match | None]]:
    """Pair each action with the task that the reading gives it; None where it leaves the action out, or no task explains it."""
    explained = [a for a in found.actions if not a.unexplained]
    given = {} if sequence is None else {id(explained[k]): m for k, m in zip(sequence.actions, sequence.matches, strict=True)}
    return [(action, given.get(id(action))) for action in found.actions]

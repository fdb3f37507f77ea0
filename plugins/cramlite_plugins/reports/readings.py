"""Which reading of the demonstration led to the solution."""

from __future__ import annotations

import itertools

from cramlite import Interpretation, Solution
from cramlite.interpretation import Interpreted, Match, TaskSequence


def first_sequences(solution: Solution, count: int) -> list[TaskSequence]:
    """The best readings, in the order in which they are tried."""
    found = solution.interpretation
    return list(itertools.islice(found.sequences(), count)) if found is not None else []


def chosen_sequence(solution: Solution) -> TaskSequence | None:
    """The reading that became the program."""
    sequences = first_sequences(solution, solution.number)
    return sequences[solution.number - 1] if len(sequences) >= solution.number else None


def pair_up(found: Interpretation, sequence: TaskSequence | None) -> list[tuple[Interpreted, Match | None]]:
    """Each action with the task that the reading gives it; None where no task explains it."""
    matches = iter(sequence.matches if sequence is not None else ())
    return [(action, None if action.hole else next(matches, None)) for action in found.actions]

"""Ranking of task sequences, and why one is better than another.

A sequence's score is a sum, so that the best ones can be found without listing all:

- *specificity* of each task: depth of its class below dul:Task, and a quarter for every condition that
  held. The more an interpretation claims (and the more of it was checked), the more it says.
- *changes explained*: 4 for every relation that the task's rule says begins or ends (a grasp, a support): what
  became of the world is what the action was for. 4 outweighs the depth of any class below another.
- *roles that carry over*: between neighbours, 2 if both handle the same thing (Patient, Locatum
  or Goal), 1 for each other shared filler. People finish with one thing before they turn to the next.
- *consistency between neighbours*: -2 if both are the same task on the same fillers: one of the two
  boundaries then tells nothing apart.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Sequence

from ..base.value import Value
from ..ontology.foundation import TASK
from ..ontology.taxonomy import Taxonomy
from .matching import Match

PER_CONDITION = 0.25
PER_CHANGE = 4.0
SAME_THING, SHARED, REPEATED = 2.0, 1.0, -2.0
_HANDLED = ("Patient", "Locatum", "Goal", "Source")

DEFAULT_CAP = 100_000
"""Unfinished sequences kept: about 20 MB."""


class TaskSequence(Value):
    """Sequence with one task for every explained action.

    Args:
        matches: the tasks with their roles, in order.
        score: higher is better.
        reason: what the score is made of.
    """

    matches: tuple[Match, ...]
    score: float
    reason: str


def specificity(match: Match, taxonomy: Taxonomy) -> float:
    """Return the score of how specific one interpretation of an action is."""
    depth = taxonomy.depth(match.task) - taxonomy.depth(TASK)
    return depth + PER_CONDITION * match.conditions + PER_CHANGE * match.changes


def affinity(before: Match, after: Match) -> float:
    """Return the score of how well two neighbours go together."""
    if before.task == after.task and before.roles == after.roles:
        return REPEATED
    handled = {before.roles.get(r) for r in _HANDLED} & {after.roles.get(r) for r in _HANDLED} - {None}
    shared = set(before.roles.values()) & set(after.roles.values()) - handled
    return SAME_THING * bool(handled) + SHARED * len(shared)


def best_first(
    choices: Sequence[Sequence[Match]], taxonomy: Taxonomy, cap: int = DEFAULT_CAP
) -> Iterator[TaskSequence]:
    """Yield all sequences in order of falling score: A* over the actions, with the exact best rest as its bound.

    Args:
        choices: the matches of each action, none of them empty.
        cap: unfinished sequences kept; beyond it the worst half is forgotten.
    """
    if not choices:
        return
    unary = [[specificity(m, taxonomy) for m in matches] for matches in choices]
    pairs = [[[affinity(a, b) for b in after] for a in before] for before, after in itertools.pairwise(choices)]
    rest = _best_rest(unary, pairs)
    tick = itertools.count()  # equal scores keep the order in which the rules are sorted
    heap: list[tuple[float, int, float, int, tuple[int, ...]]] = []
    for k, value in enumerate(unary[0]):
        heapq.heappush(heap, (-(value + rest[0][k]), next(tick), value, k, (k,)))
    while heap:
        _, _, score, last, path = heapq.heappop(heap)
        at = len(path)
        if at == len(choices):
            yield _sequence(choices, path, score, unary)
            continue
        for k, value in enumerate(unary[at]):
            reached = score + pairs[at - 1][last][k] + value
            heapq.heappush(heap, (-(reached + rest[at][k]), next(tick), reached, k, (*path, k)))
        if len(heap) > cap:
            heap = heapq.nsmallest(max(cap // 2, 1), heap)


def _best_rest(unary: list[list[float]], pairs: list[list[list[float]]]) -> list[list[float]]:
    """For every choice, the most that all later actions can add."""
    rest = [[0.0] * len(unary[-1])]
    for values, links in zip(reversed(unary[1:]), reversed(pairs), strict=True):
        below = rest[0]
        rest.insert(0, [max(link + v + b for link, v, b in zip(row, values, below, strict=True)) for row in links])
    return rest


def _sequence(
    choices: Sequence[Sequence[Match]], path: tuple[int, ...], score: float, unary: list[list[float]]
) -> TaskSequence:
    claimed = sum(unary[i][k] for i, k in enumerate(path))
    tasks = tuple(choices[i][k] for i, k in enumerate(path))
    return TaskSequence(tasks, score, f"specificity {claimed:g}, neighbours {score - claimed:+g}")

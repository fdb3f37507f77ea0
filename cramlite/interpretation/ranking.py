"""Ranking of task sequences by description length: the best is the shortest that explains all changes and nothing else.

A sequence's length is a sum over the actions of a demonstration, in bits, so that the best ones can be found without listing
all. A *name* costs as much as naming one task among all that there are rules for.

- *tasks*: a name for each task that the sequence has.
- *choices*: for each role, which of the things that would fit it as well, log2 of their number; none where it is known.
- *not known*: ``UNKNOWN`` for each condition that could not be judged.
- *unexplained*: what the sequence does not say must be told beside it: a relation that began or ended, three names; what the
  recording itself calls the action, two; that a more specific task of a user's own was done (``coherence.generic``), two; a
  thing that is elsewhere in the end and that some reading speaks of, one.
- *checked*: ``CHECKED`` less for each condition that held and each class above the task's: of two readings that say the same,
  the one that claims more, and was right. ``COUNTED`` less for a number that was measured while the action lasted: five swings
  happen by chance less often than that a thing moves, or is near another.

An action in which nothing changed may be left out, at no cost: no idle motion is part of a best sequence.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence

from ..base.value import Value
from ..model.entity_name import thing_of
from ..ontology.foundation import TASK
from ..ontology.taxonomy import Taxonomy
from .matching import Match

UNKNOWN = 1.0
"""Description length of a condition that could not be judged [bits]: that of one yes-or-no answer."""
CHECKED, COUNTED, MOST_CHECKED = 0.25, 1.5, 0.9
"""Bits by which a condition that held and a measured number shorten the description length, and the largest such saving as a share of
the bits of a name. Naming a task that explains nothing therefore never pays."""
CHANGE, LABEL, GENERIC, MOVED = 3.0, 2.0, 2.0, 1.0
"""Costs of what a reading leaves unexplained, in multiples of the bits of a name: a change, a label, a generic reading, a moved thing."""

DEFAULT_CAP = 100_000
"""Largest number of unfinished task sequences that the search keeps, which take about 20 MB."""


class DescriptionLength(Value):
    """Description length of a task sequence, or the part of it that one action adds [bits].

    Args:
        tasks, choices, unknown, unexplained, checked: see the module; ``checked`` is subtracted.
    """

    tasks: float = 0.0
    choices: float = 0.0
    unknown: float = 0.0
    unexplained: float = 0.0
    checked: float = 0.0

    @property
    def bits(self) -> float:
        """Total description length: the sum of its terms [bits]."""
        return self.tasks + self.choices + self.unknown + self.unexplained - self.checked

    def __add__(self, other: DescriptionLength) -> DescriptionLength:
        return DescriptionLength(
            self.tasks + other.tasks, self.choices + other.choices, self.unknown + other.unknown,
            self.unexplained + other.unexplained, self.checked + other.checked,
        )  # fmt: skip

    def __str__(self) -> str:
        return (
            f"{self.bits:.1f} bits: tasks {self.tasks:.1f}, choices {self.choices:.1f}, not known {self.unknown:.1f}, "
            f"unexplained {self.unexplained:.1f}, checked {-self.checked:.1f}"
        )


class Option(Value):
    """Way in which a task sequence reads an action: as one of the action's readings, or not at all.

    Args:
        match: the task; None to leave the action out.
        length: what it adds to the description.
        number: of the reading, counted from 0; -1 for none.
    """

    match: Match | None
    length: DescriptionLength
    number: int = -1


class TaskSequence(Value):
    """Sequence of tasks that a demonstration may have shown.

    Args:
        matches: the tasks with their roles, in order.
        actions: number of the action that each task is a reading of, among those that some task explains.
        lengths: what each action that some task explains adds to the description, those that are left out among them.
    """

    matches: tuple[Match, ...]
    actions: tuple[int, ...] = ()
    lengths: tuple[DescriptionLength, ...] = ()

    @property
    def length(self) -> DescriptionLength:
        """Description length of the whole task sequence."""
        return sum(self.lengths, DescriptionLength())

    @property
    def score(self) -> float:
        """Score of the sequence: its description length with the sign changed [bits]; a higher one is
        better."""
        return -self.length.bits

    @property
    def reason(self) -> str:
        """Explain the score: what each part of the description length adds, as text."""
        return str(self.length)


def naming_length(match: Match, fellows: Sequence[Match], taxonomy: Taxonomy, name: float) -> DescriptionLength:
    """Return the description length [bits] of telling which reading of an action is meant: its task and
    the fillers of its roles.

    Args:
        fellows: all readings of the action.
        name: bits of a name.
    """
    fillers: dict[str, set[str]] = defaultdict(set)
    for other in fellows:
        if other.task == match.task:
            for role, filler in other.roles.items():
                fillers[role].add(thing_of(filler))
    choices = sum(math.log2(len(fillers[role])) for role in match.roles)
    depth = taxonomy.depth(match.task) - taxonomy.depth(TASK)
    checked = min(CHECKED * (max(match.conditions, 0) + depth) + COUNTED * match.counted, MOST_CHECKED * name)
    return DescriptionLength(name, choices, UNKNOWN * len(match.unknown), checked=checked)


def shortest_first(
    options: Sequence[Sequence[Option]], allowed: Callable[[Sequence[int]], bool], cap: int = DEFAULT_CAP, most: int = DEFAULT_CAP
) -> Iterator[TaskSequence]:
    """Yield task sequences that a demonstration may show, the shortest description first, by A* over its actions.

    Args:
        options: for each action what may be said of it; none of them empty.
        allowed: whether a beginning of a sequence, the numbers of its readings, may go on.
        cap: unfinished sequences kept; beyond it the worst half is forgotten.
        most: unfinished sequences looked at.
    """
    rest = [0.0]
    for choices in reversed(options):
        rest.append(rest[-1] + min(o.length.bits for o in choices))
    rest.reverse()
    tick = itertools.count()  # of equal lengths the one that is nearer to its end, then in the order of the rules
    heap: list[tuple[float, int, int, float, tuple[Option, ...]]] = [(rest[0], 0, next(tick), 0.0, ())]
    for _ in range(most):
        if not heap:
            return
        *_, length, path = heapq.heappop(heap)
        if len(path) == len(options):
            if any(o.match for o in path):
                yield _sequence(path)
            continue
        for option in options[len(path)]:
            if allowed([*(o.number for o in path), option.number]):
                reached = length + option.length.bits
                bound = round(reached + rest[len(path) + 1], 9)
                heapq.heappush(heap, (bound, -len(path), next(tick), reached, (*path, option)))
        if len(heap) > cap:
            heap = heapq.nsmallest(max(cap // 2, 1), heap)


def _sequence(path: Sequence[Option]) -> TaskSequence:
    chosen = [(k, o.match) for k, o in enumerate(path) if o.match is not None]
    return TaskSequence(tuple(m for _, m in chosen), tuple(k for k, _ in chosen), tuple(o.length for o in path))

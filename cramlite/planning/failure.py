"""Text for a person on a failed search: how it ended, its nearest miss, what became of each goal, and remedies."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from .diagnosis import cause, how_it_ended, nearest_miss
from .goal_parts import GoalAnswer, goal_answers
from .trace import Entry, Trace
from .what_to_try import what_to_try

CAUSES = 3
"""Number of misses that are listed beside the nearest one."""


def failure_text(trace: Trace, faults: Iterable[object]) -> str:
    """Return the report of a failed search: the nearest miss, those of other candidates, each cause once, and
    remedies."""
    lines = [f"No solution: {how_it_ended(trace.entries)}."]
    lines += [f"  Fault: {f}" for f in dict.fromkeys(str(f) for f in faults)]
    nearest, *others = misses(trace.entries) or [()]
    lines += [f"  Nearest miss: {_miss(nearest)}"] if nearest else []
    lines += [f"  Also {_miss(same)}" for same in others[:CAUSES]]
    lines += [f"  Also {len(others) - CAUSES} other causes"] if len(others) > CAUSES else []
    lines += [f"  Goal: {answer}" for answer in _once(goal_answers(trace), nearest)]
    lines += [f"  To try: {said}." for said in what_to_try(trace.entries)]
    return "\n".join(lines)


def brief_failure_text(trace: Trace, faults: Iterable[object], run: str = "") -> str:
    """Return three lines for a terminal: the end of the search, the nearest miss or a plugin's fault, and
    remedies.

    Args:
        run: its directory, for ``cramlite explain``; "" where there is none.
    """
    broken, (nearest, *others) = [str(f) for f in faults], misses(trace.entries) or [()]
    more = f" ({len(others)} other causes: --verbose)" if len(others) > 1 else " (another cause: --verbose)" if others else ""
    where = f". Every decision: cramlite explain {run}" if run else "."
    lines = [f"No solution: {how_it_ended(trace.entries)}{where}{more}"]
    lines += [f"  Fault: {broken[0]}"] if broken else []
    first = first_objection(nearest[0].reason) if nearest else ""
    lines += [f"  Nearest miss: {_miss(nearest, first)}"] if nearest else []
    tries = [said.removesuffix(f": {first.partition(' (and ')[0]}") for said in what_to_try(trace.entries, 1)] if first else []
    return "\n".join([*lines, *(f"  To try: {said}." for said in tries)][:LINES])


LINES = 3
"""Largest number of lines that a terminal shows about a failed search."""
OBJECTION = re.compile(r"[a-z_]+: ")


def first_objection(reason: str) -> str:
    """Return the first objection of a reason that joins several with ";", and the number of the others."""
    first, *rest = reason.split("; ")
    others = sum(1 for part in rest if OBJECTION.match(part))
    return (f"{first} (and {others} more)" if others else first) if OBJECTION.match(reason) else reason


def misses(entries: Sequence[Entry]) -> list[tuple[Entry, ...]]:
    """Return the nearest miss of each candidate, grouped by cause; the group with the nearest miss of the whole search comes first."""
    nearest, alike = nearest_miss(entries), dict[tuple[str, str], list[Entry]]()
    for number in dict.fromkeys(e.candidate for e in entries):
        if (miss := nearest_miss([e for e in entries if e.candidate == number])) is not None:
            alike.setdefault(cause(miss), []).append(miss)
    return sorted((tuple(same) for same in alike.values()), key=lambda same: (nearest not in same, same[0].number))


def _miss(same: Sequence[Entry], reason: str = "") -> str:
    """Format the nearest misses of candidates that failed for one cause as one line: candidates, designator,
    reason and plugin."""
    first, numbers = same[0], [e.candidate for e in same]
    which = f"candidate {numbers[0]}" if len(numbers) == 1 else f"candidates {_listed(numbers)}"
    return f"{which}, {first.designator}: {reason or first.reason} [{first.plugin}]"


def _listed(numbers: Sequence[int]) -> str:
    """Numbers in words: "1 to 4", "1, 3 and 4"."""
    if len(numbers) > 2 and numbers[-1] - numbers[0] == len(numbers) - 1:
        return f"{numbers[0]} to {numbers[-1]}"
    return f"{', '.join(map(str, numbers[:-1]))} and {numbers[-1]}"


def _once(answers: Iterable[GoalAnswer], told: Sequence[Entry]) -> Iterator[GoalAnswer]:
    """Yield the answers for the goals, with "see above" in place of a reason that the report gives as the
    nearest miss."""
    said = f"{told[0].designator}: {told[0].reason}" if told else ""
    yield from (a.without_reason() if a.reason == said else a for a in answers)

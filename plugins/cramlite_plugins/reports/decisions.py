"""Decisions of the trace: questions, choices, and refusals with reasons, one candidate at a time."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from cramlite.model import Value

if TYPE_CHECKING:
    from cramlite import Entry, Trace

WHOLE = ("twin", "proof", "budget", "stop")
"""Kinds of entries that are about a whole candidate."""


class Branch(Value):
    """Alternative that was tried, with the decisions that followed from it, and its outcome."""

    entry: Entry
    decisions: tuple[Decision, ...]


class Decision(Value):
    """Decision about one designator: which alternative was chosen, and which were refused or failed.

    Args:
        asked: the question.
        chosen: the alternative that the search went on with; None when there was none.
        tried: alternatives before it that failed further down.
        refused: what plugins dropped or called impossible, no-goods and caps included.
        failed: why the whole designator failed; None if it did not.
    """

    asked: Entry
    chosen: Entry | None
    tried: tuple[Branch, ...]
    refused: tuple[Entry, ...]
    failed: Entry | None

    @property
    def asks(self) -> bool:
        """Whether the decision is about a designator, and not about a whole goal or task sequence."""
        return self.asked.kind not in ("goal", "sequence")

    @property
    def task(self) -> bool:
        """Whether the decision is about an item of the plan: a task, or a control structure around tasks."""
        return of_plan(self.asked)


class CandidateDecisions(Value):
    """Decisions of one candidate task sequence in order, and its proofs, each listed after the runs of its
    twins."""

    number: int
    decisions: tuple[Decision, ...]
    proofs: tuple[Entry, ...]

    @property
    def proven(self) -> bool:
        """Check whether the candidate was proven."""
        return any(e.outcome == "proven" for e in self.proofs)

    @property
    def refusals(self) -> int:
        """Return the number of refusals in the candidate's decisions."""
        return sum(len(d.refused) for d in self.decisions)


def of_plan(entry: Entry) -> bool:
    """Check whether an entry of the trace asks for an item of the plan: a task, or a control structure around tasks."""
    return entry.kind in ("action", "compound") and entry.numbers.get("depth") == 0


def attempts(trace: Trace) -> list[CandidateDecisions]:
    """Return the candidates in the order in which they were tried."""
    groups: dict[int, list[Entry]] = defaultdict(list)
    for entry in trace.entries:
        groups[entry.candidate].append(entry)
    return [_attempt(number, entries) for number, entries in groups.items()]


def _attempt(number: int, entries: Sequence[Entry]) -> CandidateDecisions:
    children: dict[int, list[Entry]] = defaultdict(list)
    for entry in entries:
        if entry.kind not in WHOLE:
            children[entry.parent].append(entry)
    proofs = tuple(e for e in entries if e.kind in WHOLE)
    return CandidateDecisions(number, _chain(children[0], children), proofs)


def _chain(asked: Iterable[Entry], children: Mapping[int, list[Entry]]) -> tuple[Decision, ...]:
    """Decisions along the last alternative of each designator: the path of choices with which the search
    ended.

    A loop, not a recursion: paths are long, while alternatives within alternatives are few.
    """
    decisions: list[Decision] = []
    waiting = list(asked)
    while waiting:
        question = waiting.pop(0)
        answers = children.get(question.number, [])
        tried = [e for e in answers if e.outcome == "chosen"]
        branches = tuple(Branch(e, _chain(children.get(e.number, []), children)) for e in tried[:-1])
        rest = [e for e in answers if e.outcome != "chosen"]
        failed = next((e for e in rest if e.outcome == "failed"), None)
        refused = tuple(e for e in rest if e is not failed)
        decisions.append(Decision(question, tried[-1] if tried else None, branches, refused, failed))
        if tried:
            waiting = [*children.get(tried[-1].number, []), *waiting]
    return tuple(decisions)


def path(attempt: CandidateDecisions) -> dict[str, Entry]:
    """Return designator -> the alternative that was chosen for it when the candidate ended."""
    return {d.asked.designator: d.chosen for d in attempt.decisions if d.chosen is not None}

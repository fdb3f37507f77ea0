"""Search tree: every candidate, every choice with its cost, and why its alternatives were not taken."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from cramlite import nearest_miss
from cramlite.model import Value
from cramlite.plugin import ReportSection, hookimpl

from .decisions import attempts, of_plan
from .links import lines_of, steps_of
from .readings import first_sequences, number_of
from .shared import fill, short

if TYPE_CHECKING:
    from cramlite import Entry, Finished

    from .decisions import CandidateDecisions, Decision


REASONS = 4
"""Number of reasons that the summary above the decisions names."""


class Alike(Value):
    """Refusals with the same reason, apart from its numbers: how many, and the first of them."""

    count: int
    first: Entry


class TaskStage(Value):
    """Task of a candidate, and how far the search came: "reached", "stopped" (it never got beyond this task) or "unreached"."""

    name: str
    state: str


class Bar(Value):
    """Bar for one decision in the picture of a search: the square root of the decision's cost, its number of refusals, and a text.

    Cost and number are shares of the largest.
    """

    designator: str
    cost: float
    refused: float
    text: str


class CandidateRow(Value):
    """Candidate task sequence as the report shows it: its decisions, progress and costs.

    ``miss`` is its refusal nearest to a proof. ``anchors`` are the numbers of the decisions that links lead
    to: the last one of each designator.
    """

    attempt: CandidateDecisions
    title: str
    miss: Entry | None
    stages: tuple[TaskStage, ...]
    bars: tuple[Bar, ...]
    lines: Mapping[str, Sequence[tuple[int, int]]]
    linked: bool
    anchors: frozenset[int]
    open: bool


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("Why nothing was proven", 15, lambda done: "" if done.proven else render(done), refused=True)
    yield ReportSection("The search", 50, render)


def render(done: Finished) -> str:
    """Render the report's map and list of the search's decisions as HTML."""
    found = attempts(done.trace)
    sequences = first_sequences(done.interpretation, max((a.number for a in found), default=0))
    titles = [[short(m.task) for m in s.matches] for s in sequences]
    if not titles and done.shown is not None:
        titles = [[short(a.task) for a in done.shown.plan.actions]]
    nearest = nearest_miss(done.trace.entries)
    rows = [_row(done, a, titles, nearest) for a in found]
    faults = list(dict.fromkeys(str(f) for f in done.engine.registry.faults))
    return fill("search_tree", done=done, rows=rows, faults=faults, counts=_counts(found), reasons=reasons(done.trace.entries))


def _row(done: Finished, attempt: CandidateDecisions, titles: Sequence[Sequence[str]], nearest: Entry | None) -> CandidateRow:
    entries = [e for e in done.trace.entries if e.candidate == attempt.number]
    shown = attempt.number == number_of(done)
    code = done.shown.candidate.code if shown and done.shown is not None else None
    tasks = titles[attempt.number - 1] if attempt.number <= len(titles) else []
    return CandidateRow(
        attempt,
        " → ".join(tasks) or _written(entries),
        None if attempt.proven else nearest_miss(entries),
        stages(tasks, entries, ran=bool(attempt.proofs)),
        bars([d for d in attempt.decisions if d.asks]),
        lines_of(steps_of(code)) if code is not None else {},
        shown,
        frozenset({d.asked.designator: d.asked.number for d in attempt.decisions if d.asks}.values()) if shown else frozenset(),
        attempt.proven or (not done.proven and nearest is not None and nearest.candidate == attempt.number),
    )


def _written(entries: Sequence[Entry]) -> str:
    """Join the tasks in a candidate's trace entries to a text, for a candidate whose complete task
    sequence is unknown."""
    return " → ".join(dict.fromkeys(e.designator for e in entries if of_plan(e)))


def stages(tasks: Sequence[str], entries: Sequence[Entry], *, ran: bool) -> tuple[TaskStage, ...]:
    """Return how far the search came in each task of a candidate; all tasks are reached if the program ran."""
    last = len(tasks) + 1 if ran else max((e.numbers.get("task", 0) for e in entries), default=0)
    states = ("reached" if k < last else "stopped" if k == last else "unreached" for k in range(1, len(tasks) + 1))
    return tuple(TaskStage(name, state) for name, state in zip(tasks, states, strict=True))


def bars(decisions: Sequence[Decision]) -> tuple[Bar, ...]:
    """Return the map of a search: where it was expensive, and where much was refused."""
    costs = [d.chosen.cost or 0.0 if d.chosen is not None else 0.0 for d in decisions]
    refusals = [len(d.refused) + len(d.tried) for d in decisions]
    dearest, most = max(costs, default=0.0) or 1.0, max(refusals, default=0) or 1
    return tuple(
        Bar(
            d.asked.designator,
            math.sqrt(max(c, 0.0) / dearest),
            n / most,
            f"{d.asked.designator}: cost {c:.3g}, {n} not taken",
        )
        for d, c, n in zip(decisions, costs, refusals, strict=True)
    )


def reasons(entries: Iterable[Entry]) -> list[Alike]:
    """Return the reasons for which most alternatives were refused, each with its count, the commonest first."""
    groups: dict[tuple[str, str], list[Entry]] = defaultdict(list)
    for entry in entries:
        if entry.outcome in ("refused", "impossible") and entry.plugin != "engine":
            groups[entry.plugin, re.sub(r"[-+]?\d+(\.\d+)?", "#", entry.reason)].append(entry)
    found = sorted(groups.values(), key=lambda g: (-len(g), g[0].number))
    return [Alike(len(g), g[0]) for g in found[:REASONS]]


def _counts(found: list[CandidateDecisions]) -> tuple[int, int]:
    """Numbers of decisions, and of refused alternatives, summed over all candidates."""
    return sum(len(a.decisions) for a in found), sum(a.refusals for a in found)

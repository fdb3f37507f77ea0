"""The search: every candidate, every choice with its cost, and why the others were not taken."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import ReportSection, hookimpl
from cramlite.explain import nearest_miss
from cramlite.report import Finished

from .decisions import Attempt, attempts
from .readings import first_sequences
from .shared import fill, short


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The search", 50, render)


def render(done: Finished) -> str:
    solution = done.solution
    found = attempts(solution.trace)
    sequences = first_sequences(solution, len(found))
    rows = []
    for attempt in found:
        entries = [e for e in solution.trace.entries if e.candidate == attempt.number]
        miss = None if attempt.proven else nearest_miss(entries)
        rows.append((attempt, _title(attempt, sequences, str(solution.plan)), miss))
    faults = list(dict.fromkeys(str(f) for f in done.engine.registry.faults))
    return fill("search_tree", rows=rows, entries=solution.trace.entries, faults=faults, counts=_counts(found))


def _title(attempt: Attempt, sequences: list, plan: str) -> str:  # type: ignore[type-arg]
    if attempt.number <= len(sequences):
        return " → ".join(short(m.task) for m in sequences[attempt.number - 1].matches)
    return plan.replace("->", "→")


def _counts(found: list[Attempt]) -> tuple[int, int]:
    """Decisions and refused alternatives over all candidates."""
    return sum(len(a.decisions) for a in found), sum(a.refusals for a in found)

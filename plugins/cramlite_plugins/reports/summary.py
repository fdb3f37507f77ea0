"""What was found, in words: the plan, what its objects became, and what the judges measured."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cramlite import Finding, ReportSection, hookimpl
from cramlite.report import Finished

from .decisions import attempts, path
from .shared import fill


@dataclass(frozen=True)
class Measured:
    """A finding with its numbers in units that people read, and how much of the limit was used."""

    finding: Finding
    value: str
    limit: str
    share: float | None


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("Summary", 10, render)


def render(done: Finished) -> str:
    solution = done.solution
    chosen = next((path(a) for a in attempts(solution.trace) if a.number == solution.number), {})
    rollout = solution.candidate.rollout
    return fill(
        "summary",
        solution=solution,
        chosen=chosen,
        findings=[measured(f) for f in solution.verdict.findings],
        duration=float(rollout.times[-1]) if rollout is not None else None,
        suffix=solution.candidate.code.suffix if solution.candidate.code else "",
        episode=solution.candidate.episode is not None,
    )


def measured(finding: Finding) -> Measured:
    value, limit = finding.value, finding.limit
    share = value / limit if value is not None and limit and 0 <= value <= limit else None
    return Measured(finding, _number(value, finding.unit), _number(limit, finding.unit), share)


def _number(value: float | None, unit: str) -> str:
    """Three digits; lengths below 0.1 m in mm."""
    if value is None:
        return ""
    if unit == "m" and abs(value) < 0.1:
        value, unit = value * 1000, "mm"
    return f"{value:.3g} {unit}".strip()

"""Verdict in the report: the validators' measurements in the run, and links to the other files of the run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite.model import Value
from cramlite.plugin import ReportSection, hookimpl

from .links import targets
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished
    from cramlite.plugin import Finding


class Measured(Value):
    """Finding with value and limit in convenient units, and the value's share of the limit."""

    finding: Finding
    value: str
    limit: str
    share: float | None


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("What the validators found", 25, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's table of what the validators found, and its links to the other files of the run
    directory, as HTML."""
    if done.shown is None:
        return ""
    candidate = done.shown.candidate
    findings = sorted(done.shown.verdict.findings, key=lambda f: f.passed)
    return fill(
        "validators",
        done=done,
        known=targets(done),
        left_out=done.shown.verdict.not_judged.capitalize(),
        findings=[measured(f) for f in findings],
        suffix=candidate.code.suffix if candidate.code is not None else "",
        episode=candidate.episode is not None,
        recorded=candidate.rollout is not None,
    )


def measured(finding: Finding) -> Measured:
    """Convert the value and the limit of a finding to convenient units."""
    value, limit = finding.value, finding.limit
    share = value / limit if value is not None and limit and 0 <= value <= limit else None
    return Measured(finding, _number(value, finding.unit), _number(limit, finding.unit), share)


def _number(value: float | None, unit: str) -> str:
    """Text of a number, with three digits and its unit; lengths below 0.1 m are in mm.

    Smaller numbers than a thousandth, which are rounding of the simulation, read "< 0.001".
    """
    if value is None:
        return ""
    if unit == "m" and abs(value) < 0.1:
        value, unit = value * 1000, "mm"
    said = f"{value:.3g}" if not 0 < abs(value) < 0.001 else "< 0.001"
    return f"{said} {unit}".strip()

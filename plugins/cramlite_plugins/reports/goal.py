"""Report of the goal part by part: the tasks that achieve it, or why not, and the measurement after the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from cramlite import goal_answers, nearest_miss, understood_entries
from cramlite.model import Value
from cramlite.plugin import ReportSection, hookimpl

from .links import targets
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished, GoalAnswer
    from cramlite.model import Finding

VALIDATOR = "goal"
"""Validator that measures each part of a goal at the end of a run."""
MARKS: Mapping[str, tuple[str, str]] = {
    "holds": ("✓", "good"), "achieved": ("✓", "good"), "reached": ("○", "soft"), "missed": ("✗", "bad"), "untried": ("○", "soft"),
}  # fmt: skip


class GoalRow(Value):
    """Part of a goal, as the report shows it.

    Args:
        says: the part in words.
        mark: sign, and the class that colours it.
        answer: what the search says of it; None for what a demonstration ended with, which nobody searched for.
        tasks: names of the tasks of the shown program that are for it.
        finding: what was measured of it after the run; None where nothing ran, or was judged.
    """

    says: str
    mark: tuple[str, str]
    answer: GoalAnswer | None
    tasks: tuple[str, ...]
    finding: Finding | None


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The goal", 11, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's list of the goal's parts as HTML; nothing where there was no goal."""
    rows = tuple(_rows(done))
    nearest = None if done.proven else nearest_miss(done.trace.entries)
    miss = f"{nearest.designator}: {nearest.reason}" if nearest is not None else ""
    said = understood_entries(done.trace.entries)
    return fill("goal", done=done, rows=rows, known=targets(done), miss=miss, said=said) if rows else ""


def _rows(done: Finished) -> Iterator[GoalRow]:
    shown = done.shown
    findings = [f for f in shown.verdict.findings if f.validator == VALIDATOR] if shown is not None else []
    names = [a.name for a in shown.candidate.actions] if shown is not None else []
    for answer in goal_answers(done.trace, shown.number if done.proven and shown is not None else 0):
        finding = next((f for f in findings if f.literal == answer.says), None)
        findings = [f for f in findings if f is not finding]
        first, last = answer.tasks or (1, 0)
        yield GoalRow(answer.says, _mark(answer, finding), answer, tuple(names[first - 1 : last]) if done.proven else (), finding)
    for finding in findings:
        yield GoalRow(finding.literal, ("✓", "good") if finding.passed else ("✗", "bad"), None, (), finding)


def _mark(answer: GoalAnswer, finding: Finding | None) -> tuple[str, str]:
    """Sign that marks a part of the goal as met or not: a failed measurement overrides the plan."""
    return ("✗", "bad") if finding is not None and not finding.passed else MARKS[answer.answer]

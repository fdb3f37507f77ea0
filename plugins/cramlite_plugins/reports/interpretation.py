"""Interpretation of each action: the tasks that fit and why others do not; readings that were tried."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite import how_it_ended, nearest_miss
from cramlite.model import Value
from cramlite.plugin import ReportSection, hookimpl

from .readings import chosen_sequence, first_sequences, pair_up
from .shared import fill, short

if TYPE_CHECKING:
    from cramlite import Finished, Interpretation
    from cramlite.plugin import Interpreted, Match, TaskSequence

UNTRIED = 4
"""Number of readings that the report shows beyond those that were tried."""


class Cell(Value):
    """Match of an action with a task: "chosen", "match" or "no", and a sentence that says why."""

    kind: str
    why: str


TaskRow = tuple[str, list[Cell]]
"""Table row of a task, with a cell for each action."""


class Reading(Value):
    """Candidate task sequence and its outcome in words."""

    number: int
    sequence: TaskSequence
    outcome: str
    reason: str


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("What it may mean", 40, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's interpretation of the demonstration's actions as HTML."""
    found = done.interpretation
    if found is None:
        return ""
    pairs = pair_up(found, chosen_sequence(done))
    return fill(
        "interpretation", found=found, pairs=pairs, rows=_rows(found, pairs), readings=_readings(done), untried=UNTRIED
    )


def _rows(found: Interpretation, pairs: list[tuple[Interpreted, Match | None]]) -> tuple[list[TaskRow], list[TaskRow]]:
    """Two lists of table rows, each sorted by name: the tasks that explain some action, and the tasks that
    explain none."""
    matched = {m.task for a in found.actions for m in a.matches}
    tasks = matched | {r.task for a in found.actions for r in a.rejections}
    rows = [(task, [_cell(task, action, match) for action, match in pairs]) for task in sorted(tasks, key=short)]
    return [r for r in rows if r[0] in matched], [r for r in rows if r[0] not in matched]


def _cell(task: str, action: Interpreted, chosen: Match | None) -> Cell:
    matches = action.named(task)
    if matches:
        why = "; or ".join(f"{m.explanation} ({_roles(m)})" if m.roles else m.explanation for m in matches)
        kind = "chosen" if chosen is not None and chosen.task == task else "match"
        return Cell(kind, f"{task}: {why}. All {matches[0].conditions} conditions hold.")
    why = next((r.sentence for r in action.rejections if r.task == task), f"not {task}: no rule for this task was tried on this action.")
    return Cell("no", why)


def _roles(match: Match) -> str:
    return ", ".join(f"{k} {v}" for k, v in match.roles.items())


def _readings(done: Finished) -> list[Reading]:
    tried = max((e.candidate for e in done.trace.entries), default=0)
    sequences = first_sequences(done.interpretation, tried + UNTRIED)
    return [Reading(k, s, *_outcome(done, k)) for k, s in enumerate(sequences, 1)]


def _outcome(done: Finished, number: int) -> tuple[str, str]:
    entries = [e for e in done.trace.entries if e.candidate == number]
    if any(e.outcome == "proven" for e in entries):
        return "proven", "its text ran and passed every check"
    if not entries:
        return "not tried", "a better one was proven before" if done.proven else "the budget was used up before"
    miss = nearest_miss(entries)
    return "refused", f"{miss.designator}: {miss.reason}" if miss else how_it_ended(entries)

"""What each action may have been and why it was nothing else; which readings were tried and what became of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cramlite import Interpretation, ReportSection, Solution, hookimpl
from cramlite.explain import nearest_miss
from cramlite.interpretation import Interpreted, Match, TaskSequence
from cramlite.report import Finished

from .readings import chosen_sequence, first_sequences, pair_up
from .shared import fill, short

UNTRIED = 4
"""Readings shown beyond those that were tried."""


@dataclass(frozen=True)
class Cell:
    """An action against a task: "chosen", "match" or "no", and the sentence."""

    kind: str
    why: str


@dataclass(frozen=True)
class Reading:
    """A candidate sequence and its outcome in words."""

    number: int
    sequence: TaskSequence
    outcome: str
    reason: str


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("What it may mean", 40, render)


def render(done: Finished) -> str:
    found = done.solution.interpretation
    if found is None:
        return ""
    pairs = pair_up(found, chosen_sequence(done.solution))
    return fill("interpretation", found=found, pairs=pairs, rows=_rows(found, pairs), readings=_readings(done.solution), untried=UNTRIED)


def _rows(found: Interpretation, pairs: list[tuple[Interpreted, Match | None]]) -> list[tuple[str, list[Cell]]]:
    """Tasks that explain something first, then the others, each by name."""
    matched = {m.task for a in found.actions for m in a.matches}
    tasks = matched | {r.task for a in found.actions for r in a.rejections}
    order = sorted(tasks, key=lambda t: (t not in matched, short(t)))
    return [(task, [_cell(task, action, match) for action, match in pairs]) for task in order]


def _cell(task: str, action: Interpreted, chosen: Match | None) -> Cell:
    matches = action.named(task)
    if matches:
        why = "; or ".join(f"{m.explanation} ({_roles(m)})" if m.roles else m.explanation for m in matches)
        kind = "chosen" if chosen is not None and chosen.task == task else "match"
        return Cell(kind, f"{task}: {why}. All {matches[0].conditions} conditions hold.")
    why = next((r.sentence for r in action.rejections if r.task == task), f"not {task}: no rule speaks about it here.")
    return Cell("no", why)


def _roles(match: Match) -> str:
    return ", ".join(f"{k} {v}" for k, v in match.roles.items())


def _readings(solution: Solution) -> list[Reading]:
    sequences = first_sequences(solution, solution.number + UNTRIED)
    return [Reading(k, s, *_outcome(solution, k)) for k, s in enumerate(sequences, 1)]


def _outcome(solution: Solution, number: int) -> tuple[str, str]:
    if number == solution.number:
        return "proven", "its text ran and passed every check"
    entries = [e for e in solution.trace.entries if e.candidate == number]
    if not entries:
        return "not tried", "a better one was proven before"
    miss = nearest_miss(entries)
    return "refused", f"{miss.designator}: {miss.reason}" if miss else "every alternative was refused"

"""The plan as a diagram: tasks in order against what plays their roles, and what everything was grounded to."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, ReportSection, Solution, hookimpl
from cramlite.report import Finished
from cramlite.trace import Entry

from .decisions import Decision, attempts
from .shared import fill


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The plan", 60, render)


def render(done: Finished) -> str:
    solution = done.solution
    decisions = next((a.decisions for a in attempts(solution.trace) if a.number == solution.number), ())
    chosen = {d.asked.designator: d.chosen for d in decisions if d.chosen is not None}
    return fill("plan", plan=solution.plan, chosen=chosen, tasks=_tasks(solution, decisions), summaries=_summaries(done))


def _tasks(solution: Solution, decisions: tuple[Decision, ...]) -> list[tuple[Action, list[tuple[Entry, Entry | None]]]]:
    """Each action with the designators that were decided after it and before the next one."""
    names = {a.name: a for a in solution.plan.actions}
    found: dict[str, list[tuple[Entry, Entry | None]]] = {name: [] for name in names}
    current = ""
    for decision in decisions:
        current = decision.asked.designator if decision.asked.designator in names else current
        if current:
            found[current].append((decision.asked, decision.chosen))
    return [(names[name], rows) for name, rows in found.items()]


def _summaries(done: Finished) -> dict[str, str]:
    return {name: task.summary for name, task in done.engine.knowledge.tasks.items()}

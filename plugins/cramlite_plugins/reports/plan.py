"""Diagram of a plan: tasks in order, and a lane for each object, from its designator to the tasks that use
it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from cramlite.model import Action, Compound, Value
from cramlite.plugin import ReportSection, hookimpl

from .decisions import attempts
from .links import lines_of, steps_of
from .readings import number_of
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Entry, Finished
    from cramlite.model import Object

    from .decisions import Decision


class LaneRow(Value):
    """Row of the plan's diagram: the beginning of an object's vertical line, or a task with the control structures
    around it.

    Args:
        action, thing: what it is about; one of them.
        depth: rules around it.
        rule: of a branch that begins here, in words.
        lanes: for each object "" (nothing yet, or no longer), "begin", "through", "use", "end" (used for the last time).
        roles: role -> object.
        decisions: what was decided for the task, with what was taken.
    """

    action: Action | None
    thing: Object | None
    depth: int
    rule: str
    lanes: tuple[str, ...]
    roles: Mapping[str, Object]
    decisions: tuple[tuple[Entry, Entry | None], ...] = ()


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The plan", 60, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's diagram of the plan as HTML."""
    if done.shown is None:
        return ""
    solution = done.shown
    found = next((a.decisions for a in attempts(done.trace) if a.number == number_of(done)), ())
    decisions = [d for d in found if d.asks]
    chosen = {d.asked.designator: d.chosen for d in decisions if d.chosen is not None}
    code = solution.candidate.code
    lines = lines_of(steps_of(code)) if code is not None else {}
    rows = diagram(solution.plan.objects, solution.plan.actions, decisions)
    return fill("plan", plan=solution.plan, chosen=chosen, rows=rows, lines=lines, summaries=_summaries(done))


def diagram(objects: Sequence[Object], actions: Sequence[Action], decisions: Sequence[Decision]) -> list[LaneRow]:
    """Return the rows of a plan's diagram: first one for each object, then one for each task.

    Lanes end where their objects, or parts of them, are used for the last time.
    """
    tasks = list(_flat(actions))
    names = [o.name for o in objects]
    uses = [{o.name for o in action.roles.values()} for action, _, _ in tasks]
    held = {o.name: {o.name, *(part.name for part in objects if part.part_of == o.name)} for o in objects}
    last = {n: max((k for k, used in enumerate(uses) if used & held[n]), default=-1) for n in names}
    found = [LaneRow(None, o, 0, "", _beginning(k, len(names)), {}) for k, o in enumerate(objects)]
    decided = _by_task(tasks, decisions)
    for k, (action, depth, rule) in enumerate(tasks):
        lanes = tuple(_lane(n in uses[k], k, last[n]) for n in names)
        found.append(LaneRow(action, None, depth, rule, lanes, action.roles, decided.get(action.name, ())))
    return found


def _beginning(number: int, count: int) -> tuple[str, ...]:
    return tuple("through" if k < number else "begin" if k == number else "" for k in range(count))


def _lane(used: bool, row: int, last: int) -> str:
    if used:
        return "end" if row == last else "use"
    return "through" if row < last else ""


def _flat(actions: Iterable[object], depth: int = 0, rule: str = "") -> Iterator[tuple[Action, int, str]]:
    """Actions of a plan and the control structures around them, each with its depth and branch, in the plan's order."""
    for action in actions:
        if not isinstance(action, Action):
            continue
        yield action, depth, rule
        rule = ""
        if isinstance(action, Compound):
            for number, branch in enumerate(action.branches, 1):
                yield from _flat(
                    branch, depth + 1, f"{number} of {len(action.branches)}" if len(action.branches) > 1 else ""
                )


def _by_task(
    tasks: Sequence[tuple[Action, int, str]], decisions: Sequence[Decision]
) -> dict[str, tuple[tuple[Entry, Entry | None], ...]]:
    """Return a dictionary from action name to the decisions that the trace holds between this action and the next."""
    found: dict[str, list[tuple[Entry, Entry | None]]] = {action.name: [] for action, _, _ in tasks}
    current = ""
    for decision in decisions:
        current = decision.asked.designator if decision.asked.designator in found else current
        if current and decision.asked.designator != current:
            found[current].append((decision.asked, decision.chosen))
    return {name: tuple(rows) for name, rows in found.items()}


def _summaries(done: Finished) -> dict[str, str]:
    return {name: task.summary for name, task in done.engine.knowledge.tasks.items()}

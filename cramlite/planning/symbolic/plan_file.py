"""Plans in PDDL, as planners write them, read and checked against the task rules."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from ...base.errors import UserError, nearest
from ..operators import Operator
from .goal_planner import TaskPlan
from .pddl import PddlText, PlanStep
from .planning_problem import PlanningProblem


def handed_plan(problem: PlanningProblem, file: Path) -> TaskPlan:
    """Read a plan from a PDDL plan file, with the reason for each step.

    Raises:
        UserError: there is no such file, or it is no plan for the goal.
    """
    try:
        said = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(
            f"'{file}' cannot be read as a plan: {error}. 'cramlite goal SCENARIO --pddl DIR' writes the problem for a planner."
        ) from error
    text = problem.pddl()
    return problem.plan(checked_steps(problem, steps_of(said, text, str(file)), str(file)))


def steps_of(plan: str, text: PddlText, where: str) -> list[PlanStep]:
    """Return the steps of a plan in PDDL.

    Args:
        plan: one "(action object ...)" a line; comments begin with ";".
        text: of the problem that it is for.
        where: the file, for messages.

    Raises:
        UserError: a line is no action of the problem; with its number.
    """
    found: list[PlanStep] = []
    for number, line in enumerate(plan.splitlines(), 1):
        said = line.partition(";")[0].strip()
        if said:
            found.append(_step(said, text, f"{where}:{number}"))
    return found


def _step(said: str, text: PddlText, where: str) -> PlanStep:
    form = re.fullmatch(r"(?:[\d.]+\s*:\s*)?\(\s*([^()\s]+)((?:\s+[^()\s]+)*)\s*\)(?:\s*\[[\d.]+\])?", said)
    if form is None:
        raise UserError(f"{where}: '{said}' is no step of a plan; write '(action object object)', one a line.")
    name, objects = form[1].lower(), form[2].lower().split()
    if name not in text.actions:
        raise UserError(f"{where}: the domain has no action '{name}'; {nearest(name, text.actions)}.")
    schema = text.actions[name]
    wanted = list(schema.parameters)
    named = [*wanted, *(f"whole of {v}" for v in schema.wholes)]
    if len(objects) != len(named):
        raise UserError(f"{where}: '{name}' has {len(named)} parameters ({', '.join(named)}), not {len(objects)}.")
    for entity in objects:
        if entity not in text.entities:
            raise UserError(f"{where}: the problem has no object '{entity}'; {nearest(entity, text.entities)}.")
    return PlanStep(schema, {v: text.entities[o] for v, o in zip(wanted, objects, strict=False)})


def checked_steps(problem: PlanningProblem, steps: Iterable[PlanStep], where: str) -> tuple[Operator, ...]:
    """Return the planning actions of a plan's steps, checked: each is applicable in its turn, and the goal
    holds at the end.

    Raises:
        UserError: it is no plan; it says which step needs what.
    """
    found = [(step, problem.operator(step)) for step in steps]
    for step, operator in found:
        if operator is None:
            raise UserError(f"{where}: {step.key[0]}({', '.join(step.key[1:])}) is no action of the problem: these things do not allow it.")
    operators = tuple(o for _, o in found if o is not None)
    if why := problem.failing(operators):
        raise UserError(f"{where} is no plan for '{' and '.join(problem.says)}': {why}.")
    return operators

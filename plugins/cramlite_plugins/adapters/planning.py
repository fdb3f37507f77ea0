"""Adapter to unified-planning, whose engines solve cramlite's goals; a plan is resolved task by task, and failures are
fed back as facts.

Needs unified-planning 1.2 or later with an engine that takes quantifiers and conditional effects, e.g. Fast Downward, which
cramlite installs (``pip install 'cramlite[planning]'``). Goals that cramlite plans by itself do not need it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cramlite import (
    Engine,
    Goal,
    Operator,
    PddlText,
    PlanningProblem,
    PlanStep,
    Setting,
    Solution,
    Trace,
    checked_steps,
    nearest_miss,
    planning_problem,
    steps_of,
)
from cramlite.model import Value

Planner = Callable[[PddlText], "str | None"]
"""Function that solves a planning problem in PDDL: it returns the plan, one action a line, or None where there is none."""


class Planned(Value):
    """Result of planning and resolving.

    Args:
        solution: proven, or None.
        steps: of the last plan.
        refused: operator -> why it could not be resolved; these were told to the planner as facts.
    """

    solution: Solution | None
    steps: tuple[Operator, ...]
    refused: dict[str, str]


def problem_of(engine: Engine, setting: Setting, goal: Goal) -> PlanningProblem:
    """Return the planning problem of a goal; its initial state is what the robot believes about the world.

    Raises:
        UserError: the goal is none, or names what there is not.
    """
    return planning_problem(goal, setting.symbolic(engine.knowledge.taxonomy), engine.knowledge)


def to_unified_planning(text: PddlText) -> Any:
    """Convert a planning problem for unified-planning."""
    from unified_planning.io import PDDLReader

    return PDDLReader().parse_problem_string(text.domain, text.problem)


def with_engine(name: str = "fast-downward") -> Planner:
    """Return a planner that runs the engine of unified-planning of this name."""

    def plan(text: PddlText) -> str | None:
        from unified_planning.shortcuts import OneshotPlanner, get_environment

        get_environment().credits_stream = None
        with OneshotPlanner(name=name) as planner:
            found = planner.solve(to_unified_planning(text)).plan
        if found is None:
            return None
        return "\n".join(f"({' '.join([a.action.name, *map(str, a.actual_parameters)])})" for a in found.actions)

    return plan


def resolve_planned(
    engine: Engine, setting: Setting, goal: Goal, planner: Planner | None = None, *, rounds: int = 5
) -> Planned:
    """Plan and resolve the plan task by task; exclude the first task that cannot be resolved from the
    planning problem, and plan again.

    Args:
        planner: by default Fast Downward as an engine of unified-planning.
        rounds: plans that are tried.

    Raises:
        UserError: the goal cannot be used, or the planner's plan is none.
    """
    problem, refused, planner = problem_of(engine, setting, goal), dict[str, str](), planner or with_engine()
    without = list[PlanStep]()
    steps: tuple[Operator, ...] = ()
    for _ in range(rounds):
        text = problem.pddl(refused=without)
        found = planner(text)
        if found is None:
            break
        said = steps_of(found, text, "the planner's plan")
        steps = checked_steps(problem, said, "the planner's plan")
        solution, failed, why = _step_by_step(engine, setting, steps, problem)
        if solution is not None:
            return Planned(solution, steps, refused)
        without.append(said[failed])
        refused[str(steps[failed])] = why
    return Planned(None, steps, refused)


def _step_by_step(
    engine: Engine, setting: Setting, steps: tuple[Operator, ...], problem: PlanningProblem
) -> tuple[Solution | None, int, str]:
    """The whole plan's solution, or the number of the first task with which no program can be proven, and why."""
    solution = None
    for count in range(1, len(steps) + 1):
        trace = Trace()
        solution = next(engine.resolve(problem.tasks(steps[:count]), setting=setting, seed=setting.seed, trace=trace), None)
        if solution is None:
            miss = nearest_miss(trace.entries)
            return None, count - 1, miss.reason if miss else "nothing was found"
    return solution, len(steps), ""


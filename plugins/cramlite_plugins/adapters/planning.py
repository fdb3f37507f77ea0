"""Adapter to unified-planning: task rules as a planning problem; a plan resolved stepwise, failures fed back as facts.

Needs unified-planning 1.2 or later with an engine, e.g. pyperplan (``pip install 'cramlite[planning]'``). Each task with
its fillers is one action without parameters; ``possible(action)`` is a fact of its own, which a failed resolution denies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from cramlite import Engine, Goal, Operator, PlanningProblem, Setting, Solution, Trace, nearest_miss, planning_problem
from cramlite.model import Value
from cramlite.plugin import UserError

Planner = Callable[[Any], "list[str] | None"]
"""From a unified-planning problem to the names of the actions of a plan; None where there is none."""


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
    """Return the planning problem of a goal in a setting.

    Raises:
        UserError: the goal is none, or names what there is not.
    """
    return planning_problem(goal, setting.symbolic(engine.knowledge.taxonomy), engine.knowledge)


def to_unified_planning(problem: PlanningProblem, impossible: Iterable[str] = ()) -> Any:
    """Convert a planning problem for unified-planning: one fluent a fact, one action an operator.

    Args:
        impossible: names of operators that a resolution refused.
    """
    from unified_planning.shortcuts import BoolType, Fluent, InstantaneousAction, Not
    from unified_planning.shortcuts import Problem as UpProblem

    universe = problem.universe
    fluents = {fact: Fluent("_".join(fact).replace("/", "__"), BoolType()) for fact in sorted(universe)}
    made = UpProblem("cramlite")
    for fact, fluent in fluents.items():
        made.add_fluent(fluent, default_initial_value=fact in problem.facts)
    refused = set(impossible)
    for number, operator in enumerate(problem.operators):
        if not operator.needs <= universe:
            continue
        action, possible = InstantaneousAction(f"a{number}"), Fluent(f"possible_a{number}", BoolType())
        made.add_fluent(possible, default_initial_value=str(operator) not in refused)
        action.add_precondition(possible)
        for fact in sorted(operator.needs):
            action.add_precondition(fluents[fact])
        for fact in problem.forbidden(operator.without) - operator.needs:
            action.add_precondition(Not(fluents[fact]))
        for fact in sorted(universe - operator.apply(universe)):
            action.add_effect(fluents[fact], False)
        for fact in sorted(operator.adds):
            action.add_effect(fluents[fact], True)
        made.add_action(action)
    for fact in sorted(problem.wanted.needs):
        made.add_goal(fluents[fact])
    for fact in sorted(problem.forbidden(problem.wanted.without)):
        made.add_goal(Not(fluents[fact]))
    return made


def pyperplan(problem: Any) -> list[str] | None:
    """Plan with pyperplan (Helmert group, Basel); it knows no denials: they are compiled away first."""
    from unified_planning.engines import CompilationKind
    from unified_planning.shortcuts import Compiler, OneshotPlanner, get_environment

    get_environment().credits_stream = None
    with Compiler(problem_kind=problem.kind, compilation_kind=CompilationKind.NEGATIVE_CONDITIONS_REMOVING) as compiler:
        compiled = compiler.compile(problem, CompilationKind.NEGATIVE_CONDITIONS_REMOVING)
    with OneshotPlanner(name="pyperplan") as planner:
        found = planner.solve(compiled.problem).plan
    if found is None:
        return None
    original = found.replace_action_instances(compiled.map_back_action_instance)
    return [a.action.name for a in original.actions]


def resolve_planned(
    engine: Engine, setting: Setting, goal: Goal, planner: Planner = pyperplan, *, rounds: int = 5
) -> Planned:
    """Plan, resolve the plan one task more at a time; tell the planner of the first that cannot be, and plan again.

    Args:
        planner: see ``Planner``.
        rounds: plans that are tried.

    Raises:
        UserError: the goal cannot be used, or the planner's plan is none.
    """
    problem, refused = problem_of(engine, setting, goal), dict[str, str]()
    steps: tuple[Operator, ...] = ()
    for _ in range(rounds):
        names = planner(to_unified_planning(problem, refused))
        if names is None:
            return Planned(None, steps, refused)
        steps = _checked(problem, names)
        solution, failed, why = _step_by_step(engine, setting, steps, problem)
        if solution is not None:
            return Planned(solution, steps, refused)
        refused[str(failed)] = why
    return Planned(None, steps, refused)


def _checked(problem: PlanningProblem, names: Iterable[str]) -> tuple[Operator, ...]:
    """The operators of a plan, each applicable where it stands, and the goal met after the last."""
    steps = tuple(problem.operators[int(name.removeprefix("a"))] for name in names)
    facts = problem.facts
    for step in steps:
        if not step.applies(facts):
            raise UserError(f"The planner's plan is none: '{step}' cannot be done where it stands.")
        facts = step.apply(facts)
    if not problem.wanted.met(facts):
        raise UserError("The planner's plan is none: it does not lead to the goal.")
    return steps


def _step_by_step(
    engine: Engine, setting: Setting, steps: tuple[Operator, ...], problem: PlanningProblem
) -> tuple[Solution | None, Operator | None, str]:
    """The whole plan's solution, or the first task with which no program can be proven, and why."""
    solution = None
    for count in range(1, len(steps) + 1):
        trace = Trace()
        solution = next(engine.resolve(problem.tasks(steps[:count]), setting=setting, seed=setting.seed, trace=trace), None)
        if solution is None:
            miss = nearest_miss(trace.entries)
            return None, steps[count - 1], miss.reason if miss else "nothing was found"
    return solution, None, ""

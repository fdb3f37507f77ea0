"""Task sequences for a goal, lazily, each from a further call of the planner that forbids the earlier ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from .goal_planner import NEEDLESS, TaskPlan
from .operators import Operator
from .pddl import PlanStep
from .plan_file import steps_of
from .planning_problem import PlanningProblem
from .symbolic_planner import fast_downward

MOST = 6
"""Sequences of one choice of things."""

FEW = 4
"""Things that can be moved, up to which the shortest plans are searched; their states number some 10000 then."""

WRONG = 3
"""Plans of the planner in a row that are none of the engine's, or bring nothing new, after which it is asked no more."""


def task_plans(
    problem: PlanningProblem,
    progress: Callable[[str], None] = lambda _: None,
    stop: Callable[[], bool] = lambda: False,
    most: int = MOST,
) -> Iterator[TaskPlan]:
    """Generate task sequences that achieve a goal with the things that it is about, or, where there is none, with all.

    No sequence contains an earlier one, and none has a step that nothing asks for.
    """
    earlier, given = list[list[PlanStep]](), list[tuple[Operator, ...]]()
    for scope in problem.scopes():
        if given:
            return
        missed = 0
        while len(given) < most and missed < WRONG and not stop():
            text = problem.pddl(scope, earlier)
            few = sum(problem.grounder.things[n].movable for n in scope.things) <= FEW
            answer = fast_downward(text, few, progress, stop)
            if answer.plan is None:
                break
            steps = steps_of(answer.plan, text, "the planner's plan")
            plan, kept = _plan(problem, steps)
            earlier.append(kept)
            new = plan is not None and NEEDLESS not in plan.reasons and not any(_within(e, plan.steps) for e in given)
            missed = 0 if new else missed + 1
            if plan is not None and new:
                given.append(plan.steps)
                yield plan


def _plan(problem: PlanningProblem, steps: list[PlanStep]) -> tuple[TaskPlan | None, list[PlanStep]]:
    """A planner's plan as the engine sees it, without needless steps, and the steps that are left of it."""
    found = [(s, o) for s in steps if (o := problem.operator(s)) is not None]
    operators = [o for _, o in found]
    if len(found) < len(steps) or problem.failing(operators):
        return None, steps
    shorter = problem.shortened(operators)
    return problem.plan(shorter), [s for s, o in found if any(o is kept for kept in shorter)]


def _within(short: tuple[Operator, ...], long: tuple[Operator, ...]) -> bool:
    """Whether a sequence is another one with detours."""
    rest = iter(long)
    return all(any(str(step) == str(other) for other in rest) for step in short)

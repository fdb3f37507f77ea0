"""Task sequences for a goal, generated lazily: each by another call of the planner, with the earlier plans excluded."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from msgspec.structs import replace

from ...base.pulse import checkpoint
from ...model.entity_name import thing_of
from ..operators import Operator
from ..trace import Trace
from .goal_planner import NEEDLESS, TaskPlan
from .handling import task_text
from .pddl import PddlText, PlanStep
from .plan_file import steps_of
from .planning_problem import PlanningProblem, Scope
from .symbolic_planner import fast_downward

MOST = 6
"""Largest number of task sequences that are generated for one choice of things."""

FEW = 4
"""Number of movable things up to which the planner searches for a shortest plan; that many things have some 10000 states."""

ON_JOINT = 1 / 3
"""Weight of a thing on a joint in the count of movable things that ``FEW`` limits. It is open or closed, so three such things have eight
states, about as many as one thing with some ten places."""

WRONG = 3
"""Number of useless plans in a row (invalid, or nothing new) after which the planner is not asked again."""


def task_plans(
    problem: PlanningProblem,
    progress: Callable[[str], None] = lambda _: None,
    most: int = MOST,
    trace: Trace | None = None,
) -> Iterator[TaskPlan]:
    """Generate task sequences that achieve a goal, as far as possible with only the things that it names or
    that are in the way.

    No sequence contains an earlier one, and none has a step that nothing asks for. But where the trace says what the failure of
    one depends on, the next are those in which that is another: what was in the way is moved first. Where it says that a thing
    can play no role which the goal needs, there is no next one.

    Sequences of shipped and of preferred tasks come first, then those that other plugins' tasks are in (``added_tasks``). One of
    these comes before only where it is shorter, and has no effects beyond the goal and the preconditions of its later steps
    that the other has not.

    Args:
        most: sequences of which nothing was said; of those with other plugins' tasks as many again.
        trace: of the search that tries each sequence before the next is asked for.
    """
    given = _Given(problem)
    for added in (False, True) if problem.knowledge.added_tasks else (True,):
        if not given.hopeless(trace):
            yield from _stream(given, added, progress, most, trace)


def _stream(
    given: _Given, added: bool, progress: Callable[[str], None], most: int, trace: Trace | None
) -> Iterator[TaskPlan]:
    """Generate further task sequences for a goal, with or without tasks of plugins that are neither shipped
    nor preferred."""
    known, level, missed = len(given.unexplained), 0, 0
    while len(given.unexplained) < known + most and missed < WRONG:
        checkpoint()
        scopes = [replace(s, added=added) for s in given.problem.scopes()]
        if level == len(scopes):
            return
        problem = given.problem.within(scopes[level])
        found = _planned(given, problem, scopes[level], progress)
        if found is None:
            if len(given.unexplained) > known and not given.problem.blocked:
                return
            level += 1
            continue
        plan, kept = found if added else _better(given, problem, scopes[level], found, progress)
        new = given.new(plan)
        missed = 0 if new else missed + 1
        if plan is not None and new:
            yield plan
            if given.hopeless(trace):
                return
        if plan is not None and new and given.learn(plan, trace):
            level = 0
        else:
            given.earlier.append(kept)
            given.unexplained += [plan.steps] if plan is not None and new else []


class _Given:
    """Record of the task sequences that the caller has received, and of what their failures rule out.

    Args:
        problem: with what the failures of some have ruled out.
    """

    def __init__(self, problem: PlanningProblem) -> None:
        self.problem = problem
        self.earlier: list[list[PlanStep]] = []
        """Plans that the planner must not make again."""
        self.unexplained: list[tuple[Operator, ...]] = []
        """Task sequences whose failure gave no reason, or that did not fail."""

    def new(self, plan: TaskPlan | None) -> bool:
        """Check whether a plan has no needless step and does not contain a sequence that the caller has
        received."""
        return plan is not None and NEEDLESS not in plan.reasons and not any(_is_with_detours(e, plan.steps) for e in self.unexplained)

    def hopeless(self, trace: Trace | None) -> bool:
        """Check whether no sequence can succeed, since a thing that unmet goals need was found to fit no
        role."""
        found = trace.refutation if trace is not None else None
        lacking = {thing_of(e) for fact in self.problem.wanted.needs - self.problem.facts for e in fact[1:]}
        return found is not None and any(thing_of(name) in lacking for name in found.unfit)

    def learn(self, plan: TaskPlan, trace: Trace | None) -> bool:
        """Record what the failure of a task sequence rules out; return whether any of it is new."""
        found = trace.refutation if trace is not None else None
        new = self.problem.blockings(plan.steps, found) if found is not None else ()
        if trace is not None:
            self.problem = replace(self.problem, blocked=(*self.problem.blocked, *new))
            for blocking in new:
                trace.add(0, "goal", task_text(blocking.task), "refused", "engine", str(blocking), kind="goal")
        return bool(new)


FoundPlan = tuple[TaskPlan | None, list[PlanStep]]
"""Task plan made from a plan of the planner (None if that is invalid), and the planner's steps without the needless ones."""


def _planned(given: _Given, problem: PlanningProblem, scope: Scope, progress: Callable[[str], None]) -> FoundPlan | None:
    """Return the planner's plan within a scope of things and tasks; None if it finds none."""
    return _answer(problem.pddl(scope, given.earlier), problem, scope, progress)


def _answer(text: PddlText, problem: PlanningProblem, scope: Scope, progress: Callable[[str], None]) -> FoundPlan | None:
    answer = fast_downward(text, few_things(problem, scope), progress)
    return _plan(problem, steps_of(answer.plan, text, "the planner's plan")) if answer.plan is not None else None


def _better(given: _Given, problem: PlanningProblem, scope: Scope, found: FoundPlan, progress: Callable[[str], None]) -> FoundPlan:
    """Return the planner's plan, or a shorter one that uses tasks of further plugins and has no more needless effects than that plan.

    Further plugins are those that are neither shipped nor preferred.

    Where plans are not the shortest, their lengths say nothing; and after a plan that failed, the known tasks' others come first.
    """
    plan, wider = found[0], replace(scope, added=True)
    added = problem.knowledge.added_tasks
    if plan is None or given.unexplained or not few_things(problem, scope):
        return found
    text = problem.pddl(wider, given.earlier)
    other = _answer(text, problem, wider, progress) if added & {s.task for s in text.actions.values()} else None
    rival = other[0] if other is not None and given.new(other[0]) else None
    if rival is None or other is None or len(rival.steps) >= len(plan.steps):
        return found
    return other if problem.surplus(rival.steps) <= problem.surplus(plan.steps) else found


def few_things(problem: PlanningProblem, scope: Scope) -> bool:
    """Check whether so few things can be moved that the planner's search for the shortest plan is complete."""
    things = [problem.grounder.things[n] for n in scope.things]
    return sum(ON_JOINT if t.joint is not None else t.movable for t in things) < FEW + ON_JOINT / 2  # thirds do not add up to ones


def _plan(problem: PlanningProblem, steps: list[PlanStep]) -> FoundPlan:
    """Check a planner's plan, drop its needless steps, and let it close things as early as possible.

    The result is the plan, which is None if it is invalid, and the planner's steps that are left.
    """
    found = [(s, o) for s in steps if (o := problem.operator(s)) is not None]
    operators = [o for _, o in found]
    if len(found) < len(steps) or problem.failing(operators):
        return None, steps
    shorter = problem.shortened(operators)
    return problem.plan(problem.shut_first(shorter)), [s for s, o in found if any(o is kept for kept in shorter)]


def _is_with_detours(short: tuple[Operator, ...], long: tuple[Operator, ...]) -> bool:
    """Check whether a task sequence contains all steps of another one in the same order."""
    rest = iter(long)
    return all(any(str(step) == str(other) for other in rest) for step in short)

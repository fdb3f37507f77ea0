"""Symbolic planning problems, for external planners: facts, goal condition and ground operators."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from ..base.value import Value
from ..interpretation.fluents import Fact, Pattern, SymbolicWorld, matches
from .goal_planner import GoalFacts, TaskPlan, as_tasks, ground_goal, parse_goals, with_sides
from .operators import Grounder, Operator

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge
    from ..scenario.task_specs import TaskSpec
    from .task_goals import Goal


class PlanningProblem(Value):
    """A symbolic planning problem (STRIPS with negative preconditions; Fikes and Nilsson 1971).

    Args:
        facts: what holds at first, e.g. ``("on", "coffee", "hook")``.
        wanted: what must hold in the end, and what may not.
        operators: ground tasks with preconditions and effects.
        knowledge: of the engine, which has the task types.
    """

    facts: frozenset[Fact]
    wanted: GoalFacts
    operators: tuple[Operator, ...]
    knowledge: Knowledge

    @property
    def universe(self) -> frozenset[Fact]:
        """Every fact that the problem mentions."""
        return self.facts | {fact for operator in self.operators for fact in operator.adds} | self.wanted.needs

    def forbidden(self, patterns: Iterable[Pattern]) -> set[Fact]:
        """Return the facts of the problem that match one of the patterns: those that a negative condition forbids."""
        return {fact for fact in self.universe for pattern in patterns if matches(fact, pattern)}

    def tasks(self, steps: Sequence[Operator]) -> list[TaskSpec]:
        """Return the tasks of a plan as a scenario lists them, for ``Engine.resolve``."""
        return as_tasks(TaskPlan(tuple(steps), ()), self.knowledge.tasks, self.wanted)


def planning_problem(goal: Goal, scene: SymbolicWorld, knowledge: Knowledge) -> PlanningProblem:
    """Ground the task rules in a world, as the planning problem of a goal.

    Args:
        scene: what is known before anything is done, e.g. ``Setting.symbolic``.
        knowledge: of the engine.

    Raises:
        UserError: the goal cannot be read, or names what there is not.
    """
    grounder = Grounder(scene, knowledge.predicates)
    operators = grounder.ground(knowledge.goal_rules, knowledge.tasks)
    (meaning,) = ground_goal(goal, {}, grounder)
    target = parse_goals(meaning.says, grounder)
    return PlanningProblem(grounder.initial(), target, with_sides(target, operators, knowledge.tasks), knowledge)

"""Meaning of a scenario's goal: sentences replaced by goals, and described objects by things of a scene."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..base.errors import UserError
from .operators import Grounder
from .spoken_goals import spoken
from .symbolic.goal_planner import ground_goal
from .symbolic.planning_problem import PlanningProblem, problem_of
from .task_goals import Goal

if TYPE_CHECKING:
    from ..interpretation.fluents import SymbolicWorld
    from ..plugin.catalogue import Knowledge
    from ..scenario.scenario import Scenario


def meanings(scenario: Scenario, scene: SymbolicWorld, knowledge: Knowledge) -> Iterator[Goal]:
    """Generate the goals that a scenario's goal may mean among the things of a scene, the best first.

    Raises:
        NotUnderstood: a sentence is ambiguous, false of the scene, or in words that are not known.
    """
    goal = spoken(Goal(scenario.spec.goal or ()), scene, knowledge, f"{scenario.where('goal')}: ")
    yield from ground_goal(goal, scenario.spec.objects, Grounder(scene, knowledge.predicates))


def problem_of_scenario(scenario: Scenario, scene: SymbolicWorld, knowledge: Knowledge) -> PlanningProblem:
    """Return the planning problem of a scenario's goal, described objects replaced by the things that fit them best.

    Raises:
        UserError: no thing fits.
    """
    choice = next(meanings(scenario, scene, knowledge), None)
    if choice is None:
        raise UserError(f"{scenario.where('goal')}: no thing of the world fits the goal's objects.")
    return problem_of(choice, Grounder(scene, knowledge.predicates), knowledge, f"{scenario.where('goal')}: ")

"""Changes of plans: shipped goals that are planned with other tasks once a plugin is installed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from ..base.resources import shipped_scenarios
from ..base.value import Value
from ..engine.engine import Engine
from ..planning.scenario_goals import problem_of_scenario
from ..planning.symbolic.plan_stream import task_plans
from ..planning.symbolic.planning_problem import PlanningProblem
from ..plugin.entry_points import OWN_DISTRIBUTION
from ..scenario.scenario import Scenario, read_scenario

FAILING = "_fails"
"""Suffix of the names of shipped scenarios that are unsolvable variants of another scenario with the same goal."""


class PlanChange(Value):
    """Difference between the first plans for a goal with a plugin and without it.

    Args:
        scenario: file.
        goal: in words.
        without, with_it: tasks of the first plan, without the plugin and with it; empty where there is no plan.
    """

    scenario: Path
    goal: str
    without: tuple[str, ...]
    with_it: tuple[str, ...]

    def __str__(self) -> str:
        one, other = (" -> ".join(tasks) or "no plan" for tasks in (self.without, self.with_it))
        return f"'{self.goal}' of {self.scenario.stem}: with the plugin {other}, without it {one}"


def plan_changes(module: ModuleType, scenarios: tuple[Path, ...] | None = None) -> tuple[PlanChange, ...]:
    """Return the goals whose first plan changes when a plugin module is installed.

    Args:
        module: of the plugin, installed or not.
        scenarios: files with goals; those of the shipped ones by default, whose worlds are known without a camera.
    """
    with_it = Engine()
    place = getattr(module, "__file__", None)
    installed = [i for i in with_it.registry.infos if place is not None and i.file == place]
    if any(i.distribution == OWN_DISTRIBUTION for i in installed):
        return ()
    if not installed:
        with_it.registry.include(module)
    own = installed[0].name if installed else module.__name__
    added = frozenset(t for t in with_it.knowledge.added_tasks if with_it.knowledge.task_owners[t] == own)
    if not any(rule.task in added for rule in with_it.knowledge.goal_rules):
        return ()
    without = Engine(blocked=[i.name for i in installed])
    found = (_change(path, without, with_it, added) for path in (_shipped() if scenarios is None else scenarios))
    return tuple(change for change in found if change is not None)


def _shipped() -> Iterator[Path]:
    yield from (path for name, path in shipped_scenarios().items() if not name.endswith(FAILING))


def _change(path: Path, without: Engine, with_it: Engine, added: frozenset[str]) -> PlanChange | None:
    scenario = read_scenario(path)
    if scenario.spec.goal is None or scenario.spec.poses == "camera":
        return None
    new = _problem(scenario, with_it)
    if not added & {s.task for s in new.pddl(next(new.scopes())).actions.values()}:
        return None  # the planner is given the same problem
    one, other = (_first(problem) for problem in (_problem(scenario, without), new))
    return PlanChange(path, " and ".join(scenario.spec.goal), one, other) if one != other else None


def _problem(scenario: Scenario, engine: Engine) -> PlanningProblem:
    return problem_of_scenario(scenario, engine.setting(scenario).symbolic(engine.knowledge.taxonomy), engine.knowledge)


def _first(problem: PlanningProblem) -> tuple[str, ...]:
    plan = next(task_plans(problem), None)
    return tuple(map(str, plan.steps)) if plan is not None else ()

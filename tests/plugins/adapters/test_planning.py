"""unified-planning: rules become actions, an engine's plan is resolved, refusals are told to it as facts."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Engine, Goal, PddlText, PlanningProblem, Setting, find_scenario, read_scenario, steps_of
from cramlite.plugin import UserError

pytest.importorskip("unified_planning")

from cramlite_plugins.adapters.planning import problem_of, resolve_planned, with_engine

ENGINE = Engine()
GOAL = Goal(("block on shelf",))
SHELF = find_scenario("place_on_shelf")


def _setting(path: Path) -> Setting:
    return ENGINE.setting(read_scenario(path))


def _text(problem: PlanningProblem, *refused: str) -> PddlText:
    """The whole world, without some tasks of the plan that the engine finds first."""
    text = problem.pddl()
    plan = with_engine()(text)
    assert plan is not None
    steps = [s for s in steps_of(plan, text, "plan") if str(problem.operator(s)).startswith(refused)] if refused else []
    return problem.pddl(refused=steps)


@pytest.mark.heavy
def test_the_planners_plan_is_resolved() -> None:
    planned = resolve_planned(ENGINE, _setting(SHELF), GOAL)
    assert planned.solution is not None and planned.solution.verdict.passed
    assert [s.task for s in planned.steps] == ["soma:Grasping", "soma:PickingUp", "soma:Placing"]
    assert planned.refused == {}


def test_a_refusal_is_a_fact_for_the_planner(tmp_path: Path) -> None:
    """The first block is too wide for the gripper; the goal is met by no other, so the planner finds nothing more."""
    path = tmp_path / "wide.yaml"
    path.write_text(SHELF.read_text().replace("[50 mm, 50 mm, 100 mm]", "[150 mm, 150 mm, 100 mm]"))
    planned = resolve_planned(ENGINE, _setting(path), GOAL)
    assert planned.solution is None
    assert list(planned.refused) == ["Grasping(Patient=block)"]
    assert "fits the gripper's" in planned.refused["Grasping(Patient=block)"]


@pytest.mark.heavy
def test_facts_of_refusals_change_the_plan() -> None:
    problem = problem_of(ENGINE, _setting(SHELF), GOAL)
    other = with_engine()(_text(problem, "Placing", "PuttingDown"))
    assert other is not None and "(placing block shelf)" not in other
    assert with_engine()(_text(problem, "Grasping")) is None


def test_a_planner_that_is_wrong_is_caught() -> None:
    setting = _setting(SHELF)
    with pytest.raises(UserError, match=r"step 1 of the plan, needs grasps\(gripper, block\)"):
        resolve_planned(ENGINE, setting, GOAL, lambda _: "(placing block shelf)")
    with pytest.raises(UserError, match="which the goal asks for"):
        resolve_planned(ENGINE, setting, GOAL, lambda _: "(grasping block)")
    with pytest.raises(UserError, match="no action 'placin'; did you mean 'placing'"):
        resolve_planned(ENGINE, setting, GOAL, lambda _: "(placin block shelf)")

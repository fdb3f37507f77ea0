"""unified-planning: rules become actions, a real planner's plan is resolved, refusals are told to it as facts."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Engine, Goal, Setting, find_scenario, read_scenario
from cramlite.plugin import UserError

pytest.importorskip("unified_planning")
pytest.importorskip("up_pyperplan")

from cramlite_plugins.adapters.planning import problem_of, pyperplan, resolve_planned, to_unified_planning

ENGINE = Engine()
GOAL = Goal(("block on shelf",))


def _setting(path: Path) -> Setting:
    return ENGINE.setting(read_scenario(path))


def test_the_planners_plan_is_resolved() -> None:
    planned = resolve_planned(ENGINE, _setting(find_scenario("place_on_shelf")), GOAL)
    assert planned.solution is not None and planned.solution.verdict.passed
    assert [s.task for s in planned.steps][:2] == ["soma:Grasping", "soma:PickingUp"]
    assert planned.refused == {}


def test_a_refusal_is_a_fact_for_the_planner(tmp_path: Path) -> None:
    """The first block is too wide for the gripper; the goal is met by no other, so the planner finds nothing more."""
    path = tmp_path / "wide.yaml"
    path.write_text(
        find_scenario("place_on_shelf").read_text().replace("[50 mm, 50 mm, 100 mm]", "[150 mm, 150 mm, 100 mm]")
    )
    planned = resolve_planned(ENGINE, _setting(path), GOAL)
    assert planned.solution is None
    assert list(planned.refused) == ["Grasping(Patient=block)"]
    assert "fits the gripper's" in planned.refused["Grasping(Patient=block)"]


def test_facts_of_refusals_change_the_plan() -> None:
    setting = _setting(find_scenario("place_on_shelf"))
    problem = problem_of(ENGINE, setting, GOAL)

    def plan(*refused: str) -> list[str] | None:
        names = pyperplan(to_unified_planning(problem, refused))
        return None if names is None else [str(problem.operators[int(n[1:])]) for n in names]

    first = plan()
    assert first is not None
    (placing,) = [s for s in first if s.startswith(("Placing", "PuttingDown"))]
    second = plan(placing)
    assert second is not None and placing not in second
    assert plan("Grasping(Patient=block)") is None


def test_a_planner_that_is_wrong_is_caught() -> None:
    setting = _setting(find_scenario("place_on_shelf"))
    problem = problem_of(ENGINE, setting, GOAL)
    placing = next(k for k, o in enumerate(problem.operators) if str(o).startswith("Placing"))
    grasping = next(k for k, o in enumerate(problem.operators) if str(o) == "Grasping(Patient=block)")
    with pytest.raises(UserError, match="cannot be done where it stands"):
        resolve_planned(ENGINE, setting, GOAL, lambda _: [f"a{placing}"])
    with pytest.raises(UserError, match="does not lead to the goal"):
        resolve_planned(ENGINE, setting, GOAL, lambda _: [f"a{grasping}"])

"""What a scenario's limits keep in its place is in no plan: it is neither put aside, opened nor pushed."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Engine, Goal, Trace, planning_problem, read_scenario
from cramlite.planning.refutation import Refutation
from cramlite.planning.symbolic.plan_stream import task_plans
from cramlite.planning.symbolic.planning_problem import PlanningProblem
from cramlite.planning.symbolic.unreachable import why_unreachable

ENGINE = Engine()
PILE = """scenario: pile
robot: {type: ur5e}
tasks: []
limits: {keep: {KEPT: 2 mm}}
things:
  - {name: floor, model: table, at: {position: [0.3, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: wanted, model: block, at: {position: [0.5, 0.2, 31 mm]}}
  - {name: upper, model: block, at: {position: [0.5, 0.2, 92 mm]}}
  - {name: base, model: block, at: {position: [0.5, -0.2, 31 mm]}}
  - {name: other, model: block, at: {position: [0.3, -0.2, 31 mm]}}
  - {name: cabinet, model: cabinet, at: {position: [0.75, 0.5, 0.35], yaw: 180 deg}}
  - {name: drawer, model: drawer, at: {position: [0.75, 0.5, 0.35], yaw: 180 deg}, with: {parent: cabinet}}
"""


def problem(folder: Path, goal: str, kept: str) -> PlanningProblem:
    (folder / "pile.yaml").write_text(PILE.replace("KEPT", kept))
    scene = ENGINE.setting(read_scenario(folder / "pile.yaml")).symbolic(ENGINE.knowledge.taxonomy)
    return planning_problem(Goal((goal,)), scene, ENGINE.knowledge)


@pytest.mark.parametrize(("kept", "plans"), [("upper", 0), ("base", 1)])
def test_what_lies_on_the_payload_is_put_aside_unless_it_must_stay(tmp_path: Path, kept: str, plans: int) -> None:
    found = list(task_plans(problem(tmp_path, "wanted on base", kept), most=1))
    assert len(found) == plans


@pytest.mark.parametrize(("kept", "moved"), [("base", {"other", "wanted"}), ("other", {"wanted"})])
def test_what_is_in_the_way_is_not_moved_if_it_must_stay(tmp_path: Path, kept: str, moved: set[str]) -> None:
    trace, found = Trace(), list[set[str]]()
    for plan in task_plans(problem(tmp_path, "upper on base", kept), trace=trace, most=2):
        found.append({e for s in plan.steps for r, e in s.roles.items() if r in ("Patient", "Locatum")})
        trace.candidate = len(found)
        trace.refuted("", Refutation((1,), (("other",),)))
    assert ("other" in set().union(*found)) == ("other" in moved)


@pytest.mark.parametrize(("goal", "kept"), [("wanted on base", "wanted"), ("drawer open", "drawer")])
def test_a_goal_that_moves_it_is_refused_with_the_reason(tmp_path: Path, goal: str, kept: str) -> None:
    assert why_unreachable(problem(tmp_path, goal, kept)).endswith(f"; not to be moved (limits: keep): '{kept}'")

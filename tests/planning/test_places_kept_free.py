"""What is put aside does not take the place of what the goal asks for there, unless nothing else is left."""

from __future__ import annotations

from pathlib import Path

from cramlite import Engine, Goal, Trace, planning_problem, read_scenario
from cramlite.planning.refutation import Refutation
from cramlite.planning.symbolic.plan_stream import task_plans

ENGINE = Engine()
DOWN = "soma:Placing", "soma:PuttingDown"
PILE = """scenario: pile
robot: {type: ur5e}
tasks: []
things:
  - {name: floor, model: table, at: {position: [0.3, 0, -5 mm]}, with: {size: [1.2 m, 1.2 m, 20 mm]}}
  - {name: wanted, model: block, at: {position: [0.5, 0.2, 31 mm]}}
  - {name: upper, model: block, at: {position: [0.5, 0.2, 92 mm]}}
  - {name: base, model: block, at: {position: [0.5, -0.2, 31 mm]}}
"""


def _upper_goes_onto(folder: Path, goal: str, refused: str = "") -> str:
    """What the upper block of a pile is put onto, as the first plan says, or the one after a refusal of that."""
    (folder / "pile.yaml").write_text(PILE)
    scene = ENGINE.setting(read_scenario(folder / "pile.yaml")).symbolic(ENGINE.knowledge.taxonomy)
    trace = Trace()
    for plan in task_plans(planning_problem(Goal((goal,)), scene, ENGINE.knowledge), trace=trace):
        put = [k for k, s in enumerate(plan.steps) if s.task in DOWN and s.roles["Locatum"] == "upper"]
        if plan.steps[put[0]].roles["Relatum"] != refused:
            return plan.steps[put[0]].roles["Relatum"]
        trace.refuted("", Refutation((put[0] + 1,), ()))
    return ""


def test_what_is_put_aside_leaves_the_place_of_another_free(tmp_path: Path) -> None:
    assert _upper_goes_onto(tmp_path, "wanted on base") == "floor"


def test_it_is_put_there_where_nothing_else_is_left(tmp_path: Path) -> None:
    assert _upper_goes_onto(tmp_path, "wanted on base", refused="floor") == "base"


def test_what_the_goal_asks_for_there_is_put_there(tmp_path: Path) -> None:
    assert _upper_goes_onto(tmp_path, "upper on base") == "base"

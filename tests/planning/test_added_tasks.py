"""Tasks of further plugins change no plan unseen: sequences of shipped tasks come first, unless another is shorter and as clean."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest
from helpers.goal_plans import plans_in
from helpers.strangers_tasks import NUISANCES, imported, stranger

from cramlite import Engine, Goal, Trace, find_scenario, read_scenario
from cramlite.testing import check_plugin, plan_changes

BOX = """
scenario: box
goal: [red in box]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: box, model: basket, at: {position: [0.1, -0.55, 5 mm]}}
  - {name: red, model: block, at: {position: [0.45, 0.1, 31 mm]}}
"""
SHIPPED = "Grasping -> PickingUp -> Ungrasping -> Retracting"
SOME = ("bottle_on_rack", "drawer_blocked", "swap_on_shelf")


@pytest.fixture(scope="module")
def box(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("box") / "box.yaml"
    path.write_text(BOX)
    return path


def _plans(scenario: Path, engine: Engine, most: int = 1) -> list[str]:
    setting = engine.setting(read_scenario(scenario))
    return [str(p) for p in islice(plans_in(setting, Goal(("red in box",)), engine.knowledge, Trace()), most)]


@pytest.mark.heavy
@pytest.mark.parametrize("name", NUISANCES)
def test_a_task_with_further_effects_changes_no_plan(name: str, box: Path, tmp_path: Path) -> None:
    assert _plans(box, Engine(files=[stranger(name, tmp_path)])) == [SHIPPED]


@pytest.mark.heavy
def test_its_sequences_come_later_and_first_where_it_is_preferred(box: Path, tmp_path: Path) -> None:
    file = stranger("dipping", tmp_path)
    assert "Grasping -> Dipping -> Placing" in _plans(box, Engine(files=[file]), most=8)
    assert _plans(box, Engine(files=[file], preferred=["dipping"])) == ["Grasping -> Dipping -> Placing"]


def test_it_is_used_where_shipped_tasks_alone_do_not_achieve_the_goal(box: Path, tmp_path: Path) -> None:
    engine = Engine(files=[stranger("dipping", tmp_path)], blocked=["ungrasping"])
    assert _plans(box, Engine(blocked=["ungrasping"])) == []
    assert _plans(box, engine) == ["Grasping -> Dipping -> Placing"]


def test_a_shorter_plan_without_further_effects_comes_first_and_is_told(box: Path, tmp_path: Path) -> None:
    file = stranger("tossing", tmp_path)
    assert _plans(box, Engine(files=[file])) == ["Grasping -> Tossing"]
    (change,) = plan_changes(imported(file), (box,))
    assert [t.partition("(")[0] for t in change.without] == SHIPPED.split(" -> ")
    assert [t.partition("(")[0] for t in change.with_it] == ["Grasping", "Tossing"]


@pytest.mark.heavy
@pytest.mark.parametrize("name", NUISANCES)
def test_plans_of_shipped_goals_stay(name: str, tmp_path: Path) -> None:
    assert plan_changes(imported(stranger(name, tmp_path)), tuple(map(find_scenario, SOME))) == ()


@pytest.mark.heavy
@pytest.mark.parametrize("name", NUISANCES)
def test_no_shipped_goal_has_another_plan(name: str, tmp_path: Path) -> None:
    assert plan_changes(imported(stranger(name, tmp_path))) == ()


@pytest.mark.heavy
def test_a_check_of_the_plugin_tells_which_plans_change(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match=r"'tin in drawer' of drawer_blocked: with the plugin .*Tossing.*, without it Opening"):
        check_plugin(imported(stranger("tossing", tmp_path)))

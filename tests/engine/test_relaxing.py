"""What would have to change: the smallest declared change is found, and a step less does not do."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Run

from cramlite import Budget, Engine, read_scenario
from cramlite.engine.relaxing import Change, WiderGripper, _smallest, _solves, changes
from cramlite.scenario.scenario import Scenario

SCENE = """scenario: unsolvable
goal: [block on shelf]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.6, 0, -5 mm]}, with: {size: [2.4 m, 1.6 m, 20 mm]}}
  - {name: block, model: block, at: {position: [BLOCK, 0.0, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
  - {name: shelf, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}
"""


@pytest.mark.parametrize("least", [1, 2, 3, 7, 8, 20, 32])
def test_the_smallest_is_found_and_the_one_before_was_tried(least: int) -> None:
    tried: list[int] = []
    assert _smallest(lambda k: tried.append(k) or k >= least, 32) == least  # type: ignore[func-returns-value]
    assert least == 1 or least - 1 in tried
    assert _smallest(lambda k: False, 32) == 0


@pytest.mark.heavy
def test_a_block_wider_than_the_fingers_open_asks_for_a_wider_gripper(tmp_path: Path) -> None:
    """The hand grasps 81 mm at most, 98 mm with two steps; the block is 97 mm wide."""
    scenario = scene(tmp_path, "0.5", "97 mm")
    engine = Engine()
    setting = engine.setting(scenario, twins=0)
    (change,) = [c for c in changes(scenario, setting) if isinstance(c, WiderGripper)]
    assert [_solves(change, k, scenario, setting, engine, Budget(), lambda _: None) for k in (1, 2)] == [False, True]
    assert engine.knowledge.robots["ur5e"] is setting.robot, "the engine keeps its own robot"


def test_no_wider_gripper_is_asked_for_where_all_fits(tmp_path: Path) -> None:
    scenario = scene(tmp_path, "1.15", "50 mm")
    assert {type(c) for c in changes(scenario, Engine().setting(scenario, twins=0))} == {Change}


def scene(folder: Path, x: str, width: str) -> Scenario:
    (folder / "scene.yaml").write_text(SCENE.replace("BLOCK", x).replace("50 mm, 50 mm", f"{width}, {width}"))
    return read_scenario(folder / "scene.yaml")


@pytest.mark.heavy
def test_what_is_out_of_reach_asks_for_the_base(tmp_path: Path, run: Run) -> None:
    (tmp_path / "far.yaml").write_text(SCENE.replace("BLOCK", "1.15"))
    done = run("resolve", tmp_path / "far.yaml", "--relax", "--no-report", "--out", tmp_path / "out")
    assert done.code == 1
    assert "could be solved if you brought the base of 'arm' nearer to 'block' by 100 mm; by 80 mm nothing was proven." in done.err

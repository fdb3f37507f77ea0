"""What stands on the floor of a deep container was let go over it, where the hand does not fit in: if its middle is free."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Budget, Engine, Solution, Trace, failure_text, read_scenario

SCENE = """
scenario: on_floor
goal: [sample on basket within 30 mm]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: sample, model: block, at: {position: [0.5, 0.2, 26 mm]}, with: {size: [30 mm, 30 mm, 40 mm], mass: 50 g}}
  - {name: basket, model: basket, at: {position: [0.30, -0.45, 0]}, with: {size: [0.20 m, 0.20 m, DEEP m]}}
"""
POST = "  - {name: post, model: table, at: {position: [0.30, -0.45, 0.11]}, with: {size: [50 mm, 50 mm, 200 mm]}}\n"


def _solved(folder: Path, deep: float, more: str = "") -> tuple[Solution | None, str]:
    engine, trace, path = Engine(), Trace(), folder / "scenario.yaml"
    path.write_text(SCENE.replace("DEEP", str(deep)) + more)
    found = next(engine.resolve(read_scenario(path), budget=Budget(sequences=1), trace=trace), None)
    return found, "" if found else failure_text(trace, engine.registry.faults)


@pytest.mark.heavy
@pytest.mark.parametrize(("deep", "dropped"), [(0.26, True), (0.08, False)])
def test_where_the_hand_does_not_fit_in_it_is_let_go_over_the_floor(tmp_path: Path, deep: float, dropped: bool) -> None:
    found, reasons = _solved(tmp_path, deep)
    assert found is not None, reasons
    assert any(f.origin == "3.Placing/Ungrasping" for f in found.verdict.findings) == dropped


@pytest.mark.heavy
def test_where_the_middle_is_taken_it_is_not(tmp_path: Path) -> None:
    found, reasons = _solved(tmp_path, 0.26, POST)
    assert found is None and "basket" in reasons

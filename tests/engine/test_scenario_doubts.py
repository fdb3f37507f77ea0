"""Doubts about a scenario before the search: other units, things inside each other, things that stand on nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import ROOT, Run

from cramlite import Engine, UserError, read_scenario
from cramlite.engine.scenario_doubts import doubts

ENGINE = Engine()
KITCHEN = ROOT / "scenarios" / "kitchen"
SEEN = [p for p in KITCHEN.glob("*.yaml") if "_camera" in p.stem]  # the arm looks first, for seconds
SHIPPED = sorted({*(ROOT / "scenarios").glob("*.yaml"), *KITCHEN.glob("*.yaml")} - {*SEEN})


def _doubts(path: Path) -> list[str]:
    scenario = read_scenario(path)
    return doubts(scenario, ENGINE.setting(scenario), ENGINE.knowledge)


@pytest.mark.parametrize("path", [p for p in SHIPPED if not p.stem.endswith("_camera")], ids=lambda p: p.stem)
def test_there_are_none_about_what_is_shipped(path: Path) -> None:
    assert _doubts(path) == []


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            "[0.87, 0, 0.45], yaw: 180 deg",
            "[0.87, 0, 0.45], yaw: 180",
            "'yaw' is 180 rad, more than a turn; write '180 deg'",
        ),
        ("[0.30, -0.45, 0]", "[300, -450, 0]", "300 m is far away; write '300 mm'"),
        ("[0.30, -0.45, 0]", "[0.299, 0.15, 0]", "'basket' and the robot 'arm' overlap by"),
        (
            "hangs_on: {hanger: hook, depth: 70 mm}",
            "at: {position: [0.5, 0.4, 0.6]}",
            "'tea' stands on nothing and falls; the next thing below its middle is 'floor', 601 mm lower",
        ),
        (
            "hangs_on: {hanger: hook, depth: 70 mm}",
            "at: {position: [1.5, 0.4, 0.6]}",
            "'tea' stands on nothing and falls; nothing is below it",
        ),
    ],
)
def test_each_is_named_with_file_and_line(old: str, new: str, says: str, spoiled: Callable[..., Path]) -> None:
    path = spoiled((old, new))
    line = next(k for k, text in enumerate(path.read_text().splitlines(), 1) if new in text)
    found = [d for d in _doubts(path) if says in d]
    assert len(found) == 1, _doubts(path)
    assert found[0].startswith(f"{path}:") and abs(int(found[0].split(":")[1]) - line) <= 3  # the thing, or its key


@pytest.mark.parametrize(("over", "doubted"), [(7, False), (8, True)])
def test_what_begins_well_above_what_it_lies_on_is_named(over: int, doubted: bool, tmp_path: Path) -> None:
    """Of a board of 24 mm, pushed at a third of its height: hands plan for where it is said to be, and it is elsewhere."""
    text = (KITCHEN / "board_before_drawer.yaml").read_text().replace("-0.06, 7 mm]", f"-0.06, {7 + over + 0.4} mm]")
    (tmp_path / "board.yaml").write_text(text)
    found = _doubts(tmp_path / "board.yaml")
    assert len(found) == doubted
    assert all("'board', which is 24 mm high, starts 8 mm above where it comes to rest; state a lower pose" in d for d in found)


def test_check_prints_them_and_passes(spoiled: Callable[..., Path], run: Run) -> None:
    ran = run("check", spoiled(("[0.30, -0.45, 0]", "[0.299, 0.15, 0]")))
    assert ran.code == 0
    assert "overlap by" in ran.out.splitlines()[0]


def test_an_arm_that_begins_inside_a_thing_is_refused_at_once(spoiled: Callable[..., Path]) -> None:
    """By more than 5 mm; what is fixed there is not what is easiest to move, so that the robot's line is named."""
    path = spoiled(("[0.30, -0.45, 0]", "[0.05, 0, 0]"))
    with pytest.raises(UserError, match=r"'basket' and the robot 'arm' overlap by 45 mm .* with 'robot: {at: ...}'") as refused:
        _doubts(path)
    line = 1 + [text.startswith("robot:") for text in path.read_text().splitlines()].index(True)
    assert str(refused.value).startswith(f"{path}:{line}: ")


def test_a_simulator_need_not_have_any(spoiled: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> None:
    class Trusting:
        """The shipped simulator without what a simulator need not have."""

        def __init__(self, simulator: object) -> None:
            self._simulator = simulator

        def __getattr__(self, name: str) -> object:
            if name == "doubts":
                raise AttributeError(name)
            return getattr(self._simulator, name)

    monkeypatch.setattr(ENGINE.knowledge, "simulator", Trusting(ENGINE.knowledge.simulator))
    assert _doubts(spoiled(("[0.30, -0.45, 0]", "[0.299, 0.15, 0]"))) == []

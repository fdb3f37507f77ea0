"""``cramlite judge`` of a text whose thing is fragile: its largest force and its weight come from the run directory or the
scenario."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Run

from cramlite import find_scenario
from cramlite.cli.main import main

CLOSE, LOADED = "move_gripper(255, 157, 19,", "set_target_payload(1.125,"


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scenario of a block that is gripped, which bears 36 N."""
    path = tmp_path_factory.mktemp("limits") / "fragile.yaml"
    text = find_scenario("tasks/grasping").read_text()
    path.write_text(text.replace("- {name: block,", "- {name: block, max_grip_force: 36 N,"))
    return path


@pytest.fixture(scope="module")
def taken(scenario: Path) -> Path:
    """Its run directory."""
    folder = scenario.parent / "taken"
    assert main(["resolve", str(scenario), "--twins", "0", "--no-report", "--out", str(folder)]) == 0
    return folder


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("old", "new", "judge"),
    [
        (CLOSE, CLOSE, ""), (CLOSE, CLOSE.replace("19", "255"), "grip_limits: the gripper was told to press 'block' with 235.0 N"),
        (LOADED, LOADED, ""), (LOADED, "set_target_payload(4.0,", "payload: the arm was told that 4.00 kg hang on it"),
    ],
)  # fmt: skip
def test_limits_of_things_are_known_to_who_judges_a_text(run: Run, scenario: Path, taken: Path, old: str, new: str, judge: str) -> None:
    text = (taken / "program.script").read_text()
    assert text.count(old) == 1
    edited = scenario.parent / "edited.script"
    edited.write_text(text.replace(old, new))
    for plan in (taken, scenario):
        done = run("judge", edited, "--world", taken, "--plan", plan)
        assert (done.code == 0) is (not judge), done.out
        assert judge in done.out

"""A hand from a file that closes on nothing names the keys that may be wrong; its guesses are doubts in 'check' and in the report."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import Run

DATA = Path(__file__).parents[1] / "imports" / "robots_data"
KEYS = ("'pads'", "'tcp'", "'pad_friction'")
SCENARIO = """\
scenario: taken
tasks: [{{task: Grasp, Patient: block}}]
robot:
  {{file: {arm}, gripper: {{file: hand.xml{tcp}}}, payload: 4 kg, home: [0, 0.3, 1.6, 0, 1.24, 0], sensor: flange}}
budget: {{proofs: 1}}
{physics}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: block, model: block, at: {{position: [0.5, 0.2, 51 mm]}}, with: {{size: [40 mm, 40 mm, 100 mm]}}}}
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    """A scenario with a hand whose file has a site 80 mm in front of where it grips."""
    hand = (DATA / "linked_hand.xml").read_text()
    site = '<body name="palm"><site name="ahead" pos="0 0 0.22"/>'
    (tmp_path / "hand.xml").write_text(hand.replace('<body name="palm">', site))
    return tmp_path / "taken.yaml"


def written(path: Path, tcp: str = "", physics: str = "") -> Path:
    path.write_text(SCENARIO.format(arm=DATA / "six.urdf", tcp=tcp, physics=physics))
    return path


@pytest.mark.heavy
def test_a_hand_that_closes_on_nothing_names_the_keys_that_may_be_wrong(scenario: Path, run: Run, tmp_path: Path) -> None:
    ran = run("resolve", written(scenario, ", tcp: ahead"), "--twins", "0", "--out", tmp_path / "run")
    assert ran.code == 1 and "the hand closed to " in ran.err and "without 'block'" in ran.err, ran.err
    assert all(key in ran.err.partition("the hand closed to ")[2] for key in KEYS)
    assert "its pads are taken to be faces of" in (tmp_path / "run" / "report.html").read_text()


def test_one_that_holds_something_does_not(scenario: Path, run: Run, tmp_path: Path) -> None:
    ran = run("resolve", written(scenario), "--twins", "0", "--no-report", "--out", tmp_path / "run")
    assert ran.code == 0 and "the hand closed to " not in ran.err + ran.out, ran.err


def test_friction_of_the_file_is_a_doubt_until_the_scenario_states_it(scenario: Path, run: Run) -> None:
    said = "the friction of the gripper's pads is 0.8"
    assert said in run("check", written(scenario)).out
    assert said not in run("check", written(scenario, physics="physics: {pad_friction: 0.7}")).out


def test_doubts_of_files_are_printed_by_check_and_only_counted_by_resolve(scenario: Path, run: Run, tmp_path: Path) -> None:
    checked, resolved = run("check", written(scenario)), run("resolve", scenario, "--twins", "0", "--no-report", "--out", tmp_path / "run")
    printed = re.findall(r"^.*taken\.yaml:\d+: (.*)$", checked.out, re.MULTILINE)
    assert len(printed) >= 6 and not any(said in resolved.err for said in printed)
    assert f"{len(printed)} doubts about files of robot and scene: 'cramlite check {scenario}' prints the doubts" in resolved.err

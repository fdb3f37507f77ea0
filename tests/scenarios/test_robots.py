"""Both scenarios on every robot, by changing the scenario's line ``robot:``, and what no change of robot can do.

The UR5e is in test_fetch_from_hanger and test_hang_onto_hanger; tests/benchmarks/robots.py has more seeds.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from cramlite.engine.proof.executor import Executor
from cramlite.model import MoveJoints, Program, RobotMount, World, write_program
from cramlite.plugin import UserError
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry
from cramlite.plugin.selection import PluginChoice
from cramlite_plugins.robots.fr3 import FR3

SCENARIOS = Path(__file__).parents[2] / "scenarios"
LINE = "robot: {type: ur5e}"
MINE = """
from msgspec.structs import replace
from cramlite.plugin import hookimpl
from cramlite_plugins.robots.fr3 import FR3

@hookimpl
def robots():
    return [replace(FR3, type="mine")]
"""
ONCE = "\nbudget: {proofs: 1, sequences: 1}"


def variant(folder: Path, scenario: str, robot: str, *changes: tuple[str, str]) -> Path:
    """A shipped scenario with another robot, and perhaps more replaced; each replacement must change something."""
    text = (SCENARIOS / f"{scenario}.yaml").read_text()
    demonstration = ("demonstration: ", f"demonstration: {SCENARIOS}/")
    for old, new in ((LINE, LINE.replace("ur5e", robot)), demonstration, *changes):
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / "variant.yaml"
    path.write_text(text)
    return path


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("scenario", "end", "robot"),
    [
        ("fetch_from_hanger", "'coffee' rests in 'basket'", "ur5"),
        ("fetch_from_hanger", "'coffee' rests in 'basket'", "fr3"),
        pytest.param("hang_onto_hanger", "'coffee' hangs on 'hook'", "ur5", marks=pytest.mark.heavy),
        pytest.param("hang_onto_hanger", "'coffee' hangs on 'hook'", "fr3", marks=pytest.mark.heavy),
    ],
)
def test_the_scenario_runs_on_another_robot(
    scenario: str, end: str, robot: str, run: Callable[..., Any], tmp_path: Path
) -> None:
    done = run("resolve", variant(tmp_path, scenario, robot), "--out", tmp_path / "run", "--no-report", "--json")
    assert done.code == 0, done.err
    findings = json.loads(done.out)["findings"]
    assert end in [f["reason"] for f in findings]
    assert all(f["passed"] for f in findings)
    suffix = {"ur5": ".script", "fr3": ".json"}[robot]
    text = (tmp_path / "run" / f"program{suffix}").read_text()
    assert robot != "ur5" or ("axia80" in text and "zero_ftsensor()" not in text), "a sensor of its own"


def of_one_thing(folder: Path, scenario: str, robot: str) -> Path:
    """A shipped scenario without a demonstration, with another robot."""
    text = (SCENARIOS / f"{scenario}.yaml").read_text()
    assert LINE in text
    path = folder / f"{scenario}.yaml"
    path.write_text(text.replace(LINE, f"robot: {{type: {robot}}}"))
    return path


FAMILY = {"ur3": False, "ur3e": True, "ur10": True, "ur10e": True, "ur16e": True, "ur20": True, "ur30": False}
"""Robot -> whether it is between others, so that these show what it would."""


@pytest.mark.heavy
@pytest.mark.parametrize("robot", [pytest.param(r, marks=pytest.mark.heavy) if between else r for r, between in FAMILY.items()])
def test_the_family_grasps_and_places(robot: str, run: Callable[..., Any], tmp_path: Path) -> None:
    """The small arms stand nearer to the peg; all else is as shipped."""
    near = ", at: {position: [250 mm, 0, 0]}" if robot in ("ur3", "ur3e") else ""
    for scenario, where, end in (("grasp_one_thing", near, "grasps("), ("place_on_shelf", "", "'block' rests on 'shelf'")):
        varied = of_one_thing(tmp_path, scenario, f"{robot}{where}")
        done = run("resolve", varied, "--out", tmp_path / scenario, "--no-report", "--twins", "0", "--json")
        assert done.code == 0, done.err
        findings = json.loads(done.out)["findings"]
        assert any(end in f["reason"] for f in findings), [f["reason"] for f in findings]
        assert all(f["passed"] for f in findings)
        assert (tmp_path / scenario / "program.script").is_file()


def test_a_small_arm_says_what_is_out_of_its_reach(run: Callable[..., Any], tmp_path: Path) -> None:
    done = run("resolve", of_one_thing(tmp_path, "grasp_one_thing", "ur3"), "--out", tmp_path / "run", "--no-report")
    assert done.code == 1, done.err
    assert "nearest point at 0.77 m > 0.68 m reach of arm 'ur3'" in done.err


PROGRAM = Program("look", "arm", "fr3", FR3.gripper.tcp, FR3.home, (MoveJoints(((0.3, *FR3.home[1:]),), 1.0, 1.4),), ())


def test_execute_runs_a_typed_program_and_explains_a_broken_one(run: Callable[..., Any], tmp_path: Path) -> None:
    program, text = tmp_path / "program.json", write_program(PROGRAM)
    program.write_text(text)
    scenario = variant(tmp_path, "fetch_from_hanger", "fr3")
    done = run("execute", program, "--world", scenario)
    assert done.code == 0, done.err
    assert "cramlite: finished" in done.out
    program.write_text(text.replace("MoveJoints", "MoveJonts"))
    wrong = run("execute", program, "--world", scenario)
    assert wrong.code == 2
    assert "line 9: the program.steps[0].step is \"MoveJonts\"" in wrong.err
    assert "did you mean 'MoveJoints'" in wrong.err
    assert wrong.err.count("\n") == 1


def test_a_process_of_its_own_knows_the_robots_of_plugins(tmp_path: Path) -> None:
    """It asks the registry: here for a robot that only a plugin's file declares."""
    (tmp_path / "mine.py").write_text(MINE)
    text = write_program(replace(PROGRAM, robot_type="mine"))
    world = World((), (RobotMount("arm", "mine"),))
    with closing(Executor(PluginChoice((tmp_path / "mine.py",)))) as knows:
        assert knows.run(text, world, 0)[0].joints[-1][0] == pytest.approx(0.3, abs=2e-3)
    with closing(Executor()) as other, pytest.raises(UserError, match="there is no robot type 'mine'"):
        other.run(text, world, 0)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ((("size: [60 mm, 50 mm, 100 mm]", "size: [82 mm, 81 mm, 100 mm]"),), r"\(81 mm, 82 mm|81 mm\) fits the gripper's 7\d mm"),
        (
            (("at: {position: [0.87, 0, 0.45], yaw: 180 deg}", "at: {position: [1.30, 0, 0.45], yaw: 180 deg}"),),
            r"nearest point at 1\.20 m > 0\.96 m reach of arm 'fr3' with gripper",
        ),
    ],
)  # fmt: skip
def test_what_the_seven_axis_arm_cannot_do_is_refused_with_numbers(
    changes: tuple[tuple[str, str], ...], said: str, run: Callable[..., Any], tmp_path: Path
) -> None:
    once = (LINE.replace("ur5e", "fr3"), LINE.replace("ur5e", "fr3") + ONCE)
    scenario = variant(tmp_path, "fetch_from_hanger", "fr3", *changes, once)
    done = run("resolve", scenario, "--out", tmp_path / "run", "--no-report")
    assert done.code == 1, done.err
    assert re.search(said, done.err), done.err


def test_every_robot_is_in_the_reference() -> None:
    page = (SCENARIOS.parent / "docs" / "reference" / "robots.md").read_text()
    rows = dict(re.findall(r"^\| `(\w+)` \|.*\| `(\w+)`", page, re.MULTILINE))
    assert rows == {r.type: r.backend for r in Knowledge(Registry()).robots.values()}

"""The main job, as a user runs it, and its negative controls: each fails, for the right reason."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from functools import partial
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from helpers.as_a_user import changed, cramlite

ROBOT = "robot: {type: ur5e}"
HOOK = "at: {position: [0.87, 0, 0.45], yaw: 180 deg}\n"
SCENARIO = Path(__file__).parents[2] / "scenarios" / "fetch_from_hanger.yaml"
variant = partial(changed, SCENARIO)


def refusals(run: Path, task: str = "") -> list[str]:
    """What was refused, in candidates that come to a task."""
    entries = json.loads((run / "trace.json").read_text())["entries"]
    meant = {e["candidate"] for e in entries if task in e["designator"]}
    return [
        f"{e['designator']}: {e['text']}: {e['reason']}"
        for e in entries
        if e["candidate"] in meant and e["outcome"] in ("refused", "impossible", "failed")
    ]


@pytest.fixture(scope="module")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, CompletedProcess[str]]:
    """The run directory of the shipped scenario, and what the command said."""
    folder = tmp_path_factory.mktemp("shipped") / "run"
    return folder, cramlite("resolve", "fetch_from_hanger", "--out", folder, "--no-report", "--json")


def test_the_shipped_demonstration_becomes_a_proven_program(shipped: tuple[Path, CompletedProcess[str]]) -> None:
    run, done = shipped
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["objects"]["object_1"] == "coffee"
    findings = {f["validator"]: f for f in summary["findings"]}
    assert all(f["passed"] for f in summary["findings"])
    assert {
        "execution",
        "bystanders",
        "collision",
        "commanded_force",
        "force_peak",
        "grasp_slip",
        "joint_limits",
        "joint_speeds",
        "end_state",
        "task_rules",
    } <= set(findings)
    assert 1.0 < findings["force_peak"]["value"] < 60.0
    text = (run / "program.script").read_text()
    assert text.startswith("def ") or "\ndef " in text
    assert "force_mode(" in text
    # the substitution is named, and so is why each other thing was refused
    said = "\n".join(refusals(run))
    for thing in ("tin", "basket", "hook", "floor"):
        assert re.search(rf"object_1: {thing}: .* without the vrps:Hole", said), thing
    again = cramlite("interpret", run / "episode")
    assert again.returncode == 0, again.stderr
    assert "artm:ExtractHoleFromPeg(Locatum=coffee" in again.stdout


@pytest.mark.heavy
@pytest.mark.parametrize("seed", range(2001, 2006))
def test_five_seeds_of_person_and_world(seed: int, tmp_path: Path) -> None:
    """The quick form of tests/benchmarks/fetch_from_hanger.py; these seeds were chosen before the first run."""
    demonstration = tmp_path / "demonstration"
    recorded = cramlite("record", "fetch_from_hanger", "--seed", str(seed), "--out", demonstration)
    assert recorded.returncode == 0, recorded.stderr
    run = cramlite(
        "resolve", "fetch_from_hanger", "--seed", str(seed), "--demonstration", demonstration, "--out", tmp_path / "run", "--no-report",
    )  # fmt: skip
    assert run.returncode == 0, run.stderr


LAZY_GRIPPER = """
from msgspec.structs import replace
from cramlite.plugin import hookimpl
from cramlite_plugins.motions import gripping

@hookimpl
def resolve_motion(motion, belief, context):
    answers = gripping.resolve_motion(motion, belief, context)
    if motion.kind != "gripper" or motion.parameters["to"] != "closed":
        return answers
    stuck = lambda step: replace(step, opening=0.08, expect="any")
    return [replace(a, value=tuple(stuck(s) for s in a.value)) for a in answers]
"""


@pytest.mark.heavy
def test_a_gripper_that_never_closes_is_seen(tmp_path: Path) -> None:
    plugin = tmp_path / "lazy_gripper.py"
    plugin.write_text(LAZY_GRIPPER)
    once = "\nbudget: {proofs: 1, sequences: 1}\nblock: [gripping]"
    scenario = variant(tmp_path, (ROBOT, ROBOT + once))
    run = cramlite("resolve", scenario, "--plugin", plugin, "--out", tmp_path / "run", "--no-report", "--verbose")
    assert run.returncode == 1, run.stderr
    assert "after 1.Grasping 'grasps(Gripper, Patient)' does not hold" in run.stderr


@pytest.mark.heavy
def test_a_peg_that_jams_stops_the_program(tmp_path: Path) -> None:
    """Peg and product as rough as saw blades: friction needs both, 30 on the peg alone is 1.2 and lets go."""
    jam = ((HOOK, HOOK + "    with: {friction: 30}\n"), ("mass: 300 g}", "mass: 300 g, friction: 30}"))
    scenario = variant(tmp_path, *jam, (ROBOT, ROBOT + "\nbudget: {proofs: 2, sequences: 1}"))
    run = cramlite("resolve", scenario, "--out", tmp_path / "run", "--no-report")
    assert run.returncode == 1, run.stderr
    assert re.search(r"ExtractHoleFromPeg/pull: (force [\d.]+ N > 25|only [-\d.e]+ m out within|not done within)", run.stderr)


def test_a_basket_out_of_reach_is_refused_without_trying_grasps(tmp_path: Path) -> None:
    scenario = variant(tmp_path, ("at: {position: [0.30, -0.45, 0]}", "at: {position: [0.30, -1.60, 0]}"))
    run = cramlite("resolve", scenario, "--out", tmp_path / "run", "--no-report")
    assert run.returncode == 1, run.stderr
    assert re.search(r"nearest point at [\d.]+ m > [\d.]+ m reach of arm 'ur5e'", run.stderr)
    assert not any("grasp(" in r for r in refusals(tmp_path / "run", "Ungrasping"))
    assert len(refusals(tmp_path / "run")) < 200, "candidates that hold on are given up without trying every grasp"


@pytest.mark.heavy
def test_a_grasp_from_the_side_of_the_wall_is_refused(tmp_path: Path) -> None:
    """Nearer to the robot the wrist reaches behind the product, where the wall is."""
    near = (HOOK, HOOK.replace("0.87", "0.60"))
    only = tmp_path / "from_the_wall.py"
    only.write_text(
        "from msgspec.structs import replace\n"
        "from cramlite.plugin import hookimpl\n"
        "from cramlite_plugins.locations.kinds import KINDS\n\n"
        "@hookimpl\n"
        "def location_kinds():\n"
        "    return [replace(KINDS['grasp'], ground=from_the_wall)]\n\n"
        "def from_the_wall(location, belief, context):\n"
        "    answers = KINDS['grasp'].ground(location, belief, context)\n"
        "    return [a for a in answers if 'from +y' in str(a.value) + getattr(a, 'key', '')]\n"
    )
    scenario = variant(tmp_path, near, (ROBOT, ROBOT + "\nprefer: [from_the_wall]\nbudget: {sequences: 1}"))
    run = cramlite("resolve", scenario, "--plugin", only, "--out", tmp_path / "run", "--no-report")
    assert run.returncode == 1, run.stderr
    said = [r for r in refusals(tmp_path / "run") if "from +y" in r]
    assert said
    assert any("inside 'hook'" in r or "from 'hook'" in r for r in said), said


def test_an_arm_that_there_is_not(tmp_path: Path) -> None:
    """Those that there are: test_robots.py."""
    run = cramlite("resolve", variant(tmp_path, (ROBOT, "robot: {type: ur6}")), "--out", tmp_path / "run", "--no-report")
    assert run.returncode == 2, run.stderr
    assert "ur6" in run.stderr


@pytest.mark.heavy
def test_the_program_sees_only_text_and_world(shipped: tuple[Path, CompletedProcess[str]]) -> None:
    """Another process that is given the program and the world file, nothing else, gets the same end."""
    run, _ = shipped
    command = [sys.executable, "-m", "cramlite", "execute", run / "program.script", "--world", run / "world.json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "finished" in done.stdout

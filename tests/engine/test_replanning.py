"""``cramlite execute --replan``: the box was moved between planning and execution; looking again helps, where it can."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from conftest import ROOT, Run

from cramlite import Engine, read_scenario
from cramlite.cli.main import main
from cramlite.engine.late_poses import worlds_at_tolerance
from cramlite.engine.proof.proof import conflict_of
from cramlite.engine.recovery.replanning import way_back
from cramlite.model import Action, Pose, Verdict, World, read_program
from cramlite.planning.refutation import InTask, as_they_are
from cramlite.plugin import Finding

SCENARIO = ROOT / "scenarios" / "late_pose_camera.yaml"
Move = Callable[..., Path]


def resolved(scenario: Path, out: Path) -> Path:
    assert main(["resolve", str(scenario), "--out", str(out), "--no-report", "--json"]) == 0
    return out


@pytest.fixture(scope="module")
def parametric(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run directory: the program asks where the box is before it moves."""
    return resolved(SCENARIO, tmp_path_factory.mktemp("parametric") / "run")


@pytest.fixture(scope="module")
def snapshot(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The same without late poses: the program believes that the box is where it was. Run directory and scenario."""
    folder = tmp_path_factory.mktemp("snapshot")
    head, _, things = SCENARIO.read_text().partition("late:\n")
    scenario = folder / "scenario.yaml"
    scenario.write_text(head + things.partition("\n")[2])
    return resolved(scenario, folder / "run"), scenario


def moved(run: Path, to: Path, thing: str, *way: float, yaw: float = 0.0) -> Path:
    """The real world of a run with a thing displaced [m, rad]."""
    world = msgspec.json.decode((run / "execution" / "world.json").read_bytes(), type=World)
    pose = world.thing(thing).pose
    place = tuple(a + b for a, b in zip(pose.position, way, strict=True))
    turn = Pose((0, 0, 0), (math.cos(yaw / 2), 0, 0, math.sin(yaw / 2))) * Pose((0, 0, 0), pose.quaternion)
    to.write_bytes(msgspec.json.encode(world.moved({thing: Pose(place, turn.quaternion)})))  # type: ignore[arg-type]
    return to


@pytest.mark.heavy
def test_where_the_box_was_moved_too_far_the_program_stops_and_says_why(parametric: Path, tmp_path: Path, run: Run) -> None:
    world = moved(parametric, tmp_path / "w.json", "teabox_1", 0.06, -0.05, 0.0, yaw=0.4)
    done = run("execute", parametric / "program.script", "--world", world)
    assert done.code == 1
    assert "teabox_1 is 0.07" in done.err and "m from where it was planned, more than 0.016 m" in done.err


@pytest.mark.heavy
def test_looking_again_and_resolving_the_rest_succeeds(parametric: Path, tmp_path: Path, run: Run) -> None:
    world = moved(parametric, tmp_path / "w.json", "teabox_1", 0.06, -0.05, 0.0, yaw=0.4)
    out = tmp_path / "out"
    done = run("execute", parametric / "program.script", "--world", world, "--replan", SCENARIO, "--out", out, "--json")
    assert done.code == 0, done.err
    told = json.loads(done.out)
    assert told["said"][0].startswith("round 1: halted before the first step: teabox_1 is 0.07")
    assert "the camera sees teabox_1" in told["said"][1] and "left to do: Grasping -> PickingUp" in told["said"][1]
    assert told["said"][2].startswith("round 2: finished")
    first, second = (r["poses"]["teabox_1"] for r in told["rounds"])
    assert first[2] < 0.1 and second[2] > 0.2 and second[1] < -0.2, "on the shelf in the end"
    header = (out / "round_2" / "program.script").read_text().partition("# ---- functions")[0]
    assert "teabox_1: p[0.5" in header and "camera: tea_box by expert" in header, "the pose is perception's"


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("way", "said"),
    [((0.0, 5.0, 0.0), "the camera sees nothing that it knows"), ((0.6, 0.0, 0.0), "m > 1.01 m reach of arm 'ur5e'")],
)
def test_a_box_that_is_gone_or_out_of_reach_is_given_up(
    way: tuple[float, ...], said: str, parametric: Path, tmp_path: Path, run: Run
) -> None:
    world = moved(parametric, tmp_path / "w.json", "teabox_1", *way)
    done = run("execute", parametric / "program.script", "--world", world, "--replan", SCENARIO)
    assert done.code == 1
    assert "round 1: halted before the first step" in done.out
    assert "Round 2: the remaining tasks cannot be done" in done.err and said in done.out + done.err
    assert len(done.err.partition("cannot be done.\n")[2].splitlines()) <= 3, done.err


def test_rounds_are_bounded(parametric: Path, tmp_path: Path, run: Run) -> None:
    world = moved(parametric, tmp_path / "w.json", "teabox_1", 0.06, 0.0, 0.0)
    done = run("execute", parametric / "program.script", "--world", world, "--replan", SCENARIO, "--rounds", 1)
    assert done.code == 1 and "Given up after 1 rounds. The last one: halted before the first step" in done.err


@pytest.mark.heavy
def test_a_program_that_grasped_nothing_goes_back_the_way_it_came_and_on_with_a_closed_hand(
    snapshot: tuple[Path, Path], tmp_path: Path, run: Run
) -> None:
    directory, scenario = snapshot
    world = moved(directory, tmp_path / "w.json", "teabox_1", 0.1, 0.12, 0.0)
    out = tmp_path / "out"
    done = run("execute", directory / "program.script", "--world", world, "--replan", scenario, "--out", out)
    assert done.code == 0, done.err
    assert "round 1: halted in 1.Grasping/close: 1.Grasping/close: no object between the fingers" in done.out
    assert "round 2: the arm went back the way it came" in done.out
    start = msgspec.json.decode((out / "round_2" / "world.json").read_bytes(), type=World).robots[0]
    assert start.opening is not None and start.opening < 0.01, "the hand is closed"
    typed = read_program((directory / "program.json").read_text()).program
    assert max(abs(a - b) for a, b in zip(start.joints, typed.start, strict=True)) < 0.05


@pytest.mark.heavy
def test_with_something_in_the_hand_it_says_that_it_does_not_go_on(snapshot: tuple[Path, Path], tmp_path: Path, run: Run) -> None:
    """The shelf is not where the map has it: the program ends over it."""
    directory, scenario = snapshot
    world = moved(directory, tmp_path / "w.json", "shelf", 0.0, 0.0, -0.1)
    done = run("execute", directory / "program.script", "--world", world, "--replan", scenario)
    assert done.code == 1
    assert "round 1: halted in 3.Placing" in done.out and "with something in the hand" in done.err


def test_what_cannot_be_planned_anew_is_refused(parametric: Path, tmp_path: Path, run: Run) -> None:
    world, program = parametric / "world.json", parametric / "program.script"
    known = run("execute", program, "--world", world, "--replan", "late_pose")
    assert known.code == 2 and "is no plan of" in known.err
    none = run("execute", program, "--world", world, "--replan", SCENARIO, "--rounds", 0)
    assert none.code == 2 and "programs that may run is at least 1" in none.err
    other = run("execute", program, "--world", world, "--replan", "fetch_from_hanger_camera")
    assert other.code == 2 and "is no plan of" in other.err
    alone = tmp_path / "alone.script"
    shutil.copy(program, alone)
    assert "program.json' cannot be read" in run("execute", alone, "--world", world, "--replan", SCENARIO).err
    copy = tmp_path / "copy"
    shutil.copytree(parametric, copy)
    (copy / "program.script").write_text(program.read_text().replace("v=0.05", "v=0.04"))
    changed = run("execute", copy / "program.script", "--world", world, "--replan", SCENARIO)
    assert changed.code == 2 and "not the one of the program.json beside it" in changed.err


def test_the_tolerance_is_around_what_was_planned(parametric: Path) -> None:
    """The declared edges are where the program was planned for, whatever is real: else it would stop at its own edge."""
    program = read_program((parametric / "program.json").read_text()).program
    believed = msgspec.json.decode((parametric / "world.json").read_bytes(), type=World)
    real = msgspec.json.decode((parametric / "execution" / "world.json").read_bytes(), type=World)
    late = program.late[0]
    assert late.pose.distance(real.thing(late.thing).pose)[0] > 1e-4, "perception errs a little"
    found = [world.thing(late.thing).pose for _, world in worlds_at_tolerance(believed, program)]
    assert len(found) == 4
    for pose in found:
        way = math.dist(pose.position[:2], late.pose.position[:2])
        assert way == pytest.approx(late.tolerance[0], abs=1e-9)
        assert pose.position[2] == pytest.approx(late.pose.position[2]), "it stands where it was seen to stand"
        assert pose.distance(late.pose)[1] == pytest.approx(late.tolerance[1], abs=1e-6)


@pytest.mark.heavy
def test_a_setting_of_now_shows_the_camera_the_world_as_it_is() -> None:
    scenario, engine = read_scenario(SCENARIO), Engine()
    before = engine.setting(scenario)
    assert before.real is not None and before.look is not None
    pose = before.real.thing("teabox_1").pose
    now = before.real.moved({"teabox_1": Pose((0.6, 0.1, pose.position[2]), pose.quaternion)})
    after = engine.setting(scenario, now=now)
    assert math.dist(after.world.thing("teabox_1").pose.position, (0.6, 0.1, pose.position[2])) < 0.01
    assert math.dist(before.world.thing("teabox_1").pose.position, pose.position) < 0.01


def test_the_way_back_is_the_way_there() -> None:
    """Around two corners, with samples at rest; where the arm has not moved there is none."""
    corners = np.array([[0.0, 0.0], [1.0, 0.2], [1.2, -1.0]])
    there = np.concatenate([np.linspace(a, b, 50) for a, b in pairwise(corners)] + [np.repeat(corners[-1:], 20, axis=0)])
    path = np.array(way_back(there))
    assert len(path) <= 4 and np.abs(path[-1] - corners[0]).max() < 0.02
    whole = np.concatenate([np.linspace(a, b, 50) for a, b in pairwise([there[-1], *path])])
    assert max(np.abs(there - p).max(axis=1).min() for p in whole) < 0.03
    assert way_back(np.repeat(corners[:1], 9, axis=0) + 1e-3) == ()


def test_what_fails_before_the_plan_begins_is_no_choice_of_the_plan() -> None:
    """A looking motion that meets something: it was resolved before, and nothing in the plan changes it."""
    verdict = Verdict((Finding("collision", False, "hit", origin="0.LookingFor_1/look"),))
    actions = tuple(Action(name, "soma:Task") for name in ("0.LookingFor_1", "0.LookingFor_2", "1.Grasping"))
    choices = (("1.Grasping", "0"), ("grasp", "3"), ("1.Grasping/approach", "0"))
    state = SimpleNamespace(choices=choices, actions=actions, motions=frozenset({"1.Grasping/approach"}))
    assert conflict_of(verdict, state) == frozenset()  # type: ignore[arg-type]
    later = Verdict((Finding("collision", False, "hit", origin="1.Grasping/approach"),))
    assert conflict_of(later, state) == {"1.Grasping", "grasp", InTask(1), *as_they_are(None)}  # type: ignore[arg-type]
    named = Verdict((Finding("collision", False, "hit", origin="1.Grasping/approach", blocking=("cup",)),))
    assert conflict_of(named, state) == {"1.Grasping", "grasp", InTask(1), *as_they_are(("cup",))}  # type: ignore[arg-type]

"""``cramlite execute --replan`` where poses are readings: it notices, understands and goes on, and is silent where all is well."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from cramlite import Engine, read_scenario
from cramlite.base.errors import NoSolution
from cramlite.cli.main import main
from cramlite.engine.recovery.going_on import GoingOn
from cramlite.engine.recovery.replanning import Attempt
from cramlite.engine.recovery.time_line import read_time_line
from cramlite.model import Code, Deviation, Plan, Pose, Program
from cramlite.scenario.faults import faulty, read_fault_text

GOAL = """scenario: block_onto_shelf
goal: [block on shelf]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: block, model: block, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
  - {name: can, model: block, at: {position: [0.35, 0.35, 51 mm]}, with: {size: [40 mm, 40 mm, 100 mm]}}
  - {name: shelf, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}
"""
TASKS = """tasks:
  - {task: Grasping, Patient: block}
  - {task: PickingUp, Locatum: block, Relatum: floor}
  - {task: Placing, Locatum: block, Relatum: shelf}
"""


@pytest.fixture(scope="module")
def of_goal(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return resolved(tmp_path_factory.mktemp("goal"), GOAL)


def resolved(folder: Path, text: str) -> tuple[Path, Path]:
    scenario = folder / "scenario.yaml"
    scenario.write_text(text)
    assert main(["resolve", str(scenario), "--out", str(folder / "run"), "--no-report", "--json"]) == 0
    return folder / "run" / "program.script", scenario


def gone_on(run: Run, place: tuple[Path, Path], *faults: str, out: Path | None = None) -> tuple[int, dict[str, object]]:
    program, scenario = place
    said = [w for f in faults for w in ("--fault", f)] + (["--out", str(out)] if out else [])
    done = run("execute", program, "--world", scenario, "--replan", scenario, "--rounds", 6, "--json", *said)
    return done.code, json.loads(done.out[done.out.index('{\n "said"') :])


def kinds(told: dict[str, object]) -> list[str]:
    return [m["notice"]["kind"] for m in told["time_line"] if m["notice"]]  # type: ignore[attr-defined, index]


def at(told: dict[str, object], thing: str) -> list[float]:
    return told["rounds"][-1]["poses"][thing][:3]  # type: ignore[index]


@pytest.mark.heavy
def test_where_nothing_goes_wrong_nothing_is_noticed(of_goal: tuple[Path, Path], run: Run) -> None:
    code, told = gone_on(run, of_goal)
    assert code == 0 and told["executions"] == 1 and kinds(told) == []


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("fault", "kind", "same"),
    [
        ("moved: block, by: [0, 60 mm, 0], near: block, within: 0.18 m", "ObjectMoved", False),
        ("grip_lost: 0.5 s, line: PickingUp/lift, after: 0.8 s", "GraspLost", False),
        ("killed: true, line: PuttingDown/transfer, after: 0.8 s", "ProgramKilled", True),
        ("readings: lost, lasts: 1 s, line: PuttingDown/transfer", "ReadingsLost", True),
        ("added: can, by: [120 mm, -400 mm, 0], line: PuttingDown/transfer, after: 0.5 s", "ObjectAppeared", True),
        ("added: can, by: [100 mm, -700 mm, 161 mm], line: PuttingDown/transfer, after: 0.2 s", "ObjectAppeared", False),
    ],
)
def test_it_goes_on_with_an_empty_hand_and_with_a_full_one(
    fault: str, kind: str, same: bool, of_goal: tuple[Path, Path], run: Run, tmp_path: Path
) -> None:
    code, told = gone_on(run, of_goal, fault, out=tmp_path / "out")
    assert code == 0 and kinds(told) == [kind], told["said"]
    assert ("the rest of the same program" in str(told["said"])) is same, told["said"]
    assert np.allclose(at(told, "block"), (0.45, -0.35, 0.20), atol=0.12), "on the shelf"
    fault_at, notice_at = (next(m["time"] for m in told["time_line"] if m["what"] == w) for w in ("fault", "notice"))  # type: ignore[attr-defined]
    assert 0 <= notice_at - fault_at < 0.3
    shown = run("explain", tmp_path / "out", "--failures").out
    assert all(w in shown for w in ("fault", "notice", "decision", "resumption", "end", kind))
    first, second = ({e.type: e for e in Engine().read_episode(tmp_path / "out" / f"round_{k}" / "episode").events} for k in (1, 2))
    assert {"cram:Fault", f"cram:{kind}", "cram:Decision"} <= first.keys() and "cram:Resumption" not in first
    assert "cram:Resumption" in second and not {"cram:Fault", "cram:Decision"} & second.keys()
    assert first["cram:Fault"].start <= first[f"cram:{kind}"].start < first["cram:Decision"].start
    if "block" in fault:
        assert first["cram:Fault"].roles == first[f"cram:{kind}"].roles == {"object": "block"}
    page = (tmp_path / "out" / "time_line.html").read_text()
    pictures = re.findall(r'"(data:image/webp[^"]*)"', page)
    assert page.count("<figure>") == len(pictures) == len(told["time_line"]) and len(set(pictures)) > 2  # type: ignore[arg-type]


@pytest.mark.heavy
def test_another_goal_is_followed_when_what_is_held_has_been_set_down(of_goal: tuple[Path, Path], run: Run) -> None:
    code, told = gone_on(run, of_goal, "goal: [can on shelf], line: PuttingDown/transfer, after: 0.3 s")
    assert code == 0 and kinds(told) == ["GoalChanged"]
    assert at(told, "can")[2] > 0.15 and at(told, "block")[2] < 0.1


@pytest.mark.heavy
def test_a_cancelled_task_ends_at_rest(of_goal: tuple[Path, Path], run: Run) -> None:
    code, told = gone_on(run, of_goal, "cancelled: true, line: Grasping/transfer")
    assert code == 0 and kinds(told) == ["Cancelled"] and at(told, "block")[2] < 0.06


@pytest.mark.heavy
def test_what_cannot_be_mended_is_told(of_goal: tuple[Path, Path], run: Run) -> None:
    program, scenario = of_goal
    done = run("execute", program, "--world", scenario, "--replan", scenario, "--fault", "missing: block, line: Grasping/transfer")
    assert done.code == 1 and "ObjectMissing" in done.err and "To do: put the thing back, or ask for another goal" in done.err
    done = run("execute", program, "--world", scenario, "--replan", scenario, "--rounds", 6, "--fault", "closes_short: 60 mm")
    assert done.code == 1 and "was noticed 3 times" in done.err


TOO_FAST = "def p():\n  movej([0, -1.57, 0, 0, 0, 0], a=40, v=6)\nend\n"
WAITING = "def p():\n  sleep(3)\nend\n"


@pytest.mark.heavy
@pytest.mark.parametrize(("text", "faults", "person"), [(TOO_FAST, "protective_stop: 9 s", True), (WAITING, "protective_stop: 1 s", False)])
def test_a_stop_of_the_robot_itself_is_for_a_person(text: str, faults: str, person: bool, tmp_path: Path) -> None:
    (tmp_path / "scenario.yaml").write_text(GOAL)
    scenario, said = read_scenario(tmp_path / "scenario.yaml"), list[str]()
    going = GoingOn(scenario, Engine(), 0, said.append)
    world = faulty(going.setting.world, [read_fault_text(faults)])
    program = Program("p", "arm", "ur5e", Pose((0, 0, 0)), world.robots[0].joints, (), ())
    first = Attempt(Plan("p", (), ()), program, Code("urscript", text, {}, ".script"), world)
    stretches = going.stretches(first, 2)
    if not person:
        assert next(stretches).decision.startswith("goes on from here"), said
        return
    with pytest.raises(NoSolution, match=r"ProtectiveStop.* is acknowledged by a person.*To do: look why the controller stopped"):
        list(stretches)


@pytest.mark.heavy
def test_a_list_of_tasks_goes_on_from_the_task_under_way(tmp_path: Path, run: Run) -> None:
    place = resolved(tmp_path, GOAL.replace("goal: [block on shelf]\n", TASKS))
    code, told = gone_on(run, place, "added: can, by: [100 mm, -700 mm, 161 mm], line: PuttingDown/transfer, after: 0.2 s")
    assert code == 0 and "with 'block' in the hand: Placing" in told["said"][1]  # type: ignore[index]
    code, told = gone_on(run, place, "moved: block, by: [0, 60 mm, 0], near: block, within: 0.18 m")
    assert code == 0 and "goes on from here: Grasping -> PickingUp -> Placing" in told["said"][1]  # type: ignore[index]


def test_deviations_are_classes_of_the_ontology() -> None:
    taxonomy = Engine().knowledge.taxonomy
    assert all(taxonomy.is_a(f"cram:{d}", "cram:Deviation") for d in Deviation)


@pytest.mark.heavy
def test_what_was_recorded_survives_a_kill_and_a_second_start_says_why_not(of_goal: tuple[Path, Path], tmp_path: Path) -> None:
    program, scenario = of_goal
    out, fault = tmp_path / "out", "moved: block, by: [0, 60 mm, 0], near: block, within: 0.18 m"
    command = [sys.executable, "-m", "cramlite", "execute", program, "--world", scenario, "--replan", scenario, "--fault", fault]
    command += ["--out", out]
    running = subprocess.Popen(command, stdout=subprocess.PIPE)
    while not (out / "time_line.json").is_file() and running.poll() is None:
        time.sleep(0.01)
    running.kill()
    running.wait()
    assert [m.what for m in read_time_line(out)][:3] == ["fault", "notice", "decision"]
    assert (out / "round_1" / "rollout.npz").is_file()
    again = subprocess.run(command, capture_output=True, text=True, check=False)
    assert again.returncode == 2 and "is not an empty folder; nothing was run" in again.stderr

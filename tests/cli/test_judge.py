"""``cramlite judge`` and ``cramlite execute --plan``: any program text is judged, also one that somebody has edited."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Run

from cramlite.cli.main import main


@pytest.fixture(scope="module")
def shelf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run directory of a block that was placed on a shelf, by tasks."""
    folder = tmp_path_factory.mktemp("judge") / "shelf"
    assert main(["resolve", "place_on_shelf", "--no-report", "--out", str(folder)]) == 0
    return folder


@pytest.fixture
def edited(shelf: Path, tmp_path: Path) -> Callable[..., Path]:
    """The run's program with text replaced, or without the lines from one with some words up to one with others."""

    def write(*changes: tuple[str, str], without: tuple[str, str] | None = None) -> Path:
        text = (shelf / "program.script").read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        if without is not None:
            lines = text.splitlines()
            first = next(k for k, line in enumerate(lines) if without[0] in line)
            last = next(k for k, line in enumerate(lines) if without[1] in line and k > first)
            text = "\n".join([*lines[:first], *lines[last:], ""])
        path = tmp_path / "edited.script"
        path.write_text(text)
        return path

    return write


def test_the_text_of_a_run_passes_with_every_judge_that_the_run_had(run: Run, shelf: Path) -> None:
    done = run("judge", shelf / "program.script", "--world", shelf, "--plan", shelf / "plan.json", "--json")
    assert done.code == 0, done.err
    said = json.loads(done.out)
    first = json.loads((shelf / "verdict.json").read_text())["findings"]
    assert said["passed"] and {f["validator"] for f in said["findings"]} == {f["validator"] for f in first}
    assert [f["origin"] for f in said["findings"]] == [f["origin"] for f in first]
    typed = run("judge", shelf / "program.json", "--world", shelf, "--plan", shelf, "--json")
    asked = {f["validator"] for f in json.loads(typed.out)["findings"]}  # another text than the proven one: safeguards are compared
    assert typed.code == 0 and asked == {"safeguards", *(f["validator"] for f in first)}


@pytest.mark.heavy
def test_a_text_that_was_edited_and_still_works_passes(run: Run, shelf: Path, edited: Callable[..., Path]) -> None:
    mine = ("# 3.Placing/Retracting", "sleep(0.3)  # mine\n  # 3.Placing/Retracting")
    text = edited(mine, ('textmsg("cramlite: finished")', 'textmsg("done")'))
    done = run("judge", text, "--world", shelf, "--plan", shelf)
    assert done.code == 0, done.err
    assert "ok  task_rules: 4.ParkingArms" in done.out and "not judged: joint_limits, program_safety" in done.out


@pytest.mark.heavy
def test_a_comment_that_moved_changes_no_finding(run: Run, shelf: Path, tmp_path: Path) -> None:
    lines = (shelf / "program.script").read_text().splitlines()
    k = next(k for k, line in enumerate(lines) if "# 3.Placing/Releasing/payload" in line)
    (tmp_path / "moved.script").write_text("\n".join([*lines[:k], *lines[k + 1 : k + 4], lines[k], *lines[k + 4 :], ""]))
    for judged, of in ((tmp_path / "moved.script", "moved"), (shelf / "program.script", "as it was")):
        done = run("judge", judged, "--world", shelf, "--plan", shelf)
        assert done.code == 0 and "nothing says which task" not in done.out, of


@pytest.mark.heavy
def test_a_typed_program_on_one_line_is_judged_a_step_a_line(run: Run, shelf: Path, tmp_path: Path) -> None:
    flat = tmp_path / "flat.json"
    flat.write_text(json.dumps(json.loads((shelf / "program.json").read_text())))
    done = run("judge", flat, "--world", shelf, "--plan", shelf, "--json")
    assert done.code == 0, done.err
    said = json.loads(done.out)
    usual = json.loads(run("judge", shelf / "program.json", "--world", shelf, "--plan", shelf, "--json").out)
    assert said["findings"] == usual["findings"] and usual["remarks"] == []
    (remark,) = said["remarks"]
    assert remark.startswith("steps share a line of the text") and "(line 1: " in remark
    lines = (shelf / "program.json").read_text().splitlines()
    first, last = (int(n) for n in remark.split("(line 1: ")[1].rstrip(")").split(" to "))
    assert [line.strip().startswith('{"step"') for line in lines[first - 1 : last]] == [True] * 15


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("first", "last", "said"),
    [
        ("---- 4.ParkingArms", "kill watchdog_thread", "4.ParkingArms has no line of code"),
        ("# 4.ParkingArms/park", "kill watchdog_thread", "4.ParkingArms has no line of code"),  # its title is left
        ("---- 1.Grasping", "---- 2.PickingUp", "1.Grasping has no line of code"),
    ],
)
def test_a_text_without_the_code_of_a_task_is_refused(
    run: Run, shelf: Path, edited: Callable[..., Path], first: str, last: str, said: str
) -> None:
    done = run("judge", edited(without=(first, last)), "--world", shelf, "--plan", shelf)
    assert done.code == 1 and said in done.err and "Refused:" in done.out


@pytest.mark.heavy
def test_execute_fails_where_the_goal_was_not_reached(run: Run, shelf: Path, edited: Callable[..., Path]) -> None:
    stays = edited(without=("---- 2.PickingUp", "---- 3.Placing"))
    held = edited(without=("---- 3.Placing", "---- 4.ParkingArms"))
    program = shelf / "program.script"
    assert run("execute", held, "--world", shelf).code == 0  # it came to its end, and nobody asked for more
    missed = run("execute", held, "--world", shelf, "--goal", "block on shelf")
    assert missed.code == 1 and "'block on shelf' is not reached" in missed.err
    assert run("execute", held, "--world", shelf, "--goal", "block held").code == 0
    both = run("execute", program, "--world", shelf, "--goal", "block on shelf", "--goal", "block off floor", "--json")
    assert both.code == 0 and [f["passed"] for f in json.loads(both.out)["verdict"]["findings"]] == [True, True]
    assert run("execute", program, "--world", shelf, "--goal", "block on shelf", "--goal", "block on floor").code == 1
    assert run("execute", stays, "--world", shelf, "--plan", shelf).code == 1


@pytest.mark.heavy
def test_execute_fails_where_what_was_to_be_taken_still_hangs_on_its_hook(run: Run, tmp_path: Path) -> None:
    """The fingers never close: every motion is made, with nothing between them."""
    out, stays = tmp_path / "run", tmp_path / "stays.script"
    assert run("resolve", "take_off_hanger_tasks", "--no-report", "--out", out).code == 0
    lines = (out / "program.script").read_text().splitlines()
    stays.write_text("\n".join("  sleep(0.1)" if line.lstrip().startswith("move_gripper(255") else line for line in lines))
    assert run("execute", out / "program.script", "--world", out, "--goal", "tea in basket", "--goal", "tea off hook").code == 0
    missed = run("execute", stays, "--world", out, "--goal", "tea off hook")
    assert missed.code == 1 and "'tea off hook' is not reached" in missed.err
    assert run("execute", stays, "--world", out, "--plan", out).code == 1


def test_a_text_of_ones_own_is_judged_by_its_goal_alone(run: Run, shelf: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.script"
    own.write_text('def p():\n  textmsg("nothing to do")\n  sleep(1.0)\nend\np()\n')
    done = run("judge", own, "--world", shelf, "--goal", "block on floor", "--json")
    assert done.code == 0 and [f["validator"] for f in json.loads(done.out)["findings"]] == ["goal"]
    assert run("judge", own, "--world", shelf, "--goal", "block on shelf").code == 1
    own.write_text('def p():\n  textmsg("cramlite abort: no")\n  halt\nend\np()\n')
    stopped = run("judge", own, "--world", shelf, "--goal", "block on floor")
    assert stopped.code == 1 and "ended by halted" in stopped.err


@pytest.mark.heavy
def test_a_scenario_says_what_a_text_is_for(run: Run, shelf: Path, edited: Callable[..., Path], tmp_path: Path) -> None:
    done = run("judge", shelf / "program.script", "--world", "place_on_shelf", "--plan", "place_on_shelf")
    assert done.code == 0 and "no run directory says where" in done.out
    assert run("judge", edited(without=("---- 3.Placing", "---- 4.Park")), "--world", shelf, "--plan", "place_on_shelf").code == 1
    unnamed = tmp_path / "own.script"
    unnamed.write_text("def p():\n  sleep(1.0)\nend\np()\n")
    lost = run("judge", unnamed, "--world", shelf, "--plan", "place_on_shelf")
    assert lost.code == 2 and "No line of the text leads to a task" in lost.err and "--goal" in lost.err


def test_what_cannot_be_judged_is_explained(run: Run, shelf: Path, tmp_path: Path) -> None:
    program = shelf / "program.script"
    for words, said in (
        ((), "--goal"),
        (("--goal", "block upon shelf"), "is no goal"),
        (("--goal", "block on shelv"), "did you mean 'shelf'"),
        (("--plan", tmp_path), "does not say what its program is for"),
        (("--plan", "fetch_from_hanger"), "run directory"),
        (("--plan", "grasp_one_thing"), "only found when it is resolved"),
        (("--plan", "no_such_thing"), "no_such_thing"),
    ):
        done = run("judge", program, "--world", shelf, *words)
        assert done.code == 2 and said in done.err and "Traceback" not in done.err, (words, done.err)
    (tmp_path / "intent.json").write_text("{}")
    damaged = run("judge", program, "--world", shelf, "--plan", tmp_path)
    assert damaged.code == 2 and "is damaged" in damaged.err
    replanned = run("execute", program, "--world", shelf, "--replan", "late_pose", "--goal", "block on shelf")
    assert replanned.code == 2 and "--replan" in replanned.err


OPEN_AND_CLOSED = """scenario: both
goal:
  - drawer open
  - drawer {second}
robot: {{type: ur5e}}
things:
  - {{name: cabinet, model: cabinet, at: {{position: [0.75, 0.1, 0.35], yaw: 180 deg}}}}
  - {{name: drawer, model: drawer, at: {{position: [0.75, 0.1, 0.35], yaw: 180 deg}}, with: {{parent: cabinet}}}}
"""


@pytest.mark.parametrize("command", ["check", "resolve"])
def test_goals_that_contradict_each_other_are_refused_with_both_lines(run: Run, tmp_path: Path, command: str) -> None:
    path = tmp_path / "both.yaml"
    path.write_text(OPEN_AND_CLOSED.format(second="closed"))
    words = ("--out", tmp_path / "out") if command == "resolve" else ()
    done = run(command, path, *words)
    assert done.code == 2 and f"'drawer open' ({path}:3)" in done.err and f"'drawer closed' ({path}:4)" in done.err
    if command == "check":
        path.write_text(OPEN_AND_CLOSED.format(second="open"))
        assert run(command, path).code == 0

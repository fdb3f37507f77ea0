"""Scenes that cannot be done end with a true cause, with numbers, and with what to try, once."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from cramlite import Engine, Trace, UserError, failure_text, find_scenario, goal_answers, read_scenario, what_to_try
from cramlite.cli.main import main
from cramlite.model import Finding, Remedy, Verdict
from cramlite.planning.failure import brief_failure_text, first_objection

HEAD = """scenario: fails
{wanted}
robot: {{type: ur5e}}
budget: {{expansions: 60, sequences: 4}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [3 m, 3 m, 20 mm]}}}}
"""
RED = "  - {name: red, model: block, at: {position: [0.5, 0.1, 30 mm]}, with: {size: [40 mm, 40 mm, 50 mm]}}\n"
BLUE = "  - {name: blue, model: block, at: {position: [0.5, -0.2, 30 mm]}, with: {size: [60 mm, 60 mm, 50 mm]}}\n"
GREEN = "  - {name: green, model: block, at: {position: [0.4, 0.35, 30 mm]}, with: {size: [40 mm, 40 mm, 50 mm]}}\n"
TRAY = "  - {name: tray, model: table, at: {position: [1.4, 0, 20 mm]}, with: {size: [0.2 m, 0.2 m, 20 mm]}}\n"
PLATE = "  - {name: plate, model: table, at: {position: [0.5, -0.2, 0.15]}, with: {size: [60 mm, 60 mm, 20 mm]}}\n"
POST = "  - {name: post, model: table, at: {position: [0.5, -0.2, 0.21]}, with: {size: [50 mm, 50 mm, 100 mm]}}\n"
SHELF = """<mujoco><worldbody><body name="shelf" pos="0.6 0 0.2">
  <geom type="box" size="0.12 0.2 0.01"/><geom type="box" size="0.12 0.2 0.48" pos="0 0 0.52"/>
</body></worldbody></mujoco>"""
FAR = HEAD.format(wanted="goal: [red on blue, green on tray]") + RED + BLUE + GREEN + TRAY
REACH = "'tray' is 0.24 m out of reach of arm 'ur5e': move it at least so much nearer, or the robot ('robot: {at: ...}')"


def _with(wanted: str, *things: str) -> str:
    return HEAD.format(wanted=wanted) + "".join(things)


def _red(said: str, middle: int = 30) -> str:
    """The red block, of another size and with its middle so high [mm]."""
    return RED.replace("size: [40 mm, 40 mm, 50 mm]", said).replace("30 mm]}", f"{middle} mm]}}")


FAILING = {
    "out of reach": (FAR, REACH),
    "too heavy": (
        _with("goal: [red on blue]", _red("size: [40 mm, 40 mm, 50 mm], mass: 8"), BLUE),
        "'red' with the gripper is 3.93 kg too heavy for 'ur5e'",
    ),
    "so heavy that it slips as well": (
        _with("goal: [red on blue]", _red("size: [40 mm, 40 mm, 50 mm], mass: 650"), BLUE),
        "'red' with the gripper is 645.92 kg too heavy for 'ur5e'",
    ),
    "too wide": (
        _with("goal: [red held]", _red("size: [140 mm, 150 mm, 50 mm]")),
        "'red' is 140 mm wide, the hand grasps 81 mm at most: turn it so that its 50 mm can be taken",
    ),
    "too slippery": (
        _with("goal: [red held]", _red("size: [40 mm, 40 mm, 50 mm], mass: 3, friction: 0.05")),
        "the grip on 'red' slips: friction 0.095 between pads and thing, 0.18 is needed for 3 kg at 235 N",
    ),
    "an opening too low": (
        _with("goal: [red on shelf]\nworld: {file: shelf.xml, types: {shelf: cram:Shelf}}", _red("size: [40 mm, 40 mm, 100 mm]", 55)),
        "the opening of 'shelf' is 30 mm high, 'red' needs 120 mm",
    ),
    "no such thing": (
        _with("tasks: [{task: Grasping, Patient: bottle}]\nobjects: {bottle: {types: [soma:Bottle]}}", RED),
        "nothing in the world is a soma:Bottle for 'bottle': add one",
    ),
    "a place that is taken": (
        _with("goal: [red on plate]", RED, PLATE, POST),
        "there is no room for 'red' beside 'post' on or in 'plate': their outlines and the gap between them overlap by 16.0 cm2",
    ),
    "something in the way": (
        find_scenario("tasks/opening_blocked").read_text(),
        "handle(drawer): 'drawer' is 1.0 mm inside 'post': make at least 1 mm more room between them",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Trace]:
    @cache
    def search(text: str) -> Trace:
        folder, trace = tmp_path_factory.mktemp("fails"), Trace()
        (folder / "shelf.xml").write_text(SHELF)
        (folder / "fails.yaml").write_text(text)
        assert next(Engine().resolve(read_scenario(folder / "fails.yaml"), trace=trace), None) is None
        return trace

    return search


@pytest.mark.heavy
@pytest.mark.parametrize("name", FAILING)
def test_a_failure_says_what_is_missing_and_what_to_try(name: str, searched: Callable[[str], Trace]) -> None:
    text, said = FAILING[name]
    tries = what_to_try(searched(text).entries)
    assert any(one.startswith(said) for one in tries), tries
    assert len(tries) <= 3 and len(set(tries)) == len(tries)
    told = failure_text(searched(text), ()).splitlines()
    assert [line for line in told if line.startswith("  To try: ")] == [f"  To try: {one}." for one in tries]
    brief = brief_failure_text(searched(text), (), "run").splitlines()
    assert len(brief) == 3 and "cramlite explain run" in brief[0] and brief[2].removesuffix(".") in "\n".join(told)


def test_one_cause_is_said_once_and_nobody_is_blamed_for_what_was_not_tried(searched: Callable[[str], Trace]) -> None:
    trace = searched(FAR)
    told = failure_text(trace, ())
    assert told.count("1.25 m > 1.01 m") == 1 and "candidate 1, " in told
    answers = {a.says: a for a in goal_answers(trace)}
    assert answers["green on tray"].answer == "missed" and "1.25 m" in answers["green on tray"].reason
    assert answers["red on blue"].answer == "untried" and not answers["red on blue"].reason


def test_what_stopped_a_program_is_to_be_mended_and_equal_objections_of_tasks_are_one() -> None:
    trace = Trace()
    goal, halted = Finding("goal", False, "not reached"), Finding("execution", False, "halted at line 9", stopped=True)
    trace.add(0, "proof", "plan", "failed", "urscript", Verdict((goal, halted)).reason, kind="proof")
    assert [one.split(": ", 1)[1] for one in what_to_try(trace.entries)] == ["execution: halted at line 9"]
    for number in (1, 4):
        reason = f"task_rules: {number}.Grasping was not executed"
        trace.add(0, "proof", "plan", "failed", "urscript", reason, kind="proof")
    assert len(what_to_try(trace.entries)) == 2


def test_of_programs_it_is_told_how_many_failed_alike_and_what_their_validator_would_let() -> None:
    trace = Trace()
    for at, force in ((3.1, 4.2), (3.3, 3.1)):
        meet = f"'nut' and 'table' meet with {force} N where 2 N are permitted"
        let = Remedy("touch nut table", f"{meet}: make more room between them", force - 2)
        hit = Finding("collision", False, f"'nut' hit 'table' with {force} N at {at} s", remedy=let)
        verdict = Verdict((hit, Finding("goal", False, "not reached")))
        trace.add(0, "proof", "plan", "failed", "urscript", verdict.reason, kind="proof", remedy=verdict.remedy)
    trace.add(0, "proof", "plan", "failed", "urscript", "goal: 'nut on table' is not reached", kind="proof")
    assert what_to_try(trace.entries) == (
        "'nut' and 'table' meet with 3.1 N where 2 N are permitted: make more room between them (2 of 3 programs)",
        "remove the first objection, others may follow from it: goal: 'nut on table' is not reached",
    )


def test_refusals_that_differ_in_the_number_of_a_task_are_said_once() -> None:
    trace = Trace()
    for number in (1, 4, 7):
        name = f"{number}.Grasping"
        trace.add(0, name, "", "refused", "tasks", f"the hand of {name} is full", kind="action")
    trace.add(0, "grasp(tin)", "", "impossible", "grasps", "no face", kind="location")
    assert what_to_try(trace.entries) == ("1.Grasping: the hand of 1.Grasping is full (3 times)",)


DRAWER = """  - {name: cabinet, model: cabinet, at: {position: [0.75, 0.1, 0.35], yaw: 180 deg}}
  - {name: drawer, model: drawer, at: {position: [0.75, 0.1, 0.35], yaw: 180 deg}, with: {parent: cabinet}}
"""


def test_a_part_of_a_goal_is_not_blamed_for_tasks_between_its_own(searched: Callable[[str], Trace]) -> None:
    """The drawer is opened before the green block is taken, the red one is put into it after that."""
    things = RED, BLUE.replace("-0.2", "-0.35"), GREEN, TRAY, PLATE, DRAWER
    trace = searched(_with("goal: [green on tray, blue on plate, red in drawer]", *things))
    answers = {a.says: a for a in goal_answers(trace)}
    first, last = answers["red in drawer"].tasks or (0, 0)
    green = answers["green on tray"].tasks or (0, 0)
    assert first < green[0] <= green[1] < last
    assert answers["red in drawer"].answer == "untried" and answers["green on tray"].answer == "missed"


@pytest.mark.parametrize(
    ("goals", "one"),
    [
        (("red on blue", "blue on red"), "blue"), (("red on blue", "blue on green", "green on red"), "blue"),
        (("red on blue", "blue in red", "green held"), "blue"),
    ],
)  # fmt: skip
def test_goals_in_a_ring_contradict_each_other(goals: tuple[str, ...], one: str, tmp_path: Path) -> None:
    """At once: no task is planned."""
    path, trace = tmp_path / "ring.yaml", Trace()
    path.write_text(_with(f"goal: [{', '.join(goals)}]", RED, BLUE, GREEN))
    with pytest.raises(UserError, match=f"contradict each other: '{one}' would have to carry itself"):
        next(Engine().resolve(read_scenario(path), trace=trace))
    assert not trace.entries


@pytest.mark.heavy
def test_a_stack_is_no_ring(tmp_path: Path) -> None:
    path, trace = tmp_path / "stack.yaml", Trace()
    path.write_text(_with("goal: [red on blue, blue on green]", RED, BLUE, GREEN).replace("sequences: 4", "sequences: 1, proofs: 1"))
    next(Engine().resolve(read_scenario(path), trace=trace), None)
    assert any(e.designator == "goal part" for e in trace.entries)


@pytest.mark.heavy
def test_what_to_try_in_terminal_json_and_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "far.yaml"
    path.write_text(FAR)
    assert main(["resolve", str(path), "--twins", "0", "--out", str(tmp_path / "run")]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1] == f"  To try: {REACH}." and "Every decision: cramlite explain" in lines[-3]
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    first = page.split("</section>")[0]
    assert "What to try" in first and "0.24 m out of reach" in first
    assert first.count('src="data:image/webp') == 1 and "The scene at the start" in first
    candidates = page.count('<details class="attempt"')
    assert page.count("1.25 m &gt; 1.01 m") == candidates + 3  # of each decision; nearest miss, its candidate, and the reasons
    assert main(["resolve", str(path), "--twins", "0", "--no-report", "--json", "--out", str(tmp_path / "again")]) == 1
    assert json.loads(capsys.readouterr().out)["try"] == [REACH]


def test_causes_that_differ_in_numbers_and_their_units_only_are_told_once() -> None:
    trace = Trace()
    for candidate, far, missing in ((1, "0.01 m", 0.01), (2, "1 mm", 0.001)):
        trace.candidate = candidate
        lacks = Remedy("", f"the place is {far} out of reach: move it nearer", missing)
        trace.add(0, "2.Retracting/away", "", "refused", "reach", f"{far} too far", kind="location", remedy=lacks)
    assert what_to_try(trace.entries) == ("2.Retracting/away: the place is 1 mm out of reach: move it nearer",)


def test_of_a_program_that_failed_in_twins_it_is_said_what_failed_there() -> None:
    trace = Trace()
    reason = "twins: 2 of 4, interval .15 to .85; 5 not run: the verdict is certain; twin 2: grasp_slip: 'obj' moved 12.1 mm"
    trace.add(0, "proof", "plan", "failed", "urscript", reason, kind="proof")
    assert what_to_try(trace.entries) == (
        "remove the first objection, others may follow from it: twin 2: grasp_slip: 'obj' moved 12.1 mm",
    )


def test_of_several_objections_the_first_is_told() -> None:
    said = "grip_strength: 'tin' slipped; 246 N carry it; payload: off by 0.2 kg; task_rules: before 2 it does not hold"
    assert first_objection(said) == "grip_strength: 'tin' slipped (and 2 more)"
    assert first_objection("collision: 'tin' hit 'jug'") == "collision: 'tin' hit 'jug'"
    assert first_objection("too high; too wide") == "too high; too wide"


def test_a_refusal_has_three_lines_and_the_plugin_that_broke() -> None:
    trace = Trace()
    for number in range(3):
        trace.add(0, f"thing_{number}", "", "refused", "objects", f"reason {chr(97 + number)}", kind="object")
    brief = brief_failure_text(trace, ("plugin x: broke in hook y",), "run").splitlines()
    assert len(brief) == 3 and brief[1] == "  Fault: plugin x: broke in hook y" and "thing_" in brief[2]
    without_run = brief_failure_text(trace, ()).splitlines()
    assert [without_run[0], *brief[2:]] == ["No solution: every alternative was refused.", without_run[1]]
    assert len(failure_text(trace, ("a", "b")).splitlines()) > 3

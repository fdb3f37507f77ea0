"""Proof under doubt: the share that must succeed, when the runs end, what is said of a program that a doubt breaks."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
from conftest import Run
from helpers.properties import examples
from helpers.task_scenarios import attempted
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Engine, UserError, find_scenario, read_scenario
from cramlite.base.pulse import Stopped, pulse
from cramlite.base.rate import wilson_interval
from cramlite.engine.proof.executor_group import ExecutorGroup
from cramlite.engine.proof.twin_proof import doubt, twin_seed
from cramlite.engine.setting import Setting
from cramlite.model import ErrorModel, Finding, PoseError, ProofDoubts, TwinRun, TwinVerdict, Verdict
from cramlite.model.twins.error_model import NO_ERRORS
from cramlite.planning.trace import Trace
from cramlite.plugin import Candidate
from cramlite.plugin.selection import INSTALLED, PluginChoice
from cramlite.scenario.scenario import scenario_from

PICK = find_scenario("tasks/picking_up")
ENGINE = Engine()
NOMINAL = Verdict((Finding("nominal", True, "it was accepted"),))
FAR = replace(NO_ERRORS, things={"block": PoseError(0.1)})  # the gripper closes beside the block


@pytest.fixture(scope="module")
def picked() -> Candidate:
    candidate, verdict, reasons = attempted("picking_up")
    assert candidate is not None and verdict is not None and verdict.passed, reasons
    return candidate


@pytest.fixture(scope="module")
def pair() -> Iterator[ExecutorGroup]:
    with closing(ExecutorGroup(INSTALLED, 2)) as group:
        yield group


def setting(**doubts: object) -> Setting:
    return replace(ENGINE.setting(read_scenario(PICK)), doubts=ProofDoubts(**doubts))  # type: ignore[arg-type]


def doubted(candidate: Candidate, group: ExecutorGroup, **doubts: object) -> Verdict:
    found = doubt(candidate, NOMINAL, setting(**doubts), ENGINE.knowledge, group, lambda _: None, 0.0)
    assert found is not None
    return found


def test_the_default_asks_for_eight_of_nine() -> None:
    doubts = ProofDoubts()
    assert (doubts.runs, doubts.needed) == (9, 8)
    assert [f"{v:.2f}" for v in wilson_interval(8, 9)] == ["0.57", "0.98"]
    failed, won = TwinRun(1, 5, (), False, "r", "o"), TwinRun(2, 5, (), True)
    assert TwinVerdict(doubts, (failed, *[won] * 7)).text == "8 of 9, interval .57 to .98"
    assert TwinVerdict(doubts, (failed, *[won] * 7)).passed and not TwinVerdict(doubts, (failed, failed)).passed


@examples(100)
@given(st.integers(0, 12), st.floats(0, 1), st.lists(st.booleans(), min_size=12, max_size=12))
def test_runs_end_when_the_others_can_change_nothing(twins: int, at_least: float, outcomes: list[bool]) -> None:
    doubts = ProofDoubts(twins, at_least)
    results = [True, *outcomes[:twins]]
    ran = next(k for k in range(1, doubts.runs + 1) if doubts.decided(sum(results[:k]), k))
    early = sum(results[:ran]) >= doubts.needed
    for rest in (0, doubts.runs - ran):  # whatever the others do
        assert (sum(results[:ran]) + rest >= doubts.needed) == early
    assert ran == 1 or not doubts.decided(sum(results[: ran - 1]), ran - 1)


@pytest.mark.parametrize("wrong", [{"twins": -1}, {"twins": 2.5}, {"twins": True}, {"twins": 1001}, {"at_least": 1.1}, {"at_least": -0.1}])
def test_doubts_that_are_none(wrong: dict[str, float]) -> None:
    with pytest.raises(UserError, match=r"it is (a whole number|the share)"):
        ProofDoubts(**wrong)  # type: ignore[arg-type]


def test_small_errors_break_nothing_and_a_large_one_is_named(picked: Candidate, pair: ExecutorGroup) -> None:
    good = doubted(picked, pair, twins=2, errors=replace(NO_ERRORS, things={"block": PoseError(0.001)}))
    assert good.passed and good.twins is not None and good.twins.succeeded == 3
    bad = doubted(picked, pair, twins=4, errors=FAR)
    assert not bad.passed and bad.twins is not None
    first = bad.twins.failed[0]
    assert first.causes == ("poses",) and first.origin.startswith("1.Grasping") and "block: " in first.largest()
    assert "of 5 required" in bad.reason and "one source of error breaks it alone: poses" in bad.reason and bad.twins.ran < 5
    assert [f.validator for f in bad.objections] == ["twins"] and bad.objections[0].origin.startswith("1.Grasping")


@pytest.mark.heavy
def test_the_verdict_is_the_same_for_any_number_of_processes(picked: Candidate, pair: ExecutorGroup) -> None:
    errors = replace(ErrorModel(), things={"block": PoseError(0.03)})
    with closing(ExecutorGroup(INSTALLED, 1)) as one:
        assert doubted(picked, one, twins=3, errors=errors) == doubted(picked, pair, twins=3, errors=errors)


def test_who_stops_it_gets_no_verdict(picked: Candidate, pair: ExecutorGroup) -> None:
    with pytest.raises(Stopped), pulse(lambda: True):
        doubt(picked, NOMINAL, setting(twins=8), ENGINE.knowledge, pair, lambda _: None, 0.0)


def test_seeds_of_proofs_are_no_others() -> None:
    own = {twin_seed(0, "text", k) for k in range(1, 100)}
    assert len(own) == 99
    assert not own & {twin_seed(0, "text", k, "figures") for k in range(1, 100)}
    assert twin_seed(0, "text", 1) not in (twin_seed(1, "text", 1), twin_seed(0, "other", 1))


DYING = """
import os

class Dying:
    name = "dying"
    def check(self, world, robots): ...
    def execute(self, text, world, robots, *, mount, seed): os._exit(3)

@hookimpl
def simulators():
    return [Dying()]
"""


@pytest.mark.heavy
def test_a_process_that_dies_again_and_again_is_no_success(plugin: Callable[[str, str], Path]) -> None:
    world = ENGINE.setting(read_scenario(PICK)).world
    with closing(ExecutorGroup(PluginChoice((plugin("dying", DYING),)), 1)) as group:
        assert "died 2 times" in str(next(group.runs("def p():\nend\np()\n", iter([(world, 0)]))))


SCRIPT = """
from cramlite import Engine, find_scenario, read_scenario
engine = Engine()
scenario = read_scenario(find_scenario("tasks/no_op"))
print("ran")
print(next(engine.resolve(scenario, setting=engine.setting(scenario, twins=1))).verdict.twins.text)
"""


@pytest.mark.heavy
def test_a_script_without_a_guard_is_run_once(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, tmp_path / "mine.py"], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == ["ran", "2 of 2, interval .34 to 1.00"]


def test_who_says_how_many(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "three.yaml"
    path.write_text(PICK.read_text() + "proof: {twins: 3}\n")

    def count(file: Path, twins: int | None = None) -> int:
        return ENGINE.setting(read_scenario(file), twins=twins).doubts.twins

    assert (count(PICK), count(path), count(path, 1)) == (0, 3, 1)  # tests/conftest.py says 0
    monkeypatch.delenv("CRAMLITE_TWINS")
    assert count(PICK) == 8
    monkeypatch.setenv("CRAMLITE_TWINS", "many")
    with pytest.raises(UserError, match=r"CRAMLITE_TWINS is 'many'; it is a whole number"):
        count(PICK)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("proof: {twin: 3}", r":17: unknown key 'twin'; did you mean 'twins'"),
        ("proof: {twins: -1}", r"'proof.twins': Input should be greater than or equal to 0"),
        ("proof: {at_least: 85}", r"'proof.at_least': Input should be less than or equal to 1"),
        ("proof: {errors: {friction: 1.5}}", r"'proof.errors.friction'"),
        ("proof: {errors: {frictoin: 0.5}}", r"unknown key 'frictoin'; did you mean 'friction'"),
        ("proof: {errors: {latency: [24 ms, 8 ms]}}", r"'proof.errors.latency'.*lowest and the highest time, in this order, from 0 to 1"),
        ("proof: {errors: {latency: 8 ms}}", r"it should be a list"),
        ("proof: {errors: {position: 3 N}}", r"'N' is not a unit of length"),
        ("proof: {errors: {things: [{thing: block, positoin: 1}]}}", r"unknown key 'positoin'; did you mean 'position'"),
    ],
)
def test_what_is_wrong_in_a_scenario_is_said_in_one_paragraph(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(PICK.read_text() + text + "\n")
    with pytest.raises(UserError, match=said) as caught:
        read_scenario(path)
    assert "\n" not in str(caught.value)


def test_errors_of_a_thing_that_there_is_not(tmp_path: Path) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(PICK.read_text() + "proof: {errors: {things: [{thing: blok, position: 1 mm}]}}\n")
    with pytest.raises(UserError, match=r"wrong.yaml:\d+: no thing 'blok'; did you mean 'block'"):
        ENGINE.setting(read_scenario(path))


def test_what_a_scenario_changes_and_what_it_leaves() -> None:
    written = {"errors": {"friction": 0.2, "force_noise": "1 N", "angle": "2 deg", "hand_eye": {"position": "1 mm"}, "scale": 2}}
    data = {"scenario": "s", "tasks": ["ParkingArms"], "robot": {"type": "ur5"}, "things": [], "proof": written}
    errors = ENGINE.setting(scenario_from(Path("s.yaml"), data)).doubts.errors
    sensor = ENGINE.knowledge.robots["ur5"].sensor_errors
    assert errors.friction == 0.2 and errors.mass == ErrorModel().mass and errors.scale == 2
    assert errors.pose.position == ErrorModel().pose.position and errors.pose.angle == pytest.approx(0.0349, abs=1e-4)
    assert errors.sensor == replace(sensor, noise=1.0) and errors.hand_eye == PoseError(0.001)


@pytest.mark.heavy
def test_the_command_line_says_it(run: Run, tmp_path: Path) -> None:
    said = run("resolve", PICK, "--twins", "1", "--out", tmp_path / "run")
    assert said.code == 0 and "ok  twins: 2 of 2, interval .34 to 1.00; .85 of 2 required" in said.out
    assert "ok twin 1 succeeded (" in run("explain", tmp_path / "run").out
    page = (tmp_path / "run" / "report.html").read_text()
    assert "Proof under doubt</h2>" in page and "block: friction" in page
    kept = json.loads((tmp_path / "run" / "verdict.json").read_text())
    assert kept["twins"]["twins"][0]["succeeded"] and kept["twins"]["twins"][0]["draws"][0]["source"] == "poses"
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["twins"]["ran"] == summary["twins"]["of"] == 2 and summary["twins"]["failed"] == []
    again = run("resolve", PICK, "--twins", "0", "--out", tmp_path / "run")
    assert again.code == 2  # the directory is of another run: the number of twins is part of it
    assert run("resolve", PICK, "--twins", "-1", "--out", tmp_path / "other").err.startswith("cramlite: The number of twins is -1")


@pytest.mark.heavy
def test_a_program_that_a_doubt_breaks_is_refused_with_the_reason(tmp_path: Path) -> None:
    path = tmp_path / "doubtful.yaml"
    path.write_text(PICK.read_text() + "budget: {proofs: 1}\nproof: {twins: 2, errors: {things: [{thing: block, position: 100 mm}]}}\n")
    trace = Trace()
    assert next(ENGINE.resolve(read_scenario(path), trace=trace), None) is None
    proof = next(e for e in trace.entries if e.kind == "proof")
    assert proof.outcome == "failed" and "twins: " in proof.reason and "breaks it alone: poses" in proof.reason
    assert [e.outcome for e in trace.entries if e.kind == "twin"].count("failed") >= 1

"""Assertions about runs of programs: each holds for a run that is as it should be, and fails for one that is not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from conftest import Proven

from cramlite.base.errors import UserError
from cramlite.program_tests.miss import ProgramFailure
from cramlite.program_tests.program_run import ProgramRun
from cramlite.program_tests.robot import ProgramRobot, TestPlace

WORLD = "place_on_shelf"
NOTHING = "def p():\n  sleep(0.1)\n  textmsg(\"waited\")\nend\n"
Ask = Callable[[ProgramRun], Any]


def robot(folder: Path, **place: Any) -> ProgramRobot:
    """A robot whose tests lie in a folder."""
    return ProgramRobot(TestPlace("test_x.py::test_y", folder, folder / "pages", **place), WORLD)


@pytest.fixture(scope="module")
def picked(proven: Proven, tmp_path_factory: pytest.TempPathFactory) -> ProgramRun:
    """The proven program of the scenario, run once; ``pick.script`` in its folder is its text."""
    folder = tmp_path_factory.mktemp("cell")
    (folder / "pick.script").write_text(proven(WORLD).code)
    return robot(folder).run("pick.script")


HOLD: Mapping[str, Ask] = {
    "a goal": lambda run: run.ends("block on shelf", "not block held"),
    "a contact": lambda run: run.touches("hand", "block").touches("hand/left", "block").touches("block", "shelf"),
    "no contact": lambda run: run.never_touches("hand", "shelf"),
    "what stays": lambda run: run.leaves("shelf", "floor"),
    "forces": lambda run: run.pushes("20 N").pushes(1000, after="1 s", before="2 s"),
    "speeds": lambda run: run.moves(1.5),
    "times": lambda run: run.takes("30 s"),
    "anything": lambda run: run.holds(lambda r: r.outcome == "finished", "it comes to its end"),
}
FAIL: Mapping[str, tuple[Ask, str]] = {
    "a goal": (lambda run: run.ends("block on floor"), "'block on floor' is not reached"),
    "stops": (lambda run: run.stops(), "it came to its end"),
    "a contact": (lambda run: run.touches("hand", "shelf"), "'hand' and 'shelf' never touch"),
    "no contact": (lambda run: run.never_touches("block", "hand"), "'hand/"),
    "what stays": (lambda run: run.leaves("block", within="5 mm"), "'block' moves"),
    "forces": (lambda run: run.pushes(0.5), "0.5 N are allowed"),
    "speeds": (lambda run: run.moves(0.02), "m/s, 0.02 m/s are allowed"),
    "times": (lambda run: run.takes("2 s"), "2 s are allowed"),
    "logs": (lambda run: run.logs("nobody said this"), "no message has 'nobody said this'"),
    "anything": (lambda run: run.holds(lambda r: len(r.times) < 5, "it is short"), "it does not hold that it is short"),
}
WRONG: Mapping[str, tuple[Ask, str]] = {
    "no such thing": (lambda run: run.touches("hand", "blok"), "There is no 'blok' in the world; did you mean 'block'"),
    "no such goal": (lambda run: run.ends("blok on shelf"), "blok"),
    "no unit": (lambda run: run.pushes("20 kg"), "'kg' is not a unit of force"),
}


@pytest.mark.parametrize("name", HOLD)
def test_what_holds(picked: ProgramRun, name: str) -> None:
    assert HOLD[name](picked) is picked


@pytest.mark.parametrize("name", FAIL)
def test_what_does_not_hold_says_what_happened_when_and_where(picked: ProgramRun, name: str) -> None:
    ask, said = FAIL[name]
    with pytest.raises(ProgramFailure) as raised:
        ask(picked)
    assert said in str(raised.value) and "Drawn on" in str(raised.value)
    page = picked.page.read_text()
    assert "data:image/png;base64," in page and "The program" in page


@pytest.mark.parametrize("name", WRONG)
def test_a_mistake_of_who_asks_is_named(picked: ProgramRun, name: str) -> None:
    ask, said = WRONG[name]
    with pytest.raises((UserError, ValueError), match=said):
        ask(picked)


def test_a_failure_names_moment_and_line(picked: ProgramRun) -> None:
    with pytest.raises(ProgramFailure, match=r"At \d+\.\d+ s, line \d+: movel\(picking_up") as raised:
        picked.leaves("block", within="5 mm")
    line = str(raised.value).split("line ")[1].split(":")[0]
    assert f'class="ran"><span\n class="number">{int(line):4d} ' in picked.page.read_text()


def test_a_claim_about_each_sample_names_the_first_that_is_wrong(picked: ProgramRun) -> None:
    assert picked.holds(lambda r: r.times >= 0.0, "time passes") is picked
    with pytest.raises(ProgramFailure, match=r"it does not hold that it is soon over\nAt 3\.00 s, line \d+"):
        picked.holds(lambda r: r.times < 2.99, "it is soon over")


def test_snapshots(picked: ProgramRun, tmp_path: Path) -> None:
    run = ProgramRun("pick", picked.text, picked.ways, picked.knowledge, tmp_path, tmp_path / "page.html")
    with pytest.raises(ProgramFailure, match="there was no snapshot"):
        run.matches("pick.yaml")
    assert run.matches("pick.yaml") is run
    kept = (tmp_path / "pick.yaml").read_text()
    (tmp_path / "pick.yaml").write_text(kept.replace("block: [0.45", "block: [0.47"))
    with pytest.raises(ProgramFailure, match="'block' ends 20 mm from where it ended in the snapshot, 5 are allowed"):
        run.matches("pick.yaml")
    assert run.matches("pick.yaml", places="3 cm") is run
    (tmp_path / "pick.yaml").write_text("a: 1\n")
    with pytest.raises(UserError, match="is no snapshot"):
        run.matches("pick.yaml")
    accepting = ProgramRun("pick", picked.text, picked.ways, picked.knowledge, tmp_path, tmp_path / "page.html", accept=True)
    accepting.matches("pick.yaml")
    assert (tmp_path / "pick.yaml").read_text() == kept


FAULTS: Mapping[str, tuple[dict[str, Any], Ask, Ask]] = {
    "missing": ({"missing": "block"}, lambda r: r.stops("no object"), lambda r: r.ends()),
    "moved": ({"moved": "block", "by": ["60 mm", 0, 0]}, lambda r: r.stops(), lambda r: r.ends("block on shelf")),
    "stop": ({"protective_stop": "2 s"}, lambda r: r.stops("protective stop"), lambda r: r.ends()),
    "tool": ({"tool": [0, 0, "30 mm"]}, lambda r: r.stops(), lambda r: r.ends("block on shelf")),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_felt(picked: ProgramRun, name: str) -> None:
    fault, holds, fails = FAULTS[name]
    run = robot(picked.folder).run("pick.script", faults=[fault])
    holds(run)
    with pytest.raises(ProgramFailure):
        fails(run)


@pytest.mark.parametrize(("fault", "force"), [({"payload": "1 kg"}, 9.0), ({"sensor": ["5 N", 0, 0]}, 4.0)])
def test_payload_and_sensor_are_felt_before_a_tare(picked: ProgramRun, fault: dict[str, Any], force: float) -> None:
    run = robot(picked.folder).run(NOTHING, faults=[fault])
    run.holds(lambda r: float(r.contact_force().max()) > force, "the fault is felt").logs("waited")
    with pytest.raises(ProgramFailure):
        robot(picked.folder).run(NOTHING).holds(lambda r: float(r.contact_force().max()) > force, "nothing is felt")


def test_twins_err_and_most_must_hold(picked: ProgramRun) -> None:
    run = robot(picked.folder).run("pick.script", twins=2).ends("block on shelf")
    ends = {tuple(w.rollout.poses["block"][-1, :2].round(5)) for w in run.ways}
    assert len(ends) == 3 and [bool(w.draws) for w in run.ways] == [False, True, True]
    one = run.ways[1].rollout
    with pytest.raises(ProgramFailure, match=r"in twin 1 of 2 .*\n.*holds in 2 of 3 runs"):
        run.holds(lambda r: r is not one, "it is not that twin")
    again = robot(picked.folder).run("pick.script", twins=1)
    assert (again.ways[1].rollout.poses["block"] == one.poses["block"]).all()


def test_bad_faults_and_programs_are_named(tmp_path: Path) -> None:
    for fault, said in (
        ({"missing": "blok"}, "did you mean 'block'"),
        ({"mising": "block"}, "exactly one of missing, moved"),
        ({"moved": "block"}, "'moved' needs 'by'"),
        ({"missing": "block", "payload": "1 kg"}, "exactly one"),
        ({"payload": True}, "is a number in kg"),
    ):
        with pytest.raises(UserError, match=said):
            robot(tmp_path).run(NOTHING, faults=[fault])
    with pytest.raises(UserError, match=r"nobody\.script' cannot be read"):
        robot(tmp_path).run("nobody.script")
    with pytest.raises(UserError, match="Say where 'program' runs"):
        ProgramRobot(TestPlace("x", tmp_path, tmp_path)).run(NOTHING)
    with pytest.raises(UserError, match=r"program: URScript, line 3"):
        robot(tmp_path).run("def p():\n  x = (\nend\n")

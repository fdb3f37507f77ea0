"""The real world is entered once, by the first accepted program, and the search learns nothing of how that went."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import pytest
from conftest import ROOT, Run

from cramlite import Engine, Setting, Solution, read_scenario
from cramlite.engine.picture_checks import Looks, PictureChecks
from cramlite.model import replace
from cramlite.model.fault import Fault, FaultKind, Trigger
from cramlite.model.run.readings import Deviation
from cramlite.plugin import UserError

SCENARIO = """
scenario: lift
tasks:
  - {{task: Grasping, Patient: block}}
  - {{task: PickingUp, Locatum: block, Relatum: floor}}
robot: {{type: ur5e}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: block, model: block, at: {{position: [0.5, 0.2, 51 mm]}}, with: {{size: [50 mm, 50 mm, 100 mm]}}}}
unknown_error: {{thing: block, position: {error}}}
"""
CAMERA = "camera: {mount: world, at: {position: [0.5, 0.9, 0.9], roll: -139 deg, yaw: 180 deg}, checks: tasks}\n"

WITNESS = '''
from pathlib import Path

class Witness:
    """Writes down in which world each run was, and refuses the first REFUSED ones."""

    name, cost = "witness", "rollout"

    def check(self, candidate):
        real = candidate.rollout.world.thing("block").pose != candidate.world.thing("block").pose
        file = Path(__file__).with_suffix(".log")
        before = file.read_text().split() if file.exists() else []
        file.write_text("\\n".join([*before, "real" if real else "believed"]))
        yield Finding("witness", len(before) >= REFUSED, f"run {len(before) + 1}", origin="1.Grasping")

@hookimpl
def validators():
    return [Witness()]
'''

WISE = '''
class Wise:
    """Objects to every run in which the block is not where it is believed to be: it would drive a search by the truth."""

    name, cost = "wise", "rollout"

    def check(self, candidate):
        true = candidate.rollout.world.thing("block").pose == candidate.world.thing("block").pose
        yield Finding("wise", true, "the block is where it is believed to be" if true else "the block is elsewhere")

@hookimpl
def validators():
    return [Wise()]
'''

Plugin = Callable[[str, str], Path]


def lift(folder: Path, error: str, camera: str = "") -> Path:
    path = folder / "lift.yaml"
    path.write_text(SCENARIO.format(error=error) + camera)
    return path


@pytest.mark.heavy
@pytest.mark.parametrize("refused", [0, 2])
def test_the_real_world_is_entered_exactly_once(refused: int, tmp_path: Path, plugin: Plugin, run: Run) -> None:
    witness = plugin("witness", WITNESS.replace("REFUSED", str(refused)))
    done = run("resolve", lift(tmp_path, "2 mm"), "--plugin", witness, "--out", tmp_path / "run", "--no-report", "--json")
    assert done.code == 0, done.err
    assert witness.with_suffix(".log").read_text().split() == ["believed"] * (refused + 1) + ["real"]


@pytest.mark.heavy
def test_a_failed_execution_ends_it_with_the_reason(tmp_path: Path, plugin: Plugin, run: Run) -> None:
    """Nothing else is tried in the real world, though the search has more to offer."""
    witness = plugin("witness", WITNESS.replace("REFUSED", "0"))
    out = tmp_path / "run"
    done = run("resolve", lift(tmp_path, "1 m", CAMERA), "--plugin", witness, "--out", out, "--no-report", "--json")
    assert done.code == 1
    assert "proven in the believed world, but its first execution failed: " in done.err
    assert witness.with_suffix(".log").read_text().split() == ["believed", "real"]
    summary = json.loads(done.out)
    assert (summary["solved"], summary["proven"], summary["execution"]["succeeded"]) == (False, True, False)
    assert summary["reason"].startswith("first execution: ")
    assert "after 1.Grasping 'grasps(Gripper, Patient)' does not hold" in (out / "execution" / "verdict.json").read_text()
    checks = summary["execution"]["checks"]
    assert checks["looks"] == "could not be seen" and not checks["notices"], "the hand is where the block should be"
    again = run("resolve", tmp_path / "lift.yaml", "--plugin", witness, "--out", out, "--no-report")
    assert again.code == 1, "a run that failed is not complete"


@pytest.mark.heavy
def test_what_succeeded_at_the_first_execution_says_so(tmp_path: Path, run: Run) -> None:
    out = tmp_path / "run"
    done = run("resolve", lift(tmp_path, "2 mm", CAMERA), "--out", out)
    assert done.code == 0 and "Solved at the first execution: Grasping -> PickingUp" in done.out
    assert "Seen by the camera, at rest: the goal looks reached: of " in done.out
    page = (out / "report.html").read_text()
    assert "took 2 pictures of this run" in page and "the goal looks reached" in page
    assert "Program proven, first execution succeeded" in page and "The first execution" in page
    worlds = [json.loads((out / at / "world.json").read_text())["things"][1]["pose"] for at in ("", "execution")]
    assert worlds[0] != worlds[1]
    assert "complete" in run("resolve", tmp_path / "lift.yaml", "--out", out).err


def test_without_a_real_world_nothing_is_executed(tmp_path: Path, run: Run) -> None:
    path = lift(tmp_path, "2 mm")
    path.write_text(path.read_text().partition("unknown_error")[0])
    done = run("resolve", path, "--out", tmp_path / "run", "--no-report", "--json")
    assert done.code == 0 and json.loads(done.out)["execution"] is None
    assert not (tmp_path / "run" / "execution").exists()


def programs(folder: Path, wise: Path, *, executed: bool) -> list[str]:
    """The first proven programs, each executed before the next is asked for, or none of them."""
    engine, found = Engine(files=[wise]), []
    for solution in islice(engine.resolve(read_scenario(lift(folder, "1 m"))), 3):
        if executed:
            assert not engine.execute(solution).succeeded
        found.append(solution.code)
    return found


@pytest.mark.heavy
def test_the_search_goes_on_as_if_nothing_had_been_executed(tmp_path: Path, plugin: Plugin) -> None:
    """Not even a validator that knows the truth when it is shown it can tell the search."""
    wise = plugin("wise", WISE)
    found = programs(tmp_path, wise, executed=True)
    assert len(found) == 3 and found == programs(tmp_path, wise, executed=False)


@pytest.mark.parametrize("module", ["candidates", "engine", "late_poses", "proof/proof", "reading"])
def test_what_searches_and_proves_does_not_read_the_real_world(module: str) -> None:
    assert ".real" not in (ROOT / "cramlite" / "engine" / f"{module}.py").read_text()


PLACED = SCENARIO.replace("  - {{task: PickingUp, Locatum: block, Relatum: floor}}\n", (
    "  - {{task: PickingUp, Locatum: block, Relatum: floor}}\n  - {{task: Placing, Locatum: block, Relatum: floor}}\n"
))


@pytest.fixture
def placed(tmp_path: Path) -> tuple[Engine, Solution, Setting]:
    path = tmp_path / "placed.yaml"
    path.write_text(PLACED.format(error="2 mm") + CAMERA)
    engine = Engine()
    solution = next(engine.resolve(read_scenario(path)))
    return engine, solution, solution.setting


@pytest.mark.heavy
def test_where_it_goes_on_is_known_after_the_execution_only(placed: tuple[Engine, Solution, Setting]) -> None:
    engine, solution, before = placed
    with pytest.raises(UserError, match=r"Engine\.execute"):
        solution.setting_after()
    after = engine.execute(solution).setting_after()
    assert before.real is not None and after.real is not None
    assert after.world.thing("block").pose != before.world.thing("block").pose
    assert after.real.thing("block").pose not in (before.real.thing("block").pose, after.world.thing("block").pose)


def checked(engine: Engine, solution: Solution) -> PictureChecks:
    """What the camera tells of the execution of a solution."""
    execution = engine.execute(solution).execution
    assert execution is not None and execution.checks is not None
    return execution.checks


@pytest.mark.heavy
def test_pictures_tell_whether_a_thing_is_where_it_was_put(placed: tuple[Engine, Solution, Setting]) -> None:
    engine, solution, setting = placed
    checks = checked(engine, solution)
    assert checks.looks is Looks.REACHED and not checks.notices, str(checks)
    assert [p.task for p in checks.pictures] == ["1.Grasping", "2.PickingUp", ""]
    fallen = Fault(FaultKind.MOVED, "block", by=(0.0, 0.1, 0.0), trigger=Trigger(line="Retracting"))
    real = replace(setting.real, faults=(fallen,))
    checks = checked(engine, replace(solution, setting=replace(setting, real=real)))
    assert checks.looks is Looks.MISSED, str(checks)
    assert [(n.kind, n.thing, n.step) for n in checks.notices] == [(Deviation.MOVED, "block", "")]

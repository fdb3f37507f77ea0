"""Open programs: the tasks of a stage are resolved when their time comes, from what is read then, or others in their place."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from cramlite import Engine, NoSolution, Trace, UserError, read_scenario
from cramlite.cli.resolve import _say_notes
from cramlite.engine.recovery.going_on import GoingOn, Stretch
from cramlite.engine.recovery.replanning import Attempt, rounds

SCENE = """scenario: open_program
tasks:
  - {task: PickAndPlace, Locatum: block, Relatum: shelf}
then:
  - do: [{task: PickAndPlace, Locatum: cup, Relatum: shelf}]
ELSE
objects:
  cup: {types: ["soma:Cup"]}
robot: {type: ur5e}
FAULTS
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: block, model: block, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
  - {name: shelf, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.35 m, 0.35 m, 20 mm]}}
  - {name: visitor, model: block, type: "soma:Cup", at: {position: [0.35, 0.38, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
"""
ELSE = "    else: [ParkingArms]"
COMES = 'faults: [{added: visitor, line: "PuttingDown/lower"}]'


@cache
def engine() -> Engine:
    return Engine()


def ran(folder: Path, faults: str, otherwise: str) -> list[Stretch]:
    path = folder / "open.yaml"
    text = SCENE.replace("FAULTS", faults).replace("ELSE\n", f"{otherwise}\n" if otherwise else "")
    path.write_text("\n".join(v for v in text.splitlines() if faults or "visitor" not in v))
    scenario = read_scenario(path)
    solution = next(engine().resolve(scenario, setting=engine().setting(scenario, twins=0)))
    assert "cup" not in str(solution.plan)
    return list(GoingOn(scenario, engine()).execute(solution))


@pytest.mark.heavy
def test_what_came_meanwhile_is_what_a_later_task_is_about(tmp_path: Path) -> None:
    done = ran(tmp_path, COMES, ELSE)
    assert "(do): PickAndPlace" in done[-2].decision and done[-1].notice is None
    assert done[-1].round.rollout.poses["visitor"][-1][2] > 0.15, "on the shelf"


@pytest.mark.heavy
def test_where_it_cannot_be_resolved_the_others_are_done_in_its_place(tmp_path: Path) -> None:
    done = ran(tmp_path, "", ELSE)
    assert "(else): ParkingArms" in done[-2].decision and done[-1].round.rollout.outcome == "finished"


@pytest.mark.heavy
def test_without_others_it_ends_there_and_says_why(tmp_path: Path) -> None:
    said = r"came to its end\. The arm stands still: what comes then cannot be done as things are\.(.|\n)*soma:Cup"
    with pytest.raises(NoSolution, match=said):
        ran(tmp_path, "", "")


SEEN = """scenario: open_and_seen
tasks: [CloseGripperTask]
then:
  - do: [{task: Grasping, Patient: product}]
  - do: [{task: Grasping, Patient: cup}]
objects:
  product: {types: ["cram:TeaBox"]}
  cup: {types: ["soma:Cup"]}
robot: {type: ur5e}
camera: {mount: world, at: {position: [0.6, 1.0, 0.55], roll: -125 deg, yaw: 180 deg}}
poses: camera
things:
  - {name: table, model: table, at: {position: [0.4, 0, -1 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: tea, model: tea_box, at: {position: [0.5, 0.2, 65 mm]}}
"""


@pytest.mark.heavy
def test_a_camera_looks_before_each_stage(tmp_path: Path) -> None:
    """The box is found at the place where it is seen then; a cup is not, so that nothing follows."""
    (tmp_path / "seen.yaml").write_text(SEEN)
    scenario, said = read_scenario(tmp_path / "seen.yaml"), list[str]()
    solution = next(engine().resolve(scenario, setting=engine().setting(scenario, twins=0)))
    real = solution.setting.real
    assert real is not None and "teabox_1" not in {t.name for t in solution.setting.world.things}
    first = Attempt(solution.plan, solution.candidate.program, solution.candidate.written, real)
    done = rounds(first, scenario, engine(), seed=0, most=3, say=said.append)
    assert next(done).rollout.outcome == "finished"
    grasped = next(done)
    assert grasped.rollout.outcome == "finished" and grasped.attempt.candidate is not None
    assert "round 2: resolves what comes then (do): Grasping" in said
    with pytest.raises(NoSolution, match=r"Round 3: what comes then cannot be done as things are\.(.|\n)*soma:Cup"):
        next(done)


@pytest.mark.parametrize(("then", "said"), [(True, ["the proven program does not contain 1 stage of the scenario's 'then'"]), (False, [])])
def test_resolve_says_that_more_is_to_come(tmp_path: Path, capsys: pytest.CaptureFixture[str], then: bool, said: list[str]) -> None:
    path, text = tmp_path / "open.yaml", SCENE.replace("FAULTS\n", "").replace("ELSE\n", "")
    path.write_text(text if then else text.replace(text[text.index("then:") : text.index("objects:")], ""))
    scenario = read_scenario(path)
    _say_notes(scenario, engine().setting(scenario, twins=0), engine())
    lines = [line for line in capsys.readouterr().err.splitlines() if "the proven program does not contain" in line]
    assert [line.removeprefix("cramlite: ").partition(": 'cramlite")[0] for line in lines] == said
    assert all(f"'cramlite execute PROGRAM --replan {path}'" in line for line in lines)


def test_a_stage_is_a_scenario_whose_errors_have_its_lines(tmp_path: Path) -> None:
    path = tmp_path / "open.yaml"
    path.write_text(SCENE.replace("FAULTS\n", "").replace("ELSE\n", "").replace("Relatum: shelf}]", "Relatum: shell}]"))
    scenario = read_scenario(path)
    stage = scenario.stage(0, "do")
    assert stage is not None and not stage.spec.then and scenario.stage(0, "else") is None
    with pytest.raises(UserError, match=r"open\.yaml:5: .*'shell'"):
        next(engine().plans(stage, engine().setting(stage), Trace()), None)


def test_a_stage_does_something(tmp_path: Path) -> None:
    path = tmp_path / "open.yaml"
    what = "do: [{task: PickAndPlace, Locatum: cup, Relatum: shelf}]"
    path.write_text(SCENE.replace("FAULTS\n", "").replace("ELSE\n", "").replace(what, "do: []"))
    with pytest.raises(UserError, match=r"open\.yaml:5"):
        read_scenario(path)

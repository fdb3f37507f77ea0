"""A scene that somebody else made, from its file to a program that is proven in it."""

from __future__ import annotations

import shutil
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from helpers.as_a_user import cramlite

from cramlite.cli.main import main

DATA = Path(__file__).parents[1] / "plugins" / "imports" / "scenes_data"
ONTO = "  - {task: PickAndPlace, Locatum: red_box, Relatum: kitchen_counter}"
INTO = """  - {task: Grasping, Patient: red_box}
  - {task: PickingUp, Locatum: red_box}
  - {task: Ungrasping, Locatum: red_box, Relatum: RELATUM}"""


def _import(scene: Path, out: Path, *more: str) -> CompletedProcess[str]:
    return cramlite("import", scene, "--out", out, *more)


@pytest.fixture
def kitchen(tmp_path: Path) -> Path:
    """The folder of a copy of the scene, with the scenario that ``cramlite import`` wrote."""
    shutil.copytree(DATA, tmp_path / "scene")
    done = _import(tmp_path / "scene" / "kitchen.xml", tmp_path / "kitchen.yaml", "--robot", "ur5e")
    assert done.returncode == 0, done.stderr
    assert "akita_white_bowl_1  soma:Bowl, because 'akita_white_bowl_1' contains the label 'bowl'" in done.stdout
    assert "not taken over: 1 shape without contacts" in done.stdout
    return tmp_path


def _resolve(folder: Path, tasks: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    scenario = folder / "kitchen.yaml"
    scenario.write_text(scenario.read_text().replace("tasks: []", f"tasks:\n{tasks}"))
    code = main(["resolve", str(scenario), "--twins", "0", "--no-report", "--out", str(folder / "run")])
    said = capsys.readouterr()
    return code, said.out + said.err


@pytest.mark.heavy
def test_a_box_of_a_foreign_scene_comes_onto_its_counter(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, said = _resolve(kitchen, ONTO, capsys)
    assert code == 0 and "'red_box' rests on 'kitchen_counter'" in said, said


@pytest.mark.heavy
def test_a_box_that_the_file_makes_slippery_is_not_brought_there(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = kitchen / "scene" / "kitchen.xml"
    file.write_text(file.read_text().replace('friction="0.7 0.01 0.001"', 'friction="0.00001 0 0"'))
    code, said = _resolve(kitchen, ONTO, capsys)
    assert code == 1 and "1.PickAndPlace/Grasping/close: " in said and "'red_box' 1e-05) needs" in said, said


@pytest.mark.heavy
def test_the_box_comes_into_the_bowl(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, said = _resolve(kitchen, INTO.replace("RELATUM", "akita_white_bowl_1"), capsys)
    assert code == 0 and "'red_box' rests in 'akita_white_bowl_1'" in said, said


def test_the_box_comes_into_nothing_that_has_no_opening(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, said = _resolve(kitchen, INTO.replace("RELATUM", "kitchen_counter"), capsys)
    assert code != 0 and "kitchen_counter" in said, said


def test_the_box_comes_into_no_bowl_that_is_too_small_for_it(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = kitchen / "scene" / "kitchen.xml"
    file.write_text(file.read_text().replace('scale="0.002 0.002 0.0012"', 'scale="0.0006 0.0006 0.0012"'))
    code, said = _resolve(kitchen, INTO.replace("RELATUM", "akita_white_bowl_1"), capsys)
    assert code == 1 and "akita_white_bowl_1" in said, said


@pytest.mark.heavy
def test_the_box_comes_into_no_bowl_that_is_full(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    full = "things:\n  - {name: filler, model: block, at: {position: [0.45, -0.3, 0.068]}, with: {size: [95 mm, 95 mm, 120 mm]}}\n"
    few = "budget: {proofs: 1, sequences: 1}\n"
    scenario = kitchen / "kitchen.yaml"
    scenario.write_text(scenario.read_text() + full + few)
    code, said = _resolve(kitchen, INTO.replace("RELATUM", "akita_white_bowl_1"), capsys)
    assert code == 1 and "middle of the opening of 'akita_white_bowl_1'" in said, said


@pytest.mark.heavy
def test_its_drawer_opens(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, said = _resolve(kitchen, "  - {task: Opening, Patient: drawer_1}", capsys)
    assert code == 0 and "joint_rises" in said, said


def _bar(folder: Path, pitch: float) -> None:
    """Put a bar above the handle of the drawer, so far from it [m], as that of another drawer is; its front ends below that."""
    file = folder / "scene" / "kitchen.xml"
    bar = f'<geom class="wood" type="box" size=".006 .05 .006" pos="-.213 0 {0.1 + pitch}"/>'
    text = file.read_text().replace('size="0.008 0.17 0.06"', 'size="0.008 0.17 0.012"')
    file.write_text(text.replace('<body name="drawer_1"', f'{bar}<body name="drawer_1"'))


@pytest.mark.heavy
def test_its_drawer_opens_beside_another_by_fingers_that_open_no_wider(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _bar(kitchen, 0.050)
    code, said = _resolve(kitchen, "  - {task: Opening, Patient: drawer_1}", capsys)
    assert code == 0 and "joint_rises" in said, said


@pytest.mark.heavy
def test_its_drawer_stays_closed_where_the_hand_has_no_room_along_its_way(kitchen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _bar(kitchen, 0.022)
    code, said = _resolve(kitchen, "  - {task: Opening, Patient: drawer_1}", capsys)
    assert code == 1 and "1.Opening" in said and "inside 'kitchen_counter'" in said, said


def test_own_things_stand_in_a_foreign_scene_and_what_the_scenario_says_holds(
    kitchen: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (kitchen / "kitchen.yaml").read_text().replace("tasks: []", f"tasks:\n{ONTO}").replace("soma:Box", "cram:Tin")
    own = "things:\n  - {name: can, model: can, at: {position: [0.6, 0.1, 0.36]}}\n"
    rest = "  leave_out: ['akita*']\n"
    path = kitchen / "kitchen.yaml"
    lines = [line for line in text.splitlines() if "akita_white_bowl_1:" not in line]
    path.write_text("\n".join(lines).replace("  types:", f"{rest}  types:") + f"\n{own}")
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    assert "thing 'red_box': taken for cram:Tin, because the scenario says so of 'red_box'" in said
    assert "robot ur5e, 5 things" in said and "akita" not in said


WRONG = {
    "types: {'blue*': soma:Bowl}": "no thing of 'kitchen.xml' is called 'blue*'",
    "types: {'red*': soma:Bowll}": "unknown class 'soma:Bowll'",
    "leave_out: [chair]": "no thing of 'kitchen.xml' is called 'chair'",
    "keyframe: home": "there is no keyframe 'home'",
    "colour: red": "unknown key 'colour'",
}


@pytest.mark.parametrize("key", WRONG)
def test_a_wrong_key_is_refused_with_its_line(key: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(f"scenario: wrong\nrobot: {{type: ur5e}}\ntasks: [ParkingArms]\nworld:\n  file: {DATA / 'kitchen.xml'}\n  {key}\n")
    assert main(["check", str(path)]) == 2
    said = capsys.readouterr().err
    assert WRONG[key] in said and (f"{path}:6" in said or "kitchen.xml:1" in said), said


def test_bad_files_end_the_command_with_one_paragraph(tmp_path: Path) -> None:
    bad = tmp_path / "bad.xml"
    bad.write_text('<mujoco>\n<asset>\n<mesh name="a" file="no.stl"/></asset><worldbody/></mujoco>')
    done = _import(bad, tmp_path / "out.yaml")
    assert done.returncode == 2 and not (tmp_path / "out.yaml").exists()
    assert done.stderr.startswith(f"cramlite: {bad}:3: ") and len(done.stderr.strip().splitlines()) == 1


def test_a_scenario_is_not_written_over(kitchen: Path) -> None:
    done = _import(kitchen / "scene" / "kitchen.xml", kitchen / "kitchen.yaml")
    assert done.returncode == 2 and "exists already" in done.stderr


def test_a_goal_is_written_into_the_scenario_of_a_scene(tmp_path: Path) -> None:
    from cramlite import read_scenario

    goal = ("red_box on kitchen_counter", "akita_white_bowl_1 on kitchen_counter")
    done = _import(DATA / "kitchen.xml", tmp_path / "a.yaml", "--robot", "ur5e", "--goal", goal[0], "--goal", goal[1])
    assert done.returncode == 0 and "Put tasks into it" not in done.stdout, done.stderr
    assert read_scenario(tmp_path / "a.yaml").spec.goal == goal
    assert main(["check", str(tmp_path / "a.yaml")]) == 0


def test_a_goal_without_a_scenario_to_write_it_into_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(DATA / "kitchen.xml"), "--goal", "red_box on kitchen_counter"]) == 2
    assert "--out" in capsys.readouterr().err

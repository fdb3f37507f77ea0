"""Grippers from MJCF and URDF: pads, stroke and force are those of the file, they hold by friction, and bad ones are refused."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Geom, HandFile, ImportedRobot, Physics, Pose, RobotMount, Stated, Thing, World
from cramlite.plugin import UserError
from cramlite.testing.plugin_checks import check_robot
from cramlite_plugins.imports.robots.robot_file import read_robot
from cramlite_plugins.simulation.controller.gripper_drive import GripperDrive
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

DATA = Path(__file__).parent / "robots_data"
SIX, LINKED, SLIDES = DATA / "six.urdf", DATA / "linked_hand.xml", DATA / "slides.urdf"
ARM = Stated(4.0, sensor="flange", home=(0.0, 0.3, 1.6, 0.0, 1.24, 0.0))


def arm_with(hand: HandFile) -> ImportedRobot:
    return read_robot(SIX, "mine", replace(ARM, gripper=hand))


@pytest.fixture(scope="module")
def linked() -> ImportedRobot:
    return arm_with(HandFile(str(LINKED)))


@pytest.fixture(scope="module")
def slides() -> ImportedRobot:
    return arm_with(HandFile(str(SLIDES)))


def world_of(read: ImportedRobot, *things: Thing, friction: float = 0.9) -> Compiled:
    mount = RobotMount("arm", "mine")
    return compile_world(World(things, (mount,), Physics(pad_friction=friction)), {"mine": read.robot})


def test_a_closed_loop_is_understood(linked: ImportedRobot) -> None:
    hand = linked.robot.gripper
    assert hand.opening == pytest.approx((0.0, 0.07), abs=1e-4)
    assert hand.pad == pytest.approx((0.02, 0.05), abs=1e-6)
    assert hand.mass == pytest.approx(0.54)
    assert hand.friction == pytest.approx(0.8)
    # the fingers' middle is 135 mm above the palm's foot when wide, and rises by 50 mm (1 - cos 36.9 deg) on its arc, and falls again
    assert hand.tcp.position == pytest.approx((0.0, 0.0, 0.14), abs=1e-3)
    z, y = (np.array(hand.tcp.rotate(axis)) for axis in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
    assert z == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)
    assert np.abs(y) == pytest.approx((0.0, 1.0, 0.0), abs=1e-6)
    check_robot(linked.robot)


def test_a_mimicking_finger_and_a_missing_drive_are_understood(slides: ImportedRobot) -> None:
    hand = slides.robot.gripper
    assert hand.opening == pytest.approx((0.0, 0.08), abs=1e-4)
    assert hand.force[1] == pytest.approx(15.0, rel=0.01)  # 30 N of effort are shared by two fingers
    assert "no actuator drives the hand" in "; ".join(slides.notes)
    check_robot(slides.robot)


@given(share=st.floats(0.0, 1.0))
@examples(50)
def test_the_table_closes_the_loops_and_is_read_back(linked: ImportedRobot, share: float) -> None:
    compiled = world_of(linked)
    data, index = compiled.data(), compiled.robots["arm"]
    opening = share * 0.07
    index.set_opening(data, opening)
    mujoco.mj_forward(compiled.model, data)
    assert float(index.opening(data.qpos)) == pytest.approx(opening, abs=2e-4)
    assert np.abs(data.efc_pos[: data.ne]).max() < 3e-4  # the loops' ends lie on each other [m, rad]
    ends = [data.geom_xpos[compiled.model.geom(f"arm/{side}_pad1").id] for side in ("left", "right")]
    assert np.linalg.norm(ends[0] - ends[1]) - 0.01 == pytest.approx(opening, abs=5e-4)


def squeezed(read: ImportedRobot, force: float, friction: float = 0.9) -> tuple[float, float, float]:
    """Opening [m] and force of the left pad [N] once a block of 40 mm and 0.3 kg was gripped, and how far it has sunk [m]."""
    empty = world_of(read)
    tcp = empty.robots["arm"].pose(empty.data())
    block = Thing("block", "cram:Product", tcp, (Geom("box", (0.02, 0.02, 0.015)),), mass=0.3, friction=0.9)
    compiled = world_of(read, block, friction=friction)
    data, index = compiled.data(), compiled.robots["arm"]
    drive = GripperDrive(read.robot.gripper, index, compiled.model)
    drive.begin_as(data)
    drive.move(read.robot.gripper.opening[0], 0.1, force)
    start, gravity = compiled.pose(data, "block").position[2], compiled.model.opt.gravity.copy()
    for k in range(1000):
        compiled.model.opt.gravity[:] = gravity * (k > 400)  # it floats until the fingers have it
        drive.advance(data, 0.002)
        mujoco.mj_step(compiled.model, data)
    pressed = 0.0
    for c in range(data.ncon):
        if set(data.contact[c].geom) & set(index.left):
            wrench = np.zeros(6)
            mujoco.mj_contactForce(compiled.model, data, c, wrench)
            pressed += float(wrench[0])
    return drive.opening, pressed, start - compiled.pose(data, "block").position[2]


@pytest.mark.parametrize(("which", "force"), [("linked", 20.0), ("linked", 40.0), ("slides", 12.0)])
def test_it_grips_with_the_commanded_force_and_holds_by_friction(
    which: str, force: float, request: pytest.FixtureRequest
) -> None:
    opening, pressed, sunk = squeezed(request.getfixturevalue(which), force)
    assert opening == pytest.approx(0.04, abs=0.002)
    assert pressed == pytest.approx(force, rel=0.1)
    assert sunk < 0.003


def test_without_friction_it_holds_nothing(linked: ImportedRobot) -> None:
    assert squeezed(linked, 40.0, friction=0.0)[2] > 0.05


def resisted(read: ImportedRobot) -> set[tuple[int, float]]:
    """condim and torsional friction [m] between the pads and a block."""
    block = Thing("block", "cram:Product", Pose((1.0, 0.0, 0.5)), (Geom("box", (0.02, 0.02, 0.015)),), mass=0.3, friction=0.5)
    model = world_of(read, block).model
    pads = [p for p in range(model.npair) if "_pad" in model.pair(p).name]
    return {(int(model.pair_dim[p]), float(model.pair_friction[p][2])) for p in pads}


def test_what_the_file_says_of_turning_in_the_pads_is_kept(tmp_path: Path) -> None:
    hand, text = tmp_path / "hand.xml", LINKED.read_text()
    hand.write_text(text.replace("0.8 0.005", "0.8 0.02"))
    assert resisted(arm_with(HandFile(str(hand)))) == {(4, 0.02)}
    hand.write_text(text.replace('condim="4"', 'condim="3"'))
    sliding = arm_with(HandFile(str(hand)))
    assert {condim for condim, _ in resisted(sliding)} == {3}
    assert any("no torsional friction (condim 3)" in n for n in sliding.notes)
    stated = arm_with(HandFile(str(hand), torsion=0.01))
    assert resisted(stated) == {(4, 0.01)}
    assert not any("torsional" in n for n in stated.notes)


def test_a_stated_force_is_exerted() -> None:
    read = arm_with(HandFile(str(LINKED), force=(10.0, 100.0)))
    assert read.robot.gripper.force == (10.0, 100.0)
    assert any("made as strong" in note for note in read.notes)
    assert squeezed(read, 100.0)[1] == pytest.approx(100.0, rel=0.1)


def test_pads_pinch_point_and_opening_can_be_named(linked: ImportedRobot) -> None:
    named = arm_with(HandFile(str(LINKED), pads=("left_tip", "right_finger"), tcp="pinch", opening=(0.01, 0.06))).robot.gripper
    assert named.tcp.position == pytest.approx((0.0, 0.0, 0.14), abs=1e-9)
    assert named.opening == pytest.approx((0.01, 0.06))
    assert named.pad == linked.robot.gripper.pad


def test_what_was_guessed_of_a_hand_is_said_until_it_is_stated(linked: ImportedRobot) -> None:
    pads, tcp, stroke = (next(n for n in linked.notes if f"its {what} " in n) for what in ("pads", "pinch point", "stroke"))
    assert "20 x 50 mm on 'left_finger' and 'right_finger'" in pads and "'pads' of 'gripper'" in pads
    assert "at [0, 0, 140] mm" in tcp and "'tcp' of 'gripper'" in tcp
    assert "0.0 to 70.0 mm" in stroke and "'opening' of 'gripper'" in stroke
    stated = arm_with(HandFile(str(LINKED), pads=("left_tip", "right_finger"), tcp="pinch", opening=(0.01, 0.06)))
    assert not any("taken to be" in note for note in stated.notes)


def test_a_mounted_hand_is_where_it_is_said() -> None:
    turned = Pose.from_rotvec((0.0, 0.0, 0.02), (0.0, 0.0, 0.5))
    tcp = arm_with(HandFile(str(LINKED), at=turned)).robot.gripper.tcp
    assert tcp.position[2] == pytest.approx(0.16, abs=1e-3)
    assert abs(float(np.dot(tcp.rotate((0.0, 1.0, 0.0)), turned.rotate((0.0, 1.0, 0.0))))) == pytest.approx(1.0)


def with_hand(tmp_path: Path) -> Path:
    """An arm of seven joints whose file has a hand of two slides behind its last link."""
    fingers = "".join(
        f'<body name="finger{k}" pos="0 {s * 0.004} 0.1"><joint name="f{k}" type="slide" axis="0 {s} 0" range="0 0.03"/>'
        f'<geom type="box" size="0.01 0.004 0.02" mass="0.05"/></body>'
        for k, s in ((1, 1), (2, -1))
    )
    hand = f'<body name="hand" pos="0 0 0.12"><geom type="box" size="0.02 0.05 0.03" pos="0 0 0.03" mass="0.4"/>{fingers}</body>'
    drive = (
        '<equality><joint joint1="f1" joint2="f2"/></equality><actuator><position name="grip" joint="f1" kp="4000" kv="80"'
        ' ctrlrange="0 0.03" forcerange="-60 60"/></actuator>'
    )
    text = (DATA / "seven.xml").read_text().replace('<site name="attachment_site"', hand + '<site name="attachment_site"')
    path = tmp_path / "both.xml"
    path.write_text(re.sub(r"<keyframe>.*</keyframe>", "", text, flags=re.DOTALL).replace("</mujoco>", drive + "</mujoco>"))
    return path


SEVEN = Stated(3.0, sensor="flange", torques=(87.0,) * 4 + (12.0,) * 3, home=(0.0, -0.7854, 0.0, -2.3562, 0.0, 1.5708, 0.0))


def test_a_hand_in_the_arms_own_file(tmp_path: Path) -> None:
    read = read_robot(with_hand(tmp_path), "mine", replace(SEVEN, gripper=HandFile()))
    hand = read.robot.gripper
    check_robot(read.robot)
    assert hand.opening == pytest.approx((0.0, 0.06), abs=1e-3)
    assert hand.force[1] == pytest.approx(30.0, rel=0.05)
    ours = mujoco.MjModel.from_xml_string(read.robot.mjcf())
    data = mujoco.MjData(ours)
    data.qpos[:7] = read.robot.home
    mujoco.mj_kinematics(ours, data)
    theirs = mujoco.MjModel.from_xml_path(str(with_hand(tmp_path)))
    there = mujoco.MjData(theirs)
    there.qpos[:7] = SEVEN.home
    mujoco.mj_kinematics(theirs, there)
    base = there.body("stand").xpos
    place = data.body("gripper/hand").xpos - data.body("base_link").xpos
    assert place == pytest.approx(there.body("hand").xpos - base, abs=1e-4)


HAND = LINKED.read_text()
STILL = re.sub(r'<joint (name="(left|right)_\w+"|axis)[^>]*/>|<equality>.*</actuator>', "", HAND, flags=re.DOTALL)
FINGER = (
    '<body name="f{0}" pos="{1} {2} 0.1"><joint name="f{0}" type="slide" axis="{1} {2} 0" range="0 0.03"/>'
    '<geom type="box" size="0.01 0.01 0.02" mass="0.05"/></body>'
)
ROUND = "".join(FINGER.format(k, round(0.015 * np.cos(k * 2.0944), 5), round(0.015 * np.sin(k * 2.0944), 5)) for k in range(3))
THREE = (
    f'<mujoco><worldbody><body><geom type="box" size="0.05 0.05 0.02" mass="0.5"/>{ROUND}</body></worldbody><equality>'
    '<joint joint1="f0" joint2="f1"/><joint joint1="f0" joint2="f2"/></equality>'
    '<actuator><position joint="f0" kp="4000" kv="80" ctrlrange="0 0.03"/></actuator></mujoco>'
)
DRIVES = '<position name="d{0}" joint="{0}" kp="1" ctrlrange="0 1"/>'
MANY = HAND.replace("</actuator>", "".join(DRIVES.format(j) for j in ("left_driver", "right_driver")) + "</actuator>")
BAD: dict[str, tuple[str, HandFile, str]] = {
    "no joints": (STILL, HandFile(), "the hand has no joint"),
    "three drives": (MANY, HandFile(), "3 drives move the hand"),
    "fingers that do not meet": (HAND.replace('range="0 0.78"', 'range="0 0.02"').replace('ctrlrange="0 0.78"', 'ctrlrange="0 0.02"'),
                                 HandFile(), "no two fingers of the hand come nearer"),
    "three fingers": (THREE, HandFile(), "do not close along one line"),
    "no order": (HAND.replace(' ctrlrange="0 0.78"', ""), HandFile(), "'ctrlrange'"),
    "pads of another hand": (HAND, HandFile(pads=("left_tip", "right_pad")), "'pads' names 'right_pad'"),
    "a point of another hand": (HAND, HandFile(tcp="grip_site"), "'tcp' names 'grip_site'"),
    "wider than it opens": (HAND, HandFile(opening=(0.0, 0.2)), "'opening' of 0 to 200 mm is not within"),
    "no force": (HAND, HandFile(force=(20.0, 10.0)), "the lower one first"),
    "not a number": (HAND.replace('pos="0 0.02 0.06"', 'pos="0 nan 0.06"'), HandFile(), "finite|nan"),
    "broken XML": (HAND.replace("</worldbody>", ""), HandFile(), "correct the XML"),
    "millimetres": (re.sub(r'pos="0 (-?[\d.]+) (0\.\d+)"', lambda m: f'pos="0 {float(m[1]) * 1000} {float(m[2]) * 1000}"', HAND),
                    HandFile(), "metres"),
}  # fmt: skip


@pytest.mark.parametrize("kind", BAD)
def test_bad_hands_are_refused_in_one_paragraph(kind: str, tmp_path: Path) -> None:
    text, stated, said = BAD[kind]
    path = tmp_path / "hand.xml"
    path.write_text(text)
    with pytest.raises(UserError, match=said) as refused:
        arm_with(replace(stated, path=str(path)))
    assert "hand.xml" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_an_arm_without_a_hand_says_so() -> None:
    with pytest.raises(UserError, match="nothing moves behind the arm's last joint"):
        arm_with(HandFile())
    with pytest.raises(UserError, match=r"no gripper file 'nowhere\.xml'"):
        arm_with(HandFile("nowhere.xml"))


def test_a_hand_that_is_too_heavy_is_refused() -> None:
    with pytest.raises(UserError, match=r"payload of 0\.5 kg does not carry the gripper 'linked_hand\.xml' of 0\.54 kg"):
        read_robot(SIX, "mine", replace(ARM, payload=0.5, gripper=HandFile(str(LINKED))))

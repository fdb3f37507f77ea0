"""Scenes that other programs wrote: what becomes of an MJCF and a URDF, and how bad ones are refused."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Engine
from cramlite.model import ImportedScene, World
from cramlite.plugin import UserError
from cramlite_plugins.imports.scenes.reader import read_scene
from cramlite_plugins.simulation.model.compile import compile_world

DATA = Path(__file__).with_name("scenes_data")


def _read(path: Path) -> ImportedScene:
    scene = read_scene(path, {}, "", {})
    assert scene is not None
    return scene


def _scene(tmp_path: Path, body: str, rest: str = "") -> ImportedScene:
    path = tmp_path / "scene.xml"
    path.write_text(f"<mujoco>{rest}<worldbody>{body}</worldbody></mujoco>")
    return _read(path)


@pytest.fixture(scope="module")
def kitchen() -> ImportedScene:
    return _read(DATA / "kitchen.xml")


def test_bodies_become_what_they_can_do(kitchen: ImportedScene) -> None:
    things = {t.name: t for t in kitchen.things}
    assert [t.name for t in kitchen.things if t.mass is None] == ["kitchen_counter", "floor"]
    assert things["drawer_1"].joint is not None and things["drawer_1"].joint.kind == "slide"
    assert things["red_box"].mass == pytest.approx(0.15) and things["red_box"].joint is None
    assert any("purely visual" in n for n in kitchen.notes)


def test_features_are_found_in_the_geometry(kitchen: ImportedScene) -> None:
    things = {t.name: t for t in kitchen.things}
    handle = things["drawer_1"].feature("cram:Handle")
    assert handle is not None and handle.pose.position == pytest.approx((-0.213, 0, 0), abs=1e-6)
    assert handle.size == {"radius": 0.006, "length": 0.1}
    assert handle.pose.rotate((0, 0, 1)) == pytest.approx((-1, 0, 0), abs=1e-9)
    drawer, bowl = (things[n].feature("cram:Cavity") for n in ("drawer_1", "akita_white_bowl_1"))
    assert drawer is not None and drawer.size == pytest.approx({"width": 0.253, "depth": 0.306, "height": 0.054}, abs=0.006)
    assert bowl is not None and bowl.pose.position == pytest.approx((0, 0, 0.06), abs=1e-3)
    assert things["red_box"].feature("cram:Cavity") is None and things["kitchen_counter"].feature("cram:Cavity") is None
    top = things["kitchen_counter"].feature("vrps:SurfaceFeature")
    assert top is not None and top.size == {"width": 0.3, "depth": 0.4}


def test_a_plate_without_anything_that_sticks_out_has_no_handle(tmp_path: Path) -> None:
    plate = '<geom type="box" size=".2 .01 .2"/><joint type="hinge" axis="0 0 1" pos="-.2 0 0" range="0 90"/>'
    scene = _scene(tmp_path, f'<body name="door">{plate}</body>')
    assert scene.things[0].feature("cram:Handle") is None
    assert "no handle was found" in scene.found["door"]


def test_a_door_of_a_urdf_has_its_knob_and_packages_are_found() -> None:
    scene = _read(DATA / "cabinet.urdf")
    things = {t.name: t for t in scene.things}
    handle = things["door_panel"].feature("cram:Handle")
    assert handle is not None and "named 'door_knob'" in scene.found["door_panel"]
    assert handle.pose.rotate((0, 0, 1)) == pytest.approx((-1, 0, 0), abs=1e-9)
    assert things["wedge"].mass == pytest.approx(0.2)
    assert things["wedge"].pose.position == pytest.approx((-0.12, 0, 0.215))


def test_a_lever_is_held_by_its_bar_not_by_the_post_that_carries_it(tmp_path: Path) -> None:
    """The post comes farther out of the door than the bar in front of it."""
    panel = '<geom type="box" size=".22 .02 .29"/><joint type="hinge" axis="0 0 1" pos=".255 0 0" range="0 23"/>'
    post = '<geom name="handle_base" type="cylinder" size=".025 .0625" pos="-.175 -.0625 0" euler="90 0 0"/>'
    lever = '<geom name="handle" type="box" size=".075 .015 .02" pos="-.1 -.1 0"/>'
    handle = _scene(tmp_path, f'<body name="door">{panel}{post}{lever}</body>').things[0].feature("cram:Handle")
    assert handle is not None and handle.pose.position == pytest.approx((-0.1, -0.1, 0)) and handle.size == {"radius": 0.02, "length": 0.15}
    knob = _scene(tmp_path, f'<body name="door">{panel}{post}</body>').things[0].feature("cram:Handle")
    assert knob is not None and knob.size["radius"] == 0.025  # a post alone is a knob


def test_contact_parameters_and_options_stay_the_files(tmp_path: Path) -> None:
    body = '<body name="box"><freejoint/><geom size=".1" condim="6" solref=".01 2" friction=".3 .02 .003" priority="2"/></body>'
    scene = _scene(tmp_path, body, '<option timestep="0.001" impratio="3"/>')
    assert scene.physics == {"timestep": 0.001, "impratio": 3.0}
    assert not [n for n in scene.notes if "impratio" in n]  # a note is about what was not taken over
    model = compile_world(World(scene.things), {}).model
    assert model.geom_condim[0] == 6 and model.geom_priority[0] == 2
    assert model.geom_friction[0] == pytest.approx((0.3, 0.02, 0.003)) and model.geom_solref[0] == pytest.approx((0.01, 2))


def test_a_joint_that_is_closed_above_is_turned_round(tmp_path: Path) -> None:
    body = '<geom type="box" size=".1 .1 .1"/><joint name="j" type="slide" axis="1 0 0" range="-0.2 0"/>'
    scene = _scene(tmp_path, f'<body name="drawer">{body}</body>')
    joint = scene.things[0].joint
    assert joint is not None and (joint.lower, joint.upper, joint.value) == (0, 0.2, 0)
    assert joint.pose.rotate((0, 0, 1)) == pytest.approx((-1, 0, 0))
    assert any("turned round" in n for n in scene.things[0].notes)


@pytest.mark.parametrize(("exclude", "meets"), [("", True), ('<contact><exclude body1="cabinet" body2="drawer"/></contact>', False)])
def test_a_drawer_is_mounted_in_its_cabinet_whether_they_collide_or_not(tmp_path: Path, exclude: str, meets: bool) -> None:
    slide = '<joint type="slide" axis="1 0 0" range="0 0.2"/><geom type="box" size=".1 .1 .04"/>'
    walls = "".join(f'<geom type="box" size=".1 .01 .1" pos="0 {y} 0"/>' for y in (-0.12, 0.12))
    scene = _scene(tmp_path, f'<body name="cabinet">{walls}<body name="drawer">{slide}</body></body>', exclude)
    joint = next(t.joint for t in scene.things if t.name == "drawer")
    assert joint is not None and (joint.parent, joint.meets) == ("cabinet", meets)
    assert compile_world(World(scene.things), {}).model.nexclude == (not meets)


@pytest.mark.parametrize(("bits", "meets"), [('contype="0"', False), ("", True)])
def test_a_door_meets_its_frame_where_the_bits_of_both_let_it(tmp_path: Path, bits: str, meets: bool) -> None:
    """Shapes that are met by hands alone: a microwave of LIBERO, whose door is 1 mm beside its frame, with a margin of 1 mm."""
    hinge = '<joint type="hinge" axis="0 0 1" pos="-.1 0 0" range="0 2"/>'
    frame, panel = f'<geom type="box" size=".02 .02 .1" pos=".121 0 0" {bits}/>', f'<geom type="box" size=".1 .01 .1" {bits}/>'
    scene = _scene(tmp_path, f'<body name="oven">{frame}<body name="door">{hinge}{panel}</body></body>')
    joint = next(t.joint for t in scene.things if t.name == "door")
    assert joint is not None and (joint.parent, joint.meets) == ("oven", meets)


LEVER = (
    '<joint name="turn" type="hinge" axis="0 1 0" range="-90 90" stiffness="1"/><geom type="cylinder" size=".02 .05" euler="90 0 0"/>'
    '<geom name="handle" type="box" size=".07 .01 .015" pos=".07 -.06 0"/>'
)


def _with_lever(tmp_path: Path, joint: str) -> ImportedScene:
    panel = f'{joint}<geom type="box" size=".2 .02 .3"/><body name="lever" pos="-.1 0 0">{LEVER}</body>'
    post = '<geom type="box" size=".02 .03 .3" pos=".25 0 0"/>'
    return _scene(tmp_path, f'<body name="frame">{post}<body name="door" pos="0 0 .1">{panel}</body></body>')


def test_a_lever_on_a_door_moves_along_with_it_and_keeps_its_spring(tmp_path: Path) -> None:
    scene = _with_lever(tmp_path, '<joint type="hinge" axis="0 0 1" pos=".2 0 0" range="0 60"/>')
    door, lever = (next(t for t in scene.things if t.name == name) for name in ("door", "lever"))
    assert door.joint is not None and lever.joint is not None
    assert (door.joint.parent, lever.joint.parent, lever.type) == ("frame", "door", "cram:Latch")
    assert (lever.joint.spring, lever.joint.rest) == (1.0, 0.0)
    assert (lever.joint.lower, lever.joint.upper) == pytest.approx((-math.pi / 2, math.pi / 2))
    assert door.feature("cram:Handle") is None and lever.feature("cram:Handle") is not None
    compiled = compile_world(World(scene.things), {})
    data = compiled.data()
    before = compiled.pose(data, "lever")
    data.qpos[compiled.things["door"].joint] = 0.5
    mujoco.mj_kinematics(compiled.model, data)
    assert before.distance(compiled.pose(data, "lever"))[1] == pytest.approx(0.5)


def test_a_lever_on_what_can_be_carried_is_held_where_it_starts(tmp_path: Path) -> None:
    lever = f'<body name="lever" pos="-.1 0 0">{LEVER}</body>'
    scene = _scene(tmp_path, f'<body name="box"><freejoint/><geom type="box" size=".2 .02 .3"/>{lever}</body>')
    assert [t.name for t in scene.things] == ["box"]
    assert any("'lever' is on a joint of a body that can be carried" in n for n in scene.notes)


def test_what_cannot_be_taken_over_is_said(tmp_path: Path) -> None:
    ball = '<body name="globe"><joint type="ball"/><geom size=".1"/></body>'
    two = '<body name="xy" pos="1 0 0"><joint type="slide"/><joint type="slide" axis="1 0 0"/><geom size=".1"/></body>'
    free = '<body name="1 cup" pos="2 0 0"><freejoint/><geom name="g" size=".1" margin=".01"/></body>'
    rest = '<option gravity="0 0 -1"/><keyframe><key name="start"/></keyframe>'
    scene = _scene(tmp_path, ball + two + free, rest)
    said = "; ".join(scene.notes)
    parts = ("'globe' has a ball joint", "'xy' has 2 joints", "'1 cup' is called 'thing_1_cup'", "gravity", "keyframes: 'start'")
    assert [p for p in parts if p not in said] == []
    assert [t.mass is None for t in scene.things if t.name in ("globe", "xy")] == [True, True]


def test_an_arm_is_recognised_and_left_out(tmp_path: Path) -> None:
    arm = ""
    for k in range(5, 0, -1):
        arm = f'<body name="link{k}" pos="0 0 .1"><joint name="j{k}"/><geom size=".03"/>{arm}</body>'
    base = f'<body name="arm_base"><geom size=".1"/>{arm}</body><geom name="ground" type="plane" size="1 1 .1"/>'
    scene = _scene(tmp_path, base, '<actuator/>')
    assert [t.name for t in scene.things] == ["ground"]
    assert any("'arm_base' is a robot (5 joints in a row)" in n for n in scene.notes)


def test_a_keyframe_is_where_it_starts(tmp_path: Path) -> None:
    path = tmp_path / "scene.xml"
    body = '<body name="ball" pos="0 0 1"><freejoint/><geom size=".1"/></body>'
    path.write_text(f'<mujoco><worldbody>{body}</worldbody><keyframe><key name="low" qpos="1 2 3 1 0 0 0"/></keyframe></mujoco>')
    scene = read_scene(path, {}, "low", {})
    assert scene is not None and scene.things[0].pose.position == (1, 2, 3)
    with pytest.raises(UserError, match=r"scene.xml:1: there is no keyframe 'lower'; did you mean 'low'"):
        read_scene(path, {}, "lower", {})


FAR = '<mujoco><worldbody>\n<body name="b" pos="{} 0 0"><geom size=".1"/></body></worldbody></mujoco>'
BAD = {
    "broken XML": ("<mujoco>\n<worldbody>\n<geom>\n</worldbody></mujoco>", r"scene.xml:[34]: .*correct the XML"),
    "missing mesh": ('<mujoco>\n<asset>\n<mesh name="a" file="no.stl"/></asset><worldbody/></mujoco>', r"scene.xml:3: .*'no.stl'"),
    "missing include": ('<mujoco>\n<include file="no.xml"/></mujoco>', r"scene.xml:2: .*'no.xml'"),
    "cyclic include": ('<mujoco>\n<include file="scene.xml"/></mujoco>', r"scene.xml:\d+: .*includes itself"),
    "no mass": ('<mujoco><worldbody>\n<body name="b"><freejoint/></body></worldbody></mujoco>', r"scene.xml:2: .*give the body a mass"),
    "no number": (FAR.format("nan"), r"scene.xml:2: body 'b'.*finite"),
    "millimetres": (FAR.format("600"), r"scene.xml:2: .*millimetres"),
    "nothing": ("<mujoco/>", r"scene.xml:1: the scene has no thing"),
    "another language": ("<sdf/>", r"scene.xml:1: a scene begins with <mujoco>"),
    "package": (
        '<robot name="r">\n<link name="a"><collision><geometry>\n<mesh filename="package://far/a.stl"/></geometry></collision></link></robot>',
        r"scene.xml:3: the package 'far' is in no folder",
    ),
    "y up": (
        '<mujoco><option gravity="0 -9.81 0"/><worldbody><geom size=".1"/></worldbody></mujoco>', r"scene.xml:1: gravity is .0, -9.81, 0.",
    ),
    "gravity without end": (
        '<mujoco><option gravity="0 0 -1e300"/><worldbody><geom size=".1"/></worldbody></mujoco>',
        r"scene.xml:1: gravity is .0, 0, -1e.300. m/s2; it must be at most 100",
    ),
    "a shape of kilometres": (
        '<mujoco><worldbody>\n<body name="b" pos="0 0 1"><geom name="big" size="1e5"/></body></worldbody></mujoco>',
        r"scene.xml:2: the shape 'big' of body 'b' reaches 100000 m; up to 100 m",
    ),
    "a plane of light years": (
        '<mujoco><worldbody><geom name="floor" type="plane" size="1e300 1 1"/></worldbody></mujoco>', r"'floor' of body 'world' .*1e.06 m",
    ),
    "xacro": ('<robot name="r">\n<!-- ${a} -->\n<xacro:include filename="b.xacro"/></robot>', r"scene.xml:3: this is xacro"),
    "xacro's values": ('<robot name="r">\n<link name="${a}"/></robot>', r"scene.xml:2: this is xacro"),
    "two roots": ('<robot name="r">\n<link name="a"/>\n<link name="b"/></robot>', r"scene.xml:3: a URDF has one root link"),
}  # fmt: skip


@pytest.mark.parametrize("kind", BAD)
def test_bad_files_are_refused_with_file_and_line(kind: str, tmp_path: Path) -> None:
    text, said = BAD[kind]
    path = tmp_path / "scene.xml"
    path.write_text(text)
    with pytest.raises(UserError, match=said) as refused:
        Engine().registry.first("read_scene", path=path, packages={}, keyframe="", joints={})
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("scale", ["1e300", "-1e300", "1e30"])
def test_a_mesh_scaled_without_end_is_refused(scale: str, tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "c.stl")
    mesh = f'<collision><geometry>\n<mesh filename="c.stl" scale="{scale} {scale} {scale}"/></geometry></collision>'
    (tmp_path / "scene.urdf").write_text(f'<robot name="r"><link name="box">{mesh}</link></robot>')
    with pytest.raises(UserError, match=r"scene.urdf:\d+: the shape of body 'box' (reaches|is of no)"):
        read_scene(tmp_path / "scene.urdf", {}, "", {})


ROOM = '<body name="room">{}<body name="counter" pos=".5 0 .2"><geom type="box" size=".3 .5 .02"/></body>{}</body>'
SHELF = '<body name="shelf" pos=".8 0 .6"><geom type="box" size=".1 .5 .02"/></body>'
LEGS = '<body name="leg" pos=".5 0 .1"><geom type="box" size=".02 .02 .08"/></body>'
SITE = '<site name="middle" pos="0 0 1"/>'
JOINTED = '<body name="flap" pos=".5 .8 .2"><joint type="hinge" axis="1 0 0" range="0 1"/><geom type="box" size=".1 .1 .01"/></body>'


@pytest.mark.parametrize(
    ("body", "names"),
    [
        (ROOM.format("", SHELF), {"counter", "shelf"}),
        (ROOM.format("", SHELF + JOINTED), {"counter", "shelf", "flap"}),
        (ROOM.format("", LEGS), {"room"}),
        (ROOM.format(SITE, SHELF), {"room"}),
        (ROOM.format('<geom type="box" size=".05 .05 .05"/>', SHELF), {"room"}),
    ],
)
def test_a_room_of_bodies_is_not_one_thing_and_a_table_is(body: str, names: set[str], tmp_path: Path) -> None:
    assert {t.name for t in _scene(tmp_path, body).things} == names


def test_a_height_field_is_said_to_be_left_out(tmp_path: Path) -> None:
    field = '<asset><hfield name="h" nrow="4" ncol="4" size="1 1 .1 .1"/></asset>'
    scene = _scene(tmp_path, '<geom name="ground" type="hfield" hfield="h"/><geom type="box" size=".1 .1 .1"/>', field)
    assert any("'ground' has no shape that things can have" in n for n in scene.notes)


@pytest.mark.parametrize("mesh", ["package://far/a.dae", "a.dae", "no.stl"])
def test_pictures_of_a_urdf_that_cannot_be_read_are_left_out(mesh: str, tmp_path: Path) -> None:
    (tmp_path / "a.dae").write_text("<COLLADA/>")
    looks = f'<visual>\n<geometry><mesh filename="{mesh}"/></geometry></visual>'
    solid = '<collision><geometry><box size=".1 .1 .1"/></geometry></collision>'
    (tmp_path / "scene.urdf").write_text(f'<robot name="r">\n<link name="table">{looks}{solid}</link></robot>')
    scene = read_scene(tmp_path / "scene.urdf", {}, "", {})
    assert scene is not None and [t.name for t in scene.things] == ["table"]
    (tmp_path / "scene.urdf").write_text(f'<robot name="r">\n<link name="table">{looks.replace("visual", "collision")}</link></robot>')
    with pytest.raises(UserError, match=r"scene.urdf:3: "):
        read_scene(tmp_path / "scene.urdf", {}, "", {})


def test_other_files_are_left_to_others(tmp_path: Path) -> None:
    shutil.copy(DATA / "kitchen.xml", tmp_path / "kitchen.usd")
    assert read_scene(tmp_path / "kitchen.usd", {}, "", {}) is None


# The same as MuJoCo's own

SIZES = st.floats(0.02, 0.2)
NUMBERS = st.floats(0.1, 2.0)


@st.composite
def _bodies(draw: st.DrawFn) -> str:
    """Free and fixed bodies of one to three primitives, some of which meet."""
    text = ""
    for k in range(draw(st.integers(1, 4))):
        at = " ".join(f"{draw(st.floats(-0.2, 0.2)):.3f}" for _ in range(3))
        turn = " ".join(f"{draw(st.floats(-180, 180)):.1f}" for _ in range(3))
        geoms = ""
        for _ in range(draw(st.integers(1, 3))):
            shape = draw(st.sampled_from(["box", "sphere", "capsule", "cylinder"]))
            size, off = (" ".join(f"{draw(SIZES):.3f}" for _ in range(3)) for _ in range(2))
            parameters = f'condim="{draw(st.sampled_from([1, 3, 4, 6]))}" priority="{draw(st.integers(0, 1))}"'
            friction, solref = f"{draw(NUMBERS):.2f} 0.01 0.001", f"{0.01 * draw(NUMBERS):.4f} 1"
            geoms += f'<geom type="{shape}" size="{size}" pos="{off}" {parameters} friction="{friction}" solref="{solref}"/>'
        free = "<freejoint/>" if k == 0 or draw(st.booleans()) else ""
        text += f'<body name="b{k}" pos="{at}" euler="{turn}">{free}{geoms}</body>'
    return text


def _contacts(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Bodies, position, depth, dimensions and parameters of each contact, in an order of their own."""
    rows = []
    for c in data.contact:
        names = sorted(model.body(int(model.geom_bodyid[g])).name for g in c.geom)
        rows.append([*(int(n[1:]) for n in names), c.dist, *c.pos, c.dim, *c.friction, *c.solref])
    found = np.array(rows)
    return found[np.lexsort(np.round(found, 6).T[::-1])] if rows else found


def _worlds_inertia(model: mujoco.MjModel, data: mujoco.MjData, body: str) -> np.ndarray:
    turn = data.body(body).ximat.reshape(3, 3)
    return np.asarray(turn @ np.diag(model.body(body).inertia) @ turn.T)


@examples(40)
@given(_bodies())
def test_primitives_have_the_masses_poses_and_contacts_of_mujocos_own_model(tmp_path_factory: pytest.TempPathFactory, body: str) -> None:
    path = tmp_path_factory.mktemp("scene") / "scene.xml"
    path.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    theirs = mujoco.MjModel.from_xml_path(str(path))
    state = mujoco.MjData(theirs)
    mujoco.mj_forward(theirs, state)
    compiled = compile_world(World(_read(path).things), {})
    data = compiled.data()
    for k in range(1, theirs.nbody):
        name = theirs.body(k).name
        assert data.body(name).xpos == pytest.approx(state.body(name).xpos, abs=1e-9)
        assert abs(data.body(name).xquat @ state.body(name).xquat) == pytest.approx(1.0, abs=1e-9)
        if theirs.body(k).jntnum:
            assert compiled.model.body(name).mass == pytest.approx(theirs.body(name).mass, rel=1e-9)
            assert data.body(name).xipos == pytest.approx(state.body(name).xipos, abs=1e-7)
            wanted = _worlds_inertia(theirs, state, name)
            assert _worlds_inertia(compiled.model, data, name) == pytest.approx(wanted, rel=1e-5, abs=1e-9)
    ours, wanted = _contacts(compiled.model, data), _contacts(theirs, state)
    assert ours.shape == wanted.shape
    assert ours == pytest.approx(wanted, abs=1e-5)

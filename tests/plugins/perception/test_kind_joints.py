"""Kinds with joints: recognised with a drawer or a door where it is, and believed so."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.as_a_user import cramlite

from cramlite import Engine
from cramlite.model import Camera, Geom, Intrinsics, Joint, KindJoint, MeshFile, Pose, Thing, View, World, replace
from cramlite.perception.active_perception import ask
from cramlite.perception.query import parse_query
from cramlite.perception.recognition import thing_from_percept
from cramlite.perception.result import Perceived
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.perception.kinds.joint_states import states_of
from cramlite_plugins.simulation.camera.depth_camera import look

CHEST = """<mujoco><worldbody><body name="chest">
  <geom type="box" size=".1 .09 .005" pos="0 0 .005" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".1 .09 .005" pos="0 0 .125" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".1 .005 .055" pos="0 .085 .065" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".1 .005 .055" pos="0 -.085 .065" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".005 .08 .055" pos="-.095 0 .065" rgba=".55 .35 .2 1"/>
  <body name="drawer"><joint name="slide" type="slide" axis="1 0 0" range="0 .16"/>
    <geom type="box" size=".005 .08 .053" pos=".1 0 .065" rgba=".2 .3 .7 1"/>
    <geom type="box" size=".085 .078 .003" pos="0 0 .015" rgba=".8 .75 .3 1"/>
    <geom type="box" size=".085 .003 .03" pos="0 .072 .045" rgba=".8 .75 .3 1"/>
    <geom type="box" size=".085 .003 .03" pos="0 -.072 .045" rgba=".8 .75 .3 1"/>
  </body></body></worldbody></mujoco>"""
CUBE = """<mujoco><worldbody><body name="cube"><freejoint/>
  <geom type="box" size=".02 .025 .03" rgba=".8 .15 .2 1" mass=".1"/></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    """An engine that knows a chest with a drawer, and a cube."""
    folder = tmp_path_factory.mktemp("chests")
    for name, text in (("chest", CHEST), ("cube", CUBE)):
        (folder / name).mkdir()
        (folder / name / f"{name}.xml").write_text(text)
    assert cramlite("library", "add", folder, "--out", folder / "lib", "--up", "z").returncode == 0
    return Engine(models=[folder / "lib"])


def chest(engine: Engine, opened: float) -> Thing:
    """A chest on the table, turned a little, its drawer open by so much [m]."""
    pose = Pose.from_rotvec((0.40, 0.02, 0.0), (0, 0, 0.2))
    return engine.knowledge.models["chest"].make(name="a_chest", pose=pose).at_joints({"slide": opened})


def pictured(*things: Thing) -> View:
    """A noisy picture of things on a table from 0.9 m away."""
    eye, target = np.array((1.1, 0.0, 0.65)), np.array((0.45, 0.0, 0.05))
    intrinsics = Intrinsics(450.0, 450.0, 199.5, 149.5, 400, 300)
    camera = Camera(Pose.from_axes(tuple(eye), target - eye, np.cross(target - eye, (0, 0, 1))), intrinsics=intrinsics)
    return look(World((make("table", "table", Pose((0.45, 0, 0)), {}), *things)), {}, camera, seed=1)


def perceived(engine: Engine, *things: Thing) -> Perceived:
    """What such a picture is taken for."""
    knowledge = engine.knowledge
    query = replace(parse_query("", knowledge.taxonomy, knowledge.experts), wanted=("type", "pose", "model", "instance"))
    return ask(query, pictured(*things), (), knowledge)


def seen(engine: Engine, found: Perceived, model: str) -> Thing:
    """The thing that is believed after a picture, of some kind."""
    (percept,) = (p for p in found.answers if p.value("model") == model)
    known = thing_from_percept(percept, engine.knowledge)
    assert known is not None
    return known[1]


@pytest.mark.parametrize("opened", [0.0, 0.11])
def test_a_drawer_is_seen_where_it_is(engine: Engine, opened: float) -> None:
    true = chest(engine, opened)
    found = seen(engine, perceived(engine, true), "chest")
    metres, turn = found.pose.distance(true.pose)
    assert metres < 0.005 and math.degrees(turn) < 3
    assert found.mesh is not None and found.mesh.joint_values["slide"] == pytest.approx(opened, abs=0.006)
    fronts = [found.pose.apply(found.geoms[5].pose.position), true.pose.apply(true.geoms[5].pose.position)]
    assert np.allclose(*fronts, atol=0.008), "the front stands there in the believed world"


def test_what_is_in_an_open_drawer_is_seen_in_it(engine: Engine) -> None:
    true = chest(engine, 0.15)
    cube = engine.knowledge.models["cube"].make(name="a_cube", pose=true.pose * Pose((0.16, 0.02, 0.049)))
    found = perceived(engine, true, cube)
    drawer, inside = seen(engine, found, "chest"), seen(engine, found, "cube")
    assert drawer.mesh is not None and drawer.mesh.joint_values["slide"] == pytest.approx(0.15, abs=0.006)
    assert inside.pose.distance(cube.pose)[0] < 0.006
    (percept,) = (p for p in found.answers if p.value("model") == "chest")
    ((name, value, doubt),) = percept.value("joints")
    assert name == "slide" and 0 < doubt < 0.02 and abs(value - 0.15) < 3 * doubt


def test_a_kind_is_looked_for_in_states_between_the_ends_of_its_joints(engine: Engine) -> None:
    states = states_of(chest(engine, 0.0))
    values = [s.mesh.joint_values["slide"] for s in states if s.mesh is not None]
    assert np.allclose(values, [0.0, 0.08, 0.16])
    cube = engine.knowledge.models["cube"].make(name="a_cube", pose=Pose())
    assert states_of(cube) == [cube]


def test_a_joint_carries_the_joints_behind_it_and_goes_back() -> None:
    door, lever = Joint("hinge", Pose(), 0.0, 1.6), Joint("hinge", Pose((0.4, 0.0, 0.0)), 0.0, 1.6)
    joints = (KindJoint("door", door, geoms=(0, 1)), KindJoint("lever", lever, geoms=(1,)))
    geoms = (Geom("sphere", (0.01,), Pose((0.2, 0.0, 0.0))), Geom("sphere", (0.01,), Pose((0.5, 0.0, 0.0))))
    closed = Thing("cupboard", "soma:Cupboard", Pose(), geoms, mesh=MeshFile("cupboard.glb", joints=joints))
    opened = closed.at_joints({"door": math.pi / 2, "lever": math.pi / 2})
    assert np.allclose([g.pose.position for g in opened.geoms], [(0.0, 0.2, 0.0), (-0.1, 0.4, 0.0)])
    back = opened.at_joints({"lever": 0.0}).at_joints({"door": 0.0})
    assert np.allclose([g.pose.position for g in back.geoms], [g.pose.position for g in geoms])

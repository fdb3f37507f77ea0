"""Kinds with joints: recognised with a drawer or a door where it is, and believed so."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.chest import chest, engine_with_chest, pictured

from cramlite import Engine
from cramlite.model import Geom, Joint, KindJoint, MeshFile, Pose, Thing, replace
from cramlite.perception.active_perception import ask
from cramlite.perception.query import parse_query
from cramlite.perception.recognition import levelled, thing_from_percept
from cramlite.perception.result import Perceived
from cramlite_plugins.perception.kinds.appearance import appearance_of
from cramlite_plugins.perception.kinds.joint_search import shut_together
from cramlite_plugins.perception.kinds.joint_states import states_of
from cramlite_plugins.shapes.skins import skin_of


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    """An engine that knows a chest with a drawer, and a cube."""
    return engine_with_chest(tmp_path_factory.mktemp("chests"))


def perceived(engine: Engine, *things: Thing) -> Perceived:
    """What such a picture is taken for."""
    knowledge = engine.knowledge
    query = replace(parse_query("", knowledge.taxonomy, knowledge.experts), wanted=("type", "pose", "model", "instance"))
    return ask(query, pictured(*things), (), knowledge)


def seen(engine: Engine, found: Perceived, model: str) -> Thing:
    """The thing that is believed after a picture, of some kind."""
    (percept,) = (p for p in found.answers if p.value("model") == model)
    known = thing_from_percept(percept, engine.knowledge.products)
    assert known is not None
    return known


@pytest.mark.parametrize("opened", [0.0, 0.11])
def test_a_drawer_is_seen_where_it_is(engine: Engine, opened: float) -> None:
    true = chest(engine, opened)
    found = seen(engine, perceived(engine, true), "chest")
    metres, turn = found.pose.distance(true.pose)
    assert metres < 0.005 and math.degrees(turn) < 3
    assert found.mesh is not None and found.mesh.joint_values["slide"] == pytest.approx(opened, abs=0.006)
    believed, real = (t.pose.apply(t.geoms[5].pose.position) for t in (found, true))
    assert np.allclose(believed, real, atol=0.008), "the front stands there in the believed world"


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


def test_a_kind_with_joints_comes_into_a_scene_as_its_parts(engine: Engine) -> None:
    true = chest(engine, 0.1)
    body, drawer = true.as_parts()
    assert (body.name, drawer.name) == ("a_chest", "a_chest_drawer") and body.pose == true.pose
    assert drawer.joint is not None and drawer.joint.parent == "a_chest" and drawer.joint.value == pytest.approx(0.1)
    assert np.allclose(drawer.pose.position, true.pose.apply((0.1, 0.0, 0.0)))
    whole, parts = skin_of(true.mesh), [(t.pose, skin_of(t.mesh)) for t in (body, drawer)]
    assert whole is not None
    shown = np.concatenate([pose.apply(skin.corners.reshape(-1, 3)) for pose, skin in parts if skin is not None])
    assert len(shown) == whole.corners.size / 3, "the parts look like the whole"
    assert np.allclose(np.sort(shown, axis=0), np.sort(true.pose.apply(whole.corners.reshape(-1, 3)), axis=0), atol=1e-6)


def test_what_is_mounted_on_a_part_goes_with_it() -> None:
    door = Joint("hinge", Pose(), 0.0, 1.6, parent="cupboard")
    lever = Joint("hinge", Pose(), 0.0, 1.6, parent="door")
    of = (KindJoint("h", door, part="door"), KindJoint("l", replace(lever, pose=Pose((0.4, 0.0, 0.0))), part="lever"))
    parts = (Thing("cupboard", "soma:Cupboard", Pose(), ()), Thing("door", "soma:Door", Pose(), (), joint=door),
             Thing("lever", "cram:Latch", Pose((0.4, 0.0, 0.0)), (), joint=lever))  # fmt: skip
    whole = Thing("mine", "soma:Cupboard", Pose((1.0, 0.0, 0.0)), (), mesh=MeshFile("cupboard.glb", joints=of), parts=parts)
    _, opened, turned = whole.at_joints({"h": math.pi / 2, "l": 0.3}).as_parts()
    assert opened.joint is not None and opened.joint.value == pytest.approx(math.pi / 2)
    assert turned.joint is not None and turned.joint.parent == "mine_door" and turned.joint.value == pytest.approx(0.3)
    assert np.allclose(turned.pose.position, (1.0, 0.4, 0.0))


def test_furniture_stands_level_and_on_its_feet(engine: Engine) -> None:
    askew = Pose.from_rotvec((0.4, 0.0, 0.0), (0.0, 0.0, 0.7)) * Pose.from_rotvec((0, 0, 0), (0.02, 0.01, 0.0))
    level = levelled(askew)
    assert level.rotation[2, 2] == pytest.approx(1.0) and level.distance(askew)[1] == pytest.approx(0.0224, abs=1e-3)
    assert levelled(Pose.from_rotvec((0, 0, 0), (0.1, 0.0, 0.0))).rotation[2, 2] < 0.999, "what leans is left so"
    for symmetry in appearance_of(chest(engine, 0.0)).surface.symmetries:
        assert symmetry.rotation[2, 2] > 0.9


def test_a_joint_carries_the_joints_behind_it_and_goes_back() -> None:
    door, lever = Joint("hinge", Pose(), 0.0, 1.6), Joint("hinge", Pose((0.4, 0.0, 0.0)), 0.0, 1.6)
    joints = (KindJoint("door", door, geoms=(0, 1)), KindJoint("lever", lever, geoms=(1,)))
    geoms = (Geom("sphere", (0.01,), Pose((0.2, 0.0, 0.0))), Geom("sphere", (0.01,), Pose((0.5, 0.0, 0.0))))
    closed = Thing("cupboard", "soma:Cupboard", Pose(), geoms, mesh=MeshFile("cupboard.glb", joints=joints))
    opened = closed.at_joints({"door": math.pi / 2, "lever": math.pi / 2})
    assert np.allclose([g.pose.position for g in opened.geoms], [(0.0, 0.2, 0.0), (-0.1, 0.4, 0.0)])
    back = opened.at_joints({"lever": 0.0}).at_joints({"door": 0.0})
    assert np.allclose([g.pose.position for g in back.geoms], [g.pose.position for g in geoms])


def test_drawers_that_are_all_open_by_the_same_little_are_shut() -> None:
    """The whole was registered too far back: of three drawers one is open."""
    joints = tuple(KindJoint(n, Joint("slide", Pose(), 0.0, 0.16)) for n in ("top", "middle", "bottom"))
    mesh, pose = MeshFile("cabinet.glb", joints=joints), Pose.from_rotvec((0.6, 0.3, 0.0), (0, 0, math.pi))
    stand = shut_together(mesh, pose, (0.015, 0.016, 0.158), 0.024)
    assert stand is not None and np.allclose(stand.values, (0.0, 0.0, 0.1425))
    front = pose * joints[2].step(0.158)
    assert front.distance(stand.pose * joints[2].step(stand.values[2]))[0] < 1e-9, "the open one stays where it was seen"
    assert shut_together(mesh, pose, (0.0, 0.015, 0.158), 0.024) is None, "one alone may be ajar"
    assert shut_together(mesh, pose, (0.03, 0.03, 0.158), 0.024) is None

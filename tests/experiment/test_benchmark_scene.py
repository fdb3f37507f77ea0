"""Scenes of benchmarks whose file is read once, and whose things later stand where their poses are read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from msgspec import json
from msgspec.structs import replace

from cramlite import Engine, Setting
from cramlite.model import World
from cramlite.plugin import UserError
from cramlite_plugins.backends.stream.messages import Hello
from cramlite_plugins.benchmarks.benchmark_scene import SceneModel, scene_model, scene_setting

HELLO = Hello(protocol=1, robot="ur5e", actions="joints", rate=20, joints=(0.0, -1.5, 1.5, -1.5, -1.5, 0.0), opening=0.05, poses={})
SCENE = """<mujoco><worldbody>
  <body name="cabinet" pos="0.6 0 0.2">
    <geom type="box" size="0.2 0.01 0.2" pos="0 0.2 0"/><geom type="box" size="0.2 0.01 0.2" pos="0 -0.2 0"/>
    <body name="drawer" pos="0 0 0.05"><joint name="slide" type="slide" axis="-1 0 0" range="0 0.2"/>
      <geom type="box" size="0.19 0.15 0.05" mass="0.4"/></body></body>
  <body name="box" pos="0 0.6 0.03"><freejoint/><geom type="box" size="0.03 0.03 0.03" mass="0.1"/></body>
  <body name="can" pos="5 5 -2"><freejoint/><geom type="cylinder" size="0.03 0.05" mass="0.1"/></body>
</worldbody></mujoco>"""


def described(opened: float, box: tuple[float, float], shift: float, *, can: bool) -> dict[str, Any]:
    """What a benchmark says of the scene: a drawer that is open, a box, a cabinet that was shifted, and a can that may have come."""
    model = mujoco.MjModel.from_xml_string(SCENE)
    model.body("cabinet").pos[1] += shift
    data = mujoco.MjData(model)
    at = (0.3, 0.6, 0.05) if can else (5.0, 5.0, -2.0)
    data.qpos[:] = [opened, *box, 0.03, 1.0, 0.0, 0.0, 0.0, *at, 1.0, 0.0, 0.0, 0.0]
    mujoco.mj_forward(model, data)
    xml = SCENE.replace('pos="0.6 0 0.2"', f'pos="0.6 {shift} 0.2"')
    poses = {model.body(b).name: [*data.xpos[b], *data.xquat[b]] for b in range(1, model.nbody)}
    return {"xml": xml, "qpos": data.qpos.tolist(), "poses": poses, "absent": [] if can else ["can"]}


def model_of(scene: dict[str, Any], folder: Path) -> SceneModel:
    return scene_model(Engine(), folder, scene, HELLO, 0, robot={"type": "ur5e"})


def setting(model: SceneModel, scene: dict[str, Any], folder: Path) -> Setting:
    return scene_setting(Engine(), model, folder, scene, HELLO, lambda _: [], None)[1]


def assert_alike(one: World, other: World) -> None:
    assert [t.name for t in one.things] == [t.name for t in other.things]
    for a, b in zip(one.things, other.things, strict=True):
        assert np.allclose(a.pose.position, b.pose.position, atol=1e-6) and max(a.pose.distance(b.pose)) < 1e-6, a.name
        assert (a.joint is None) == (b.joint is None) and (a.joint is None or b.joint is None or abs(a.joint.value - b.joint.value) < 1e-6)


@pytest.mark.parametrize(("opened", "shift", "can"), [(0.12, 0.0, False), (0.0, 0.04, True), (0.07, -0.05, True)])
def test_poses_that_are_read_give_the_world_that_the_file_would(opened: float, shift: float, can: bool, tmp_path: Path) -> None:
    """A drawer slides, its cabinet is shifted, a box moves, and a can comes that was absent at first."""
    start = described(0.02, (0.0, 0.6), 0.0, can=False)
    model = model_of(start, tmp_path / "first")
    first = setting(model, {**start, "poses": {}}, tmp_path / "first").world
    assert "can" not in [t.name for t in first.things] and first.thing("drawer").joint.value == pytest.approx(0.02)  # type: ignore[union-attr]
    later = described(opened, (0.1, 0.5), shift, can=can)
    read = setting(model, later, tmp_path / "later").world
    anew = setting(model_of(later, tmp_path / "anew"), {**later, "poses": {}}, tmp_path / "anew").world
    assert_alike(read, anew)
    assert not (tmp_path / "later" / "scene.xml").exists()
    assert json.decode((tmp_path / "later" / "world.json").read_bytes(), type=World) == read
    assert abs(read.thing("box").pose.position[0] - first.thing("box").pose.position[0]) > 0.09


TABLE = """<mujoco><worldbody>
  <body name="table" pos="0.6 0 0.2"><geom type="box" size="0.3 0.3 0.2"/></body>
  <body name="bottle" pos="0.6 0 {z}" euler="0 90 0"><freejoint/><geom type="cylinder" size="0.03 0.08" mass="0.3"/></body>
</worldbody></mujoco>"""


def lying(inside: float, folder: Path) -> Setting:
    """Setting of a scene at rest in which a bottle lies some way inside a table, as soft contacts of a benchmark may let it."""
    xml = TABLE.format(z=0.43 - inside)
    scene = {"xml": xml, "qpos": mujoco.MjModel.from_xml_string(xml).qpos0.tolist()}
    model = scene_model(Engine(), folder, scene, replace(HELLO, poses=None), 0, robot={"type": "ur5e"})
    return setting(model, scene, folder)


@pytest.mark.parametrize(("inside", "moved"), [(0.004, 0.0), (0.017, 0.017)])
def test_a_thing_that_rests_inside_another_is_believed_on_it(inside: float, moved: float, tmp_path: Path) -> None:
    world = lying(inside, tmp_path).world
    assert world.thing("bottle").pose.position[2] - (0.43 - inside) == pytest.approx(moved, abs=0.004)
    assert any("perceived 17.0 mm inside 'table'" in note for note in world.notes) is (moved > 0)


def test_a_thing_too_far_inside_another_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="overlap by"):
        lying(0.1, tmp_path)

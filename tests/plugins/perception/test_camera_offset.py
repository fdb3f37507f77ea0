"""A camera that is off is found from the fixtures in its picture, said, and corrected; one that is where it should be is left alone."""

from __future__ import annotations

import json
import math
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from helpers import as_a_user
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Engine
from cramlite.cli.perceive import fixtures_of
from cramlite.engine.scenario_doubts import doubts
from cramlite.model import Camera, Geom, Pose, RobotMount, Thing, View, World
from cramlite.perception.calibration.recording import written
from cramlite.perception.camera_check import camera_offset, camera_warning
from cramlite.perception.own_body import own_depth
from cramlite.scenario.scenario import read_scenario
from cramlite.scenario.worlds import camera_of

EYE = Pose.from_axes((0.9, -0.5, 0.7), z=(-0.7, 0.45, -0.55), x=(0.45, 0.7, 0.0))
TABLE = Thing("table", "cram:Table", Pose((0.3, 0.0, -0.02)), (Geom("box", (0.5, 0.5, 0.02)),))
SHELF = Thing("shelf", "dul:PhysicalObject", Pose((0.2, 0.2, 0.15)), (Geom("box", (0.15, 0.05, 0.15)),))
LOOSE = Thing("loose", "dul:PhysicalObject", Pose((0.35, -0.1, 0.04)), (Geom("box", (0.04, 0.05, 0.04)),), mass=0.2)
SCENARIO = """scenario: a
tasks: [{task: LookingAt, Patient: tin}]
robot: {type: ur5e, at: {position: [-0.5, 0, 0]}}
things:
  - {name: table, model: table, with: {size: [1 m, 1 m, 40 mm]}, at: {position: [0.3, 0, 0]}}
  - {name: shelf, model: table, with: {size: [300 mm, 100 mm, 300 mm]}, at: {position: [0.2, 0.2, 300 mm]}}
  - {name: tin, model: block, at: {position: [0.35, -0.1, 30 mm]}}
"""


@lru_cache(maxsize=1)
def engine() -> Engine:
    return Engine()


@lru_cache(maxsize=4)
def picture(*things: Thing) -> View:
    knowledge = engine().knowledge
    return knowledge.simulator.look(World(things), knowledge.robots, Camera(EYE), seed=0)


def believed(view: View, off: Pose) -> View:
    """The same picture by a camera that is off: it is at ``off`` from where it is believed, in its own frame."""
    return replace(view, camera=view.camera * off.inverse())


def test_a_camera_that_is_where_it_should_be_is_left_alone() -> None:
    view = picture(TABLE, SHELF, LOOSE)
    offset, _ = camera_offset(view, (TABLE, SHELF), engine().knowledge)
    assert offset is not None and not offset.off and offset.shift < 0.002
    assert camera_warning(view, (TABLE, SHELF), engine().knowledge) == ""


@given(
    shift=st.tuples(*[st.floats(-0.011, 0.011)] * 3).filter(lambda v: math.hypot(*v) > 0.009),
    turn=st.tuples(*[st.floats(-0.008, 0.008)] * 3),
)
@examples(8)
def test_a_camera_that_is_off_is_found(shift: tuple[float, float, float], turn: tuple[float, float, float]) -> None:
    off, view = Pose.from_rotvec(shift, turn), picture(TABLE, SHELF, LOOSE)
    offset, _ = camera_offset(believed(view, off), (TABLE, SHELF), engine().knowledge)
    assert offset is not None
    position, angle = offset.camera.distance(view.camera)
    assert position < max(0.002, 3 * offset.position) and angle < max(0.002, 3 * offset.angle)
    assert offset.off == (offset.shift > 0.006)


def test_a_camera_that_is_off_is_said_with_numbers() -> None:
    view = believed(picture(TABLE, SHELF, LOOSE), Pose.from_rotvec((0.012, 0.0, -0.008), (0.0, 0.012, 0.0)))
    said = camera_warning(view, (TABLE, SHELF), engine().knowledge)
    assert "mm (+-" in said and "deg (+-" in said and "cramlite calibrate" in said


def test_a_table_alone_leaves_directions_open() -> None:
    view = believed(picture(TABLE), Pose((0.0, 0.0, 0.015)))
    wide = replace(TABLE, geoms=(Geom("box", (3.0, 3.0, 0.02)),))
    offset, reason = camera_offset(view, (wide,), engine().knowledge)
    assert offset is not None and offset.open >= 3 and "directions are undetermined" in reason
    assert offset.position > 0.01


def test_the_robot_tells_where_its_camera_is() -> None:
    mount, knowledge = RobotMount("robot", "ur5e", Pose((-0.3, 0.1, 0.0))), engine().knowledge
    world = World((LOOSE,), (mount,))
    view = knowledge.simulator.look(world, knowledge.robots, Camera(EYE), seed=0)
    view = believed(view, Pose.from_rotvec((0.008, 0.0, 0.006), (0.0, 0.01, 0.0)))
    offset, reason = camera_offset(view, (), knowledge, own_depth(world, Camera(view.camera), knowledge))
    assert offset is not None and offset.off, reason
    truth = np.array([[0.35, -0.1, 0.04], [0.2, 0.2, 0.15]])
    seen = [np.linalg.norm(eye.apply(EYE.inverse().apply(truth)) - truth, axis=1).max() for eye in (view.camera, offset.camera)]
    assert seen[0] > 0.008 and seen[1] < 0.0025
    elsewhere = replace(mount, joints=(1.0, -1.2, 1.2, -1.0, -1.6, 0.5))
    lost, reason = camera_offset(view, (), knowledge, own_depth(replace(world, robots=(elsewhere,)), Camera(view.camera), knowledge))
    assert lost is None and "robot" in reason


def test_no_fixtures_tell_nothing() -> None:
    far = replace(SHELF, pose=Pose((5.0, 5.0, 5.0)))
    offset, reason = camera_offset(picture(TABLE, SHELF, LOOSE), (far,), engine().knowledge)
    assert offset is None and "near fixtures" in reason


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A scenario, and a recording by a camera that is 12 mm and .7 deg from where the recording says."""
    folder = tmp_path_factory.mktemp("cell")
    (folder / "a.yaml").write_text(SCENARIO)
    view = picture.__wrapped__(*fixtures_of(str(folder / "a.yaml"), engine().knowledge, 0), LOOSE)
    off = view.camera * Pose.from_rotvec((0.012, 0.0, 0.0), (0.0, 0.012, 0.0)).inverse()
    k = view.intrinsics
    said = {"fx": k.fx, "fy": k.fy, "cx": k.cx, "cy": k.cy, "width": k.width, "height": k.height}
    said |= {"camera": {"position": off.position, "quaternion": off.quaternion}}
    np.savez(folder / "shot.npz", depth=view.depth, rgb=view.rgb, intrinsics=json.dumps(said))
    return folder / "a.yaml", folder / "shot.npz"


def test_perceive_warns_and_calibrate_corrects(cell: tuple[Path, Path], tmp_path: Path) -> None:
    scenario, shot = cell
    warned = as_a_user.cramlite("perceive", shot, "--fixtures", scenario, "--attributes", "segments")
    assert "warning: the camera is 1" in warned.stderr, warned.stderr
    done = as_a_user.cramlite("calibrate", scenario, "--view", shot, "--out", tmp_path / "camera.yaml")
    assert done.returncode == 0 and "move it by" in done.stdout, done.stderr
    (tmp_path / "b.yaml").write_text(scenario.read_text() + "camera: {calibration: camera.yaml}\n")
    camera = camera_of(read_scenario(tmp_path / "b.yaml"))
    assert camera is not None and camera.mount is None
    position, angle = camera.pose.distance(EYE)
    assert position < 0.003 and angle < math.radians(0.2)


def test_mistakes_are_one_paragraph(cell: tuple[Path, Path], tmp_path: Path) -> None:
    scenario, shot = cell
    for words in ((tmp_path, "--view", shot), (scenario, "--view", scenario)):
        done = as_a_user.cramlite("calibrate", *words)
        assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_resolve_doubts_a_camera_that_is_off(tmp_path: Path) -> None:
    at = written(EYE)
    pose = f"position: {list(EYE.position)}, roll: {at.roll}, pitch: {at.pitch}, yaw: {at.yaw}"
    (tmp_path / "a.yaml").write_text(f"{SCENARIO}poses: camera\ncamera: {{mount: world, at: {{{pose}}}, queries: ['type=unknown']}}\n")
    scenario = read_scenario(tmp_path / "a.yaml")
    setting = engine().setting(scenario)
    assert setting.look is not None and not any("camera is" in d for d in doubts(scenario, setting, engine().knowledge))
    first = setting.look.pictures[0]
    off = replace(first, view=believed(first.view, Pose.from_rotvec((0.012, 0.0, 0.0), (0.0, 0.012, 0.0))), robot=None)
    told = doubts(scenario, replace(setting, look=replace(setting.look, pictures=(off,))), engine().knowledge)
    assert any("the camera is " in d and "deg (+-" in d and "a.yaml:" in d for d in told), told

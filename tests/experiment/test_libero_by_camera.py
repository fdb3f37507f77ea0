"""LIBERO by camera, as far as it needs no LIBERO: pictures with errors, a level table, scenes of known kinds, and what is not asked."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from conftest import ROOT
from PIL import Image

from cramlite import Engine, UserError
from cramlite.experiment.benchmark.protocol import module_of
from cramlite.experiment.benchmark.spec import read_benchmark
from cramlite.model import Camera, Intrinsics, Pose, RobotMount, Thing, World
from cramlite.perception.own_body import own_depth
from cramlite.perception.recognition import levelled
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.perception.own_surface import widened
from cramlite_plugins.simulation.camera.depth_camera import look

LIBERO = ROOT / "experiments" / "libero"
CUP = """<mujoco><worldbody><body name="main"><inertial pos="0 0 0" mass=".1" diaginertia="1e-4 1e-4 1e-4"/><freejoint name="joint0"/>
<geom type="box" size=".03 .03 .04"/><geom type="sphere" size=".02" contype="0" conaffinity="0" group="1"/></body></worldbody></mujoco>"""
CHEST = """<mujoco><compiler angle="radian"/><worldbody><body name="main" pos="0 0 .1"><geom type="box" size=".1 .1 .1"/>
<body name="drawer"><joint name="slide" type="slide" axis="1 0 0" range="0 .2"/>
<geom type="box" pos=".12 0 0" size=".01 .05 .02" mass=".2"/></body></body></worldbody></mujoco>"""


def part(name: str) -> ModuleType:
    """A module of the experiment."""
    return module_of(LIBERO / f"{name}.py")


def said(table: float, *things: Thing) -> dict[str, Any]:
    """What a benchmark would answer to 'look', of things on a table at some height."""
    size = 192
    eye, target = np.array((1.3, 0.0, table + 0.7)), np.array((0.55, 0.0, table))
    camera = Pose.from_axes(tuple(eye), target - eye, np.cross(target - eye, (0, 0, 1)))
    intrinsics = Intrinsics(230.0, 230.0, (size - 1) / 2, (size - 1) / 2, size, size)
    under = make("table", "table", Pose((0.6, 0, table - 0.01)), {"size": (1.4, 1.6, 0.02)})
    view = look(World((under, *things)), {}, Camera(camera, intrinsics=intrinsics, noise=False), seed=0)
    steps = np.where(np.isfinite(view.depth), np.rint(np.nan_to_num(view.depth, posinf=0) * 1e4), 0).astype(np.uint16)
    return {
        "rgb": png(view.rgb), "depth": png(steps), "intrinsics": [230.0, 230.0, (size - 1) / 2, (size - 1) / 2],
        "position": list(camera.position), "rotation": camera.rotation.reshape(-1).tolist(),
    }  # fmt: skip


def png(pixels: Any) -> str:
    """Pixels as PNG in base64."""
    Image.fromarray(pixels).save(buffer := io.BytesIO(), "png")
    return base64.b64encode(buffer.getvalue()).decode()


@pytest.mark.parametrize("seed", [0, 3])
def test_a_table_is_level_though_the_calibration_is_not(seed: int) -> None:
    sight, there = part("sight"), said(0.05)
    view = sight.pictured(there, seed)
    off = view.camera.distance(Pose(tuple(there["position"]), view.camera.quaternion))[0]
    assert 0 < off < 0.02, "an error of calibration was added"
    level, height = sight.levelled(view)
    points = level.world_cloud[level.valid]
    on = points[np.abs(points[:, 2] - height) < 0.02]
    far, near = on[on[:, 0] > 0.8][:, 2], on[on[:, 0] < 0.4][:, 2]
    assert abs(float(np.median(far) - np.median(near))) < 0.002
    assert abs(height - 0.05) < 0.015


def test_the_same_seed_errs_in_the_same_way() -> None:
    sight, there = part("sight"), said(0.0)
    one, two, other = (sight.pictured(there, seed) for seed in (1, 1, 2))
    assert one.camera == two.camera != other.camera
    assert np.array_equal(one.depth, two.depth, equal_nan=True) and np.isnan(one.depth).any()


def test_without_a_table_nothing_is_guessed() -> None:
    there = said(0.0)
    blind = there | {"depth": png(np.zeros((192, 192), np.uint16))}
    sight = part("sight")
    with pytest.raises(UserError, match="to find the table"):
        sight.levelled(sight.pictured(blind, 0))


@pytest.fixture
def kinds(tmp_path: Path) -> dict[str, Path]:
    """Files of a cup and a chest."""
    for name, text in (("cup", CUP), ("chest", CHEST)):
        (tmp_path / f"{name}.xml").write_text(text)
    return {n: tmp_path / f"{n}.xml" for n in ("cup", "chest")}


def test_kinds_stand_where_they_were_seen_joints_and_all(kinds: dict[str, Path]) -> None:
    cup, chest = Pose((0.5, 0.1, 0.053)), Pose.from_rotvec((0.7, -0.2, 0.11), (0, 0, 1.0))
    module = part("placed_kinds")
    seen = [module.Placed("cup", cup), module.Placed("cup", Pose((0.5, 0.3, 0.055))), module.Placed("chest", chest, {"slide": 0.15}),
            module.Placed("cup", Pose((0.3, 0.1, 0.069)))]  # fmt: skip
    xml, state = module.scene_of(seen, kinds, 0.012)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qpos[:] = state
    mujoco.mj_forward(model, data)
    names = {model.body(b).name for b in range(model.nbody)}
    assert {"table", "cup_1_main", "cup_2_main", "chest_1_main", "chest_1_drawer"} <= names
    assert np.allclose(data.body("cup_1_main").xpos[:2], cup.position[:2], atol=1e-3)
    assert np.allclose(data.body("chest_1_main").xpos[:2], chest.position[:2])
    top = data.geom("table_top").xpos[2] + model.geom("table_top").size[2]
    assert data.body("cup_1_main").xpos[2] - 0.04 == pytest.approx(top, abs=1e-3), "what rests on the table rests on it"
    assert data.body("cup_3_main").xpos[2] == pytest.approx(0.069, abs=1e-3), "what rests on something else stays where it was seen"
    assert data.body("chest_1_main").xpos[2] == pytest.approx(chest.position[2], abs=1e-6), "what is fixed is where it was seen"
    assert model.joint("chest_1_slide").range.tolist() == [0, 0.2]
    out = data.body("chest_1_drawer").xpos - data.body("chest_1_main").xpos
    assert np.linalg.norm(out) == pytest.approx(0.15, abs=1e-6), "its drawer is as far open as it was seen"
    assert all(model.geom_contype), "what only looks is left out"


def test_what_is_seen_a_little_off_comes_to_rest_and_what_floats_stays(kinds: dict[str, Path]) -> None:
    module = part("placed_kinds")
    below, leaning = Pose((0.5, 0.1, 0.051)), Pose.from_rotvec((0.501, 0.1, 0.126), (0.03, 0.0, 0.0))
    floating = Pose((0.5, 0.4, 0.30))
    xml, state = module.scene_of([module.Placed("cup", p) for p in (below, leaning, floating)], kinds, 0.012)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qpos[:] = state
    mujoco.mj_forward(model, data)
    on = data.body("cup_2_main").xpos[2] - data.body("cup_1_main").xpos[2]
    assert on == pytest.approx(0.08, abs=1e-3) and data.body("cup_2_main").xmat[8] > 0.9999
    assert np.allclose(data.body("cup_3_main").xpos, floating.position, atol=1e-3)
    mujoco.mj_step(model, data, 500)
    assert np.allclose(data.body("cup_3_main").xpos, floating.position, atol=2e-3), "what it hides holds it up"
    assert [model.body(b).name for b in range(model.nbody) if model.body(b).name.startswith("hidden")] == ["hidden_1"]


@pytest.mark.parametrize(("tilt", "up"), [(0.02, 1.0), (0.1, 0.995)])
def test_what_is_fixed_is_level_if_it_is_so_but_for_errors(tilt: float, up: float) -> None:
    turned = levelled(Pose.from_rotvec((0.7, -0.2, 0.11), (0, 0, 1.0)) * Pose.from_rotvec((0, 0, 0), (tilt, 0, 0))).rotation
    assert turned[2, 2] == pytest.approx(up, abs=1e-5)
    assert np.arctan2(turned[1, 0], turned[0, 0]) == pytest.approx(1.0, abs=0.01)


def test_what_would_be_within_the_table_is_not_there(kinds: dict[str, Path]) -> None:
    module = part("placed_kinds")
    xml, _ = module.scene_of([module.Placed("cup", Pose((0.5, 0.1, 0.0)))], kinds, 0.012)
    assert "cup_1" not in xml


def test_what_would_be_within_a_fixed_thing_is_not_there_unless_it_comes_out(kinds: dict[str, Path]) -> None:
    module = part("placed_kinds")
    chest = module.Placed("chest", Pose((0.7, -0.2, 0.11)))
    within, touching = (module.Placed("cup", Pose((0.57 + deep, -0.2, 0.053))) for deep in (0.02, 0.004))
    xml, state = module.scene_of([within, chest, module.Placed("cup", Pose((0.4, 0.3, 0.053)))], kinds, 0.012)
    model = mujoco.MjModel.from_xml_string(xml)
    assert "cup_2" not in xml and "chest_1" in xml
    assert state[int(model.joint("cup_1_joint0").qposadr[0])] == pytest.approx(0.4, abs=1e-3)
    assert "cup_1" in module.scene_of([touching, chest], kinds, 0.012)[0]


def test_no_more_is_asked_than_a_cell_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    module = part("by_camera")
    benchmark = object.__new__(module.LiberoByCamera)
    benchmark.asked, benchmark.lines = [], SimpleNamespace(ask=lambda line, patience: b'{"rgb": "", "joints": []}')
    assert benchmark.ask({"ask": "look"}, 1.0)["joints"] == []
    assert benchmark.asked == [{"ask": "look", "answered": ["joints", "rgb"]}]
    for more in ("scene", "cameras"):
        with pytest.raises(UserError, match=f"not sent the request '{more}'"):
            benchmark.ask({"ask": more}, 1.0)
    monkeypatch.setenv("CRAMLITE_LIBERO_KINDS", "/nowhere")
    with pytest.raises(UserError, match="no library of LIBERO's kinds"):
        module.library_folder()


def test_its_experiment_says_what_is_given() -> None:
    spec = read_benchmark(LIBERO / "camera.yaml").spec
    assert "sentence" in spec.given and "scene" not in part("by_camera").ALLOWED
    whole = read_benchmark(LIBERO / "experiment.yaml").spec
    assert all(whole.suites[name.replace("_seen_", "_")].budget == suite.budget for name, suite in spec.suites.items())


MOUNT = RobotMount("robot", "libero_panda", joints=(0.0, -0.161, 0.0, -2.445, 0.0, 2.227, 0.785), opening=0.08)


def test_what_is_no_kind_is_an_obstacle_where_it_is_seen() -> None:
    sight, box = part("sight"), make("block", "box", Pose((0.5, 0.2, 0.062)), {"size": (0.1, 0.1, 0.1)})
    view, table = sight.levelled(sight.pictured(said(0.012, box), 0))
    cup = make("block", "cup", Pose(), {"size": (0.03, 0.03, 0.2), "mass": 0.1})
    found, obstacles = sight.seen(Engine(files=[LIBERO / "panda.py"]), view, table, [cup], MOUNT)
    assert not found
    corners = np.concatenate([o.pose.apply(np.array(g.corners)) for o in obstacles for g in o.geoms])
    assert np.abs(corners - (0.5, 0.2, 0.062)).max() < 0.065
    assert np.ptp(corners, axis=0).max() > 0.08
    model = mujoco.MjModel.from_xml_string(part("placed_kinds").scene_of([], {}, 0.012, obstacles)[0])
    assert [int(model.body(o.name).jntnum[0]) for o in obstacles] == [0] * len(obstacles)


def test_beside_the_robot_is_the_robot() -> None:
    sight, engine = part("sight"), Engine(files=[LIBERO / "panda.py"])
    view = sight.pictured(said(0.012), 0)
    alone, fixed = World((), (MOUNT,)), Camera(view.camera, intrinsics=view.intrinsics, noise=False)
    drawn = np.isfinite(look(alone, engine.knowledge.robots_of(alone), fixed, seed=0).depth)
    own = np.isfinite(widened(own_depth(alone, fixed, engine.knowledge), view.intrinsics))
    assert own[drawn].all()
    assert own.sum() > 1.1 * drawn.sum()
    assert not own.all()

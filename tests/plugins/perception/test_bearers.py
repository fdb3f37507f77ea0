"""What is seen under a thing that hovers is read as a kind of that height; and pixels at edges of depth tell for and against nothing."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.as_a_user import cramlite
from helpers.printed_box import printed_box, tiles

from cramlite import Engine
from cramlite.model import Camera, Intrinsics, Pose, Thing, View, World
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.perception.kinds.agreement import Picture
from cramlite_plugins.perception.kinds.appearance import appearance_of
from cramlite_plugins.perception.kinds.bearers import Hovering, _readings, with_bearers
from cramlite_plugins.perception.kinds.explain import PARAMETERS
from cramlite_plugins.perception.kinds.reading import Part, Reading, Scene
from cramlite_plugins.perception.kinds.region import Region
from cramlite_plugins.perception.pose.outline import Outline
from cramlite_plugins.simulation.camera.depth_camera import look

LIMITS = {p.name: p.default for p in PARAMETERS}
CAMERA = Intrinsics(500.0, 500.0, 255.5, 191.5, 512, 384)
KINDS = {"cover": ((0.12, 0.10, 0.04), 3), "low_box": ((0.09, 0.06, 0.022), 1), "high_box": ((0.09, 0.06, 0.05), 1)}
TABLE = make("table", "table", Pose((0.45, 0, 0)), {})
LOW = 0.022


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    """An engine that knows a cover, and a low and a high box with one print."""
    folder = tmp_path_factory.mktemp("boxes")
    for name, (size, seed) in KINDS.items():
        (folder / name).mkdir()
        printed_box(folder / name / f"{name}.glb", size, tiles(seed))
    assert cramlite("library", "add", folder, "--out", folder / "lib").returncode == 0
    return Engine(models=[folder / "lib"])


def thing(engine: Engine, kind: str, pose: Pose) -> Thing:
    return engine.knowledge.models[kind].make(name=kind, pose=pose)


def seen(things: tuple[Thing, ...]) -> View:
    eye, target = np.array((1.0, 0.0, 0.55)), np.array((0.45, 0.0, 0.05))
    camera = Camera(Pose.from_axes(tuple(eye), target - eye, np.cross(target - eye, (0, 0, 1))), intrinsics=CAMERA)
    return look(World((TABLE, *things)), {}, camera, seed=1)


@pytest.mark.parametrize("hovers", [True, False])
def test_a_strip_under_what_hovers_is_a_kind_of_its_height(engine: Engine, hovers: bool) -> None:
    low = thing(engine, "low_box", Pose((0.495, 0.0, LOW / 2)))
    cover = thing(engine, "cover", Pose((0.45, 0.0, LOW + 0.02)))
    view = seen((low, cover))
    points = view.world_cloud
    box = view.valid & (np.abs(points[..., 1]) < 0.06) & (np.abs(points[..., 0] - 0.45) < 0.1)
    upper, strip = box & (points[..., 2] > LOW + 0.006), box & (points[..., 2] > 0.01) & (points[..., 2] < LOW + 0.004)
    known = tuple(appearance_of(thing(engine, k, Pose())) for k in KINDS)
    scene = Scene(Picture.of(view), points, known, LIMITS, upper | strip, (TABLE, *(() if hovers else (low,))))
    parts = [Part(upper, (Reading(known[0], cover.pose, 0.9, 0.9),)), Part(strip, ())]
    found = with_bearers(scene, parts)
    assert found[0] is parts[0]
    if not hovers:
        assert found[1] is parts[1]
        return
    best = found[1].readings[0]
    assert best.appearance.model.name == "low_box" and "high_box" not in {r.appearance.model.name for r in found[1].readings}
    assert best.pose.distance(low.pose)[0] < 0.008 and best.pose.rotation[2, 2] > 0.98


def test_what_bears_a_thing_is_not_tilted(engine: Engine) -> None:
    tilted = thing(engine, "low_box", Pose.from_rotvec((0.47, 0.0, 0.03), (0.0, 0.3, 0.0)))
    view = seen((tilted,))
    points = view.world_cloud
    mask = view.valid & (np.abs(points[..., 1]) < 0.06) & (np.abs(points[..., 0] - 0.47) < 0.08) & (points[..., 2] > 0.004)
    known = appearance_of(thing(engine, "low_box", Pose()))
    region = Region(Scene(Picture.of(view), points, (known,), LIMITS, mask, (TABLE,)), mask)
    above = Hovering(np.array((0.47, 0.0, 0.05)), 0.06, LOW, 0.0)
    assert all(r.pose.rotation[2, 2] > 0.98 for r in _readings(region, known, ((0.0, 0.0, 1.0),), above))


def test_pixels_at_edges_of_depth_beside_a_thing_deny_nothing() -> None:
    depth = np.full((60, 60), 1.0, np.float32)
    mask = np.zeros((60, 60), bool)
    mask[20:40, 20:40] = True
    depth[mask] = 0.9
    edges = np.zeros((60, 60), bool)
    edges[:, 40:42] = True
    view = View(np.zeros((60, 60, 3), np.uint8), depth, Intrinsics(60.0, 60.0, 29.5, 29.5, 60, 60), Pose(), 0.0)
    plain, unsure = Outline.of(view, mask), Outline.of(view, mask, edges)
    beside = np.array([[(k - 29.5) * 0.9 / 60, 0.0, 0.9] for k in (19, 40, 41)], np.float32)
    flat = unsure.pixels(beside)[2]
    assert not plain.hidden(flat, beside[:, 2]).any()
    assert unsure.hidden(flat, beside[:, 2]).tolist() == [False, True, False]


def test_a_gap_without_depth_in_a_thing_denies_nothing() -> None:
    depth = np.full((60, 60), 1.0, np.float32)
    mask = np.zeros((60, 60), bool)
    mask[20:40, 20:40] = True
    depth[mask] = 0.9
    gap, beside = (30, 30), (30, 43)
    mask[gap], depth[gap], depth[beside] = False, np.nan, np.nan
    view = View(np.zeros((60, 60, 3), np.uint8), depth, Intrinsics(60.0, 60.0, 29.5, 29.5, 60, 60), Pose(), 0.0)
    outline = Outline.of(view, mask, np.zeros((60, 60), bool))
    points = np.array([[(c - 29.5) * 0.9 / 60, (r - 29.5) * 0.9 / 60, 0.9] for r, c in (gap, beside)], np.float32)
    assert outline.hidden(outline.pixels(points)[2], points[:, 2]).tolist() == [True, False]


def test_what_the_shadow_of_something_nearer_may_hide_denies_nothing() -> None:
    """Beside what is nearer a stereo camera has no depth; beside the thing itself that is its own shadow, where it is not."""
    depth = np.full((60, 60), 1.0, np.float32)
    mask = np.zeros((60, 60), bool)
    mask[20:30, 20:40] = True
    depth[mask] = 0.9
    depth[30:40, 28:40] = 0.8
    depth[20:40, 12:20] = depth[30:40, 20:28] = np.nan
    view = View(np.zeros((60, 60, 3), np.uint8), depth, Intrinsics(60.0, 60.0, 29.5, 29.5, 60, 60), Pose(), 0.0)
    outline = Outline.of(view, mask, np.zeros((60, 60), bool))
    points = np.array([[(c - 29.5) * 0.9 / 60, (r - 29.5) * 0.9 / 60, 0.9] for r, c in ((35, 24), (25, 16), (25, 19))], np.float32)
    assert outline.hidden(outline.pixels(points)[2], points[:, 2]).tolist() == [True, False, True]

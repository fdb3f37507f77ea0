"""The camera sees what is printed on things, and their visual mesh in the place of their collision shape."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.printed_box import printed_box

from cramlite.model import Camera, Pose, View, World
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.simulation.camera.depth_camera import look

SIZE = (0.08, 0.05, 0.12)


def seen_from(eye: tuple[float, float, float], thing: object) -> View:
    forward = np.array((0, 0, 0.06)) - eye
    camera = Camera(Pose.from_axes(eye, forward, np.cross(forward, (0, 0, 1))), noise=False)
    return look(World((make("table", "table", Pose(), {}), thing)), {}, camera, seed=0)  # type: ignore[arg-type]


def colour_at(view: View, point: tuple[float, float, float]) -> list[bool]:
    """Which of red, green and blue are bright where a point of the world is seen."""
    u, v = view.intrinsics.project(view.camera.inverse().apply(np.array(point)))
    return [bool(c > 100) for c in view.rgb[round(v), round(u)]]


@pytest.mark.parametrize("kind", ["glb", "obj"])
def test_each_side_of_a_printed_box_has_its_colour(tmp_path: Path, kind: str) -> None:
    box = make("mesh", "box", Pose((0, 0, 0.06)), {"file": str(printed_box(tmp_path / f"box.{kind}", SIZE)), "mass": 0.2})
    one, other = seen_from((0.5, -0.3, 0.3), box), seen_from((-0.5, 0.3, 0.3), box)
    assert colour_at(one, (0.04, 0.0, 0.06)) == [True, False, False]
    assert colour_at(one, (0.0, -0.025, 0.06)) == [True, True, False]
    assert colour_at(other, (-0.04, 0.0, 0.06)) == [False, True, False]
    assert colour_at(other, (0.0, 0.025, 0.06)) == [False, False, True]
    for view in (one, other):
        assert colour_at(view, (0.0, 0.0, 0.12)) == [True, False, True]
        print_seen = view.rgb[view.rgb.min(axis=2) < 20]  # the table and the sky have none so dark
        assert len({tuple(p > 100) for p in print_seen.tolist() for p in [np.array(p)]}) == 3


def test_a_picture_on_a_side_is_the_right_way_up_and_not_mirrored(tmp_path: Path) -> None:
    tile = np.zeros((20, 20, 3), np.uint8)
    tile[:10, :10] = (255, 0, 0)  # top left
    tile[:10, 10:] = (0, 255, 0)
    tile[10:, :10] = (0, 0, 255)
    tile[10:, 10:] = (255, 255, 0)
    path = printed_box(tmp_path / "box.glb", SIZE, (tile,) * 6)
    view = seen_from((0.6, 0.0, 0.2), make("mesh", "box", Pose((0, 0, 0.06)), {"file": str(path), "mass": 0.2}))
    assert colour_at(view, (0.04, -0.012, 0.09)) == [True, False, False]  # -y is on the left, seen from +x
    assert colour_at(view, (0.04, 0.012, 0.09)) == [False, True, False]
    assert colour_at(view, (0.04, -0.012, 0.03)) == [False, False, True]
    assert colour_at(view, (0.04, 0.012, 0.03)) == [True, True, False]


def test_a_mesh_without_a_texture_keeps_its_colour(tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.box(SIZE).export(str(tmp_path / "box.stl"))
    plain = {"file": str(tmp_path / "box.stl"), "mass": 0.2, "rgba": (0.9, 0.0, 0.0, 1.0)}
    view = seen_from((0.5, -0.3, 0.3), make("mesh", "box", Pose((0, 0, 0.06)), plain))
    assert colour_at(view, (0.04, 0.0, 0.06)) == [True, False, False]


def test_depth_is_that_of_the_visual_mesh(tmp_path: Path) -> None:
    path = printed_box(tmp_path / "box.glb", SIZE)
    view = seen_from((0.6, 0.0, 0.06), make("mesh", "box", Pose((0, 0, 0.06)), {"file": str(path), "mass": 0.2}))
    u, v = view.intrinsics.project(view.camera.inverse().apply(np.array((0.04, 0.0, 0.06))))
    assert view.depth[round(v), round(u)] == pytest.approx(0.56, abs=0.0005)

"""The depth camera: exact on planes, and the noise has the statistics that were measured."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import D435, Geom, Intrinsics, Pose, Thing, World
from cramlite_plugins.locations.viewpoints import looking_at
from cramlite_plugins.objects.products_and_fixtures import hanger, hung, product
from cramlite_plugins.simulation.camera import depth_camera
from cramlite_plugins.simulation.camera.depth_camera import render
from cramlite_plugins.simulation.camera.noise import Noise
from cramlite_plugins.simulation.camera.ray_tracer import where_seen
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

SMALL = Intrinsics(96.25, 96.25, 79.5, 59.5, 160, 120)
QUIET = Noise(flying=0.0, dropped=0.0, disparity=0.0, steps=1 << 20, millimetres=False, colour=0.0)


def _wall(distance: float = 0.0) -> Compiled:
    plate = Thing("wall", "cram:Table", Pose((-0.01 - distance, 0, 0)), (Geom("box", (0.01, 2.0, 2.0)),))
    return compile_world(World((plate,)), {})


def _hanging() -> Compiled:
    hook = hanger("hook", Pose((0.87, 0, 0.45), (0, 0, 0, 1)))
    box = product("tea", Pose())
    return compile_world(World((hook, replace(box, pose=hung(box, hook, 0.07)))), {})


def test_a_plane_is_seen_where_it_is() -> None:
    compiled = _wall()
    view, ids = render(compiled.model, compiled.data(), looking_at((0.7, 0.1, 0.2), (0, 0, 0)), SMALL, noise=None)
    assert view.valid.all() and (ids == compiled.things["wall"].body).all()
    assert np.abs(view.world_cloud[..., 0]).max() < 1e-6


def test_rays_are_cast_where_geoms_may_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled, camera = _hanging(), looking_at((0.45, 0.1, 0.60), (0.9, 0, 0.44))
    seen: list[float] = []

    def where(*told: Any) -> Any:
        seen.append(float((found := where_seen(*told)).mean()))
        return found

    monkeypatch.setattr(depth_camera, "where_seen", where)
    some, _ = render(compiled.model, compiled.data(), camera, SMALL, noise=None)
    monkeypatch.setattr(depth_camera, "where_seen", lambda *told: np.ones_like(where_seen(*told)))
    every, _ = render(compiled.model, compiled.data(), camera, SMALL, noise=None)
    assert 0 < seen[0] < 0.9
    assert np.array_equal(some.depth, every.depth, equal_nan=True) and np.array_equal(some.rgb, every.rgb)


def test_where_nothing_is_there_is_no_depth() -> None:
    compiled = _wall()
    view, ids = render(compiled.model, compiled.data(), looking_at((0.7, 0, 0), (2, 0, 0)), SMALL)
    assert not view.valid.any() and (ids == -1).all()


def test_a_hole_is_a_hole() -> None:
    compiled = _hanging()
    camera = looking_at((0.45, 0.02, 0.50), (0.8, 0, 0.44))
    view, ids = render(compiled.model, compiled.data(), camera, noise=None)
    thing = compiled.world.thing("tea")
    hole, _ = thing.features
    below = thing.pose * hole.pose * Pose((0.0, -0.003, 0.0))  # in the hole; the peg is above, at its rim
    rim = thing.pose * hole.pose * Pose((0.0, -0.008, 0.0))
    for pose, expected in ((below, False), (rim, True)):
        u, v = np.rint(view.intrinsics.project(camera.inverse().apply(np.array(pose.position)))).astype(int)
        assert (ids[v, u] == compiled.things["tea"].body) == expected


def test_the_noise_is_that_of_the_camera() -> None:
    """Disparity of .09 px at 0.6 m is 1.7 mm: z * z / (f B) * sigma; a plane has no edges, so hardly anything is lost."""
    compiled = _wall()
    camera = looking_at((0.6, 0, 0), (0, 0, 0))
    view, _ = render(compiled.model, compiled.data(), camera, noise=Noise(), seed=1)
    error = view.depth[view.valid] - 0.6
    assert view.valid.mean() > 0.97
    assert 0.0015 < error.std() < 0.0020 and abs(error.mean()) < 2e-4
    assert np.allclose(view.depth[view.valid] * 1000, np.rint(view.depth[view.valid] * 1000), atol=1e-3)


def test_what_is_too_near_is_not_measured() -> None:
    compiled = _wall()
    near, far = (
        render(compiled.model, compiled.data(), looking_at((z, 0, 0), (0, 0, 0)), SMALL)[0] for z in (0.16, 0.2)
    )
    assert not near.valid[60, 80] and far.valid[50:70, 70:90].mean() > 0.9


def test_the_second_camera_does_not_see_behind_what_is_in_front() -> None:
    """A rod before a wall casts a shadow on its left as wide as the difference of the disparities."""
    rod = Thing("rod", "cram:Table", Pose((0.3, 0, 0)), (Geom("box", (0.001, 0.02, 1.0)),))
    wall = Thing("wall", "cram:Table", Pose((-0.01, 0, 0)), (Geom("box", (0.01, 2.0, 2.0)),))
    compiled = compile_world(World((rod, wall)), {})
    view, ids = render(compiled.model, compiled.data(), looking_at((0.6, 0, 0), (0, 0, 0)), D435, QUIET)
    row, lost = ids[240], ~view.valid[240]
    left, right = np.flatnonzero(row == compiled.things["rod"].body)[[0, -1]]
    expected = D435.fx * 0.05 * (1 / 0.299 - 1 / 0.6)
    assert abs(lost[:left].sum() - expected) <= 3
    assert lost[left : right + 1].sum() <= 2 and lost[right + 1 :].sum() == 0


def test_edges_fly_and_drop() -> None:
    compiled = _hanging()
    camera = looking_at((0.4, -0.2, 0.55), (0.8, 0, 0.38))
    view, ids = render(compiled.model, compiled.data(), camera, seed=3)
    exact, _ = render(compiled.model, compiled.data(), camera, noise=None)
    on = ids == compiled.things["tea"].body
    flying = on & (np.abs(view.depth - exact.depth) > 0.015)
    assert 0.005 < flying.sum() / on.sum() < 0.10
    assert 0.01 < (on & ~view.valid).sum() / on.sum() < 0.15


def test_three_times_the_noise_errs_three_times_as_far() -> None:
    """Of the same seed, on one surface that faces the camera; the steps of disparity grow with the noise."""
    wall = compile_world(World((Thing("wall", "soma:DesignedFurniture", Pose((0, 0, 0)), (Geom("box", (0.05, 1.0, 1.0)),)),)), {})
    camera = looking_at((0.85, 0, 0), (0, 0, 0))
    views = [render(wall.model, wall.data(), camera, SMALL, noise, seed=3)[0].depth for noise in (None, Noise(), Noise().times(3.0))]
    once, thrice = (float(np.nanmedian(np.abs(v - views[0]))) for v in views[1:])
    assert thrice == pytest.approx(3 * once, rel=0.3) and once > 0.0003
    assert Noise().times(1.0) == Noise()


def test_the_same_seed_gives_the_same_view() -> None:
    compiled = _hanging()
    camera = looking_at((0.4, -0.2, 0.55), (0.8, 0, 0.38))
    first, again, other = (render(compiled.model, compiled.data(), camera, SMALL, seed=s)[0] for s in (5, 5, 6))
    assert np.array_equal(first.depth, again.depth, equal_nan=True) and np.array_equal(first.rgb, again.rgb)
    assert not np.array_equal(first.depth, other.depth, equal_nan=True)


@pytest.mark.parametrize("rgba", [(0.9, 0.1, 0.1, 1.0), (0.1, 0.2, 0.9, 1.0)])
def test_things_have_their_colour(rgba: tuple[float, float, float, float]) -> None:
    ball = Thing("ball", "cram:Product", Pose(), (Geom("sphere", (0.1,), rgba=rgba),))
    compiled = compile_world(World((ball,)), {})
    view, ids = render(compiled.model, compiled.data(), looking_at((0.6, 0, 0), (0, 0, 0)), SMALL)
    seen = view.rgb[ids >= 0].mean(axis=0)
    assert seen.argmax() == int(np.argmax(rgba[:3])) and seen.max() > 2 * seen.min()

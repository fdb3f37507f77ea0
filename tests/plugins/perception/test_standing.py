"""Models are looked for where they stand: at the height of the furniture under the lowest points that are seen."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite.model import Camera, Intrinsics, Pose, Thing, View, World
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.perception.kinds.agreement import Picture
from cramlite_plugins.perception.kinds.appearance import appearance_of
from cramlite_plugins.perception.kinds.explain import PARAMETERS
from cramlite_plugins.perception.kinds.reading import Scene
from cramlite_plugins.perception.kinds.region import Region
from cramlite_plugins.perception.kinds.registered import posed
from cramlite_plugins.perception.kinds.standing import as_high, standing, standing_at
from cramlite_plugins.perception.pose.prior import Alignment, Prior
from cramlite_plugins.perception.pose.starts import starts_for
from cramlite_plugins.simulation.camera.depth_camera import look

LIMITS = {p.name: p.default for p in PARAMETERS}
TABLE, SHELF = table("table", Pose((0.45, 0.0, 0.0))), table("shelf", Pose((0.45, 0.3, 0.2)), (0.2, 0.2, 0.02))
TOP = float((TABLE.pose * TABLE.geoms[0].pose).position[2] + TABLE.geoms[0].half_extents[2])
SIZE = (0.03, 0.11, 0.14)


def region_of(at: Pose, *fixtures: Thing) -> Region:
    """The pixels of a block at a pose, in a picture of it among furniture."""
    eye = np.array((1.1, 0.1, 0.6))
    way = np.array((0.45, 0.0, 0.1)) - eye
    lens = Intrinsics(500.0, 500.0, 255.5, 191.5, 512, 384)
    camera = Camera(Pose.from_axes(eye, way, np.cross(way, (0, 0, 1))), intrinsics=lens, noise=0.0)
    thing = block("it", at, SIZE)
    view: View = look(World((*fixtures, thing)), {}, camera, seed=0)
    local = at.inverse().apply(np.nan_to_num(view.world_cloud, posinf=9.0).reshape(-1, 3)).reshape(*view.depth.shape, 3)
    mask = view.valid & (np.abs(local) < np.array(SIZE) / 2 + 1e-4).all(axis=-1)
    known = (appearance_of(block("it", Pose(), SIZE)),)
    return Region(Scene(Picture.of(view), view.world_cloud, known, LIMITS, mask, fixtures), mask)


@pytest.mark.parametrize(("over", "fixtures", "found"), [(0.0, (TABLE, SHELF), True), (0.05, (TABLE,), False), (0.0, (SHELF,), False)])
def test_the_floor_is_the_furniture_under_the_lowest_points(over: float, fixtures: tuple[Thing, ...], found: bool) -> None:
    floor = region_of(Pose((0.45, 0.0, TOP + over + SIZE[2] / 2)), *fixtures).floor
    assert floor == (pytest.approx(TOP) if found else None)


def test_starts_stand_on_it_turned_as_they_were_and_where_they_were() -> None:
    region = region_of(Pose.from_rotvec((0.45, 0.0, TOP + SIZE[2] / 2), (0.0, 0.0, 0.5)), TABLE)
    scene, (model,) = region.scene, region.scene.appearances
    assert region.seen is not None
    before = starts_for(scene.picture.view.camera, model.surface, standing(model), region.seen[0])
    after = standing_at(scene, model, before, TOP)
    for old, new in zip(posed(scene, before), posed(scene, after), strict=True):
        assert new.pose.apply(model.surface.points)[:, 2].min() == pytest.approx(TOP, abs=1e-4)
        assert new.pose.distance(old.pose)[1] < 1e-3 and new.pose.position[:2] == pytest.approx(old.pose.position[:2], abs=1e-4)
    aside = posed(scene, standing_at(scene, model, before, TOP, np.array((0.2, 0.1))))
    middles = [(p.min(axis=0) + p.max(axis=0)) / 2 for h in aside for p in [h.pose.apply(model.surface.points)]]
    assert np.array(middles)[:, :2] == pytest.approx(np.tile((0.2, 0.1), (len(aside), 1)), abs=1e-3)


@pytest.mark.parametrize(("height", "whole", "count"), [(0.14, True, 2), (0.105, True, 2), (0.105, False, 4), (0.3, True, 6)])
def test_directions_up_fit_the_height_that_is_seen(height: float, whole: bool, count: int) -> None:
    model = appearance_of(block("it", Pose(), SIZE))
    ups = tuple(tuple(float(v) for v in s * np.eye(3)[k]) for k in range(3) for s in (1, -1))
    prior = Prior((Alignment(ups, ((0.0, 0.0, 1.0),)),))
    assert len(as_high(model, prior, height, LIMITS, whole=whole).alignments[0].axes) == count

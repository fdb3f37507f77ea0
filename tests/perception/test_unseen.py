"""What a thing hides from a camera, by a picture of a shelf with a board on it: the shadow behind the board, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Camera, Geom, Intrinsics, Pose, Thing, View, World
from cramlite.perception.active_perception import Picture
from cramlite.perception.unseen import hidden_behind, places_above, share_shown, unknown_body
from cramlite_plugins.objects.furniture import cabinet
from cramlite_plugins.objects.products_and_fixtures import table

TAXONOMY = Engine().knowledge.taxonomy
SHELF = table("shelf", Pose((0.6, 0.0, 0.0)), size=(0.3, 0.3, 0.02))
BOARD = Thing("board", "dul:PhysicalObject", Pose((0.55, 0.0, 0.05)), (Geom("box", (0.01, 0.04, 0.05)),), mass=0.2)
WALL = table("wall", Pose((1.0, 0.0, 0.5)), size=(0.02, 2.0, 2.0))
EYE = (0.1, 0.0, 0.1)


def picture(*things: Thing) -> Picture:
    """A depth image by casting rays from the front, with the boxes of things and a wall behind them."""
    camera = Pose.from_axes(EYE, (1.0, 0.0, -0.15), (0.0, -1.0, 0.0))
    intrinsics = Intrinsics(300.0, 300.0, 160.0, 120.0, 320, 240)
    rays = intrinsics.rays.reshape(-1, 3)
    depth = np.full(len(rays), np.nan)
    for thing in (*things, WALL):
        for geom in thing.geoms:
            local = (thing.pose * geom.pose).inverse() * camera
            origin, way = np.asarray(local.position), local.apply(rays) - np.asarray(local.position)
            with np.errstate(divide="ignore", invalid="ignore"):
                a, b = (np.asarray(geom.size) * s / way - origin / way for s in (-1, 1))
            near, far = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
            depth = np.where((near < far) & (near > 0), np.fmin(depth, near), depth)
    image = depth.reshape(240, 320).astype(np.float32)
    view = View(np.zeros((240, 320, 3), np.uint8), image, intrinsics, camera)
    return Picture(view, Camera(camera, intrinsics=intrinsics), (SHELF,))


def test_places_are_above_surfaces_on_which_things_can_stand() -> None:
    points = places_above(SHELF, TAXONOMY)
    assert len(points) == 2 * 15 * 15
    assert np.allclose(sorted(set(points[:, 2].round(3))), [0.02, 0.05])
    assert np.abs(points[:, :2] - (0.6, 0.0)).max() < 0.15


def test_a_board_hides_what_is_behind_it_and_nothing_else() -> None:
    hidden = hidden_behind(BOARD, places_above(SHELF, TAXONOMY), [picture(SHELF, BOARD)])
    assert len(hidden) > 20
    assert hidden[:, 0].min() > 0.56 + 0.01  # its own place is none that nobody has seen
    assert np.abs(hidden[:, 1]).max() < 0.04 * (0.75 - EYE[0]) / (0.55 - EYE[0]) + 0.01


def test_what_another_picture_shows_is_hidden_by_nothing() -> None:
    points = places_above(SHELF, TAXONOMY)
    assert len(hidden_behind(BOARD, points, [picture(SHELF, BOARD), picture(SHELF)])) == 0
    aside = replace(BOARD, pose=Pose((0.55, 0.12, 0.05)))
    assert len(hidden_behind(aside, points, [picture(SHELF, BOARD)])) == 0  # another thing stands before them


@pytest.mark.parametrize(("things", "share"), [((SHELF,), 1.0), ((SHELF, BOARD), 0.0)])
def test_how_much_a_view_would_show(things: tuple[Thing, ...], share: float) -> None:
    hidden = hidden_behind(BOARD, places_above(SHELF, TAXONOMY), [picture(SHELF, BOARD)])
    view = picture(*things).view
    assert share_shown(hidden, view.depth, view.camera, view.intrinsics) == share


def test_nothing_is_hidden_where_nothing_can_stand() -> None:
    door = replace(cabinet("cabinet", Pose()), features=())
    assert places_above(door, TAXONOMY).shape == (0, 3)
    assert share_shown(places_above(door, TAXONOMY), picture(SHELF).view.depth, Pose(), picture(SHELF).view.intrinsics) == 0.0


def test_where_nobody_has_seen_what_is_there_a_body_is_in_the_way() -> None:
    hidden = hidden_behind(BOARD, places_above(SHELF, TAXONOMY), [picture(SHELF, BOARD)])
    body = unknown_body("unseen", hidden)
    assert body.mass is None and len(body.geoms) == len(hidden)
    World((SHELF, BOARD, body), ())

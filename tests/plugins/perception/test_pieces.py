"""Pieces of a cluster, what hides a part, and what lies within what it stands on."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import Geom, Intrinsics, Pose, Thing, View
from cramlite_plugins.perception.kinds.agreement import Picture
from cramlite_plugins.perception.kinds.appearance import appearance_of
from cramlite_plugins.perception.kinds.interpret import _beside, _held
from cramlite_plugins.perception.kinds.pieces import covered, given_back, pieces
from cramlite_plugins.perception.kinds.reading import Reading, Scene
from cramlite_plugins.perception.kinds.region import Region

FOCAL, SIDE = 400.0, 160
WALL, FRONT = 1.2, 0.9
"""Depth of the background and of things [m]."""
TABLE = Thing("table", "soma:Table", Pose((0.0, 0.0, -0.05)), (Geom("box", (0.5, 0.5, 0.05)),))
BLOCK = Thing("block", "cram:Product", Pose(), (Geom("box", (0.03, 0.03, 0.03)),), mass=0.2)


def seen(depth: np.ndarray) -> View:
    colours = np.zeros((*depth.shape, 3), np.uint8)
    return View(colours, depth.astype(np.float32), Intrinsics(FOCAL, FOCAL, SIDE / 2, SIDE / 2, SIDE, SIDE), Pose(), 0.0)


def region(rows: slice, columns: slice) -> np.ndarray:
    mask = np.zeros((SIDE, SIDE), bool)
    mask[rows, columns] = True
    return mask


UPPER, LOWER = region(slice(40, 80), slice(40, 120)), region(slice(80, 120), slice(40, 120))


def test_a_thing_before_another_is_a_piece_of_its_own_and_a_face_is_one() -> None:
    both = UPPER | LOWER
    stepped = np.where(UPPER, FRONT - 0.06, np.where(LOWER, FRONT, WALL))
    assert sorted(int((p & UPPER).sum() > (p & LOWER).sum()) for p in pieces(seen(stepped), both, 60)) == [0, 1]
    assert len(pieces(seen(np.where(both, FRONT, WALL)), both, 60)) == 1


def test_what_is_narrower_than_a_chord_has_pieces() -> None:
    strip = region(slice(40, 80), slice(40, 50))
    assert len(pieces(seen(np.where(strip, FRONT, WALL)), strip, 60)) == 1


@pytest.mark.parametrize(("nearer", "hides"), [(-0.05, True), (0.08, False)])
def test_a_part_is_covered_by_what_is_nearer_alone(nearer: float, hides: bool) -> None:
    view = seen(np.where(UPPER, FRONT + nearer, np.where(LOWER, FRONT, WALL)))
    assert (covered(view, LOWER, UPPER | LOWER) > 0.15) is hides


def test_background_covers_nothing_though_it_is_nearer() -> None:
    view = seen(np.where(UPPER, FRONT - 0.05, np.where(LOWER, FRONT, WALL)))
    assert covered(view, LOWER, LOWER) == 0.0


def test_a_piece_is_claimed_where_most_of_it_is() -> None:
    most = UPPER | region(slice(80, 90), slice(40, 120))
    both = UPPER | LOWER
    assert (given_back(most, [UPPER, LOWER], both) == UPPER).all()
    assert (given_back(both, [UPPER, LOWER], both) == both).all()
    assert (given_back(both, [UPPER, LOWER], UPPER) == UPPER).all(), "what is near a thing, and beside it in the picture"


@pytest.mark.parametrize(
    ("thing", "deep", "allowed"), [(BLOCK, 0.0, True), (BLOCK, 0.018, False), (replace(BLOCK, mass=None), 0.018, True)]
)
def test_what_can_be_moved_lies_on_a_table_and_not_in_it(thing: Thing, deep: float, allowed: bool) -> None:
    view = seen(np.full((SIDE, SIDE), WALL))
    limits = {"within_m": 0.022, "loose_m": 0.012, "within": 0.1, "robot": 0.3}
    scene = Scene(Picture.of(view), view.world_cloud, (), limits, UPPER, (TABLE,))
    assert _beside(scene, Reading(appearance_of(thing), Pose((0.0, 0.0, 0.03 - deep)), 1.0, 1.0)) is allowed


@pytest.mark.parametrize(("height", "score"), [(0.03, 0.5), (0.05, 0.4)])
def test_what_hovers_is_less_likely_than_what_stands(height: float, score: float) -> None:
    view = seen(np.full((SIDE, SIDE), WALL))
    limits = {"hover_m": 0.006, "hover": 0.8, "bad": 0.35, "small": 1500, "rarer": 0.25}
    scene, look = Scene(Picture.of(view), view.world_cloud, (), limits, UPPER, (TABLE,)), appearance_of(BLOCK)
    reading, stands = Reading(look, Pose((0.0, 0.0, height)), 1.0, 0.5), Reading(look, Pose((0.1, 0.0, 0.03)), 1.0, 0.4)
    (among_rivals,) = _held(Region(scene, UPPER), [reading], [stands])
    (alone,) = _held(Region(scene, UPPER), [reading], [reading])
    assert among_rivals.score == pytest.approx(score)
    assert alone.score == pytest.approx(0.5)

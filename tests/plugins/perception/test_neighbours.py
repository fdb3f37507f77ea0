"""Regions of a picture that one thing explains together, among neighbours, and furniture that explains what stands off it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.chest import chest, engine_with_chest, pictured
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Mask, Pose, View
from cramlite_plugins.perception.kinds import joined as joining
from cramlite_plugins.perception.kinds import turned as turning
from cramlite_plugins.perception.kinds.agreement import Picture
from cramlite_plugins.perception.kinds.appearance import Appearance, appearance_of
from cramlite_plugins.perception.kinds.explain import PARAMETERS
from cramlite_plugins.perception.kinds.reading import Part, Reading, Scene
from cramlite_plugins.perception.kinds.region import Region
from cramlite_plugins.perception.kinds.turned import turned

LIMITS = {p.name: p.default for p in PARAMETERS}


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    """An engine that knows a chest with a drawer and a handle."""
    return engine_with_chest(tmp_path_factory.mktemp("chests"))


def scene_of(view: View, look: Appearance, front: Mask) -> Scene:
    return Scene(Picture.of(view), view.world_cloud, (look,), LIMITS, front)


def test_a_kind_whose_joints_are_told_as_its_file_has_them_is_as_filed(engine: Engine) -> None:
    assert appearance_of(chest(engine, 0.0)).as_filed
    assert not appearance_of(chest(engine, 0.08)).as_filed


def test_furniture_is_turned_to_explain_its_handle(engine: Engine) -> None:
    true = chest(engine, 0.0)
    view, look = pictured(true), appearance_of(true)
    local = true.pose.inverse().apply(view.world_cloud.reshape(-1, 3)).reshape(view.world_cloud.shape)
    front = view.valid & (np.abs(local[..., :2]) < 0.2).all(axis=2) & (local[..., 2] > 0.01)
    handle = front & (local[..., 0] > 0.118)
    middle = Pose(tuple(look.surface.centre))
    wrong = true.pose * middle * Pose.from_rotvec((0, 0, 0), (0, 0, math.pi)) * middle.inverse()
    parts = [Part(front & ~handle, (Reading(look, wrong, 0.8, 0.9),)), Part(handle, ())]
    (found,) = turned(scene_of(view, look, front), parts)
    metres, turn = found.readings[0].pose.distance(true.pose)
    assert metres < 0.006 and math.degrees(turn) < 3
    (kept,) = turned(scene_of(view, look, front), parts[:1])
    assert kept is parts[0], "without a neighbour that nothing explains"


def test_a_thing_in_two_regions_is_seen_beside_one_that_is_known(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    true = chest(engine, 0.0)
    view, look = pictured(true), appearance_of(true)
    masks = [np.zeros(view.depth.shape, bool) for _ in range(3)]
    for k, mask in enumerate(masks):
        mask[140:160, 150 + 40 * k : 180 + 40 * k] = view.valid[140:160, 150 + 40 * k : 180 + 40 * k]
    both, known = masks[0] | masks[1], Part(masks[2], (Reading(look, true.pose, 0.9, 0.6),))

    def read(region: Region) -> Part:
        return Part(region.mask, (Reading(look, true.pose, 0.9, 0.9),) if (region.mask == both).all() else ())

    monkeypatch.setattr(joining, "read", read)
    monkeypatch.setattr(joining, "claimed", lambda _, part, __: part)
    one = joining.joined(scene_of(view, look, masks[0]), [Part(masks[0], ()), Part(masks[1], ()), known], {})
    assert [bool((p.mask == both).all()) for p in one] == [False, True] and one[0] is known


@pytest.mark.parametrize(("score", "taken"), [(0.6, True), (0.4, False)])
def test_neighbours_that_one_thing_explains_well_are_not_taken_apart(
    engine: Engine, monkeypatch: pytest.MonkeyPatch, score: float, taken: bool
) -> None:
    true = chest(engine, 0.0)
    view, look = pictured(true), appearance_of(true)
    front = np.zeros(view.depth.shape, bool)
    for k in range(2):
        front[140:160, 150 + 40 * k : 180 + 40 * k] = view.valid[140:160, 150 + 40 * k : 180 + 40 * k]
    apart: list[Part] = []

    def read(region: Region) -> Part:
        return Part(region.mask, (Reading(look, true.pose, 1.0, score),) if (region.mask == front).all() else ())

    halves = [Part(np.where(np.arange(view.depth.shape[1]) < 185, front, False), ())]
    halves.append(Part(front & ~halves[0].mask, ()))
    monkeypatch.setattr(joining, "read", read)
    monkeypatch.setattr(joining, "claimed", lambda _, part, __: part)
    monkeypatch.setattr(joining, "wholes", lambda _, mask: halves if (mask == front).all() else [])
    monkeypatch.setattr(joining, "whole_or_split", lambda _, whole: apart.append(whole) or whole)
    (one,) = joining.interpreted(scene_of(view, look, front))
    assert (one.mask == front).all() and one.score == score
    assert bool(apart) != taken


def test_what_stands_on_furniture_is_no_part_of_it(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    true = chest(engine, 0.0)
    view, look = pictured(true), appearance_of(true)
    mask = view.valid & (np.abs(view.world_cloud[..., :2] - true.pose.position[:2]) < 0.15).all(axis=2)
    upper = mask & (np.cumsum(mask.any(1)) < mask.any(1).sum() * 0.4)[:, None]
    mug = replace(look, model=replace(look.model, mass=0.1))
    scene = scene_of(view, look, mask)

    def read(region: Region) -> Part:
        return Part(region.mask, (Reading(mug if (region.mask == upper).all() else look, true.pose, 0.8, 0.9),))

    monkeypatch.setattr(turning, "read", read)
    monkeypatch.setattr(turning, "claimed", lambda _, part, __: part if part.readings[0].appearance is look else Part(upper, part.readings))
    part = Part(mask, (Reading(look, true.pose, 0.7, 0.9),))
    for divided, count in (([mask & ~upper, upper], 2), ([mask], 1)):
        monkeypatch.setattr(turning, "pieces", lambda *_, divided=divided: divided)
        found = turned(scene, [part])
        assert len(found) == count
        assert (count == 1) == (found[0] is part)

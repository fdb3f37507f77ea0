"""Regions of a picture that one thing explains together, among neighbours, and furniture that explains what stands off it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.chest import chest, engine_with_chest, pictured

from cramlite import Engine
from cramlite.model import Mask, Pose, View
from cramlite_plugins.perception.kinds import joined as joining
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
    one = joining.joined(scene_of(view, look, masks[0]), [Part(masks[0], ()), Part(masks[1], ()), known])
    assert [bool((p.mask == both).all()) for p in one] == [False, True] and one[0] is known

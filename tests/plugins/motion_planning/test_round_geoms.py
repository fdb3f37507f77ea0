"""Round geoms about a joint's own axis stay as they are when it turns; what is beside the axis does not."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from helpers.scenes import TABLE, make

from cramlite_plugins.motion_planning.planning_scene import PlanningScene


@pytest.fixture(scope="module")
def place() -> PlanningScene:
    return make(TABLE)


def spread(place: PlanningScene, pairs: list[tuple[int, int]]) -> np.ndarray:
    """How much the distance of each pair differs between joint positions [m]."""
    rng, model, data, found = np.random.default_rng(1), place.compiled.model, place.data, []
    for _ in range(60):
        place.tcp(rng.uniform(-3.0, 3.0, len(place.robot.joints)))
        found.append([mujoco.mj_geomDistance(model, data, g, h, 2.0, None) for g, h in pairs])
    return np.ptp(np.array(found), axis=0)


def test_only_pairs_whose_distance_never_changes_are_left_out(place: PlanningScene) -> None:
    movers = place.movers
    alike = movers.moved @ 2.0 ** np.arange(movers.moved.shape[1])
    g, h = np.nonzero(np.triu((alike[:, None] != alike[None, :]) & (movers.apart() == 0)))
    pairs = list(zip(g.tolist(), h.tolist(), strict=True))
    assert len(pairs) >= 4 and spread(place, pairs).max() < 1e-5
    assert np.isneginf([place.need[pair] for pair in pairs]).all()


def test_what_a_joint_moves_by_its_shape_is_looked_at(place: PlanningScene) -> None:
    movers, coaxial = place.movers, place.movers.moved - place.movers.turned
    assert 0 < coaxial.sum() < len(coaxial)
    boxes = place.compiled.model.geom_type == mujoco.mjtGeom.mjGEOM_BOX
    assert not coaxial[boxes].any() and (movers.apart()[boxes & (movers.moved[:, -1] > 0)][:, ~movers.moved.any(axis=1)] > 0).all()

"""Poses from one depth image: right ones are found, and what cannot be known is not claimed."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import pytest

from cramlite.geometry import Pose
from cramlite.view import Mask, View
from cramlite.world import World
from cramlite_plugins.perception.camera import looking_at, render
from cramlite_plugins.perception.models import PoseModel, pose_model
from cramlite_plugins.perception.pose import estimate
from cramlite_plugins.simulation.compile import compile_world
from cramlite_plugins.simulation.models import hanger, hung, product

FLAT = (0.08, 0.02, 0.12)


@lru_cache(maxsize=8)
def _model(size: tuple[float, float, float] = FLAT) -> PoseModel:
    return pose_model(product("tea", Pose(), size))


@lru_cache(maxsize=4)
def _hanging(yaw: float, seed: int) -> tuple[View, Mask, Pose]:
    hook = hanger("hook", Pose((0.87, 0, 0.45), (0, 0, 0, 1)))
    tea = product("tea", Pose(), FLAT)
    tea = replace(tea, pose=hung(tea, hook, 0.07, yaw))
    compiled = compile_world(World((hook, tea)), {})
    view, ids = render(compiled.model, compiled.data(), looking_at((0.4, -0.2, 0.5), (0.8, 0, 0.38)), seed=seed)
    return view, ids == compiled.things["tea"].body, tea.pose


@pytest.mark.parametrize(("yaw", "seed"), [(0.0, 1), (0.3, 2)])
def test_a_hanging_product_is_found(yaw: float, seed: int) -> None:
    view, mask, truth = _hanging(yaw, seed)
    found = estimate(view, mask, _model())
    metres, turn = _model().difference(found[0].pose, truth)
    assert metres < 0.005 and turn < math.radians(5) and found[0].score > 0.6
    assert len(found) > 1 and found[0].reasons


def test_the_front_of_a_symmetric_product_stays_open() -> None:
    """Both ways round come at the same score; without the symmetry one of them would be half a turn off."""
    view, mask, truth = _hanging(0.0, 1)
    best, other = estimate(view, mask, _model())[:2]
    assert best.score == other.score
    assert sorted(round(h.pose.distance(truth)[1] / math.pi) for h in (best, other)) == [0, 1]


def test_another_product_is_not_claimed() -> None:
    """The model of another product scores clearly lower on the same mask."""
    view, mask, _ = _hanging(0.0, 1)
    right, wrong = (estimate(view, mask, _model(s))[0].score for s in (FLAT, (0.04, 0.025, 0.15)))
    assert wrong < 0.6 < right

"""Poses from one depth image: right ones are found, and what cannot be known is not claimed."""

from __future__ import annotations

import importlib.util
import math
import runpy
import sys
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import pytest
from msgspec.structs import replace
from scipy import ndimage

from cramlite import data_folder
from cramlite.model import Intrinsics, Mask, Pose, View, World
from cramlite.plugin import UserError
from cramlite_plugins.locations.viewpoints import looking_at
from cramlite_plugins.objects.products_and_fixtures import hanger, hung, product
from cramlite_plugins.perception.pose import libraries as pose_libraries
from cramlite_plugins.perception.pose.estimate import PoseHypothesis, estimate, keeps_to
from cramlite_plugins.perception.pose.model import PoseModel, pose_model
from cramlite_plugins.perception.pose.prior import UPRIGHT, Alignment, Prior
from cramlite_plugins.simulation.camera.depth_camera import render
from cramlite_plugins.simulation.model.compile import compile_world

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


@pytest.mark.heavy
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


def test_nothing_is_found_where_nothing_was_measured() -> None:
    view, mask, _ = _hanging(0.0, 1)
    blind = View(view.rgb, np.full_like(view.depth, np.nan), view.intrinsics, view.camera)
    few = np.zeros_like(mask)
    few[np.nonzero(mask)[0][:5], np.nonzero(mask)[1][:5]] = True
    assert estimate(blind, mask, _model()) == []
    assert estimate(view, np.zeros_like(mask), _model()) == []
    assert estimate(view, few, _model()) == []


def test_wrong_intrinsics_are_not_believed() -> None:
    """Twice the focal length: everything looks half as large, and no pose explains that."""
    view, mask, _ = _hanging(0.0, 1)
    wrong = Intrinsics(2 * 385, 2 * 385, 319.5, 239.5, 640, 480)
    found = estimate(View(view.rgb, view.depth, wrong, view.camera), mask, _model())
    assert not found or found[0].score < 0.6


def test_a_mask_of_something_else_is_not_claimed() -> None:
    """The panel behind the product."""
    view, mask, _ = _hanging(0.0, 1)
    panel = view.valid & ~mask & (view.world_cloud[..., 0] > 0.85)
    found = estimate(view, panel, _model())
    assert not found or found[0].score < 0.6


def test_results_keep_to_the_prior() -> None:
    view, mask, _ = _hanging(0.0, 1)
    assert all(keeps_to(h.pose, UPRIGHT) for h in estimate(view, mask, _model()))
    down = Prior((Alignment(((0.0, 0.0, -1.0),), ((0.0, 0.0, 1.0),)),))
    assert all(not keeps_to(h.pose, UPRIGHT) for h in estimate(view, mask, _model(), down))


def test_without_a_prior_the_pose_is_found_too() -> None:
    view, mask, truth = _hanging(0.3, 2)
    metres, turn = _model().difference(estimate(view, mask, _model(), Prior())[0].pose, truth)
    assert metres < 0.005 and turn < math.radians(5)


def test_an_occluder_that_splits_the_mask() -> None:
    view, mask, truth = _hanging(0.0, 1)
    rows = np.flatnonzero(mask.any(1))
    bar = slice(int(rows[0]) + 30, int(rows[0]) + 44)
    depth = np.array(view.depth)
    depth[bar] = 0.3
    mask = mask.copy()
    mask[bar] = False
    found = estimate(View(view.rgb, depth, view.intrinsics, view.camera), mask, _model())
    metres, turn = _model().difference(found[0].pose, truth)
    assert metres < 0.005 and turn < math.radians(5)


def test_a_part_of_the_mask_that_is_not_the_object() -> None:
    """A piece of the panel, two fifths of the mask: the pose is found all the same, but not for that piece alone."""
    view, mask, truth = _hanging(0.0, 1)
    away = view.valid & ~ndimage.binary_dilation(mask, iterations=20) & (view.world_cloud[..., 0] > 0.85)
    panel = np.zeros_like(mask)
    panel.reshape(-1)[np.flatnonzero(away)[: int(0.67 * mask.sum())]] = True
    metres, turn = _model().difference(estimate(view, mask | panel, _model())[0].pose, truth)
    assert metres < 0.005 and turn < math.radians(5)
    alone = estimate(view, panel, _model())
    assert not alone or alone[0].score < 0.6


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["paper", "one_plane_icp", "one_icp"])
def test_the_other_recipes_answer(name: str) -> None:
    """They need not be right (docs/figures/perception_methods.yaml), but say a pose near the cloud, and nothing for no cloud."""
    method = runpy.run_path(str(data_folder("experiments") / "pose_recipes" / "paper_registration.py"))[name]
    view, mask, truth = _hanging(0.0, 1)
    found = method(view, mask, _model())
    assert found and _model().difference(found[0].pose, truth)[0] < 0.05
    assert method(view, np.zeros_like(mask), _model()) == []


@pytest.mark.parametrize("method", [pose_libraries.open3d_pose, pose_libraries.small_gicp_pose])
def test_extras_work_or_say_what_is_missing(method: Callable[..., list[PoseHypothesis]]) -> None:
    module = method.__name__.removesuffix("_pose")
    view, mask, truth = _hanging(0.0, 1)
    if importlib.util.find_spec(module) is None:
        extra = module.replace("_", "-")
        with pytest.raises(UserError, match=rf"pip install 'cramlite\[{extra}\]'"):
            method(view, mask, _model())
        return
    metres, turn = _model().difference(method(view, mask, _model())[0].pose, truth)
    assert metres < 0.005 and turn < math.radians(5)


def test_an_extra_that_is_absent_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "small_gicp", None)
    view, mask, _ = _hanging(0.0, 1)
    with pytest.raises(UserError, match=r"pip install 'cramlite\[small-gicp\]'"):
        pose_libraries.small_gicp_pose(view, mask, _model())

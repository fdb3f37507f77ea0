"""Baselines for pose estimation: ICP from principal axes as an expert for ``--plugin``, and two single ICPs for the benchmark.

The paper's recipe: the principal axes of cloud and model are laid on each other in 12 ways, each is refined by
point-to-point ICP (Besl and McKay, 1992), and the best fitness wins. tests/benchmarks/perception_pose.py compares.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from cramlite.model import Floats, Mask, Pose, Value, View
from cramlite.plugin import Expert, Inputs, hookimpl
from cramlite_plugins.perception.pose.estimate import LEAST, PoseHypothesis, keeps_to
from cramlite_plugins.perception.pose.icp import spread
from cramlite_plugins.perception.pose.model import PoseModel, cube_rotations
from cramlite_plugins.perception.pose.prior import UPRIGHT, Prior
from cramlite_plugins.perception.pose.registration import FITTING, NEEDED, registered
from cramlite_plugins.perception.pose.starts import scene_clouds

POINTS = 1500
REACH = (0.05, 0.01)
"""Largest distance of a matched pair of points, in the first and in the last iteration [m]."""
FIT = 0.005
"""Largest distance from the model of a point that counts as an inlier in the fitness [m]."""
ITERATIONS = 40


class Fit(Value, eq=False):
    """ICP result: transform scene to model, share of inlier points and their mean distance [m]."""

    scene_to_model: Pose
    fitness: float
    distance: float


@hookimpl
def experts() -> Iterable[Expert]:
    """Declare the expert that estimates poses by the paper's recipe: ICP from principal axes.

    Its stated cost was measured with one model at 640 x 480 pixels (tests/benchmarks/perception_pose.py).
    """
    about = "principal axes and 12 ICPs, as in the paper"
    return [
        Expert("paper_registration", about, NEEDED, ("hypotheses",), by_paper, "object", cost_ms=900.0, parameters=FITTING)
    ]


def by_paper(inputs: Inputs) -> Mapping[str, Any]:
    """Estimate, by ICP from principal axes, the poses of the models that an object's colour and size allow."""
    return registered(inputs, paper)


def one_icp(view: View, mask: Mask, model: PoseModel, prior: Prior = UPRIGHT) -> list[PoseHypothesis]:
    """Estimate a pose by one point-to-point ICP that starts with the model's own orientation and with both
    centroids equal."""
    del prior
    points = _scene(view, mask)
    if points is None:
        return []
    return [_hypothesis(_icp(points, model, Pose(tuple(model.centre - points.mean(0))), planes=False))]


def one_plane_icp(view: View, mask: Mask, model: PoseModel, prior: Prior = UPRIGHT) -> list[PoseHypothesis]:
    """Estimate a pose by one point-to-plane ICP that starts upright, the model's front (-y) to the camera."""
    del prior
    points = _scene(view, mask)
    if points is None:
        return []
    back = points.mean(0) - np.array(view.camera.position)
    turn = Pose.from_axes((0, 0, 0), (0, 0, 1), np.cross((back[0], back[1], 0.0), (0, 0, 1.0))).inverse()
    start = Pose(tuple(model.centre - turn.rotate(points.mean(0))), turn.quaternion)
    return [_hypothesis(_icp(points, model, start, planes=True))]


def paper(view: View, mask: Mask, model: PoseModel, prior: Prior = UPRIGHT) -> list[PoseHypothesis]:
    """Estimate poses by 12 point-to-point ICPs from aligned principal axes; return those that the prior
    allows, the best fitness first."""
    points = _scene(view, mask)
    if points is None:
        return []
    fits = [_icp(points, model, start, planes=False) for start in _principal_starts(points, model)]
    fits.sort(key=lambda f: (-round(f.fitness, 2), f.distance))
    found = [_hypothesis(f) for f in fits]
    return [h for h in found if keeps_to(h.pose, prior)]


def _scene(view: View, mask: Mask) -> Floats | None:
    """Points of the largest cluster in the world frame; None if there are too few."""
    parts = scene_clouds(view, mask)
    if not parts or len(parts[0].points) < LEAST:
        return None
    return view.camera.apply(spread(parts[0].points, POINTS))


def _principal_starts(points: Floats, model: PoseModel) -> Iterator[Pose]:
    """Start poses for ICP: 12 of the 24 ways to align the principal axes of two point clouds, first those that
    keep the third axis, up to its sign."""
    of_scene, of_model = _axes(points), _axes(np.asarray(model.points, dtype=float))
    for way in sorted(cube_rotations(), key=lambda p: -abs(float(p.rotation[2, 2])))[:12]:
        turn = of_model @ way.rotation @ of_scene.T
        yield Pose(tuple(model.points.mean(0) - turn @ points.mean(0)), Pose.from_matrix(turn).quaternion)


def _axes(points: Floats) -> Floats:
    _, axes = np.linalg.eigh(np.cov((points - points.mean(0)).T))
    return np.asarray(axes if np.linalg.det(axes) > 0 else -axes)


def _icp(points: Floats, model: PoseModel, start: Pose, planes: bool) -> Fit:
    tree = model.tree
    pose = start
    for k in range(ITERATIONS):
        reach = REACH[0] * (REACH[1] / REACH[0]) ** min(1.0, 2 * k / ITERATIONS)
        moved = pose.apply(points)
        away, which = tree.query(moved, distance_upper_bound=reach)
        near = np.isfinite(away)
        if near.sum() < 6:
            break
        normals = model.normals[which[near]] if planes else None
        pose = _step(moved[near], np.asarray(model.points[which[near]], dtype=float), normals) * pose
    away, _ = tree.query(pose.apply(points))
    fit = away < FIT
    return Fit(pose, float(fit.mean()), float(away[fit].mean()) if fit.any() else FIT)


def _step(moved: Floats, nearest: Floats, normals: Floats | None) -> Pose:
    """The transform that brings points nearest to their matched points (Kabsch), or to the tangent planes there
    if normals are given."""
    if normals is None:
        a, b = moved.mean(0), nearest.mean(0)
        u, _, vt = np.linalg.svd((moved - a).T @ (nearest - b))
        turn = vt.T @ np.diag([1, 1, np.linalg.det(vt.T @ u.T)]) @ u.T
        return Pose(tuple(b - turn @ a), Pose.from_matrix(turn).quaternion)
    rows = np.concatenate([np.cross(moved, normals), normals], axis=1)
    gap = np.einsum("ij,ij->i", moved - nearest, normals)
    step = np.linalg.lstsq(rows.T @ rows + 1e-6 * np.eye(6), -rows.T @ gap, rcond=None)[0]
    return Pose.from_rotvec(step[3:], step[:3])


def _hypothesis(fit: Fit) -> PoseHypothesis:
    reason = (
        f"{100 * fit.fitness:.0f} % of the points within {1000 * FIT:.0f} mm, {1000 * fit.distance:.1f} mm on average"
    )
    return PoseHypothesis(fit.scene_to_model.inverse(), fit.fitness, (reason,))

"""Pose estimation with the ICP of Open3D or of small_gicp; initial poses, prior and score are those of ``pose``.

Both are extras: ``pip install cramlite[open3d]`` (0.9 GB), ``pip install cramlite[small-gicp]``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cramlite.model import Floats, Mask, View
from cramlite.plugin import UserError

from .estimate import LEAST, PoseHypothesis, allowed, best, distinct, hypotheses
from .icp import PoseBatch, spread
from .model import Floats32, PoseModel
from .outline import Outline
from .prior import UPRIGHT, Prior
from .score import score_poses
from .starts import scene_clouds, starts_for

Align = Callable[[Floats, Floats, float], Floats]
"""(scene (N, 3), start (4, 4), reach [m]) -> scene to model (4, 4)."""
COARSE, FINE, KEPT = (250, 0.020), (1200, 0.006), 6
"""Points and reach [m] of the two stages, and how many starts go on to the second."""
ITERATIONS = 20


def open3d_pose(view: View, mask: Mask, model: PoseModel, prior: Prior = UPRIGHT) -> list[PoseHypothesis]:
    """Estimate a pose by 24 point-to-plane ICPs of Open3D in two stages.

    Raises:
        UserError: Open3D is not installed or does not load; says what is missing.
    """
    return _estimate(view, mask, model, prior, _open3d(model))


def small_gicp_pose(view: View, mask: Mask, model: PoseModel, prior: Prior = UPRIGHT) -> list[PoseHypothesis]:
    """Estimate a pose by 24 point-to-plane ICPs of small_gicp in two stages.

    Raises:
        UserError: small_gicp is not installed.
    """
    return _estimate(view, mask, model, prior, _small_gicp(model))


def _estimate(view: View, mask: Mask, model: PoseModel, prior: Prior, align: Align) -> list[PoseHypothesis]:
    parts = scene_clouds(view, mask)
    if not parts or len(parts[0].points) < LEAST:
        return []
    scene, outline = parts[0].points, Outline.of(view, parts[0].mask)
    starts = _aligned(scene, starts_for(view.camera, model, prior, scene), align, *COARSE)
    starts = best(model, scene, outline, allowed(view, prior, starts), KEPT, 400)
    starts = allowed(view, prior, _aligned(scene, starts, align, *FINE))
    return distinct(model, prior, hypotheses(view, starts, score_poses(model, scene, outline, starts)))


def _aligned(scene: Floats32, starts: PoseBatch, align: Align, count: int, reach: float) -> PoseBatch:
    points = np.asarray(spread(scene, count), dtype=float)
    ends = np.array([align(points, _matrix(t, s), reach) for t, s in zip(starts.turn, starts.shift, strict=True)])
    ends = ends.reshape(-1, 4, 4).astype(np.float32)
    return PoseBatch(ends[:, :3, :3], ends[:, :3, 3])


def _matrix(turn: Floats, shift: Floats) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, shift
    return matrix


def _open3d(model: PoseModel) -> Align:
    o3d = _library("open3d", "open3d")
    icp = o3d.pipelines.registration
    target = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.asarray(model.points, dtype=float)))
    target.normals = o3d.utility.Vector3dVector(np.asarray(model.normals, dtype=float))
    method = icp.TransformationEstimationPointToPlane()
    limit = icp.ICPConvergenceCriteria(max_iteration=ITERATIONS)

    def align(points: Floats, start: Floats, reach: float) -> Floats:
        source = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
        found = icp.registration_icp(source, target, reach, start, method, limit)
        return np.asarray(found.transformation)

    return align


def _small_gicp(model: PoseModel) -> Align:
    gicp = _library("small_gicp", "small_gicp")
    target = gicp.PointCloud(np.asarray(model.points, dtype=float))
    tree = gicp.KdTree(target)
    gicp.estimate_normals(target, tree, num_neighbors=10)

    def align(points: Floats, start: Floats, reach: float) -> Floats:
        found = gicp.align(
            target, gicp.PointCloud(points), tree, init_T_target_source=start, registration_type="PLANE_ICP",
            max_correspondence_distance=reach, max_iterations=ITERATIONS,
        )  # fmt: skip
        return np.asarray(found.T_target_source)

    return align


def _library(module: str, extra: str) -> Any:
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise UserError(
            f"The pose expert '{extra}' needs the library {module}, which is not installed or does not load "
            f"({error}); run: pip install 'cramlite[{extra.replace('_', '-')}]'"
            + (" and, on Debian, apt-get install libusb-1.0-0 libgl1 libegl1 libx11-6" if module == "open3d" else "")
            + ". The default pose expert needs neither."
        ) from error

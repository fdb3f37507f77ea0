"""Places where a known model cannot be: inside of the furniture whose place is known, and of the robot."""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats, Mask

from ..fixtures import depth_within, distance
from .appearance import Appearance
from .reading import Scene


def possible(scene: Scene, appearance: Appearance, points: Floats) -> Mask:
    """Check at which of P poses (P,) a model lies outside of the furniture whose place is known, and of the robot.

    Args:
        points: (P, N, 3) some of the model's surface at each pose, in the world [m].
    """
    every, found = points.reshape(-1, 3), np.ones(len(points), bool)
    most = scene.limits["within_m" if appearance.model.mass is None else "loose_m"]
    if scene.robot is not None:
        found &= _shares(_on_robot(scene, every), points) <= scene.limits["robot"]
    for thing in scene.fixtures:
        found &= _shares(depth_within(every, thing) > most, points) < scene.limits["within"]
    return found


def hovers(scene: Scene, appearance: Appearance, points: Floats) -> bool:
    """Check whether a model that can be moved, with points (N, 3) of its surface in the world [m], touches no furniture whose place is
    known."""
    if appearance.model.furniture or not scene.fixtures:
        return False
    return all(float(distance(points, t).min()) > scene.limits["hover_m"] for t in scene.fixtures if t.geoms)


def _shares(those: Mask, points: Floats) -> Floats:
    return np.asarray(those.reshape(points.shape[:2]).mean(axis=1))


def _on_robot(scene: Scene, points: Floats) -> Mask:
    """Which points, in the world frame, are where the camera would see the robot itself."""
    view = scene.picture.view
    seen = view.camera.inverse().apply(points)
    column, row = np.rint(np.nan_to_num(view.intrinsics.project(seen), nan=-1.0)).astype(int).T
    inside = (column >= 0) & (row >= 0) & (column < view.intrinsics.width) & (row < view.intrinsics.height)
    away = np.full(len(points), np.inf)
    away[inside] = np.abs(scene.robot[row[inside], column[inside]] - seen[inside, 2]) if scene.robot is not None else np.inf
    return np.asarray(np.nan_to_num(away, nan=np.inf) < scene.limits["robot_m"])

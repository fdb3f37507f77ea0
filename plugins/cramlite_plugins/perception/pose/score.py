"""Score of a pose hypothesis against the depth image.

It combines the share of the mask that the model explains and the share of its visible surface that the image
does not contradict.
"""

from __future__ import annotations

import numpy as np

from cramlite.model import Mask, Value

from .icp import PoseBatch, dot, match, spread
from .model import Floats32, PoseModel
from .outline import Outline, tolerance

SCENE, SURFACE = 400, 700
"""Number of points of the scene and of the model that are compared."""
ENOUGH = 0.45
"""Share of the visible side that must be seen for full confidence."""


class Scores(Value):
    """Scores of H hypotheses on a model's pose; each field is an array (H,) with a number for each hypothesis.

    Args:
        score: 0 to 1, the product of the three below and of ``closeness``.
        explained: share of the mask's points on the model's surface.
        free: of the model's visible points that nothing hides, the share that the mask shows.
        seen: share of the model's visible points that the mask shows.
        distance: mean distance of scene and model, cut off at the tolerance, as a share of it.
    """

    score: Floats32
    explained: Floats32
    free: Floats32
    seen: Floats32
    distance: Floats32


def score_poses(
    model: PoseModel, scene: Floats32, outline: Outline, starts: PoseBatch, surface: int = SURFACE
) -> Scores:
    """Score hypotheses against the depth image.

    Args:
        scene: (N, 3) all points of the mask, the optical frame [m].
    """
    if len(starts) == 0:
        return Scores(*np.zeros((5, 0), np.float32))
    explained, distance = _explained(model, spread(scene, SCENE), starts)
    agree, wrong, visible = _shown(model, scene.mean(0), outline, starts, surface)
    free = agree / np.maximum(agree + wrong, 1)
    seen = agree / np.maximum(visible, 1)
    score = explained * free**2 * np.minimum(1, seen / ENOUGH) * (1 - 0.3 * distance)
    return Scores(score, explained, free, seen, distance)


def _explained(model: PoseModel, points: Floats32, starts: PoseBatch) -> tuple[Floats32, Floats32]:
    """Share of the scene's points that lie on the model's visible side, and the mean distance of all points from that side.

    The distance of a point is in units of the tolerance, and 1 at most.
    """
    moved = starts.turn @ points.T + starts.shift[:, :, None]
    ray = points.mean(0) / np.linalg.norm(points.mean(0))
    nearest, normals, facing = match(model, moved, np.asarray(starts.turn @ ray))
    gap = moved - nearest
    plane = np.abs(dot(gap, normals))
    beside = np.sqrt(np.maximum(dot(gap, gap) - plane * plane, 0))
    near = tolerance(points[:, 2])
    away = np.maximum(plane, np.maximum(0, beside - 0.001)) / near
    away = np.where(facing, away, 1.0)
    return (away < 1).mean(1).astype(np.float32), np.minimum(away, 1).mean(1).astype(np.float32)


def _shown(
    model: PoseModel, middle: Floats32, outline: Outline, starts: PoseBatch, surface: int
) -> tuple[Floats32, Floats32, Floats32]:
    """Numbers of the model's visible points (H,): confirmed by the mask, contradicted by the image, and all of them."""
    which = np.linspace(0, len(model.points) - 1, surface).astype(np.int64)
    points, normals = model.points[which], model.normals[which]
    facing = -(starts.turn @ (middle / np.linalg.norm(middle))) @ normals.T
    facing *= facing > 0.1
    seen = starts.turn.transpose(0, 2, 1) @ (points.T - starts.shift[:, :, None])
    _, _, flat, inside = outline.pixels(seen.transpose(0, 2, 1))
    facing *= outline.in_view(seen.transpose(0, 2, 1))  # what is outside the picture tells nothing
    z = seen[:, 2]
    on = outline.mask.reshape(-1)[flat] & inside
    measured = outline.depth.reshape(-1)[flat]
    behind = z - measured > 2 * tolerance(z)  # of the object's own surface: the model hides it itself, or it is wrong
    ahead = measured - z > 2 * tolerance(z)
    denied = (on & ahead) | (~on & ~outline.hidden(flat, z))
    return _sum(facing, on & ~behind & ~ahead), _sum(facing, denied), _sum(facing, ~(on & behind))


def _sum(area: Floats32, those: Mask) -> Floats32:
    """Area of those points, seen from the camera: pixels are counted, and a face that the camera grazes has few."""
    return np.asarray(np.einsum("hn,hn->h", area, those), dtype=np.float32)

"""Registration of one scene to a model from many starts at once: hypotheses are one axis of the arrays.

Scene to model: each scene point is matched with the nearest model point, looked up in a grid, never searched for. The
error is the distance to the tangent plane (Chen and Medioni, 1992), with Tukey's weights; where a scene point lies beside
the model, and where a model point covers pixels that belong to nothing of it, the whole vector counts: they hold what
tangent planes leave free. Equations are linearised in the model's frame and solved for all hypotheses together.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .models import Floats32, PoseModel
from .outline import Outline

Batch = Floats32


@dataclass(frozen=True)
class Stage:
    """One stage of registration, from coarse to fine.

    Args:
        points: scene points used; iterations: of Gauss and Newton.
        reach: distance beyond which a match does not count, at the beginning and at the end [m].
        beside: weight of the whole vector where a scene point is beside the model by more than ``slack`` [m].
        outline: model points whose pixels are compared with the outline; 0 leaves it out. weight: of each.
    """

    points: int
    iterations: int
    reach: tuple[float, float]
    beside: float = 0.3
    slack: float = 0.002
    outline: int = 0
    weight: float = 0.5


@dataclass(frozen=True, eq=False)
class Starts:
    """Poses of the camera's optical frame in the model's: x_model = turn x + shift; (H, 3, 3) and (H, 3)."""

    turn: Batch
    shift: Batch

    def __len__(self) -> int:
        return len(self.turn)

    def pick(self, which: Any) -> Starts:
        """Those of some indices."""
        return Starts(self.turn[which], self.shift[which])

    def joined(self, other: Starts) -> Starts:
        return Starts(np.concatenate([self.turn, other.turn]), np.concatenate([self.shift, other.shift]))


def spread(points: Floats32, count: int) -> Floats32:
    """At most ``count`` of the points, evenly by index."""
    return points if len(points) <= count else points[np.linspace(0, len(points) - 1, count).astype(np.int64)]


def register(model: PoseModel, scene: Floats32, starts: Starts, stage: Stage, outline: Outline) -> Starts:
    """Refine all starts.

    Args:
        scene: (N, 3) in the optical frame [m].
    """
    points = spread(scene, stage.points)
    ray = points.mean(0) / np.linalg.norm(points.mean(0))
    turn, shift = starts.turn, starts.shift
    for k in range(stage.iterations):
        share = k / max(1, stage.iterations - 1)
        reach = stage.reach[0] ** (1 - share) * stage.reach[1] ** share
        matrix, vector = _surface_terms(model, points, turn, shift, ray, reach, stage)
        if stage.outline:
            more, right = _outline_terms(model, turn, shift, ray, outline, stage)
            matrix, vector = matrix + more, vector + right
        turn, shift = _step(matrix, vector, turn, shift)
    return Starts(turn, shift)


def match(model: PoseModel, moved: Batch, rays: Batch) -> tuple[Batch, Batch, Batch]:
    """The nearest model points that face the camera.

    Args:
        moved: (H, N, 3) scene points in the model's frame; rays: (H, 3) viewing directions there.

    Returns:
        Points and normals (H, N, 3), and 1 where the normal faces the camera (H, N).
    """
    index = model.grid.look_up(moved)
    away = np.einsum("hnj,hj->hn", model.normals[index], rays) > 0
    index = np.where(away, model.twins[index], index)
    normals = model.normals[index]
    facing = np.einsum("hnj,hj->hn", normals, rays) < 0.05
    return model.points[index], normals, facing.astype(np.float32)


def _surface_terms(
    model: PoseModel, points: Floats32, turn: Batch, shift: Batch, ray: Floats32, reach: float, stage: Stage
) -> tuple[Batch, Batch]:
    moved = points @ turn.transpose(0, 2, 1) + shift[:, None]
    nearest, normals, facing = match(model, moved, np.asarray(turn @ ray))
    gap = moved - nearest
    plane = np.einsum("hnj,hnj->hn", gap, normals)
    far = np.einsum("hnj,hnj->hn", gap, gap)
    weight = facing * np.maximum(0.0, 1 - far / np.float32(reach * reach)) ** 2
    beside = np.sqrt(np.maximum(far - plane * plane, 0)) > stage.slack
    rows = np.concatenate([cross(moved, normals), normals], axis=2)
    weighted = rows * weight[..., None]
    matrix = weighted.transpose(0, 2, 1) @ rows
    vector = np.einsum("hnj,hn->hj", weighted, plane)
    more, right = _vector_terms(moved, gap, weight * beside * np.float32(stage.beside))
    return matrix + more, vector + right


def _outline_terms(
    model: PoseModel, turn: Batch, shift: Batch, ray: Floats32, outline: Outline, stage: Stage
) -> tuple[Batch, Batch]:
    """Model points whose pixels show what is behind the object are drawn back into it."""
    which = np.linspace(0, len(model.points) - 1, stage.outline).astype(np.int64)
    points, normals = model.points[which], model.normals[which]
    facing = (turn @ ray) @ normals.T < 0.05
    seen = (points - shift[:, None]) @ turn  # the inverse of a rotation is its transpose
    pull = outline.pull(seen)
    moved = points + pull @ turn.transpose(0, 2, 1)
    outside = facing & (pull != 0).any(-1)  # a point without a pull would hold its place instead
    return _vector_terms(moved, moved - points, outside * np.float32(stage.weight))


def _vector_terms(moved: Batch, gap: Batch, weight: Batch) -> tuple[Batch, Batch]:
    """Normal equations of |gap + w x moved + v|^2, (H, 6, 6) and (H, 6)."""
    hypotheses = len(moved)
    weighted = moved * weight[..., None]
    outer = weighted.transpose(0, 2, 1) @ moved
    first = weighted.sum(1)
    matrix = np.zeros((hypotheses, 6, 6), np.float32)
    matrix[:, :3, :3] = np.trace(outer, axis1=1, axis2=2)[:, None, None] * np.eye(3, dtype=np.float32) - outer
    matrix[:, :3, 3:] = _cross_matrix(first)
    matrix[:, 3:, :3] = -matrix[:, :3, 3:]
    matrix[:, 3:, 3:] = weight.sum(1)[:, None, None] * np.eye(3, dtype=np.float32)
    pushed = gap * weight[..., None]
    vector = np.concatenate([cross(moved, pushed).sum(1), pushed.sum(1)], axis=1)
    return matrix, vector


def cross(a: Batch, b: Batch) -> Batch:
    """Cross products of (..., 3); three times as fast as numpy's on small batches."""
    out = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return out


def _cross_matrix(v: Batch) -> Batch:
    """(H, 3, 3): the matrices that take the cross product with ``v``."""
    matrix = np.zeros((len(v), 3, 3), np.float32)
    matrix[:, 0, 1], matrix[:, 0, 2], matrix[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return matrix - matrix.transpose(0, 2, 1)


def _step(matrix: Batch, vector: Batch, turn: Batch, shift: Batch) -> tuple[Batch, Batch]:
    """One damped step: what nothing holds (2 % of the strongest constraint) stays."""
    scale = np.diag(np.array([0.05, 0.05, 0.05, 1, 1, 1], np.float32) ** 2)
    strongest = np.trace(matrix[:, 3:, 3:], axis1=1, axis2=2)[:, None, None] + 1e-6
    step = np.linalg.solve((matrix + 0.004 * strongest * scale).astype(np.float64), -vector[..., None])[..., 0]
    angle = np.linalg.norm(step[:, :3], axis=1)
    step *= np.minimum(1.0, 0.35 / np.maximum(angle, 1e-9))[:, None]
    rotation = rotations(step[:, :3]).astype(np.float32)
    moved = np.einsum("hij,hj->hi", rotation, shift) + step[:, 3:].astype(np.float32)
    return np.asarray(rotation @ turn), moved


def rotations(vectors: Batch) -> Batch:
    """Rotation matrices (H, 3, 3) of rotation vectors (H, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=1)
    axis = vectors / np.maximum(angle, 1e-12)[:, None]
    k = np.zeros((len(vectors), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -axis[:, 2], axis[:, 1], -axis[:, 0]
    k -= k.transpose(0, 2, 1)
    sine, rest = np.sin(angle)[:, None, None], (1 - np.cos(angle))[:, None, None]
    return np.asarray(np.eye(3) + sine * k + rest * (k @ k))

"""Batched ICP: registration of one scene to a model from many initial poses at once.

Scene to model: each scene point is matched with the nearest model point, looked up in a grid, never searched for. The
error is the distance to the tangent plane (Chen and Medioni, 1992), with Tukey's weights; where a scene point lies beside
the model, and where a model point covers pixels that belong to nothing of it, the whole vector counts: they hold what
tangent planes leave free. Equations are linearised in the model's frame and solved for all hypotheses together.
Arrays of points are (H, 3, N), not (H, N, 3): numpy's loops then run over points, in half the time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cramlite.model import Mask, Value
from cramlite.plugin import checkpoint

from .model import Floats32, PoseModel
from .outline import Outline

Batch = Floats32
_IDENTITY = np.eye(3, dtype=np.float32)
_DAMPING = 0.004 * np.diag(np.array([0.05, 0.05, 0.05, 1, 1, 1], np.float32) ** 2)
"""Damping of the Gauss-Newton step, as a share of the strongest constraint; a product's half length, 5 cm, converts angles to shifts
[m]."""


class RegistrationStage(Value):
    """One stage of coarse-to-fine registration.

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


class PoseBatch(Value, eq=False):
    """Batch of H poses of the optical frame in the model's frame: x_model = turn x + shift; (H, 3, 3) and (H, 3) [m]."""

    turn: Batch
    shift: Batch

    def __len__(self) -> int:
        return len(self.turn)

    def pick(self, which: Any) -> PoseBatch:
        """Select poses by index or mask."""
        return PoseBatch(self.turn[which], self.shift[which])

    def joined(self, other: PoseBatch) -> PoseBatch:
        """Concatenate two batches of poses."""
        return PoseBatch(np.concatenate([self.turn, other.turn]), np.concatenate([self.shift, other.shift]))


def spread(points: Floats32, count: int) -> Floats32:
    """Subsample at most ``count`` of the points (N, 3), evenly by index."""
    return points if len(points) <= count else points[np.linspace(0, len(points) - 1, count).astype(np.int64)]


def register(model: PoseModel, scene: Floats32, starts: PoseBatch, stage: RegistrationStage, outline: Outline) -> PoseBatch:
    """Refine all initial poses by Gauss-Newton iterations of one stage.

    Args:
        scene: (N, 3) in the optical frame [m].
    """
    points = np.ascontiguousarray(spread(scene, stage.points).T)
    ray = points.mean(1) / np.linalg.norm(points.mean(1))
    which = np.linspace(0, len(model.points) - 1, stage.outline).astype(np.int64)
    surface = np.ascontiguousarray(model.points[which].T), np.ascontiguousarray(model.normals[which].T)
    turn, shift = starts.turn, starts.shift
    for k in range(stage.iterations):
        checkpoint()
        share = k / max(1, stage.iterations - 1)
        reach = stage.reach[0] ** (1 - share) * stage.reach[1] ** share
        matrix, vector = _surface_terms(model, points, turn, shift, ray, reach, stage)
        if stage.outline:
            more, right = _outline_terms(surface, turn, shift, ray, outline, stage)
            matrix, vector = matrix + more, vector + right
        turn, shift = _step(matrix, vector, turn, shift)
    return PoseBatch(turn, shift)


def match(model: PoseModel, moved: Batch, rays: Batch) -> tuple[Batch, Batch, Mask]:
    """Find, for each scene point, the nearest model point on a surface that faces the camera.

    Args:
        moved: (H, 3, N) scene points in the model's frame; rays: (H, 3) viewing directions there.

    Returns:
        Points and normals (H, 3, N), and whether the normal faces the camera (H, N).
    """
    index = model.grid.look_up(moved.transpose(0, 2, 1))
    nearest = np.take(model.surface, index, axis=0)
    away = (nearest[..., 3:] @ rays[:, :, None])[..., 0] > 0
    nearest[away] = model.surface[model.opposite_points[index[away]]]
    nearest = np.ascontiguousarray(nearest.transpose(0, 2, 1))
    normals = nearest[:, 3:]
    return nearest[:, :3], normals, (rays[:, None] @ normals)[:, 0] < 0.05


def dot(a: Batch, b: Batch) -> Batch:
    """Return the scalar products (H, N) of vectors (H, 3, N)."""
    return np.asarray(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2])


def _surface_terms(
    model: PoseModel, points: Floats32, turn: Batch, shift: Batch, ray: Floats32, reach: float, stage: RegistrationStage
) -> tuple[Batch, Batch]:
    moved = turn @ points + shift[:, :, None]
    nearest, normals, facing = match(model, moved, np.asarray(turn @ ray))
    gap = moved - nearest
    plane, far = dot(gap, normals), dot(gap, gap)
    weight = np.maximum(0.0, 1 - far * np.float32(1 / (reach * reach)))
    weight *= weight * facing
    beside = far - plane * plane > np.float32(stage.slack**2)
    rows = np.concatenate([cross(moved, normals), normals], axis=1)
    weighted = rows * weight[:, None]
    matrix = weighted @ rows.transpose(0, 2, 1)
    vector = (weighted @ plane[:, :, None])[..., 0]
    more, right = _vector_terms(moved, gap, weight * beside * np.float32(stage.beside))
    return matrix + more, vector + right


def _outline_terms(
    surface: tuple[Floats32, Floats32], turn: Batch, shift: Batch, ray: Floats32, outline: Outline, stage: RegistrationStage
) -> tuple[Batch, Batch]:
    """Terms of the normal equations that move model points back into the object's mask where their pixels
    show the background."""
    points, normals = surface
    seen = turn.transpose(0, 2, 1) @ (points - shift[:, :, None])  # the inverse of a rotation is its transpose
    which, pull = outline.silhouette_error(seen.transpose(0, 2, 1), (turn @ ray) @ normals < 0.05)
    gap, weight = np.zeros_like(seen), np.zeros(seen[:, 0].shape, np.float32)
    gap[which[0], :, which[1]] = (turn[which[0]] @ pull[..., None])[..., 0]
    weight[which] = stage.weight  # a point without a pull would hold its place instead
    return _vector_terms(points + gap, gap, weight)


def _vector_terms(moved: Batch, gap: Batch, weight: Batch) -> tuple[Batch, Batch]:
    """Normal equations (H, 6, 6) and (H, 6) of the motion of points ``moved`` that makes their weighted offsets ``gap`` smallest.

    The motion is a rotation vector w and a shift v; smallest is the sum of weight |gap + w x moved + v|^2.
    """
    weighted = moved * weight[:, None]
    outer = weighted @ moved.transpose(0, 2, 1)
    crossed = weighted @ gap.transpose(0, 2, 1)
    first = weighted.sum(2)
    matrix = np.zeros((len(moved), 6, 6), np.float32)
    matrix[:, :3, :3] = _diagonal(outer[:, 0, 0] + outer[:, 1, 1] + outer[:, 2, 2]) - outer
    matrix[:, :3, 3:] = _cross_matrix(first)
    matrix[:, 3:, :3] = -matrix[:, :3, 3:]
    matrix[:, 3:, 3:] = _diagonal(weight.sum(1))
    turned = [crossed[:, j, k] - crossed[:, k, j] for j, k in ((1, 2), (2, 0), (0, 1))]
    pushed = (gap @ weight[:, :, None])[..., 0]
    return matrix, np.concatenate([np.stack(turned, axis=1), pushed], axis=1)


def _diagonal(values: Batch) -> Batch:
    """Diagonal matrices (H, 3, 3), one for each of H values: the value times the identity matrix."""
    return np.asarray(values[:, None, None] * _IDENTITY)


def cross(a: Batch, b: Batch) -> Batch:
    """Return the cross products of vectors (H, 3, N); three times as fast as numpy's on small batches."""
    out = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, i] = a[:, j] * b[:, k] - a[:, k] * b[:, j]
    return out


def _cross_matrix(v: Batch) -> Batch:
    """(H, 3, 3): the matrices that take the cross product with ``v``."""
    matrix = np.zeros((len(v), 3, 3), np.float32)
    matrix[:, 0, 1], matrix[:, 0, 2], matrix[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return matrix - matrix.transpose(0, 2, 1)


def _step(matrix: Batch, vector: Batch, turn: Batch, shift: Batch) -> tuple[Batch, Batch]:
    """Poses after one damped step of ICP (iterative closest point).

    They hardly change in directions that the points constrain by less than 2 % of the strongest.
    """
    strongest = matrix[:, 3, 3] + matrix[:, 4, 4] + matrix[:, 5, 5] + np.float32(1e-6)
    damped = (matrix + strongest[:, None, None] * _DAMPING).astype(np.float64)
    step = np.linalg.solve(damped, -vector[..., None])[..., 0]
    angle = np.linalg.norm(step[:, :3], axis=1)
    step *= np.minimum(1.0, 0.35 / np.maximum(angle, 1e-9))[:, None]
    rotation = rotations(step[:, :3]).astype(np.float32)
    moved = np.einsum("hij,hj->hi", rotation, shift) + step[:, 3:].astype(np.float32)
    return np.asarray(rotation @ turn), moved


def rotations(vectors: Batch) -> Batch:
    """Return rotation matrices (H, 3, 3) of rotation vectors (H, 3) [rad], by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=1)
    axis = vectors / np.maximum(angle, 1e-12)[:, None]
    k = np.zeros((len(vectors), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -axis[:, 2], axis[:, 1], -axis[:, 0]
    k -= k.transpose(0, 2, 1)
    sine, rest = np.sin(angle)[:, None, None], (1 - np.cos(angle))[:, None, None]
    return np.asarray(np.eye(3) + sine * k + rest * (k @ k))

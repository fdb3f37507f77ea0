"""Initial poses for registration: from parts of the mask, in orientations that the prior allows, and
shifted in the image."""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

from cramlite.model import Floats, Mask, Pose, Value, View

from .icp import PoseBatch
from .model import Floats32, PoseModel, cube_rotations
from .outline import Outline

if TYPE_CHECKING:
    from .prior import Alignment, Prior

VOXEL = 0.008
"""Edge of the voxels whose neighbourhood makes one cluster [m]: five pixels at 0.6 m."""
SMALL = 0.03
"""Share of a mask's points below which a cluster is noise."""
DEEP = 0.6
"""Largest distance of an object's points from the middle of its mask along the ray [m]: larger objects are no products, and the grid of
voxels stays small."""
STARTS = 24


class SceneCloud(Value, eq=False):
    """Point cloud of an object, (N, 3) in the optical frame [m], and the mask without outliers."""

    points: Floats32
    mask: Mask


def scene_clouds(view: View, mask: Mask) -> list[SceneCloud]:
    """Return sets of a mask's points: the largest connected part, and then, if an occluder splits the mask, all parts together.

    Parts are what single linkage on voxels makes. Pixels without depth stay in the mask: an
    occluder's stereo shadow falls on the object.
    """
    measured = view.valid & mask
    if not measured.any():
        return []
    near = measured & (np.abs(view.depth - np.median(view.depth[measured])) < DEEP)
    points = view.points(near).astype(np.float32)
    cells = ((points - points.min(0)) / VOXEL).astype(np.int64)
    filled = np.zeros(cells.max(0) + 1, bool)
    filled[tuple(cells.T)] = True
    labels, _ = ndimage.label(filled, np.ones((3, 3, 3)))
    label = labels[tuple(cells.T)]
    counts = np.bincount(label)
    large = counts >= max(8, SMALL * len(points))
    chosen = [label == int(np.argmax(counts)), large[label]]
    found = []
    for keep in chosen[: 1 if large.sum() < 2 else 2]:
        cleaned = mask & ~measured
        cleaned[near] = keep
        found.append(SceneCloud(points[keep], cleaned))
    return found


def starts_for(camera: Pose, model: PoseModel, prior: Prior, scene: Floats32) -> PoseBatch:
    """Return some 24 initial poses with orientations that the prior allows, visible side centred on the scene.

    Args:
        camera: the optical frame in the world.
        scene: (N, 3) in the optical frame [m].
    """
    from .prior import alignment_error

    if prior.alignments:
        turn = _about_alignment(camera, prior.alignments[0])
        for a in prior.alignments[1:]:
            turn = turn[alignment_error(camera, turn, a) <= a.before]
    else:
        base = _principal(scene)
        turn = np.array([p.rotation @ base.T for p in cube_rotations()], np.float32)
    middle = scene.mean(0)
    rays = turn @ (middle / np.linalg.norm(middle))
    which = np.linspace(0, len(model.points) - 1, 800).astype(np.int64)
    facing = np.maximum(0, -(rays @ model.normals[which].T))
    visible = (facing @ model.points[which]) / np.maximum(facing.sum(1), 1e-6)[:, None]
    return PoseBatch(turn, np.asarray(visible - turn @ middle, dtype=np.float32))


def _about_alignment(camera: Pose, alignment: Alignment) -> Floats32:
    """Initial rotations that put an axis of the object exactly on a direction of the world, for each such pair.

    For each pair they are spread evenly about the direction.
    """
    return np.asarray(_world_in_object(alignment) @ camera.rotation, dtype=np.float32)


@lru_cache(maxsize=512)
def _world_in_object(alignment: Alignment) -> Floats:
    """Rotations (H, 3, 3) from the world to the object's frame that align an axis of the object with a direction of the world."""
    pairs = list(itertools.product(alignment.axes, alignment.directions))
    steps = max(6, STARTS // len(pairs))
    about = np.array([Pose.from_rotvec((0, 0, 0), (0, 0, 2 * np.pi * k / steps)).rotation for k in range(steps)])
    found = [_frame(np.asarray(d)) @ about @ _frame(np.asarray(a)).T for a, d in pairs]
    return np.concatenate(found).transpose(0, 2, 1)


def _frame(z: Floats) -> Floats:
    """A rotation whose third column is ``z``."""
    return Pose.from_axes((0, 0, 0), z, np.eye(3)[int(np.argmin(np.abs(z)))]).rotation


def _principal(scene: Floats32) -> Floats:
    """Principal axes of a cloud as the columns of a rotation."""
    _, axes = np.linalg.eigh(np.cov((scene - scene.mean(0)).T))
    if np.linalg.det(axes) < 0:
        axes = -axes
    return np.asarray(axes)


def slid(model: PoseModel, outline: Outline, starts: PoseBatch) -> PoseBatch:
    """Return the initial poses, and each shifted sideways so that the edges of the model's silhouette meet
    the mask's.

    An occluder that hides one end of an object leaves open where along it the rest belongs; only the image around
    the mask tells.
    """
    rows, columns = np.flatnonzero(outline.mask.any(1)), np.flatnonzero(outline.mask.any(0))
    which = np.linspace(0, len(model.points) - 1, 300).astype(np.int64)
    seen = starts.turn.transpose(0, 2, 1) @ (model.points[which].T - starts.shift[:, :, None])
    u, v, _, _ = outline.pixels(seen.transpose(0, 2, 1))
    z = seen[:, 2].mean(1)
    shifts_u = [np.zeros(len(starts)), columns[0] - u.min(1), columns[-1] - u.max(1)]
    shifts_v = [np.zeros(len(starts)), rows[0] - v.min(1), rows[-1] - v.max(1)]
    shift = []
    for du, dv in itertools.product(shifts_u, shifts_v):
        move = np.stack([du * z / outline.intrinsics.fx, dv * z / outline.intrinsics.fy, np.zeros(len(z))], axis=1)
        shift.append(starts.shift - np.einsum("hij,hj->hi", starts.turn, move.astype(np.float32)))
    return PoseBatch(np.tile(starts.turn, (len(shift), 1, 1)), np.concatenate(shift))

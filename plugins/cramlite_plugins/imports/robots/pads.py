"""Faces of a hand that grip: their places, sizes and distance, and the direction from which things come between them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Pose, Value
from cramlite.plugin import UserError

from .hand_motion import at

FACE = 0.0015  # distance from a finger's innermost point within which points are its face [m]
SNAP = math.cos(math.radians(20))  # an approach that leans less from an axis of the flange is along it
ASIDE = 0.3  # share of a pad's motion that may be across closing and approach: more is a hand with more fingers
SMALLEST = 0.002  # side of a face that ends in an edge or a point [m]
KINDS = mujoco.mjtGeom


class Pads(Value):
    """The faces that grip, in the frame of the hand's root.

    Args:
        left, right: geoms of the fingers on the +y and -y side.
        tcp: pinch point; z is the direction of approach, y the closing direction.
        size: width and length of a face [m].
        gaps: distance between the faces at each sample of the stroke [m].
        depth: from the pinch point back to the palm [m].
    """

    left: tuple[int, ...]
    right: tuple[int, ...]
    tcp: Pose
    size: tuple[float, float]
    gaps: tuple[float, ...]
    depth: float


def find_pads(where: Path, model: Any, states: Floats, pair: tuple[int, int], fingers: Sequence[Sequence[int]] | None) -> Pads:
    """Find the pads of a hand.

    Args:
        states: positions of its joints along the stroke (K, nq), wide first.
        pair: a geom of each finger.
        fingers: all geoms of the pad of each finger, where they are known.

    Raises:
        UserError: its fingers do not move along one line.
    """
    first, last = at(model, states[0]), at(model, states[-1])
    a, b = pair
    y = _closing(first, last, a, b)
    left, right = (tuple(f) for f in fingers) if fingers else (_pad(model, first, a, -y), _pad(model, first, b, y))
    samples = [at(model, q) for q in states]
    gaps = tuple(-_inner(model, d, left, -y) - _inner(model, d, right, y) for d in samples)
    ends = [np.mean([_centre(model, d, left, -y), _centre(model, d, right, y)], axis=0) for d in (first, last)]
    z = _approach(np.mean(ends, axis=0), y)
    _check_line(where, first, last, (a, b), y, z)
    tcp = Pose.from_axes(tuple(float(v) for v in np.mean(ends, axis=0)), z=tuple(z), x=tuple(np.cross(y, z)))
    return Pads(left, right, tcp, _size(model, first, left, y, z), gaps, _depth(model, first, tcp))


def _closing(first: Any, last: Any, a: int, b: int) -> Floats:
    """Unit vector from finger geom b to finger geom a, along which these move apart between the closed and the open hand."""
    way = (first.geom_xpos[a] - last.geom_xpos[a]) - (first.geom_xpos[b] - last.geom_xpos[b])
    return np.asarray(way / np.linalg.norm(way))


def _pad(model: Any, data: Any, geom: int, inwards: Floats) -> tuple[int, ...]:
    """Geoms that form one pad face with a given geom: on the same rigid part, and reaching as far towards the other finger."""
    part = int(model.body_weldid[model.geom_bodyid[geom]])
    own = [g for g in range(model.ngeom) if int(model.body_weldid[model.geom_bodyid[g]]) == part]
    front = _inner(model, data, (geom,), inwards)
    return tuple(g for g in own if abs(_inner(model, data, (g,), inwards) - front) < FACE)


def _inner(model: Any, data: Any, geoms: Sequence[int], inwards: Floats) -> float:
    """Return how far the geoms of a finger reach along ``inwards``, the direction to the other finger [m]."""
    return max(float((points(model, data, g) @ inwards).max()) for g in geoms)


def _face(model: Any, data: Any, geoms: Sequence[int], inwards: Floats) -> Floats:
    """Return the points (n, 3) of a finger's gripping face: those farthest along ``inwards``, the direction to
    the other finger."""
    found = np.concatenate([points(model, data, g) for g in geoms])
    reach = found @ inwards
    return np.asarray(found[reach > reach.max() - FACE])


def _centre(model: Any, data: Any, geoms: Sequence[int], inwards: Floats) -> Floats:
    face = _face(model, data, geoms, inwards)
    return np.asarray((face.min(axis=0) + face.max(axis=0)) / 2)


def _approach(centre: Floats, y: Floats) -> Floats:
    """Unit vector from the flange to the pads, across the closing direction; snapped to an axis of the
    flange that is near."""
    out = centre - (centre @ y) * y
    out = out / np.linalg.norm(out)
    axes = [s * (e - (e @ y) * y) for e in np.eye(3) for s in (1.0, -1.0)]
    near = max((a / np.linalg.norm(a) for a in axes if np.linalg.norm(a) > 0.5), key=lambda a: float(a @ out))
    return near if float(near @ out) > SNAP else np.asarray(out)


def _check_line(where: Path, first: Any, last: Any, pair: tuple[int, int], y: Floats, z: Floats) -> None:
    """Refuse a hand whose fingers do not close along one line: of three fingers, no two move straight towards
    each other."""
    for g in pair:
        way = first.geom_xpos[g] - last.geom_xpos[g]
        far = float(np.linalg.norm(way))
        if far > FACE and abs(float(way @ np.cross(y, z))) > ASIDE * far:
            raise UserError(
                f"{where}: the fingers of this hand do not close along one line, so it is no parallel gripper, which is all that is "
                "understood of hands; take another file, or one of the grippers that come with cramlite by its name."
            )


def _size(model: Any, data: Any, left: Sequence[int], y: Floats, z: Floats) -> tuple[float, float]:
    face = _face(model, data, left, -y)
    width, length = (float(np.ptp(face @ axis)) for axis in (np.cross(y, z), z))
    return max(width, SMALLEST), max(length, SMALLEST)


def _depth(model: Any, data: Any, tcp: Pose) -> float:
    """Distance [m] from the pinch point back to the hand; to the flange if nothing is behind it."""
    hit, back = np.zeros(1, np.int32), tcp.rotate((0.0, 0.0, -1.0))
    far = float(mujoco.mj_ray(model, data, np.array(tcp.position), np.array(back), None, 1, -1, hit))
    return far if far > 0 else float(np.linalg.norm(tcp.position))


def points(model: Any, data: Any, geom: int) -> Floats:
    """Return points on a geom's surface in the world (n, 3): its corners, or samples if it is round."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == KINDS.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        start = int(model.mesh_vertadr[mesh])
        own = np.asarray(model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])], dtype=float)
    elif kind == KINDS.mjGEOM_BOX:
        own = np.array(list(itertools.product((-1.0, 1.0), repeat=3))) * size
    else:
        own = _round(kind, size)
    return np.asarray(own @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])


def _round(kind: int, size: Floats) -> Floats:
    """Points of a cylinder, capsule, sphere or ellipsoid in its own frame."""
    turns = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    if kind == KINDS.mjGEOM_CYLINDER:
        return np.array([(size[0] * math.cos(t), size[0] * math.sin(t), s * size[1]) for t in turns for s in (-1, 1)])
    radii = size if kind == KINDS.mjGEOM_ELLIPSOID else np.full(3, size[0])
    high = np.linspace(-np.pi / 2, np.pi / 2, 13)
    ball = np.array([(math.cos(h) * math.cos(t), math.cos(h) * math.sin(t), math.sin(h)) for h in high for t in turns]) * radii
    half = size[1] if kind == KINDS.mjGEOM_CAPSULE else 0.0
    return np.asarray(ball + np.outer(np.sign(ball[:, 2]), (0.0, 0.0, half)))

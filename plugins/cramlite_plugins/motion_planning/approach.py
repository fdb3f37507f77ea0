"""Bounds on how fast any two geoms of a planning model approach one another while an arm moves along a
joint-space line.

Seen from the frame of one geom, a point x of the other moves with x' = sum_j q'_j u_j x (x - a_j), j over
the revolute joints between the two, with axis u_j through a_j. Over half of a part, h, the speed differs from
that in the middle by at most h |x''|, where (Hessian of a serial chain) |x''| <= sum_j lever_j (w_j (w_j + 2
sum_i<j w_i) + |q''_j|), with w_j the highest |q'_j| and lever_j the largest distance of x from the axis of
joint j.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Value

from .joint_line import JointLine
from .pairs import Movers

Indices = NDArray[np.int64]
BOX, CYLINDER = int(mujoco.mjtGeom.mjGEOM_BOX), int(mujoco.mjtGeom.mjGEOM_CYLINDER)


class Rates(Value):
    """Bounds on how much nearer two geoms can come while the arm moves along a whole line, valid on a part of
    it.

    Args:
        between: for each combination of ``Chains`` [m].
        most: the largest of them [m].
    """

    between: list[float]
    most: float


class Chains(Value):
    """Combinations of a geom that an arm moves and the joints between it and other geoms; every two geoms
    between which the same joints lie share one.

    A geom lies within ``thin`` of a line segment that reaches ``long`` to both sides of its origin.

    Args:
        which: (geoms, geoms) the combination of each pair of geoms; the last one, of no motion, where no
            joint lies between them.
        geoms: ids of the geoms that the arm moves (m,).
        turned: 1 where a joint moves such a geom (m, joints).
        kinds: 1 where a joint does not move other geoms (kinds, joints).
        row, column: of each combination in ``turned`` and in ``kinds`` (c,).
        between: 1 where a joint lies between (joints, c).
        long: half of the segment in the frame of the geom (m, 3) [m].
        thin: radius about the segment (m,) [m].
        bound: radius of a sphere about the geom's origin that contains the geom (m,) [m].
        first: id of the arm's first joint.
    """

    which: Indices
    geoms: Indices
    turned: Floats
    kinds: Floats
    row: Indices
    column: Indices
    between: Floats
    long: Floats
    thin: Floats
    bound: Floats
    first: int


def chains(model: Any, movers: Movers, first: int) -> Chains:
    """Return the combinations of moved geoms and joints between geoms of a planning model.

    Args:
        first: id of the arm's first joint.
    """
    geoms = np.flatnonzero(movers.moved.any(axis=1))
    turned = movers.turned[geoms]
    kinds, kind = np.unique(movers.still, axis=0, return_inverse=True)
    joints = turned[:, None] * kinds[None]
    row, column = np.nonzero(joints.any(axis=-1))
    index = np.full((model.ngeom, len(kinds)), len(row))
    index[geoms[row], column] = np.arange(len(row))
    one = index[:, kind.reshape(-1)]
    long, thin = _segments(model, geoms)
    bound = np.array(model.geom_rbound[geoms])
    between = np.ascontiguousarray(joints[row, column].T)
    return Chains(
        np.minimum(one, one.T), geoms, turned, kinds, row, column, between, long, thin, bound, first
    )


def _segments(model: Any, geoms: Indices) -> tuple[Floats, Floats]:
    """Return half of the longest line inside each geom, in its frame (m, 3) [m], and the radius about this
    line that the geom fills (m,) [m]; only boxes and cylinders have one."""
    long, thin = np.zeros((len(geoms), 3)), np.array(model.geom_rbound[geoms])
    for k, g in enumerate(geoms.tolist()):
        size = model.geom_size[g]
        if model.geom_type[g] == BOX:
            side = int(np.argmax(size))
            long[k, side], thin[k] = size[side], np.linalg.norm(np.delete(size, side))
        elif model.geom_type[g] == CYLINDER:
            long[k, 2], thin[k] = size[1], size[0]
    return long, thin


class Posture(Value):
    """Where all geoms and the axes of all joints of a model are at a joint position.

    Args:
        origins, turns: of the geoms (geoms, 3) [m], (geoms, 9).
        axes, anchors: directions of the joints' axes, and points on them (joints, 3) [m].
    """

    origins: Floats
    turns: Floats
    axes: Floats
    anchors: Floats


def posture(data: Any) -> Posture:
    """Return where everything is now in a simulation state."""
    return Posture(*(v.copy() for v in (data.geom_xpos, data.geom_xmat, data.xaxis, data.xanchor)))


class Span(Value):
    """A part of a joint-space line.

    Args:
        low, high: where it begins and ends, as fractions of the line.
        middle: the arm in the middle of the part.
    """

    line: JointLine
    low: float
    high: float
    middle: Posture


def rates(spans: Sequence[Span], arm: Chains) -> list[Rates]:
    """Compute upper bounds on how fast each two geoms approach one another on parts of lines."""
    way = np.abs([s.line.way for s in spans])
    half = np.array([[(s.high - s.low) / 2] for s in spans])
    joints = slice(arm.first, arm.first + way.shape[1])
    x = np.array([s.middle.origins for s in spans])[:, arm.geoms]
    u = np.array([s.middle.axes for s in spans])[:, joints]
    a = np.array([s.middle.anchors for s in spans])[:, joints]
    # The lever grows by no more than the way G of the geom itself: G = sum_j (lever_j + G) w_j h.
    lever = _levers(x, u, a, arm) * arm.turned
    grows = np.vecdot(lever, (half * way)[:, None]) / (1.0 - half * way.sum(axis=1, keepdims=True))
    lever += grows[:, :, None] * arm.turned
    found = _summed(lever, way, arm)
    if len(spans) > 1:  # of a short line a tighter bound takes longer than the postures that it saves
        bend = half * (way * (way + 2.0 * (np.cumsum(way, axis=1) - way)) + [s.line.bend for s in spans])
        found = np.minimum(found, _in_the_middle(spans, arm, x, u, a) + _summed(lever, bend, arm))
    found = np.column_stack((found, np.zeros(len(spans))))
    return [Rates(*known) for known in zip(found.tolist(), found.max(axis=1).tolist(), strict=True)]


def _summed(lever: Floats, turns: Floats, arm: Chains) -> Floats:
    """Return the sum over the joints between of lever times turn, of each combination (p, c).

    Args:
        lever: (p, m, joints) [m].
        turns: (p, joints).
    """
    found: Floats = (lever @ (turns[:, :, None] * arm.kinds.T))[:, arm.row, arm.column]
    return found


def _in_the_middle(spans: Sequence[Span], arm: Chains, x: Floats, u: Floats, a: Floats) -> Floats:
    """Return the highest speeds in the middles of parts (p, c), with the joints' motions added as vectors [m
    for a whole line].

    Args:
        x: origins of the geoms (p, m, 3) [m].
        u, a: directions of the joints' axes, and points on them (p, joints, 3) [m].
    """
    speeds = np.array([s.line.speed((s.low + s.high) / 2) for s in spans])
    turns = np.array([s.middle.turns for s in spans])[:, arm.geoms].reshape(*x.shape, 3)
    ends = (turns @ arm.long[:, :, None])[..., 0]
    x, u, a, ends = (np.ascontiguousarray(v.transpose(2, 0, 1)) for v in (x, u, a, ends))
    return _fastest(speeds, arm, (x + ends, x - ends), u, a)


def _levers(x: Floats, u: Floats, a: Floats, arm: Chains) -> Floats:
    """Return bounds on the distances of the points of the moved geoms from the joints' axes (p, m, joints)
    [m].

    A geom's centre x is sqrt(|x - a|^2 - ((x - a) u)^2) from an axis.

    Args:
        x: origins of the geoms (p, m, 3) [m].
        u, a: directions of the axes, and points on them (p, joints, 3) [m].
    """
    along = x @ u.transpose(0, 2, 1) - np.vecdot(a, u)[:, None]
    apart = np.vecdot(x, x)[:, :, None] - 2.0 * (x @ a.transpose(0, 2, 1)) + np.vecdot(a, a)[:, None]
    found: Floats = np.sqrt(np.maximum(apart - along * along, 0.0)) + arm.bound[:, None]
    return found


def _fastest(speeds: Floats, arm: Chains, ends: Sequence[Floats], u: Floats, a: Floats) -> Floats:
    """Return the highest speed of any point of each combination's geom, as seen from the geoms beyond the
    joints between (p, c) [m for a whole line].

    Args:
        speeds: of the joints (p, joints) [rad for a whole line].
        ends: of the segments in the geoms, both (3, p, m) [m].
        u, a: directions of the joints' axes, and points on them (3, p, joints) [m].
    """
    (ux, uy, uz), (ax, ay, az) = u * speeds, a
    moments = np.stack((ux, uy, uz, ay * uz - az * uy, az * ux - ax * uz, ax * uy - ay * ux))
    wx, wy, wz, vx, vy, vz = moments @ arm.between
    most = np.zeros_like(wx)
    for end in ends:
        x, y, z = end[:, :, arm.row]
        px, py, pz = vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
        np.maximum(most, px * px + py * py + pz * pz, out=most)
    found: Floats = np.sqrt(most) + np.sqrt(wx * wx + wy * wy + wz * wz) * arm.thin[arm.row]
    return found

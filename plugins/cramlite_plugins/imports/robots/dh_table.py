"""A standard Denavit-Hartenberg table from the axes of an arm (Siciliano et al., Robotics, 2009, section 2.8.2).

Any row of hinges has one, if its joints may be counted from another zero, and if frame 0 may lie elsewhere on the first axis than the
file's base, and frame n elsewhere on the last axis than its flange. What is left over is returned: ``zeros``, ``base`` and ``tool``.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np

from cramlite.model import Floats, Pose, Value

from ...robots.dh_arm import forward

ROOTED = 1e-9  # a frame 0 nearer than this to the base is the base [m, rad]
PARALLEL = 1e-7  # sine of the angle between two axes below which they are parallel


class Table(Value):
    """Denavit-Hartenberg table of an arm.

    Args:
        rows: (a, d, alpha) [m, rad].
        zeros: what a joint's angle in the table is when the file counts zero [rad].
        base: frame 0 in the file's base.
        last: frame n in the file's base, all joints at the file's zero.
        tool: the file's flange in frame n.
    """

    rows: tuple[tuple[float, float, float], ...]
    zeros: tuple[float, ...]
    base: Pose
    last: Pose
    tool: Pose


def table_of(axes: tuple[tuple[Floats, Floats], ...], flange: Pose) -> Table:
    """Derive an arm's Denavit-Hartenberg table from its joint axes (point, direction) and flange, in the base's
    frame, all joints at zero."""
    frames = [_first(*axes[0])]
    for axis in axes[1:]:
        frames.append(_next(frames[-1], *axis))
    frames.append(_last(frames[-1], flange))
    steps = [_row(a, b) for a, b in pairwise(frames)]
    rows, zeros = tuple(s[:3] for s in steps), tuple(s[3] for s in steps)
    last = _pose(frames[-1])
    base = _pose(frames[0])
    base = Pose() if max(base.distance(Pose())) < ROOTED else base
    return Table(rows, zeros, base, last, last.inverse() * flange)


@lru_cache(maxsize=32)  # a model, its servos and the robot ask for the same table's
def reach_of(table: Table, limits: tuple[tuple[float, float], ...]) -> float:
    """Return the largest distance of the flange from the base's z axis within the joint limits [m].

    ``limits`` count joint angles as the file does.
    """
    from scipy.optimize import minimize

    bounds = [(low + zero, high + zero) for (low, high), zero in zip(limits, table.zeros, strict=True)]

    low, high = np.array(bounds).T

    def nearer(q: Floats) -> float:
        place = table.base * forward(table.rows, tuple(float(v) for v in q)) * table.tool
        return -math.hypot(*place.position[:2])

    starts = np.random.default_rng(0).uniform(low, high, (200, len(bounds)))
    best = sorted(starts, key=nearer)[:3]
    return -min(float(minimize(nearer, start, bounds=bounds, method="L-BFGS-B").fun) for start in best)


def _first(point: Floats, z: Floats) -> Floats:
    """Denavit-Hartenberg frame 0: on the first joint's axis, level with the base's origin, x as near to the
    base's x as it can be."""
    z = z / np.linalg.norm(z)
    x = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    return _frame(point - (point @ z) * z, x - (x @ z) * z, z)


def _next(frame: Floats, point: Floats, z: Floats) -> Floats:
    """Denavit-Hartenberg frame i, on the axis of joint i + 1: its x lies along the common normal from the axis of joint i."""
    before, origin, z = frame[:3, 2], frame[:3, 3], z / np.linalg.norm(z)
    normal = np.cross(before, z)
    between = point - origin
    if np.linalg.norm(normal) < PARALLEL:
        foot = between - (between @ before) * before
        far = float(np.linalg.norm(foot))
        return _frame(origin + foot, foot if far > 1e-9 else frame[:3, 0], z)
    normal = normal / np.linalg.norm(normal)
    apart = float(between @ normal)
    # the point of this axis that is nearest to the one before: between + s z has no part in the plane across both
    s = float(np.cross(between, before) @ normal) / float(np.cross(before, z) @ normal)
    return _frame(point + s * z, normal if apart >= 0 else -normal, z)


def _last(frame: Floats, flange: Pose) -> Floats:
    """Last Denavit-Hartenberg frame: on the last joint's axis, level with the flange, x as near to the flange's x as it can be."""
    z, origin = frame[:3, 2], frame[:3, 3]
    x = flange.rotation[:, 0]
    x = x - (x @ z) * z
    x = x if np.linalg.norm(x) > 1e-6 else frame[:3, 0]
    return _frame(origin + ((np.array(flange.position) - origin) @ z) * z, x, z)


def _frame(origin: Floats, x: Floats, z: Floats) -> Floats:
    x = x / np.linalg.norm(x)
    found = np.eye(4)
    found[:3, :4] = np.array([x, np.cross(z, x), z, origin]).T
    return found


def _row(before: Floats, after: Floats) -> tuple[float, float, float, float]:
    """Return the Denavit-Hartenberg parameters (a, d, alpha, theta) that lead from one frame of the table to the
    next."""
    moved = np.linalg.inv(before) @ after
    theta = math.atan2(moved[1, 0], moved[0, 0])
    alpha = math.atan2(moved[2, 1], moved[2, 2])
    a = float(moved[0, 3] * math.cos(theta) + moved[1, 3] * math.sin(theta))
    return _round(a), _round(float(moved[2, 3])), alpha, theta


def _round(length: float) -> float:
    """Return a length without rounding errors: 0 if it is nearly 0.

    The analytic solver checks whether axes meet exactly.
    """
    return 0.0 if abs(length) < 1e-9 else length


def _pose(frame: Floats) -> Pose:
    return Pose.from_matrix(frame)

"""Forward kinematics of arms, the Jacobian, and how far joint positions are from a singularity.

Frames: poses are of the tool centre point (tcp, the pinch point of the gripper) in the
robot's base frame. Joint positions are tuples in the order of ``robot.joints`` [rad].

The model is the standard Denavit-Hartenberg table of the robot plugin (Denavit and
Hartenberg 1955; Siciliano et al., Robotics, 2009, section 2.8.2):
T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i), behind ``Robot.root``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from cramlite.model import Floats, Pose, Robot

Joints = tuple[float, ...]
Table = tuple[tuple[float, float, float], ...]

BEYOND = -0.5
"""Cosine of a rotation's angle below which the rotation vector is computed by a quaternion, in three times
the time."""
ASTRAY = 0.05
"""Largest difference of a joint from the value at which the arm settles, for controllers that are given TCP
poses [rad]: it was the worst of 100 rests in LIBERO."""


def table(robot: Robot) -> Table:
    """Return the Denavit-Hartenberg rows of a robot.

    Raises:
        ValueError: the robot has none: its inverse has to be found numerically.
    """
    if robot.dh is None:
        raise ValueError(
            f"robot '{robot.type}' has no Denavit-Hartenberg table, so it has no analytic kinematics"
        )
    return robot.dh


def frames(robot: Robot, q: Sequence[float] | Floats) -> list[Floats]:
    """Compute the (4, 4) frames 0 (``Robot.root``) to n (flange) in the base frame."""
    still = _links(table(robot))
    x, y, links = still[:, 0], still[:, 1], still.copy()
    angles = np.asarray(q, dtype=float)[:, None]
    cos, sin = np.cos(angles), np.sin(angles)
    links[:, 0], links[:, 1] = cos * x - sin * y, sin * x + cos * y
    result = [robot.root.matrix]
    for link in links:
        result.append(result[-1].dot(link))  # half the time of @
    return result


@lru_cache(maxsize=512)
def _links(rows: Table) -> Floats:
    """Return the transform of each link in the frame of the link before it, with all joints at 0: (n, 4, 4).

    A joint's angle turns the first two rows.
    """
    found = np.zeros((len(rows), 4, 4))
    for link, (a, d, alpha) in zip(found, rows, strict=True):
        ca, sa = math.cos(alpha), math.sin(alpha)
        link[:] = ((1.0, 0.0, 0.0, a), (0.0, ca, -sa, 0.0), (0.0, sa, ca, d), (0.0, 0.0, 0.0, 1.0))
    return found


def flange(robot: Robot, q: Sequence[float]) -> Pose:
    """Solve forward kinematics: the pose of the flange in the base frame."""
    return Pose.from_matrix(frames(robot, q)[-1])


def forward(robot: Robot, q: Sequence[float]) -> Pose:
    """Solve forward kinematics: the pose of the tcp in the base frame."""
    return Pose.from_matrix(frames(robot, q)[-1] @ robot.gripper.tcp.matrix)


def from_root(robot: Robot, target: Pose) -> Pose:
    """Pose of the flange in frame 0 of the Denavit-Hartenberg table, for a pose of the TCP in the base
    frame."""
    return robot.root.inverse() * target * robot.gripper.tcp.inverse()


def jacobian(robot: Robot, q: Sequence[float]) -> Floats:
    """Compute the geometric Jacobian (6, n) at the tcp in the base frame: rows linear [m/rad], then angular
    [rad/rad].

    Column i is (z_i x (p - p_i), z_i) (Siciliano et al., 2009, equation 3.30).
    """
    chain = np.array(frames(robot, q))
    return jacobian_of(chain, chain[-1] @ robot.gripper.tcp.matrix)


def jacobian_of(chain: Floats, end: Floats) -> Floats:
    x, y, z = axes = chain[:-1, :3, 2].T
    u, v, w = (end[:3, 3] - chain[:-1, :3, 3]).T
    return np.vstack([y * w - z * v, z * u - x * w, x * v - y * u, axes])  # np.cross takes five times as long


def twist(from_: Floats, to: Floats) -> Floats:
    """Compute the twist from one (4, 4) frame to another: (6,) translation [m] and rotation vector [rad],
    parent axes."""
    (a, b, c), (d, e, f), (g, h, i) = (to[:3, :3] @ from_[:3, :3].T).tolist()
    x, y, z, cosine = (h - f) / 2, (c - g) / 2, (d - b) / 2, (a + e + i - 1) / 2
    sine = math.hypot(x, y, z)
    if cosine < BEYOND:
        turn = Pose.from_matrix(
            to[:3, :3] @ from_[:3, :3].T
        ).rotvec  # near half a turn the axis is not in these
    else:
        scale = math.atan2(sine, cosine) / sine if sine > 1e-12 else 1.0
        turn = (scale * x, scale * y, scale * z)
    return np.array((*(to[:3, 3] - from_[:3, 3]).tolist(), *turn))


def smallest_singular_value(robot: Robot, q: Sequence[float]) -> float:
    """Return the smallest singular value of the Jacobian, lengths in units of the robot's reach: 0 at a
    singularity."""
    scaled = jacobian(robot, q) / np.array([robot.reach] * 3 + [1.0] * 3)[:, None]
    return float(np.linalg.svd(scaled, compute_uv=False)[-1])


def conditioning(robot: Robot, q: Sequence[float]) -> float:
    """Return the smallest singular value of the arm's Jacobian; it is 0 at a singularity.

    For a seven-axis arm whose controller is given TCP poses, it is the smallest value within ``ASTRAY`` along
    the null space.
    """
    if robot.posture is None or len(q) < 7:
        return smallest_singular_value(robot, q)
    beside = np.linalg.svd(jacobian(robot, q))[2][6]
    beside *= ASTRAY / np.abs(beside).max()
    return min(smallest_singular_value(robot, near) for near in (q, q + beside, q - beside))


def well_conditioned(robot: Robot, q: Sequence[float]) -> bool:
    """Check whether joint positions are as far from a singularity as the robot must stay
    (``Robot.conditioning``)."""
    return not robot.conditioning or conditioning(robot, q) >= robot.conditioning

"""Kinematics of many joint positions of one arm at once, as arrays.

Frames and equations are those of ``kinematics``; N joint positions of n joints are an (N, n) array [rad].
"""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats, Robot

from .kinematics import ASTRAY, EXACT, POLISH_M, links_at


def refined(robot: Robot, goals: Floats, near: Floats, steps: int) -> Floats:
    """Refine near inverse kinematics solutions by Newton's method, each on its own.

    Args:
        goals: (N, 4, 4) frames of the tcp in the base frame.
        near: (N, n) joint positions.

    Returns:
        (N, n) joint positions with errors below 1e-6 m and 1e-6 rad; a row is nan where the method does not
        converge.
    """
    joints = near
    for step in range(steps + 1):
        chain = _chain(robot, joints)
        error = _twists(chain[:, -1], goals)
        size = np.abs(error).max(axis=1)
        if step == steps or (size < POLISH_M).all():
            break
        joints = joints + (np.linalg.pinv(_jacobians(chain), rcond=1e-6) @ error[:, :, None])[:, :, 0]
    return np.where((size < EXACT)[:, None], joints, np.nan)


def conditionings(robot: Robot, joints: Floats) -> Floats:
    """Return the smallest singular value of the arm's Jacobian at each of (N, n) joint positions, as
    ``kinematics.conditioning`` has it: (N,)."""
    smallest = _smallest(robot, joints)
    if robot.posture is None or joints.shape[1] < 7:
        return smallest
    beside = np.linalg.svd(_jacobians(_chain(robot, joints)))[2][:, 6]
    beside *= ASTRAY / np.abs(beside).max(axis=1, keepdims=True)
    ways = (_smallest(robot, near) for near in (joints + beside, joints - beside))
    return np.minimum(smallest, np.minimum(*ways))


def _smallest(robot: Robot, joints: Floats) -> Floats:
    columns = _jacobians(_chain(robot, joints))
    columns[:, :3] /= robot.reach
    return np.asarray(np.linalg.svd(columns, compute_uv=False)[:, -1])


def _chain(robot: Robot, joints: Floats) -> Floats:
    """Frames 0 (``Robot.root``) to n - 1, and that of the tcp, in the base frame: (N, n + 1, 4, 4)."""
    links = links_at(robot, joints)
    found = np.empty((len(links), links.shape[1] + 1, 4, 4))
    found[:, 0] = robot.root.matrix
    for k in range(links.shape[1]):
        found[:, k + 1] = found[:, k] @ links[:, k]
    found[:, -1] = found[:, -1] @ robot.gripper.tcp.matrix
    return found


def _jacobians(chain: Floats) -> Floats:
    """Geometric Jacobians (N, 6, n) at the tcp in the base frame (Siciliano et al., 2009, equation 3.30)."""
    axes = chain[:, :-1, :3, 2]
    ways = np.cross(axes, chain[:, -1:, :3, 3] - chain[:, :-1, :3, 3])
    return np.concatenate([ways, axes], axis=2).swapaxes(1, 2)


def _twists(ends: Floats, goals: Floats) -> Floats:
    """Twists (N, 6) from frames to near frames: translation [m] and rotation vector [rad], parent axes."""
    turn = goals[:, :3, :3] @ ends[:, :3, :3].swapaxes(1, 2)
    apart = turn - turn.swapaxes(1, 2)
    twice = np.stack([apart[:, 2, 1], apart[:, 0, 2], apart[:, 1, 0]], axis=1)
    sine, cosine = np.linalg.norm(twice, axis=1) / 2, (np.trace(turn, axis1=1, axis2=2) - 1) / 2
    scale = np.where(sine > 1e-12, np.arctan2(sine, cosine) / np.maximum(sine, 1e-12), 1.0)
    return np.concatenate([goals[:, :3, 3] - ends[:, :3, 3], twice / 2 * scale[:, None]], axis=1)

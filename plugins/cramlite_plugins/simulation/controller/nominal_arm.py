"""Nominal kinematics of the controller, from the Denavit-Hartenberg table, fast enough for every control cycle.

Equations as in kinematics/kinematics.py (Siciliano et al., Robotics, 2009, 2.8.2 and 3.30), which finds all branches of
the inverse; here one solution is followed from cycle to cycle by Newton's method. Frames are (4, 4) in the base frame.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cramlite.model import Floats, Pose, Robot

from ...kinematics.kinematics import table

DAMPING = 1e-8  # squared: keeps the step finite at a singularity, far below what else would matter
CLOSE = 1e-8  # a target is reached below this error [m, rad]
ROUNDS = 12


class NominalArm:
    """Kinematics of a robot with any tool centre point.

    Args:
        robot: must have a Denavit-Hartenberg table.

    Raises:
        ValueError: it has none.
    """

    def __init__(self, robot: Robot) -> None:
        rows = np.array(table(robot))
        self.a, self.alpha = rows[:, 0], rows[:, 2]
        ca, sa = np.cos(self.alpha), np.sin(self.alpha)
        self.ca, self.sa = ca, sa
        self.links = np.zeros((len(rows), 4, 4))
        self.links[:, 2, 1], self.links[:, 2, 2], self.links[:, 2, 3], self.links[:, 3, 3] = sa, ca, rows[:, 1], 1.0
        self.tcp = robot.gripper.tcp.matrix
        self.base, self.damping = np.eye(4), DAMPING * np.eye(6)
        self._last: tuple[Floats, Floats] | None = None  # a commanded joint position, and its frames

    def frames(self, q: Floats) -> Floats:
        """Compute the frames (n + 1, 4, 4): the base, then the frame of each joint up to the flange."""
        c, s, m = np.cos(q), np.sin(q), self.links
        m[:, 0, 0], m[:, 0, 1], m[:, 0, 2], m[:, 0, 3] = c, -s * self.ca, s * self.sa, self.a * c
        m[:, 1, 0], m[:, 1, 1], m[:, 1, 2], m[:, 1, 3] = s, c * self.ca, -c * self.sa, self.a * s
        out = np.empty((len(m) + 1, 4, 4))
        out[0] = self.base
        for i in range(len(m)):
            np.matmul(out[i], m[i], out=out[i + 1])
        return out

    def flange(self, q: Floats) -> Floats:
        """Compute the frame (4, 4) of the flange."""
        return np.asarray(self.frames(q)[-1])

    def forward(self, q: Floats) -> Pose:
        """Solve forward kinematics: the pose of the tool centre point."""
        return Pose.from_matrix(self.flange(q) @ self.tcp)

    def place(self, q: Floats) -> Floats:
        """Compute the position (3,) of the tool centre point [m]."""
        return np.asarray((self.flange(q) @ self.tcp)[:3, 3])

    def lift(self, q: Floats, center: Floats, force: Floats) -> Floats:
        """Compute the joint torques (n,) [Nm] that hold a force (3,) [N] at a point of the flange frame (3,) [m]."""
        frames = self._frames_again(q)
        point = frames[-1, :3, :3] @ center + frames[-1, :3, 3]
        return _columns(frames, point)[:3].T @ force

    def speed(self, q: Floats, rate: Floats) -> Floats:
        """Compute the twist (6,) of the tool centre point at joint speeds (n,) [m/s, rad/s]."""
        frames = self.frames(q)
        return np.asarray(_columns(frames, (frames[-1] @ self.tcp)[:3, 3]) @ rate)

    def follow(self, target: Pose, near: Floats) -> Floats | None:
        """Solve inverse kinematics on the branch of a near joint position; None where Newton's method fails."""
        goal, q = target.matrix, near
        for _ in range(ROUNDS):
            frames = self._frames_again(q)
            end = frames[-1] @ self.tcp
            error = np.empty(6)
            error[:3] = goal[:3, 3] - end[:3, 3]
            error[3:] = _turn(goal[:3, :3] @ end[:3, :3].T)
            if np.abs(error).max() < CLOSE:
                return q
            j = _columns(frames, end[:3, 3])
            q = q + j.T @ np.linalg.solve(j @ j.T + self.damping, error)
        return None

    def _frames_again(self, q: Floats) -> Floats:
        """The frames; not computed again for the very array that they were computed for last: nobody changes one in place."""
        if self._last is None or self._last[0] is not q:
            self._last = q, self.frames(q)
        return self._last[1]


def cross(a: Floats | Sequence[float], b: Floats | Sequence[float]) -> Floats:
    """Compute the cross product a x b of two vectors (3,); numpy's own takes ten times as long for so few numbers."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _columns(frames: Floats, point: Floats) -> Floats:
    """The geometric Jacobian (6, n) of a point."""
    z, r = frames[:-1, :3, 2].T, (point - frames[:-1, :3, 3]).T
    out = np.empty((6, z.shape[1]), order="F")  # by columns, as its products take it
    out[0], out[1], out[2], out[3:] = z[1] * r[2] - z[2] * r[1], z[2] * r[0] - z[0] * r[2], z[0] * r[1] - z[1] * r[0], z
    return out


def _turn(r: Floats) -> Floats:
    """The rotation vector of a rotation, exact for small ones: half the skew part."""
    return np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2

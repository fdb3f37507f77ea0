"""Nominal kinematics of the controller, from the Denavit-Hartenberg table, fast enough for every control cycle.

Equations as in kinematics/kinematics.py (Siciliano et al., Robotics, 2009, 2.8.2 and 3.30), which finds all branches of
the inverse; here one solution is followed from cycle to cycle by Newton's method. Frames are (4, 4) in the base frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import sub

import numpy as np

from cramlite.model import Floats, Pose, Robot

from ...kinematics.kinematics import table

DAMPING = 1e-8  # squared: keeps the step finite at a singularity, far below what else would matter
CLOSE = 1e-8  # a target is reached below this error [m, rad]
ROUNDS = 12
TRIGONOMETRY = np.array([[0, 1, 1, 0], [1, 0, 0, 1]])  # 0 for the cosine of a joint, 1 for its sine


class NominalArm:
    """Kinematics of a robot with any tool centre point.

    Args:
        robot: must have a Denavit-Hartenberg table.

    Raises:
        ValueError: it has none.
    """

    def __init__(self, robot: Robot) -> None:
        rows = np.array(table(robot))
        a, d, alpha = rows.T
        ca, sa, one = np.cos(alpha), np.sin(alpha), np.ones(len(rows))
        # the first two rows of each joint's matrix: these factors, times cosine or sine of the joint as TRIGONOMETRY has it
        self.factors = np.array([[one, -ca, sa, a], [one, ca, -sa, a]]).transpose(2, 0, 1).copy()
        self.links = np.zeros((len(rows), 4, 4))
        self.links[:, 2, 1], self.links[:, 2, 2], self.links[:, 2, 3], self.links[:, 3, 3] = sa, ca, d, 1.0
        self.upper, self.each = self.links[:, :2], list(self.links)
        self.both = np.empty((len(rows), 2))  # cosine and sine of each joint
        self.cosines, self.sines = self.both.T
        self.tcp = robot.gripper.tcp.matrix
        self.base, self.damping = np.eye(4), DAMPING * np.eye(6)
        self._last: tuple[Floats, Floats] | None = None  # a commanded joint position, and its frames

    def frames(self, q: Floats) -> Floats:
        """Compute the frames (n + 1, 4, 4): the base, then the frame of each joint up to the flange."""
        np.cos(q, self.cosines)
        np.sin(q, self.sines)
        np.multiply(self.factors, self.both.take(TRIGONOMETRY, axis=1), self.upper)
        out = np.empty((len(q) + 1, 4, 4))
        out[0] = before = self.base
        for link, after in zip(self.each, out[1:], strict=True):
            before.dot(link, after)  # np.dot and @ take twice as long for so few numbers, and give the same bits
            before = after
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
        point = frames[-1, :3, :3].dot(center) + frames[-1, :3, 3]
        return np.asarray(_columns(frames, point)[:3].T.dot(force))

    def speed(self, q: Floats, rate: Floats) -> Floats:
        """Compute the twist (6,) of the tool centre point at joint speeds (n,) [m/s, rad/s]."""
        frames = self.frames(q)
        return np.asarray(_columns(frames, (frames[-1] @ self.tcp)[:3, 3]) @ rate)

    def follow(self, target: Pose, near: Floats) -> Floats | None:
        """Solve inverse kinematics on the branch of a near joint position; None where Newton's method fails."""
        turn, q = target.rotation, near
        for _ in range(ROUNDS):
            frames = self._frames_again(q)
            end = frames[-1].dot(self.tcp)
            error = [*map(sub, target.position, end[:3, 3].tolist()), *_turn(turn.dot(end[:3, :3].T))]
            if max(map(abs, error)) < CLOSE:
                return q
            j = _columns(frames, end[:3, 3])
            q = q + j.T.dot(np.linalg.solve(j.dot(j.T) + self.damping, error))
        return None

    def _frames_again(self, q: Floats) -> Floats:
        """The frames; not computed again for the very array that they were computed for last: nobody changes one in place."""
        if self._last is None or self._last[0] is not q:
            self._last = q, self.frames(q)
        return self._last[1]


def cross(a: Floats | Sequence[float], b: Floats | Sequence[float]) -> Floats:
    """Compute the cross product a x b of two vectors (3,); numpy's own takes ten times as long for so few numbers."""
    (u, v, w), (x, y, z) = np.asarray(a).tolist(), np.asarray(b).tolist()
    return np.array([v * z - w * y, w * x - u * z, u * y - v * x])


def _columns(frames: Floats, point: Floats) -> Floats:
    """The geometric Jacobian (6, n) of a point."""
    z, r = frames[:-1, :3, 2].T, (point - frames[:-1, :3, 3]).T
    out = np.empty((6, z.shape[1]), order="F")  # by columns, as its products take it
    out[0], out[1], out[2], out[3:] = z[1] * r[2] - z[2] * r[1], z[2] * r[0] - z[0] * r[2], z[0] * r[1] - z[1] * r[0], z
    return out


def _turn(r: Floats) -> list[float]:
    """The rotation vector (3,) of a rotation, exact for small ones: half the skew part."""
    (_, b, c), (d, _, f), (g, h, _) = r.tolist()
    return [(h - f) / 2, (c - g) / 2, (d - b) / 2]

"""Nominal kinematics of the controller, from the Denavit-Hartenberg table, fast enough for every control cycle.

MuJoCo computes frames and Jacobians, of a model that is nothing but the table: in a tenth of the time that NumPy takes for so few numbers.
kinematics/inverse.py finds all branches of the inverse; here one solution is followed from cycle to cycle by Newton's method.
Frames are (4, 4) in the base frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from operator import sub

import mujoco
import numpy as np

from cramlite.model import Floats, Pose, Robot

from ...kinematics.forward import table

DAMPING = 1e-8  # squared: keeps the step finite at a singularity, far below what else would matter
CLOSE = 1e-8  # a target is reached below this error [m, rad]
ROUNDS = 12
FLANGE, TCP = 0, 1  # ids of the sites
IDENTITY = np.eye(4)


class NominalArm:
    """Kinematics of a robot with any tool centre point.

    Args:
        robot: must have a Denavit-Hartenberg table.

    Raises:
        ValueError: it has none.
    """

    def __init__(self, robot: Robot) -> None:
        rows = table(robot)
        self.model = mujoco.MjModel.from_xml_string(_mjcf(rows, robot.root, robot.gripper.tcp))
        self.data = mujoco.MjData(self.model)
        # MuJoCo's own memory, looked up once
        self.joints, self.places, turns = self.data.qpos, self.data.site_xpos, self.data.site_xmat
        self.turns = turns.reshape(-1, 3, 3)
        self.tcp = robot.gripper.tcp.matrix
        self.last = len(rows)  # id of the last body
        self.jacobian = np.zeros((6, len(rows)))
        self.linear, self.angular = self.jacobian[:3], self.jacobian[3:]
        self.damping, self.step = DAMPING * np.eye(6), np.zeros(6)

    def flange(self, q: Floats) -> Floats:
        """Compute the frame (4, 4) of the flange."""
        return self._frame(q, FLANGE)

    def forward(self, q: Floats) -> Pose:
        """Solve forward kinematics: the pose of the tool centre point."""
        return Pose.from_matrix(self._frame(q, TCP))

    def place(self, q: Floats) -> Floats:
        """Compute the position (3,) of the tool centre point [m]."""
        self._put(q)
        return np.array(self.places[TCP])

    def lift(self, q: Floats, center: Floats, force: Floats) -> Floats:
        """Compute the joint torques (n,) [Nm] that hold a force (3,) [N] at a point of the flange frame (3,) [m]."""
        self._put(q)
        self._differentiate(self.turns[FLANGE].dot(center) + self.places[FLANGE])
        return np.asarray(self.linear.T.dot(force))

    def speed(self, q: Floats, rate: Floats) -> Floats:
        """Compute the twist (6,) of the tool centre point at joint speeds (n,) [m/s, rad/s]."""
        self._put(q)
        self._differentiate(self.places[TCP])
        return np.asarray(self.jacobian.dot(rate))

    def follow(self, target: Pose, near: Floats) -> Floats | None:
        """Solve inverse kinematics by Newton's method from near joint positions, on their branch; None if it
        does not converge."""
        turn, q, j = target.rotation, near, self.jacobian
        for _ in range(ROUNDS):
            self._put(q)
            error = [*map(sub, target.position, self.places[TCP].tolist()), *_turn(turn.dot(self.turns[TCP].T))]
            if max(map(abs, error)) < CLOSE:
                return q
            self._differentiate(self.places[TCP])
            square = j.dot(j.T) + self.damping
            mujoco.mju_cholFactor(square, DAMPING)  # no pivot of what is damped is smaller
            mujoco.mju_cholSolve(self.step, square, np.array(error))
            q = q + j.T.dot(self.step)
        return None

    def _put(self, q: Floats) -> None:
        self.joints[:] = q
        mujoco.mj_kinematics(self.model, self.data)

    def _frame(self, q: Floats, site: int) -> Floats:
        self._put(q)
        out = IDENTITY.copy()  # numpy.eye takes seven times as long
        out[:3, :3], out[:3, 3] = self.turns[site], self.places[site]
        return out

    def _differentiate(self, point: Floats) -> None:
        """Compute the geometric Jacobian (6, n) of a point (3,) that moves with the flange, at the joint
        positions set last by ``_put``."""
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_jac(self.model, self.data, self.linear, self.angular, point, self.last)


def _mjcf(rows: Sequence[tuple[float, float, float]], root: Pose, tcp: Pose) -> str:
    """Return the MJCF of an arm with given Denavit-Hartenberg rows, and with sites at the flange and the tool centre point.

    Its masses have no effect, but MuJoCo needs some.
    """
    a, d, alpha = rows[-1]
    flange = Pose((a, 0.0, d), (math.cos(alpha / 2), math.sin(alpha / 2), 0.0, 0.0))
    inner = "".join(f'<site pos="{_line(p.position)}" quat="{_line(p.quaternion)}"/>' for p in (flange, flange * tcp))
    frames = [Pose((a, 0.0, d), (math.cos(alpha / 2), math.sin(alpha / 2), 0.0, 0.0)) for a, d, alpha in reversed(rows[:-1])]
    for place in (*frames, root):
        own = '<joint axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        inner = f'<body pos="{_line(place.position)}" quat="{_line(place.quaternion)}">{own}{inner}</body>'
    return f"<mujoco><worldbody>{inner}</worldbody></mujoco>"


def _line(values: Iterable[float]) -> str:
    return " ".join(f"{v:.17g}" for v in values)


def cross(a: Floats | Sequence[float], b: Floats | Sequence[float]) -> Floats:
    """Compute the cross product a x b of two vectors (3,); numpy's own takes ten times as long for so few numbers."""
    (u, v, w), (x, y, z) = np.asarray(a).tolist(), np.asarray(b).tolist()
    return np.array([v * z - w * y, w * x - u * z, u * y - v * x])


def _turn(r: Floats) -> list[float]:
    """Approximate rotation vector (3,) of a small rotation matrix: half its skew-symmetric part."""
    (_, b, c), (d, _, f), (g, h, _) = r.tolist()
    return [(h - f) / 2, (c - g) / 2, (d - b) / 2]

"""Rigid transforms: the one type by which all parts of cramlite exchange poses.

Convention everywhere in cramlite: metres, right-handed frames, quaternions as
(w, x, y, z). File formats that store (x, y, z, w) convert at their border.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from msgspec.structs import force_setattr
from numpy.typing import ArrayLike, NDArray

from ..base.value import Value

Vector3 = tuple[float, float, float]
"""(x, y, z): a point or direction [m], or a rotation vector [rad]."""
Quaternion = tuple[float, float, float, float]
Floats = NDArray[np.float64]
"""Array of float64."""
HALF_TURN = 1e-7
"""Largest magnitude of a quaternion component that counts as rounding error: a hundred times the error of a chain of ten products."""


class Pose(Value, dict=True):
    """Rigid transform: the pose of a child frame in its parent.

    Args:
        position: (x, y, z) [m].
        quaternion: (w, x, y, z); normalised on construction.

    Raises:
        ValueError: a number is not finite, or the quaternion has no length.
    """

    position: Vector3 = (0.0, 0.0, 0.0)
    quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        position = tuple(map(float, self.position))
        quaternion = tuple(map(float, self.quaternion))
        length = math.hypot(*quaternion)
        if len(position) != 3 or len(quaternion) != 4 or not math.isfinite(sum(position) + length) or length < 1e-9:
            raise ValueError(f"not a pose: position {self.position}, quaternion {self.quaternion}")
        if abs(length - 1.0) > 1e-12:
            quaternion = tuple(v / length for v in quaternion)
        force_setattr(self, "position", position)
        force_setattr(self, "quaternion", quaternion)

    @classmethod
    def at(cls, point: ArrayLike, turned: Pose) -> Pose:
        """Return the pose at a point (3,) [m], with the orientation of another pose."""
        return cls(vector3(point), turned.quaternion)

    @classmethod
    def from_row(cls, row: Sequence[float] | Floats) -> Pose:
        """Return the pose of a row of samples: position (3,) [m], then quaternion (w, x, y, z)."""
        return cls(tuple(row[:3]), tuple(row[3:]))

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Pose:
        """Return the pose of a (4, 4) homogeneous or (3, 3) rotation matrix."""
        m = np.asarray(matrix, dtype=float)
        position = m[:3, 3] if m.shape == (4, 4) else np.zeros(3)
        return cls(tuple(position), _quaternion(m[:3, :3]))

    @classmethod
    def from_rotvec(cls, position: Sequence[float] | Floats, rotvec: Sequence[float] | Floats) -> Pose:
        """Return the pose with a position [m] and a rotation vector [rad], as in URScript's p[...]."""
        return cls(tuple(position), rotvec_quaternion(rotvec))

    @classmethod
    def from_axes(cls, position: ArrayLike, z: ArrayLike, x: ArrayLike) -> Pose:
        """Return the pose whose z axis is ``z`` and whose x axis is as near to ``x`` as it can be.

        Args:
            position: of its origin, (3,) [m].
            z, x: directions (3,) in the parent frame, of any length but 0, and not parallel.
        """
        axis_z = np.asarray(z, dtype=float) / np.linalg.norm(z)
        side = np.asarray(x, dtype=float)
        side = side - axis_z * (side @ axis_z)
        axis_x = side / np.linalg.norm(side)
        matrix = np.eye(4)
        matrix[:3, :3] = np.column_stack([axis_x, np.cross(axis_z, axis_x), axis_z])
        matrix[:3, 3] = position
        return cls.from_matrix(matrix)

    @cached_property
    def rotation(self) -> Floats:
        """Orientation of the pose as a (3, 3) rotation matrix."""
        w, x, y, z = self.quaternion
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    @cached_property
    def matrix(self) -> Floats:
        """(4, 4) homogeneous transformation matrix."""
        m = np.eye(4)
        m[:3, :3], m[:3, 3] = self.rotation, self.position
        return m

    @property
    def rotvec(self) -> Vector3:
        """Rotation vector (axis times angle) [rad], of length 0 to pi.

        Half a turn has two; the one whose first component that is not zero is positive is taken, so that rounding
        does not decide which one a program shows.
        """
        w, *v = self.quaternion
        leading = next((c for c in v if abs(c) > HALF_TURN), 0.0)
        if w < -HALF_TURN or (abs(w) <= HALF_TURN and leading < 0):
            w, v = -w, [-c for c in v]
        sine = math.hypot(*v)
        scale = 2 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
        return (v[0] * scale, v[1] * scale, v[2] * scale)

    def __mul__(self, other: Pose) -> Pose:
        """This pose followed by ``other``: a_T_b * b_T_c = a_T_c."""
        return Pose(tuple(self.apply(other.position).tolist()), quaternion_product(self.quaternion, other.quaternion))

    def inverse(self) -> Pose:
        """Return the inverse transform: the pose of the parent frame in the child."""
        w, x, y, z = self.quaternion
        turned = Pose((0, 0, 0), (w, -x, -y, -z))
        return Pose(tuple(-turned.apply(self.position)), turned.quaternion)

    def apply(self, points: ArrayLike) -> Floats:
        """Transform points (..., 3) [m] from the child frame to the parent frame."""
        moved: Floats = self.rotate(points) + np.asarray(self.position)
        return moved

    def rotate(self, vectors: ArrayLike) -> Floats:
        """Rotate directions (..., 3), of any unit, from the child frame to the parent frame, without the translation."""
        turned: Floats = np.asarray(vectors, dtype=float) @ self.rotation.T
        return turned

    def distance(self, other: Pose) -> tuple[float, float]:
        """Return the distance to another pose: translation [m] and rotation angle [rad]."""
        dot = abs(sum(a * b for a, b in zip(self.quaternion, other.quaternion, strict=True)))
        return math.dist(self.position, other.position), 2 * math.acos(min(1.0, dot))


def vector3(values: ArrayLike) -> Vector3:
    """Return three numbers (3,) as a tuple of floats."""
    x, y, z = np.asarray(values, dtype=float).tolist()
    return (x, y, z)


def rotations(quaternions: Floats) -> Floats:
    """Return the rotation matrices (N, 3, 3) of quaternions (N, 4) as (w, x, y, z), of any length but 0."""
    w, x, y, z = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def seen_from(frames: Floats, points: Floats) -> Floats:
    """Transform points (N, 3) of the world into one frame each, of poses (N, 7) as position and quaternion (w, x, y, z) [m]."""
    return np.asarray(np.einsum("ni,nij->nj", points - frames[:, :3], rotations(frames[:, 3:])))


def quaternion_product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Multiply two quaternions (w, x, y, z): the rotation b, followed by a."""
    (p, q, r, s), (w, x, y, z) = a, b
    return (
        p * w - q * x - r * y - s * z,
        p * x + q * w + r * z - s * y,
        p * y - q * z + r * w + s * x,
        p * z + q * y - r * x + s * w,
    )


def rotvec_quaternion(rotvec: Sequence[float] | Floats) -> Quaternion:
    """Compute the quaternion (w, x, y, z) of a rotation vector (3,) [rad]."""
    x, y, z = rotvec
    angle = math.hypot(x, y, z)
    scale = math.sin(angle / 2) / angle if angle > 1e-12 else 0.5
    return (math.cos(angle / 2), x * scale, y * scale, z * scale)


def _quaternion(r: Floats) -> Quaternion:
    """Quaternion of a rotation by Shepperd's method: the largest of the four components is computed first,
    against cancellation."""
    rows = r.tolist()
    diagonal = [rows[0][0], rows[1][1], rows[2][2]]
    trace = diagonal[0] + diagonal[1] + diagonal[2]
    candidates = [trace, *diagonal]
    k = candidates.index(max(candidates))
    if k == 0:
        q = (1 + trace, rows[2][1] - rows[1][2], rows[0][2] - rows[2][0], rows[1][0] - rows[0][1])
    else:
        i, j, m = k - 1, k % 3, (k + 1) % 3
        parts = [0.0, 0.0, 0.0]
        parts[i], parts[j], parts[m] = 1 + 2 * rows[i][i] - trace, rows[i][j] + rows[j][i], rows[i][m] + rows[m][i]
        q = (rows[m][j] - rows[j][m], *parts)
    return q

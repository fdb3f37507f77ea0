"""Conventions of recordings (unit, axes, handedness, order of quaternions), and conversion to metres, right-handed, z up.

Game engines and motion capture disagree on all of these. A convention is a signed permutation of axes: ``M`` (3, 3) with
p = M p' and R = M R' M^T, where p', R' are as recorded. A left-handed one has det M = -1; of a quaternion (w, v) it makes
(w, det(M) M v), because the axis of a rotation is an axial vector.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from cramlite.model import Floats, Value
from cramlite.plugin import UserError

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Units of length [m]."""
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Units of time [s]."""
QUATERNIONS = ("wxyz", "xyzw")
ROTATION_VECTOR = "rotation_vector"
EULER = re.compile(r"euler_([xyz]{3}|[XYZ]{3})")
"""Angles about three axes in this order: capitals about the axes that turn along, small letters about those that stay."""
PRESETS: dict[str, tuple[str, str, str, str]] = {
    "ros": ("m", "z", "right", "xyzw"),
    "unity": ("m", "y", "left", "xyzw"),
    "unreal": ("cm", "z", "left", "xyzw"),
    "optitrack": ("m", "y", "right", "xyzw"),
    "vicon": ("mm", "z", "right", "xyzw"),
}
"""Usual conventions: unit, the axis that points up, handedness, rotations. Unity's and Unreal's are those of their manuals."""
LONGEST = 0.02
"""Largest deviation of a quaternion's length from 1: rounding to two digits causes up to 0.01."""


class Convention(Value):
    """Convention by which a recording writes poses: unit of length, axes, form of rotations, unit of angles.

    Args:
        unit: of length [m].
        axes: (3, 3), rows: our x, y and z in the recording's axes.
        rotation: "wxyz" or "xyzw", "rotation_vector", or "euler_XYZ" and the like.
        angle: unit of angles [rad].
    """

    unit: float
    axes: Floats
    rotation: str
    angle: float = 1.0

    @property
    def numbers(self) -> int:
        """Return how many numbers the recording has for a rotation: 4 for a quaternion, else 3."""
        return 4 if self.rotation in QUATERNIONS else 3

    def positions(self, recorded: Floats) -> Floats:
        """Convert positions (N, 3) from the recording's unit and axes to cramlite's: metres, z up."""
        return np.asarray(self.unit * np.asarray(recorded) @ self.axes.T)

    def extents(self, recorded: Sequence[float]) -> Floats:
        """Convert extents (3,) along the recording's axes to extents along cramlite's axes [m]."""
        return np.asarray(np.abs(self.axes) @ (self.unit * np.asarray(recorded, dtype=float)))

    def quaternions(self, recorded: Floats) -> Floats:
        """Convert rotations (N, 4), or (N, 3) where they are no quaternions, to unit quaternions (N, 4) in
        cramlite's axes, w first."""
        q = self._w_first(np.asarray(recorded, dtype=float))
        turned = q[:, 1:] @ (np.linalg.det(self.axes).round() * self.axes).T
        q = np.hstack([q[:, :1], turned])
        return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))

    def _w_first(self, recorded: Floats) -> Floats:
        from scipy.spatial.transform import Rotation

        if self.rotation == "wxyz":
            return recorded
        if self.rotation == "xyzw":
            return recorded[:, [3, 0, 1, 2]]
        angles = self.angle * recorded
        vector = self.rotation == ROTATION_VECTOR
        found = Rotation.from_rotvec(angles) if vector else Rotation.from_euler(self.rotation.removeprefix("euler_"), angles)
        return np.asarray(found.as_quat()[:, [3, 0, 1, 2]])


def axes_of(up: str, handedness: str) -> Floats:
    """Return cramlite's axes (x forward, y left, z up) in the axes of a recording of which only the upward
    axis and the handedness are known.

    The next two in cyclic order become our x and y; the second one with its sign changed where the recording is
    left-handed. For y up and left-handed that is what Unity's ROS packages do (z, -x, y), for z up Unreal's (x, -y, z).
    """
    k, down = "xyz".index(up[-1]), up.startswith("-")
    rows = np.zeros((3, 3))
    rows[0, (k + 1) % 3], rows[1, (k + 2) % 3], rows[2, k] = 1.0, 1.0, -1.0 if down else 1.0
    if (handedness == "left") != down:
        rows[1] *= -1.0
    return rows


def axes_from(names: Sequence[str]) -> Floats:
    """Return cramlite's axes (x forward, y left, z up) from their names in the recording, such as [z, -x, y].

    Raises:
        UserError: they are not x, y and z, once each.
    """
    rows = np.zeros((3, 3))
    for row, name in zip(rows, names, strict=False):
        if name.lstrip("+-") in ("x", "y", "z"):
            row["xyz".index(name[-1])] = -1.0 if name.startswith("-") else 1.0
    if len(names) != 3 or abs(np.linalg.det(rows)) != 1.0:
        raise UserError(
            f"'axes: [{', '.join(names)}]' says what our x (forward), y (left) and z (up) are in the recording; it needs x, y and z "
            "once each, some with a minus, such as [z, -x, y] for Unity."
        )
    return rows

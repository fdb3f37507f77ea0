"""Poses in scenario files, in the form that people write."""

from __future__ import annotations

from ..base.quantities import Angle, Length
from ..base.spec import Spec
from ..model.geometry import Pose


class PoseSpec(Spec):
    """Pose as people write it: position and rotations about the fixed axes x, y, z, in that order."""

    position: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    roll: Angle = 0.0
    pitch: Angle = 0.0
    yaw: Angle = 0.0

    def pose(self) -> Pose:
        """Return the pose as a rigid transform."""
        turns = [((0, 0, 1), self.yaw), ((0, 1, 0), self.pitch), ((1, 0, 0), self.roll)]
        result = Pose(self.position)
        for axis, angle in turns:
            result = result * Pose.from_rotvec((0, 0, 0), [a * angle for a in axis])
        return result

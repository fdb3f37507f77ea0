"""What keys of scenario files share: unknown keys are refused, poses are written as people write them."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from ..base.quantities import Angle, Length
from ..model.geometry import Pose


class Spec(BaseModel):
    """Mapping of a scenario file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


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

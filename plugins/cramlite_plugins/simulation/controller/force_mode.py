"""Force mode of the virtual UR controller: admittance around the running motion.

On compliant axes the tool moves at v = gain * (wanted - applied), up to the axis's speed limit, in addition to the
motion that is running; other axes follow the motion. The deviation limits of axes that do not comply are
accepted and ignored: a real controller stops when they are exceeded.

Gain and dead band: docs/explanation/simulation.md (4 mm/s/N and 0.3 N at 125 Hz); the rotational pair gives the same
time constant at a lever of 0.1 m.
"""

from __future__ import annotations

import numpy as np
from msgspec import Struct, field

from cramlite.model import Floats, Pose, quaternion_product, rotvec_quaternion

GAIN = np.array([0.004] * 3 + [0.4] * 3)  # m/s/N and rad/s/Nm
DEAD = np.array([0.3] * 3 + [0.03] * 3)  # N and Nm


class ForceMode(Struct):
    """State of force mode while it is switched on.

    Args:
        frame: compliance frame in base; only its rotation counts.
        selection: (6,) which axes comply.
        wrench: (6,) wanted on them, what the robot applies [N, Nm].
        limits: (6,) highest speed of compliant axes [m/s, rad/s].
        offset: (6,) how far the compliant axes have gone [m, rad], in the frame.
    """

    frame: Pose
    selection: Floats
    wrench: Floats
    limits: Floats
    offset: Floats = field(default_factory=lambda: np.zeros(6))

    def advance(self, applied: Floats, period: float, scale: float = 1.0) -> None:
        """Integrate force mode's deviation over a control cycle; ``applied`` is the wrench (6,) of the robot on its
        environment, base axes [N, Nm].

        Args:
            scale: of the gain, as ``force_mode_set_gain_scaling`` sets it.
        """
        turn = self.frame.rotation.T
        error = self.wrench - np.concatenate([turn.dot(applied[:3]), turn.dot(applied[3:])])
        error = np.where(np.abs(error) < DEAD, 0.0, error)
        self.offset += self.selection * np.clip(scale * GAIN * error, -self.limits, self.limits) * period

    def target(self, nominal: Pose) -> Pose:
        """Return the commanded TCP pose: that of the running motion, shifted and turned by the deviation of
        force mode."""
        shift = self.frame.rotate(self.offset[:3])
        turn = rotvec_quaternion(self.frame.rotate(self.offset[3:]).tolist())
        x, y, z = (a + b for a, b in zip(nominal.position, shift.tolist(), strict=True))
        return Pose((x, y, z), quaternion_product(turn, nominal.quaternion))

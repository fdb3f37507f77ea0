"""Inaccuracies of an arm that its controller does not know: wrong joint zeros, play (backlash) in joints, and
delayed measurements.

Encoders sit on the motors' side: what a joint really stands at is what its encoder says, plus the error of its zero, less the play
that it has not yet gone through. Servos and the watch over them are beside the motors and see encoders at once; what a program and
force mode are told, encoders and wrist sensor, is late.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from cramlite.model import Disturbance, Floats


class ArmErrors:
    """Simulated inaccuracies of an arm while it runs: wrong joint zeros, play in joints, and delayed
    measurements.

    Args:
        off: as drawn.
        q: what the joints really stand at, at the start (n,) [rad].
        period: of a control cycle [s].
    """

    def __init__(self, off: Disturbance, q: Floats, period: float) -> None:
        self.zeros = np.array(off.joint_zeros) if off.joint_zeros else np.zeros(len(q))
        self.half = off.backlash / 2
        self.behind = q - self.zeros  # the joints, as their encoders would say without play
        self.play = np.zeros(len(q))
        self.now = q - self.zeros  # what the encoders said at the end of the last cycle
        cycles = round(off.latency / period)
        self._joints: deque[Floats] = deque([q - self.zeros], cycles + 1)
        self._readings: deque[Floats] = deque(maxlen=cycles + 1)

    def moved(self, goal: Floats) -> Floats:
        """Return the true joint positions (n,) [rad] when the motors are at ``goal`` (n,).

        They differ from it by the play of the joints, and by the errors of their zeros.
        """
        self.behind = np.minimum(np.maximum(self.behind, goal - self.half), goal + self.half)
        self.play = goal - self.behind
        return np.asarray(self.behind + self.zeros)

    def encoders(self, q: Floats) -> Floats:
        """Return the encoders' readings (n,) [rad] at joint positions ``q`` (n,)."""
        return np.asarray(q - self.zeros + self.play)

    def measured(self, encoders: Floats, reading: Floats) -> Floats:
        """Store the encoder positions (n,) [rad] and the sensor reading (6,) of a cycle; return the delayed
        reading that programs and force mode get now."""
        self.now = encoders
        self._joints.append(encoders)
        self._readings.append(reading)
        return self._readings[0]

    @property
    def told(self) -> Floats:
        """Delayed encoder positions (n,) [rad] that programs and force mode get now."""
        return self._joints[0]

"""The force-torque sensor of the virtual UR controller.

Raw readings are averaged over the substeps of a control cycle and low-pass filtered. The weight of the payload that
the program has set is taken off, then the bias of the last zero_ftsensor, which is fixed in the sensor.
Inertia stays in: 3 to 9 N in fast free motion (docs/explanation/simulation.md).
"""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import GRAVITY, Disturbance, Floats

from .nominal_arm import cross

# Time constant of the low-pass filter [s]: 10 Hz corner, between UR's 500 Hz sensor and its 8 ms script cycle.
SMOOTHING = 0.016
SPREAD = np.array([1.0] * 3 + [0.05] * 3)  # of noise: N and Nm


class WristSensor:
    """The force-torque sensor: the wrench of the environment on the tool, base axes at the TCP.

    Args:
        up: unit vector against gravity, in the base frame.
        noise: standard deviation of each raw reading [N]; torques get a twentieth of it [Nm].
    """

    def __init__(self, up: Floats, noise: float, seed: int) -> None:
        self.up, self.noise = up, noise
        self.drift, self.wandered = np.zeros(6), np.zeros(6)
        self.turning: Floats | None = None
        self.wanders = False
        self.random = np.random.default_rng(seed)
        self.raw = np.zeros(6)
        self.bias = np.zeros(6)
        self.mass = 0.0
        self.center = np.zeros(3)
        self.started = self.tared = False

    def disturb(self, off: Disturbance) -> None:
        """Add errors: noise, a drifting offset of the zero, and a force that turns with the wrist, as weight
        does."""
        self.noise = math.hypot(self.noise, off.force_noise)
        self.drift, self.wandered = np.array([*off.force_drift, 0.0, 0.0, 0.0]), np.array([*off.force_bias, 0.0, 0.0, 0.0])
        self.turning = np.array(off.force_turning) if any(off.force_turning) else None
        self.wanders = any(off.force_drift) or any(off.force_bias)

    def feed(self, reading: Floats, period: float) -> None:
        """Filter a control cycle's mean reading (6,): the wrench of the wrist on the tool, sensor axes [N, Nm]."""
        if self.wanders:
            self.wandered = self.wandered + period * self.drift
            reading = reading + self.wandered
        if self.noise:
            reading = reading + self.noise * self.random.standard_normal(6) * SPREAD
        share = period / (SMOOTHING + period) if self.started else 1.0
        self.started = True
        self.raw = self.raw + share * (reading - self.raw)

    def zero(self, flange: Floats) -> None:
        """Set the force sensor's reading to zero (tare) at the present pose (4, 4) of the flange in the base frame."""
        turn = flange[:3, :3]
        self.bias, self.tared = np.concatenate([self._force(turn), self._torque(turn)]), True

    def force(self, flange: Floats) -> Floats:
        """Return the force (3,) of the environment on the tool, base axes [N]; most cycles need no torque.

        Args:
            flange: (4, 4) in the base frame; the sensor sits there.
        """
        turn = flange[:3, :3]
        return np.asarray(turn.dot(self._force(turn) - self.bias[:3]))

    def torque(self, flange: Floats, tcp: Floats, force: Floats) -> Floats:
        """Return the torque (3,) of the environment on the tool about the TCP, base axes [Nm].

        Args:
            flange, tcp: (4, 4) in the base frame.
            force: what ``force`` returns there (3,) [N].
        """
        turn = flange[:3, :3]
        return np.asarray(turn.dot(self._torque(turn) - self.bias[3:]) - cross(tcp[:3, 3] - flange[:3, 3], force))

    def _force(self, turn: Floats) -> Floats:
        """The force (3,) on the tool less the payload's weight, sensor axes, bias included [N]."""
        felt: Floats = -self.raw[:3] - self._weight(turn)
        return felt if self.turning is None else felt + self.turning.dot(turn)

    def _torque(self, turn: Floats) -> Floats:
        """The torque (3,) on the tool less the payload's, sensor axes, bias included [Nm]."""
        return -self.raw[3:] - cross(self.center, self._weight(turn))

    def _weight(self, turn: Floats) -> Floats:
        """The payload's weight (3,), sensor axes [N]."""
        return np.asarray(self.up.dot(turn) * -(self.mass * GRAVITY))

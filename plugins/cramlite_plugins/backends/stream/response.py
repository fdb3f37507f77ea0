"""What an arm must be told that is behind what it is told."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Floats

STIFFER = 1.5
"""A spring is made so much stiffer by what it is told beside its command. It may pull with 0.2 to 2 times the force that it should, as
one that treats position and rotation apart does: with a lag of 3.3 periods an error then falls to a share of at most 0.83 a period, and
without to 0.89."""
SAMPLES = 2.0
"""Periods that the lag must have for that (0.78 a period, 0.82 without); where it has one, such a spring would swing ever more."""


class Response:
    """How an arm follows: with a lag, or as a critically damped spring that is pulled along, x'' = w^2 (u - x) - 2 w x', w = 2 / lag.

    Args:
        lag: how long it stays behind at an even speed [s].
        spring: whether it is a spring; else nothing is known of how it speeds up.
        period: of an action [s].
        joints: of the robot.
    """

    def __init__(self, lag: float, spring: bool, period: float, joints: int) -> None:
        self.lag, self.spring, self.period = lag, spring, period
        self.stiffer = STIFFER if spring and lag >= SAMPLES * period else 0.0
        self.rate, self.off = np.zeros(joints), np.zeros(6)

    def lead(self, rate: Floats) -> Floats:
        """Return how far ahead of its command the arm is told to be (n,) [rad], at a rate (n,) of the command [rad/s]."""
        faster = (rate - self.rate) / self.period
        return self.lag * rate + (self.lag**2 / 4 * faster if self.spring else 0.0)

    def correction(self, off: Floats) -> Floats:
        """Return what is added to a delta (6,) where the tool is off the last command (6,) [m, rad]; it is damped critically, too."""
        further = (off - self.off) / self.period
        damping = self.lag * (math.sqrt(1.0 + self.stiffer) - 1.0)
        added: Floats = self.stiffer * off + damping * further
        return added

    def passed(self, rate: Floats, off: Floats) -> None:
        """Take what was commanded and measured in a period that is over."""
        self.rate, self.off = rate, off

"""Response of an arm that lags behind its commands, and the correction for it."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Floats

STIFFER = 1.5
"""Factor by which corrections of its commands make a spring-like arm stiffer. The arm may pull with 0.2 to 2 times the
nominal force, as one that treats position and rotation apart does: with 2 / w of 3.3 periods an error then falls to a
share of at most 0.83 a period, and without the factor to 0.89."""
SAMPLES = 2.0
"""Least ratio of the time constant 2 / w to the control period at which ``STIFFER`` is used (errors fall to 0.78 a period, without the
factor to 0.82); at a ratio of 1 the spring would oscillate with growing amplitude."""


class Response:
    """Model of how an arm follows its commands: with a lag, or as a critically damped spring x'' = w^2 (u - x) - 2 w
    x'.

    Args:
        lag: how long it stays behind at an even speed [s].
        inertia: how far it stays behind while it speeds up [s2], 1 / w^2 of a spring; 0 where nothing is known of that.
        period: of an action [s].
        joints: of the robot.
    """

    def __init__(self, lag: float, inertia: float, period: float, joints: int) -> None:
        self.lag, self.inertia, self.period = lag, inertia, period
        self.slow = 2.0 * math.sqrt(inertia)
        self.stiffer = STIFFER if inertia and self.slow >= SAMPLES * period else 0.0
        self.rate, self.off = np.zeros(joints), np.zeros(6)

    def lead(self, rate: Floats, free: bool = True) -> Floats:
        """Return how far the command must be ahead of the arm (n,) [rad] while the command moves at a rate
        (n,) [rad/s].

        Args:
            free: whether it may be led by its acceleration, too; what a force commands is noise.
        """
        faster = (rate - self.rate) / self.period
        return self.lag * rate + (self.inertia * faster if free else 0.0)

    def correction(self, off: Floats) -> Floats:
        """Return what to add to a commanded displacement (6,) [m, rad] so that the tool's deviation (6,) dies
        out without overshoot."""
        further = (off - self.off) / self.period
        damping = self.slow * (math.sqrt(1.0 + self.stiffer) - 1.0)
        added: Floats = self.stiffer * off + damping * further
        return added

    def gliding(self, off: Floats) -> Floats:
        """Estimate how far an arm glides on before it stops (6,) [m, rad], from the speed at which its
        distance to the goal changes.

        One that treats position and rotation apart may hardly be pulled back: at a grasp it was within 1 mm, at 60 mm/s, and glided on by
        9 mm in 0.3 s, while the fingers closed. A spring that falls back as it should ends this sum at its distance, and takes no longer.
        """
        further: Floats = (off - self.off) * max(1.0, self.slow / self.period)
        return further

    def passed(self, rate: Floats, off: Floats) -> None:
        """Remember the commanded rates of the joints and the deviation of the tool in the control period that has
        ended."""
        self.rate, self.off = rate, off

"""The controller of a mobile platform: straight legs as commands of its joints, and odometry.

Like an arm's joints, the platform is driven by servos whose force is limited; what stands in its way stops it. Nothing
else is ever set: no position is written into the simulation.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cramlite.model import Floats, Pose, Vector3

from ..model.index import RobotIndex, flat
from .trajectories import StoppingMotion, TrapezoidalProfile, stopping_motion

TRACKING = 0.05, 0.05
"""Largest deviation of the platform from its command [m, rad]; beyond it an obstacle holds the platform. In free motion it stays below 2
mm and 2 mrad (measured)."""


class Leg(TrapezoidalProfile):
    """Straight motion of a mobile platform from ``start`` to ``goal``, x, y and turn (3,) [m, m, rad], from rest to rest."""

    start: Floats
    goal: Floats

    def at(self, time: float) -> Floats:
        """Return the platform's x, y, turn (3,) [m, m, rad] at a time since the start [s]."""
        return np.asarray(self.start + self.share(time) * (self.goal - self.start))


def leg(start: Floats, goal: Floats, rates: tuple[float, float], turning: tuple[float, float]) -> Leg:
    """Plan a straight motion of a platform within the limits of speed and acceleration of translation and rotation.

    Args:
        start, goal: x, y [m] and turn [rad].
        rates, turning: speed and acceleration [m/s, m/s2], [rad/s, rad/s2].
    """
    way, turn = math.hypot(*(goal - start)[:2]), abs(float(goal[2] - start[2]))
    pairs = [(r, amount) for amount, r in ((way, rates), (turn, turning)) if amount > 1e-9]
    if not pairs:
        return Leg(0.0, 1.0, 1.0, start, goal)
    speed, acceleration = (min(r[k] / amount for r, amount in pairs) for k in (0, 1))
    return Leg(1.0, speed, acceleration, start, goal)


class PlatformDrive:
    """The servos of a platform.

    Args:
        model, data: MuJoCo's.
        index: of the robot; it has a platform.
        start: where the platform stands when its joints are at zero, in the world.
    """

    def __init__(self, model: Any, data: Any, index: RobotIndex, start: Pose) -> None:
        assert index.platform is not None
        self.data, self.index, self.start = data, index.platform, start
        self.servos, self.joints = list(index.platform.actuators), list(index.platform.joints)
        self.lag = -model.actuator_biasprm[self.servos, 2] / model.actuator_gainprm[self.servos, 0]
        self.goal = np.array(data.qpos[self.joints])
        self.before, self.rate = self.goal, np.zeros(3)
        self.motion: Leg | StoppingMotion | None = None
        self.time = 0.0

    @property
    def driving(self) -> bool:
        """Check whether the platform is driving along a straight leg of its path."""
        return self.motion is not None

    def drive(self, place: Vector3, rates: tuple[float, float], turning: tuple[float, float]) -> None:
        """Start a straight motion to x, y, turn in the world [m, m, rad], turning the shorter way round, from the goal
        of the last one."""
        x0, y0, turn0 = flat(self.start)
        c, s = math.cos(turn0), math.sin(turn0)
        dx, dy = place[0] - x0, place[1] - y0
        turn = math.remainder(place[2] - turn0 - self.goal[2], math.tau)
        goal = np.array([c * dx + s * dy, c * dy - s * dx, self.goal[2] + turn])
        self.motion, self.time = leg(self.goal, goal, rates, turning), 0.0

    def stop(self) -> None:
        """Stop the platform along the leg that it drives, with that leg's own deceleration."""
        if isinstance(self.motion, Leg):
            self.motion, self.time = stopping_motion(self.motion, self.time, self.motion.acceleration), 0.0

    def advance(self, period: float) -> None:
        """Advance the platform's commanded position by a control cycle."""
        self.before = self.goal
        if self.motion is not None:
            self.time += period
            self.goal = np.asarray(self.motion.at(self.time))
            if self.time >= self.motion.duration:
                self.motion = None
        self.rate = (self.goal - self.before) / period

    def apply(self, share: float) -> None:
        """Command the platform's servos to the pose after a share (0 to 1) of the control cycle, with velocity
        feed-forward."""
        self.data.ctrl[self.servos] = self.before + share * (self.goal - self.before) + self.lag * self.rate

    def actual(self) -> Pose:
        """Return the platform's pose in the world, from its odometry."""
        x, y, turn = (float(v) for v in self.data.qpos[self.joints])
        return self.start * Pose((x, y, 0.0), (math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)))

    def late(self) -> str:
        """Explain in words why the platform does not follow its command; "" if it does."""
        off = self.data.qpos[self.joints] - self.goal
        way, turn = math.hypot(off[0], off[1]), abs(float(off[2]))
        if way <= TRACKING[0] and turn <= TRACKING[1]:
            return ""
        return f"the platform is {way:.3f} m and {turn:.3f} rad off its command: something is in its way"

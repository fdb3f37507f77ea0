"""Streamed motions, commanded again and again while the arm moves: speedj, speedl, servoj.

Names, parameters and defaults: the URScript manual (e-Series 5.x), module "motion". How servoj filters its targets is not
published; here the arm nears the target as a first-order system does, with the look-ahead time as its time constant,
shorter for a higher gain (300 is the default of both).
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Any

import numpy as np
from msgspec import field

from cramlite.model import Floats, Pose, Value

from ..simulation.controller.controller import Controller
from ..simulation.controller.trajectories import StoppingMotion
from .urscript.values import ScriptError, numbers, real

Wait = Generator[None, None, None]
STREAMING = ("speedj", "speedl", "servoj", "servoc")
GAIN = 300.0


class JointSpeed(Value):
    """A motion at joint speeds (n,) [rad/s] that change from ``before`` to ``wanted`` within ``ramp`` seconds,
    and then stay constant."""

    start: Floats
    before: Floats
    wanted: Floats
    ramp: float
    duration: float = math.inf
    way: float = math.inf

    def gone(self, time: float) -> Floats:
        """Compute the displacement of each axis at a time since the start of the motion [rad or m]."""
        t = min(time, self.ramp)
        bent = t * t / (2 * self.ramp) if self.ramp > 0 else 0.0
        return self.before * t + (self.wanted - self.before) * bent + self.wanted * (time - t)

    def at(self, time: float) -> Floats | Pose:
        """Return the joint positions (n,) [rad] at a time since the start of the motion [s]."""
        return self.start + self.gone(time)

    def rate(self, time: float) -> float:
        """Return the speed of the fastest axis at a time since the start of the motion [s]."""
        share = min(1.0, time / self.ramp) if self.ramp > 0 else 1.0
        return float(np.abs(self.before + share * (self.wanted - self.before)).max())


class ToolSpeed(JointSpeed):
    """Tool speeds (6,) [m/s, rad/s], base axes, that change to the wanted ones within a time.

    They change as the joint speeds of ``JointSpeed`` do. ``place`` is the first TCP pose, and ``start`` is
    unused.
    """

    place: Pose = field(default_factory=Pose)

    def at(self, time: float) -> Floats | Pose:
        """Return the TCP pose in the base frame at a time since the start of the motion [s]."""
        gone = self.gone(time)
        turned = Pose.from_rotvec((0, 0, 0), gone[3:]) * self.place
        return Pose.at(self.place.position + gone[:3], turned)


class Servo(Value):
    """A motion to a joint target (n,) that slows down exponentially (first-order lag); the target may change
    at any time."""

    start: Floats
    goal: Floats
    constant: float
    way: float = math.inf

    @property
    def duration(self) -> float:
        """Return the time after which e^-10 of the initial distance to the target is left [s]."""
        return 10 * self.constant  # e^-10: below the encoder's resolution

    def at(self, time: float) -> Floats | Pose:
        """Return the joint positions (n,) [rad] at a time since the start of the motion [s]."""
        return self.goal + (self.start - self.goal) * math.exp(-time / self.constant)

    def rate(self, time: float) -> float:
        """Return the largest joint speed [rad/s] at a time since the start of the motion [s]."""
        return float(np.abs(self.goal - self.start).max()) / self.constant * math.exp(-time / self.constant)


STREAMED = (JointSpeed, Servo)


class Streaming:
    """The URScript functions for streamed motions of one run."""

    def __init__(self, controller: Controller) -> None:
        self.arm = controller

    def speedj(self, qd: Any, a: Any, t: Any = 0) -> Wait:
        """Move the joints at speeds (n,) [rad/s], reached at an acceleration [rad/s2], for a time [s]."""
        wanted = np.array(numbers(qd, len(self.arm.q), "speedj"))
        ramp = _ramp(self.arm.rate, wanted, a, "speedj")
        yield from self._hold_on(JointSpeed(self.arm.q.copy(), self.arm.rate.copy(), wanted, ramp), t, ramp)

    def speedl(self, xd: Any, a: Any, t: Any = 0, aRot: Any = "a") -> Wait:
        """Move the TCP at a twist (6,) in base axes [m/s, rad/s], reached at an acceleration [m/s2], for a time [s]."""
        wanted = np.array(numbers(xd, 6, "speedl"))
        before = self.arm.tool_speed()
        ramp = _ramp(before[:3], wanted[:3], a, "speedl") or _ramp(before, wanted, a, "speedl")
        place = self.arm.kinematics.forward(self.arm.q)
        yield from self._hold_on(ToolSpeed(np.zeros(6), before, wanted, ramp, place=place), t, ramp)

    def servoj(
        self, q: Any, a: Any = 0, v: Any = 0, t: Any = 0.002, lookahead_time: Any = 0.1, gain: Any = GAIN
    ) -> Wait:
        """Follow a joint target (n,) [rad] for a time [s]."""
        goal = np.array(numbers(q, len(self.arm.q), "servoj"))
        ahead, strong, wait = real(lookahead_time, "servoj"), real(gain, "servoj"), real(t, "servoj")
        if not 0.03 <= ahead <= 0.2 or not 100 <= strong <= 2000:
            raise ScriptError(
                f"servoj: lookahead_time {ahead:g} is not in 0.03 .. 0.2 s, or gain {strong:g} not in 100 .. 2000"
            )
        self.only_mover()
        motion = self.arm.follow(Servo(self.arm.q.copy(), goal, ahead * GAIN / strong))
        yield from self._wait(motion, wait)

    def servoc(self, pose: Any, a: Any = 1.2, v: Any = 0.25, r: Any = 0) -> None:
        """Refuse ``servoc``: it is not modelled."""
        raise ScriptError("servoc is not modelled here: use servoj or movel")

    def _hold_on(self, motion: JointSpeed, t: Any, ramp: float) -> Wait:
        self.only_mover()
        yield from self._wait(self.arm.follow(motion), real(t, "t") or ramp)

    def _wait(self, motion: Any, seconds: float) -> Wait:
        """Wait for a time [s], at least one control cycle; if the thread is killed meanwhile, the arm stops
        by itself."""
        try:
            for _ in range(max(1, math.ceil(seconds / self.arm.period - 1e-9))):
                yield
        except GeneratorExit:
            if self.arm.motion is motion:
                self.arm.stop(2.0)
            raise

    def only_mover(self) -> None:
        """Raise ScriptError if another thread moves the robot."""
        if self.arm.motion is not None and not isinstance(self.arm.motion, (StoppingMotion, *STREAMED)):
            raise ScriptError("another thread is already moving the robot: kill it first")


def _ramp(before: Floats, wanted: Floats, a: Any, name: str) -> float:
    acceleration = real(a, name)
    if acceleration <= 0:
        raise ScriptError(f"{name} needs a positive acceleration, not {acceleration:g}")
    return float(np.abs(wanted - before).max()) / acceleration

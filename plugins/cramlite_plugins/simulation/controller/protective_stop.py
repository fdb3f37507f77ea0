"""Protective stops: limits of joints and of the safety configuration."""

from __future__ import annotations

from operator import gt, lt, sub, truediv

import numpy as np

from cramlite.model import Floats, Robot, Value


class Safety(Value):
    """The controller's safety configuration: limits whose violation ends in a protective stop.

    Args:
        force: on the TCP [N]; the factory preset of e-Series arms is 150.
        force_time, torque_time, tracking_time: how long a limit may be exceeded [s].
        tracking: largest joint error [rad]; fast free motion stays below 0.007 (3 rad/s, 5 rad/s2).
    """

    force: float = 150.0
    force_time: float = 0.02
    torque_time: float = 0.1
    tracking: float = 0.03
    tracking_time: float = 0.1


class ProtectiveStop(Exception):
    """The arm was stopped by the controller; the message gives the reason with numbers."""


class SafetyWatch:
    """A monitor that stops an arm: at once beyond joint limits, after a time beyond limits of the safety configuration.

    Args:
        arm: whose joint limits hold.
        torques: largest torques of its servos [Nm].
        period: of a control cycle [s].
    """

    def __init__(self, safety: Safety, arm: Robot, torques: Floats, period: float) -> None:
        self.safety, self.arm, self.torques, self.period = safety, arm, torques, period
        self.limits = np.array(arm.limits).T
        self.lows, self.highs = zip(*arm.limits, strict=True)
        self.fastest = [1.05 * v for v in arm.velocity]
        self.strongest: list[float] = torques.tolist()
        self.over = {"force": 0.0, "torque": 0.0, "tracking": 0.0, "platform": 0.0}

    def command(self, before: Floats, goal: Floats) -> None:
        """Check that joint positions to be commanded next are in range, and reachable from the last ones within a cycle.

        Raises:
            ProtectiveStop: a joint would leave its range, or move too fast.
        """
        # maps over lists: for so few numbers NumPy takes four times as long
        wanted, was = goal.tolist(), before.tolist()
        if any(map(lt, wanted, self.lows)) or any(map(gt, wanted, self.highs)):
            i = next(i for i, (low, high) in enumerate(self.arm.limits) if not low <= wanted[i] <= high)
            low, high = self.arm.limits[i]
            raise ProtectiveStop(f"joint '{self.arm.joints[i]}' at {wanted[i]:.3f} rad, outside {low:.3f} .. {high:.3f}")
        rates = [abs(way) / self.period for way in map(sub, wanted, was)]
        if any(map(gt, rates, self.fastest)):
            shares = list(map(truediv, rates, self.fastest))
            i = shares.index(max(shares))
            most = self.arm.velocity[i]
            raise ProtectiveStop(f"joint '{self.arm.joints[i]}' at {rates[i]:.2f} rad/s > {most:.2f} rad/s")

    def cycle(self, force: float, effort: Floats, error: Floats, platform: str) -> None:
        """Check the measurements of a control cycle against the limits of the safety configuration.

        Args:
            force: on the TCP [N].
            effort: of the servos [Nm].
            error: of the joints [rad].
            platform: how far the platform is behind, as a clause; empty while it is not.

        Raises:
            ProtectiveStop: a limit was exceeded for longer than it may be.
        """
        s, torque, errors = self.safety, list(map(truediv, map(abs, effort.tolist()), self.strongest)), list(map(abs, error.tolist()))
        worst, late = max(torque), max(errors)
        if not (force > s.force or worst > 0.99 or late > s.tracking or platform):
            self.over = dict.fromkeys(self.over, 0.0)
            return
        if self._lasts("force", force > s.force, s.force_time):
            self._stop_for("force", f"force {force:.0f} N > {s.force:.0f} N")
        if self._lasts("torque", worst > 0.99, s.torque_time):
            i = torque.index(worst)
            self._stop_for("torque", f"joint '{self.arm.joints[i]}' at its torque limit of {self.torques[i]:.0f} Nm")
        if self._lasts("tracking", late > s.tracking, s.tracking_time):
            joint = self.arm.joints[errors.index(late)]
            self._stop_for("tracking", f"joint '{joint}' is {late:.3f} rad off its command, more than {s.tracking} rad")
        if self._lasts("platform", bool(platform), s.tracking_time):
            self._stop_for("platform", platform)

    def _lasts(self, name: str, exceeded: bool, patience: float) -> bool:
        """Whether a limit has been exceeded for longer than it may be."""
        self.over[name] = self.over[name] + self.period if exceeded else 0.0
        return self.over[name] > patience

    def _stop_for(self, name: str, reason: str) -> None:
        raise ProtectiveStop(f"{reason} for {self.over[name] * 1000:.0f} ms")

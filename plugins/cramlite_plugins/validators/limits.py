"""Validators of joint limits and joint speeds, before and after the text ran."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from cramlite.model import AnyStep, Joints, MoveJoints, Value, walk
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

OVERSHOOT = 1.05  # measured speeds may exceed the limit by this factor: the position servo lags, then catches up


class JointLimits(Value):
    """Check that every joint target of the program lies within the robot's limits."""

    name: str = "joint_limits"
    cost: Cost = "ik"

    def check(self, candidate: Candidate) -> Iterable[Finding]:
        robot = candidate.robot
        worst = np.inf
        for step in walk(candidate.program.steps):
            for joints in _targets(step):
                for name, value, (low, high) in zip(robot.joints, joints, robot.limits, strict=True):
                    margin = min(value - low, high - value)
                    worst = min(worst, margin)
                    if margin < 0:
                        reason = f"{name} {value:.2f} rad is outside {low:.2f} to {high:.2f} rad"
                        yield Finding(self.name, False, reason, value, low if value < low else high, "rad", step.origin)
                        return
        yield Finding(self.name, True, f"nearest limit is {worst:.2f} rad away", float(worst), 0.0, "rad")


def _targets(step: AnyStep) -> tuple[Joints, ...]:
    """Joint positions that a step leads to."""
    if isinstance(step, MoveJoints):
        return step.path
    joints: Joints = getattr(step, "joints", ())
    return (joints,) if joints else ()


class JointSpeeds(Value):
    """Check that the arm stayed within its joint limits and speeds while the text ran."""

    name: str = "joint_speeds"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout, robot = candidate.rollout, candidate.robot
        if rollout is None or len(rollout.times) < 2:
            return
        speeds = np.abs(np.diff(rollout.joints, axis=0)) / np.diff(rollout.times)[:, None]
        shares = speeds.max(axis=0) / np.array(robot.velocity)
        k = int(np.argmax(shares))
        reason = f"{robot.joints[k]} at most {speeds[:, k].max():.2f} rad/s of {robot.velocity[k]:.2f} rad/s"
        yield Finding(
            self.name, bool(shares[k] <= OVERSHOOT), reason, float(speeds[:, k].max()), robot.velocity[k], "rad/s"
        )


@hookimpl
def validators() -> Iterable[Validator]:
    return [JointLimits(), JointSpeeds()]

"""Validators of joint limits and singularities, before and after the text ran."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from cramlite.model import AnyStep, Joints, MoveJoints, Value, walk
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from .task_times import task_at

LOOK = 0.1  # between samples that are looked at [s]
BACK = 0.002  # by which an arm that leaves a singularity may come back to it: it is led at 20 Hz [smallest singular value]
PASSING = 0.8  # distance kept from limits at a stop; free motions are planned without it


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
        yield Finding(self.name, True, f"the nearest joint limit is {worst:.2f} rad away", float(worst), 0.0, "rad")


def _targets(step: AnyStep) -> tuple[Joints, ...]:
    """Joint positions to which a step of a program moves the arm."""
    if isinstance(step, MoveJoints):
        return step.path
    joints: Joints = getattr(step, "joints", ())
    return (joints,) if joints else ()


class Singularities(Value):
    """Check that the arm kept its distance from singularities while the text ran, if it must keep one (``Robot.conditioning``).

    An arm that stands nearer to one when the text begins may leave it, and come no nearer before.
    """

    name: str = "singularities"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        from ..kinematics.forward import conditioning

        rollout, robot = candidate.rollout, candidate.robot
        if rollout is None or not robot.conditioning:
            return
        count = 1 + round((rollout.times[-1] - rollout.times[0]) / LOOK)
        samples = np.unique(np.linspace(0, len(rollout.times) - 1, count).round().astype(int))
        values = np.array([conditioning(robot, rollout.joints[k]) for k in samples])
        kept = PASSING * robot.conditioning
        leaving = 0 if values[-1] < kept else int(np.argmax(values >= kept))
        nearer = values[:leaving] < np.maximum.accumulate(values[:leaving]) - BACK
        first = int(np.argmax(nearer)) if nearer.any() else leaving
        worst = first + int(np.argmin(values[first:]))
        least, at = float(values[worst]), int(samples[worst])
        reason = f"smallest singular value {least:.3f} at {rollout.times[at]:.1f} s, {robot.conditioning} is kept"
        yield Finding(self.name, least >= kept, reason, least, robot.conditioning, origin=task_at(candidate, at))


@hookimpl
def validators() -> Iterable[Validator]:
    return [JointLimits(), Singularities()]

"""Estimate of how long a typed program runs, used only to show progress."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

from ...model.geometry import Pose
from ...model.program.program import Program
from ...model.program.steps import (
    AnyStep,
    CompliantSlide,
    Drive,
    Fallback,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Joints,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Repeat,
    SetGripper,
    SpiralSearch,
    Wait,
    ZeroSensor,
)
from ...model.robot import Robot
from ..late_poses import flange

STROKE = 0.04
"""Distance that each finger of a gripper travels when it opens or closes [m]: half of the strokes of 80 to 85 mm of shipped hands."""
TARE = 0.2
"""Duration of a tare with the standstill before it [s], as the controller model has it."""


def about(program: Program, robot: Robot) -> float:
    """Estimate the duration of a program [s].

    Of several branches the first counts, guarded motions have their full length, and the arm stops at each corner.
    """
    return _Clock(program, robot).whole(program.steps)


class _Clock:
    """Estimator of the time that successive steps take, which keeps track of the arm's joint position."""

    def __init__(self, program: Program, robot: Robot) -> None:
        self._tcp, self._robot, self._at = program.tcp, robot, program.start

    def whole(self, steps: Iterable[AnyStep]) -> float:
        return sum(self._of(step) for step in steps)

    def _of(self, step: AnyStep) -> float:
        if isinstance(step, Fallback):
            return self.whole(step.branches[0])
        if isinstance(step, Parallel):
            return max(map(self.whole, step.branches), default=0.0)
        if isinstance(step, Repeat):
            return step.count * self.whole(step.steps)
        if isinstance(step, Monitor):
            return self.whole(step.steps)
        before, self._at = self._at, _end(step) or self._at
        return self._motion(step, before)

    def _motion(self, step: AnyStep, before: Joints) -> float:
        if isinstance(step, MoveJoints):
            ways = (_leading(a, b) for a, b in pairwise((before, *step.path)))
            return sum(_trapezoid(way, step.speed, step.acceleration) for way in ways)
        if isinstance(step, MoveLinear):
            way = math.dist(self._tip(before).position, step.target.position)
            return _trapezoid(way, step.speed, step.acceleration)
        if isinstance(step, ForceMove | CompliantSlide):
            return _path_length([self._tip(before), *step.waypoints]) / step.speed
        if isinstance(step, Drive):
            return _drive(step)
        return _in_place(step)

    def _tip(self, joints: Joints) -> Pose:
        return flange(self._robot, joints) * self._tcp


def _in_place(step: AnyStep) -> float:
    """Return the duration [s] of a step whose motion does not depend on where the arm starts."""
    if isinstance(step, MoveUntilContact):
        return step.distance / step.speed
    if isinstance(step, ForceInsert):
        return step.depth / step.speed
    if isinstance(step, ForceExtract):
        return step.way / step.speed
    if isinstance(step, SpiralSearch):
        return math.pi * step.radius**2 / step.pitch / step.speed / 2  # found half way, on average
    if isinstance(step, SetGripper):
        return min(step.timeout, STROKE / step.speed)
    if isinstance(step, Wait):
        return step.duration
    return TARE if isinstance(step, ZeroSensor) else 0.0


def _drive(step: Drive) -> float:
    """Return the duration of a platform's drive without its first leg [s].

    That of the first leg is unknown, since no step states where the platform started.
    """
    return sum(
        max(
            _trapezoid(math.dist(a[:2], b[:2]), step.speed, step.acceleration),
            _trapezoid(abs(math.remainder(b[2] - a[2], 2 * math.pi)), step.turn_speed, step.turn_acceleration),
        )
        for a, b in pairwise(step.legs)
    )


def _end(step: AnyStep) -> Joints:
    """Return the joint position at the end of a step; () if the step does not move the arm, or its end is not
    known."""
    if isinstance(step, MoveJoints):
        return step.path[-1]
    return getattr(step, "joints", ())


def _leading(a: Sequence[float], b: Sequence[float]) -> float:
    return max((abs(y - x) for x, y in zip(a, b, strict=True)), default=0.0)


def _path_length(poses: Sequence[Pose]) -> float:
    return sum(math.dist(a.position, b.position) for a, b in pairwise(poses))


def _trapezoid(way: float, speed: float, acceleration: float) -> float:
    """Duration of a trapezoidal velocity profile from rest to rest [s]."""
    if way >= speed**2 / acceleration:
        return way / speed + speed / acceleration
    return 2 * math.sqrt(way / acceleration)

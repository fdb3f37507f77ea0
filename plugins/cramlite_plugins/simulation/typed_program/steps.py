"""Steps of typed programs on the virtual controller: motions, the gripper, waiting.

One function for each type of step, a generator that yields once a control cycle; ``machine`` says which. A step
that cannot come to its end brings the arm to rest and raises ``StepFailed``. Numbers and conditions are those that the
URScript backend writes as text (backends/urscript), so that one program does the same in both languages; a test
compares them.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable
from typing import Protocol

import numpy as np

from cramlite.model import AnyStep, Drive, MoveJoints, MoveLinear, SetGripper, SetPayload, Wait, ZeroSensor

from ..controller.commanded_arm import CommandedArm

Cycles = Generator[None, None, None]
BRAKE = 3.0  # deceleration when a watched motion is stopped [m/s2]
SETTLE = 0.3  # of a platform that has stopped [s]


class StepFailed(Exception):
    """The failure of a step; its message gives the reason with numbers."""


class Running(Protocol):
    """Interface of the running program that its steps use."""

    @property
    def arm(self) -> CommandedArm:
        """Return the controller of the arm."""
    def log(self, text: str) -> None:
        """Write a line to the program's log."""
        ...

    def perform(self, steps: Iterable[AnyStep]) -> Cycles:
        """Execute steps one after the other, for steps that contain other steps."""
        ...


def force(arm: CommandedArm) -> float:
    """Return the magnitude of the measured force [N]."""
    return arm.force()


def follow(arm: CommandedArm) -> Cycles:
    """Wait until the running motion has ended."""
    motion = arm.motion
    while motion is not None and arm.motion is motion:
        yield


def brake(arm: CommandedArm, deceleration: float = BRAKE) -> Cycles:
    """Stop the running motion on its path, and wait for it."""
    arm.stop(deceleration)
    yield from follow(arm)


def wait(arm: CommandedArm, seconds: float) -> Cycles:
    """Wait for a time [s]."""
    for _ in range(max(1, round(seconds / arm.period))):
        yield


def move_joints(run: Running, step: MoveJoints) -> Cycles:
    """Move through joint positions, with blended corners where radii are given."""
    goals = [np.array(q) for q in step.path]
    radii = step.radii or (0.0,) * (len(goals) - 1)
    rates = step.speed, step.acceleration
    if any(r > 0 for r in radii):
        try:
            run.arm.move_along(goals, list(radii), [rates] * len(goals))
        except ValueError as error:
            raise StepFailed(f"{step.origin}: {error}") from None
        yield from follow(run.arm)
        return
    for q in goals:
        run.arm.move_joints(q, *rates)
        yield from follow(run.arm)


def move_linear(run: Running, step: MoveLinear) -> Cycles:
    """Move the TCP straight to a pose."""
    run.arm.move_linear(step.target, step.speed, step.acceleration)
    yield from follow(run.arm)


def set_gripper(run: Running, step: SetGripper) -> Cycles:
    """Move the fingers, and check whether an object is between them."""
    gripper, waited = run.arm.gripper, 0.0
    gripper.move(step.opening, step.speed, step.force)
    while gripper.state() == "moving":
        if waited > step.timeout:
            raise StepFailed(f"{step.origin}: the gripper still moved after {step.timeout:g} s")
        yield
        waited += run.arm.period
    if step.expect == "object" and gripper.state() == "there":
        raise StepFailed(f"{step.origin}: no object between the fingers")
    if step.expect == "none" and gripper.state() != "there":
        raise StepFailed(f"{step.origin}: an object stopped the fingers")


def set_payload(run: Running, step: SetPayload) -> Cycles:
    """Tell the controller the payload's mass and centre of gravity."""
    payload = run.arm.arm.payload
    if not 0 <= step.mass <= payload:
        raise StepFailed(f"{step.origin}: payload {step.mass:.3f} kg is outside 0 .. {payload:g} kg")
    run.arm.set_payload(step.mass, np.array(step.center))
    if not run.arm.carries:
        yield


def zero_sensor(run: Running, step: ZeroSensor) -> Cycles:
    """Tare the wrist sensor, after the arm has settled."""
    yield from wait(run.arm, run.arm.settling)
    run.arm.zero_sensor()


def stand_still(run: Running, step: Wait) -> Cycles:
    """Wait for a step's duration."""
    yield from wait(run.arm, step.duration)


def drive(run: Running, step: Drive) -> Cycles:
    """Drive the platform leg by leg; an obstacle ends it as a protective stop."""
    platform = run.arm.platform
    if platform is None:
        raise StepFailed(f"{step.origin}: there is no platform to drive")
    for leg in step.legs:
        platform.drive(leg, (step.speed, step.acceleration), (step.turn_speed, step.turn_acceleration))
        while platform.driving:
            yield
    yield from wait(run.arm, SETTLE)

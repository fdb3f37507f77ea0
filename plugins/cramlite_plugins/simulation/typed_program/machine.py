"""Execution of typed programs on the virtual controller: the counterpart of the URScript interpreter.

The text is all that it is given. Before the first step it does what the URScript preamble does: tool centre point, payload,
start check, tare; while it runs, it watches the program's force limit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import zip_longest
from typing import Any

import numpy as np

from cramlite.model import (
    AnyStep,
    CompliantSlide,
    Drive,
    Fallback,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Program,
    ProgramText,
    Repeat,
    Robot,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Wait,
    ZeroSensor,
    branch_conflict,
    read_program,
    walk,
)
from cramlite.plugin import UserError

from ..controller.commanded_arm import CommandedArm
from ..controller.halted import Halted
from . import control, force_steps, steps
from .steps import Cycles, StepFailed

STEPS: Mapping[type, Callable[[Any, Any], Cycles]] = {
    MoveJoints: steps.move_joints,
    MoveLinear: steps.move_linear,
    SetGripper: steps.set_gripper,
    SetPayload: steps.set_payload,
    ZeroSensor: steps.zero_sensor,
    Wait: steps.stand_still,
    Drive: steps.drive,
    MoveUntilContact: force_steps.until_contact,
    ForceMove: force_steps.force_move,
    SpiralSearch: force_steps.spiral_search,
    ForceInsert: force_steps.force_insert,
    ForceExtract: force_steps.force_extract,
    CompliantSlide: force_steps.compliant_slide,
    Fallback: control.fallback,
    Parallel: control.parallel,
    Repeat: control.repeat,
    Monitor: control.monitor,
}

START_TOLERANCE = 0.01  # how far each joint may be from the start posture [rad]
HALT = 2.0  # deceleration of an abort [rad/s2]


def load_program(text: str, robot: Robot) -> ProgramText:
    """Parse a program's text and check that it fits this robot.

    Raises:
        UserError: it is no program, is for another robot, or has joint positions of another arm.
    """
    found = read_program(text)
    program = found.program
    if program.robot_type != robot.type:
        raise UserError(f"The program is for a robot of type '{program.robot_type}'; the world has a '{robot.type}'.")
    if program.late:
        raise UserError("The program asks for poses when it runs (late): typed programs that run here must know them all.")
    _count(program.start, robot, "start posture")
    for step in walk(program.steps):
        for q in (*getattr(step, "path", ()), getattr(step, "joints", ()) or program.start):
            _count(q, robot, f"step in line {found.lines[id(step)]}")
        if isinstance(step, Drive) and robot.platform is None:
            raise UserError(f"The program, line {found.lines[id(step)]}: a '{robot.type}' stands still; it cannot drive.")
        if wrong := branch_conflict(step.branches) if isinstance(step, Parallel) else _wrong(step):
            raise UserError(f"The program, line {found.lines[id(step)]}: {type(step).__name__}: {wrong}.")
    return found


def _wrong(step: AnyStep) -> str:
    """Explain in words why the controller model cannot run a step; "" if it can."""
    if type(step) not in STEPS:
        return "the controller model has no such step"
    for name in ("speed", "acceleration", "turn_speed", "turn_acceleration"):
        if getattr(step, name, 1.0) <= 0:
            return f"{name} {getattr(step, name):g} is not positive"
    radii = step.radii if isinstance(step, MoveJoints) else ()
    if isinstance(step, MoveJoints) and radii and (len(radii) != len(step.path) - 1 or min(radii) < 0):
        return f"{len(radii)} radii for {len(step.path)} points; it needs one less than points, none negative"
    return ""


def _count(q: tuple[float, ...], robot: Robot, where: str) -> None:
    if len(q) != len(robot.joints):
        raise UserError(f"The program's {where} has {len(q)} joints; a '{robot.type}' has {len(robot.joints)}.")


def _transfers(step: AnyStep | None) -> bool:
    """Whether a step begins with a motion of the arm between joint positions."""
    first = [branch[0] for branch in step.branches if branch] if isinstance(step, Parallel) else [step]
    return any(isinstance(one, MoveJoints) for one in first)


class ProgramMachine:
    """A program in execution.

    Args:
        loaded: what ``load_program`` gave.
        controller: of the robot that runs it.
        log: called with each line that the program writes.
    """

    def __init__(self, loaded: ProgramText, controller: CommandedArm, log: Callable[[str], None]) -> None:
        self.program: Program = loaded.program
        self.lines, self.arm, self._log = loaded.lines, controller, log
        self.main_line = 0
        self.finished = False
        self._main = self._run()

    def log(self, text: str) -> None:
        """Write a line to the program's log."""
        self._log(text)

    def cycle(self) -> None:
        """Let the program run until it waits for the next control cycle; then check the measured force
        against the program's limit.

        Raises:
            Halted: it gave up; its last message says why.
        """
        try:
            next(self._main)
        except StopIteration:
            self.finished = True
            return
        measured = steps.force(self.arm)
        if measured > self.program.force_limit:
            self.log(f"cramlite abort: force {measured:.3f} N > {self.program.force_limit:g} N")
            raise Halted

    def remember(self) -> None:
        """Do nothing after a control cycle: typed programs cannot read measurements of earlier cycles."""

    def close(self) -> None:
        """End the program."""
        self._main.close()

    def perform(self, steps: Iterable[AnyStep]) -> Cycles:
        """Execute steps one after the other.

        Raises:
            StepFailed: one of them did not come to its end.
        """
        for step, following in zip_longest(row := tuple(steps), row[1:]):
            self.main_line = self.lines.get(id(step), self.main_line)
            self.arm.leads_on = isinstance(following, MoveUntilContact) or _transfers(following)
            yield from STEPS[type(step)](self, step)

    def _run(self) -> Cycles:
        try:
            yield from self._start()
            yield from self.perform(self.program.steps)
        except StepFailed as failed:
            self.arm.end_force_mode()
            yield from steps.brake(self.arm, HALT)
            self.log(f"cramlite abort: {failed}")
            raise Halted from None
        self.log("cramlite: finished")

    def _start(self) -> Cycles:
        program, arm = self.program, self.arm
        arm.set_tcp(program.tcp)
        if not 0 <= program.mass <= arm.arm.payload:
            raise StepFailed(f"payload {program.mass:.3f} kg is outside 0 .. {arm.arm.payload:g} kg")
        arm.set_payload(program.mass, np.array(program.center))
        for i, (is_, should) in enumerate(zip(arm.actual_joints(), program.start, strict=True)):
            if abs(is_ - should) > START_TOLERANCE:
                raise StepFailed(f"joint {i} is at {is_:.6f} rad, the program starts from {should:.6f} rad")
        arm.zero_sensor()
        yield

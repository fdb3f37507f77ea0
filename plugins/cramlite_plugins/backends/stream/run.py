"""A program streamed to a robot process, and the record of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from msgspec import Struct, field

from cramlite.model import (
    CompliantSlide,
    Drive,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Message,
    Monitor,
    MoveUntilContact,
    Pose,
    Program,
    ProgramText,
    Robot,
    RobotMount,
    Rollout,
    SpiralSearch,
    World,
    walk,
)
from cramlite.plugin import UserError

from ...simulation.controller.halted import Halted
from ...simulation.controller.protective_stop import ProtectiveStop
from ...simulation.typed_program.machine import ProgramMachine, load_program
from .arm import StreamedArm
from .messages import Action, Hello, State
from .process import PATIENCE, LineProcess, RobotProcess


class RobotConnection(Protocol):
    """Protocol of a connection to a robot."""

    @property
    def name(self) -> str:
        """Return what it is called in errors."""

    def hello(self) -> Hello:
        """Return what robot there is."""

    def step(self, action: Action) -> State:
        """Send an action and return what the robot feels after it."""


FEELING = MoveUntilContact | ForceMove | SpiralSearch | ForceInsert | ForceExtract | CompliantSlide
"""Steps that end by what is felt."""
PAGE = "docs/how-to/drive_a_robot.md"
LONGEST = 600.0
"""A program that still runs then is stopped [s]."""


def drive(text: str, robot: Robot, command: Sequence[str], patience: float = PATIENCE) -> Rollout:
    """Stream a typed program to a robot process.

    Args:
        text: the program as JSON.
        robot: that it is for.
        command: starts the process.
        patience: how long the process may take to answer [s].

    Returns:
        What the robot felt, once a period; no thing is in its world, for nobody told where any is. The outcome is "finished",
        "halted", "protective stop" or "timeout".

    Raises:
        UserError: the text is no program for this robot; the process cannot be started, dies, hangs or does not answer as it must;
            its robot lacks what the program needs.
    """
    loaded = load_program(text, robot)
    lines = LineProcess("robot process", command, PAGE)
    with RobotProcess(lines, robot.type, len(robot.joints), patience) as process:
        return stream(loaded, robot, process)


def stream(loaded: ProgramText, robot: Robot, process: RobotConnection) -> Rollout:
    """Stream a typed program to a robot that is connected already; see ``drive``."""
    hello = process.hello()
    _refuse(loaded.program, hello, process.name)
    arm = StreamedArm(robot, hello, process.step)
    record = _Record(arm)
    record.machine = machine = ProgramMachine(loaded, arm, record.say)
    outcome, reason = _play(machine, arm, record)
    return record.rollout(loaded.program, outcome, reason)


def _refuse(program: Program, hello: Hello, name: str) -> None:
    """Refuse steps that the process cannot do, before anything moves."""
    for step in walk(program.steps):
        label = step.origin or type(step).__name__
        if isinstance(step, Drive):
            raise UserError(f"Step '{label}' drives a platform, and a stream of actions moves an arm only.")
        if hello.wrench is None and (isinstance(step, FEELING) or (isinstance(step, Monitor) and step.force is not None)):
            raise UserError(
                f"Step '{label}' ends by the force that it feels, and the {name} tells none. Answer with 'wrench', "
                "or let the scenario's tasks do without contact."
            )


def _play(machine: ProgramMachine, arm: StreamedArm, record: _Record) -> tuple[str, str]:
    """Cycle the program and the robot until either ends; the outcome and its reason."""
    try:
        while arm.clock < LONGEST:
            if not machine.finished:
                machine.cycle()
            if machine.finished and arm.settled():
                return "finished", ""
            arm.cycle()
            record.observe()
        return "timeout", f"line {machine.main_line}: the program still ran after {LONGEST:g} s"
    except Halted:
        return "halted", record.messages[-1].text.removeprefix("cramlite abort: ")
    except ProtectiveStop as stop:
        return "protective stop", f"line {machine.main_line}: {stop}"
    finally:
        machine.close()


class _Record(Struct):
    """Sensations of the robot, once a period."""

    arm: StreamedArm
    machine: ProgramMachine | None = None
    messages: list[Message] = field(default_factory=list)
    rows: list[tuple[float, tuple[float, ...], list[float], float, int, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.observe()

    @property
    def line(self) -> int:
        return self.machine.main_line if self.machine else 0

    def say(self, text: str) -> None:
        """Take a line of the log."""
        self.messages.append(Message(self.arm.clock, text, self.line))

    def observe(self) -> None:
        """Take a sample."""
        arm, state = self.arm, self.arm.state
        felt = np.array(state.wrench or (0.0,) * 6)
        self.rows.append((arm.clock, state.joints, (-felt).tolist(), state.opening, self.line, arm.force()))
        if state.say:
            self.say(state.say)

    def rollout(self, program: Program, outcome: str, reason: str) -> Rollout:
        """Return the run."""
        times, joints, wrench, opening, lines, force = (np.array(column) for column in zip(*self.rows, strict=True))
        mount = RobotMount(program.robot, program.robot_type, Pose(), joints=tuple(self.rows[0][1]))
        return Rollout(
            world=World((), (mount,)), effector=program.robot, times=times, poses={}, touches=((),) * len(times), joints=joints,
            wrench=wrench, opening=opening, lines=lines, messages=tuple(self.messages), outcome=outcome, reason=reason, force=force,
        )  # fmt: skip

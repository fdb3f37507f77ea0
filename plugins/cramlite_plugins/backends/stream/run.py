"""A program streamed to a robot process, and the record of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from msgspec import Struct, field

from cramlite.model import (
    CompliantSlide,
    Deviation,
    Drive,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Message,
    Monitor,
    MoveUntilContact,
    Notice,
    Pose,
    Program,
    ProgramText,
    Readings,
    Robot,
    RobotMount,
    Rollout,
    SpiralSearch,
    Watch,
    World,
    vector3,
    walk,
)
from cramlite.plugin import UserError

from ...simulation.controller.halted import Halted
from ...simulation.controller.protective_stop import ProtectiveStop
from ...simulation.typed_program.machine import HALT, ProgramMachine, load_program
from .arm import StreamedArm
from .messages import Action, Hello, State
from .process import PATIENCE, LineProcess, RobotProcess


class RobotConnection(Protocol):
    """Protocol of a connection to a robot."""

    @property
    def name(self) -> str:
        """Return the process's name for error messages."""

    def hello(self) -> Hello:
        """Return the description of the robot."""

    def step(self, action: Action) -> State:
        """Send an action and return the state of the robot after it."""


FEELING = MoveUntilContact | ForceMove | SpiralSearch | ForceInsert | ForceExtract | CompliantSlide
"""Steps that end by a measured force, so that the robot must have a force reading."""
PAGE = "docs/how-to/drive_a_robot.md"
REST = 1.0
"""Longest time until a braking arm, and the things around it, are at rest [s]."""
AT_ONCE = 1000.0
"""Deceleration of the command after a task was cancelled: it stands still from the next action on [rad/s2, m/s2]."""
MOVED, TURNED = 0.02, 0.2
"""Largest speed at which things and joints count as at rest: positions [m/s]; joints [rad/s], and quaternions [1/s]. LIBERO's Panda
creeps where it stands still."""
LONGEST = 600.0
"""Longest duration of a run [s]; a program that still runs then is stopped."""


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


def stream(
    loaded: ProgramText, robot: Robot, process: RobotConnection, watch: Watch | None = None, mount: RobotMount | None = None
) -> Rollout:
    """Stream a typed program to a robot that is connected already; see ``drive``.

    Args:
        watch: is shown readings after each action; the arm brakes when it notices something, and the outcome is "noticed".
        mount: where the robot stands in the world of the poses that are read, and what it holds.
    """
    hello = process.hello()
    _refuse(loaded.program, hello, process.name)
    arm = StreamedArm(robot, hello, process.step)
    mount = mount or RobotMount(loaded.program.robot, robot.type)
    if mount.holds is not None:
        arm.grip(mount.holds.force)
    record = _Record(arm)
    record.machine = machine = ProgramMachine(loaded, arm, record.say)
    outcome, reason = _play(machine, arm, record, _Watched(watch, mount) if watch else None)
    if watch is not None:
        watch.rest(readings(arm, machine.main_line, mount))
    return record.rollout(loaded.program, outcome, reason)


def _refuse(program: Program, hello: Hello, name: str) -> None:
    """Refuse a program with steps that the robot process cannot execute, before the robot moves."""
    for step in walk(program.steps):
        label = step.origin or type(step).__name__
        if isinstance(step, Drive):
            raise UserError(f"Step '{label}' drives a platform, and a stream of actions moves an arm only.")
        if hello.wrench is None and (isinstance(step, FEELING) or (isinstance(step, Monitor) and step.force is not None)):
            raise UserError(
                f"Step '{label}' needs the force at the hand, and the {name} reports none. Answer with 'wrench', "
                "or take tasks that need no force sensor."
            )


def _play(machine: ProgramMachine, arm: StreamedArm, record: _Record, watched: _Watched | None) -> tuple[str, str]:
    """Advance program and robot period by period until the run ends; return the outcome and its reason."""
    try:
        while arm.clock < LONGEST:
            if not machine.finished:
                machine.cycle()
            if machine.finished and arm.settled():
                return "finished", ""
            arm.cycle()
            record.observe()
            if watched is not None and (notice := watched.see(arm, machine.main_line)):
                _brake(arm, record, AT_ONCE if notice.kind is Deviation.CANCELLED else HALT)
                return "noticed", str(notice)
        return "timeout", f"line {machine.main_line}: the program still ran after {LONGEST:g} s"
    except Halted:
        return "halted", record.messages[-1].text.removeprefix("cramlite abort: ")
    except ProtectiveStop as stop:
        return "protective stop", f"line {machine.main_line}: {stop}"
    finally:
        machine.close()


def _brake(arm: StreamedArm, record: _Record, deceleration: float) -> None:
    """Bring the arm to rest on its path, and wait until joints and things are at rest."""
    arm.end_force_mode()
    arm.stop(deceleration)
    for _ in range(round(REST / arm.period)):
        before = arm.state
        arm.cycle()
        record.observe()
        if arm.motion is None and _is_still(before, arm.state, arm.period):
            return


def _is_still(before: State, now: State, period: float) -> bool:
    """Whether joints and things are at rest, judged by two successive states."""
    was, are = before.poses or {}, now.poses or {}
    poses = np.array([np.subtract(are[n], was[n]) for n in are.keys() & was.keys()]).reshape(-1, 7)
    turned, most = np.abs(np.subtract(now.joints, before.joints)).max(), np.array([MOVED] * 3 + [TURNED] * 4)
    return bool(are.keys() == was.keys() and turned < TURNED * period and (np.abs(poses) < most * period).all())


def readings(arm: StreamedArm, line: int, mount: RobotMount) -> Readings:
    """Return the present sensor readings of the robot, and the poses of the things around it.

    The fingers are taken to close along the tool's y axis.
    """
    state, tool = arm.state, mount.base * arm.actual_tcp()
    poses = None if state.poses is None else {n: Pose.from_row(p) for n, p in state.poses.items()}
    goal = None if state.goal is None else tuple(" ".join(literal) for literal in state.goal)
    closing = vector3(tool.rotation[:, 1])
    return Readings(arm.clock, line, state.joints, state.opening, arm.force(), arm.gripper.pressing, tool, closing, poses, goal)


class _Watched(Struct):
    """Watcher of a run on a robot process: in each period it checks the robot's sensor readings, expressed in the
    world, for deviations."""

    watch: Watch
    mount: RobotMount

    def see(self, arm: StreamedArm, line: int) -> Notice | None:
        return self.watch.see(readings(arm, line, self.mount))


class _Record(Struct):
    """Recorder of a streamed run: a sample of joints, wrench and gripper for each period, and the run's log."""

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
        """Append a line to the run's log."""
        self.messages.append(Message(self.arm.clock, text, self.line))

    def observe(self) -> None:
        """Append a sample to the run's record."""
        arm, state = self.arm, self.arm.state
        felt = np.array(state.wrench or (0.0,) * 6)
        self.rows.append((arm.clock, state.joints, (-felt).tolist(), state.opening, self.line, arm.force()))
        if state.say:
            self.say(state.say)

    def rollout(self, program: Program, outcome: str, reason: str) -> Rollout:
        """Return the recording of the run."""
        times, joints, wrench, opening, lines, force = (np.array(column) for column in zip(*self.rows, strict=True))
        mount = RobotMount(program.robot, program.robot_type, Pose(), joints=tuple(self.rows[0][1]))
        return Rollout(
            world=World((), (mount,)), effector=program.robot, times=times, poses={}, touches=((),) * len(times), joints=joints,
            wrench=wrench, opening=opening, lines=lines, messages=tuple(self.messages), outcome=outcome, reason=reason, force=force,
        )  # fmt: skip

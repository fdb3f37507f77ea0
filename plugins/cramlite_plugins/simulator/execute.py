"""Execution of a program's text on the virtual controller, in the physics of a world.

What runs is the text and the world, nothing else: no object pose reaches the program but
through its own text and its sensors.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Protocol

import numpy as np
from msgspec.structs import replace

from cramlite.model import Notice, Readings, Robot, Rollout, Vector3, Watch, World, is_program_text, vector3
from cramlite.plugin import UserError, nearest

from ..simulation.controller.controller import Controller
from ..simulation.controller.gripper_drive import GripperDrive
from ..simulation.controller.gripper_server import GripperServer
from ..simulation.controller.halted import Halted
from ..simulation.controller.protective_stop import ProtectiveStop, Safety
from ..simulation.faults import FaultsToCome, Killed
from ..simulation.model.compile import Compiled, compile_world, misbuild, unstable
from ..simulation.model.no_slip import NoSlip
from ..simulation.recording.recorder import Peaks, Recorder
from ..simulation.typed_program.machine import ProgramMachine, load_program
from ..ur_controller.functions import Functions, known_functions
from ..ur_controller.pose_server import PoseServer
from ..ur_controller.urscript.interpreter import Limits, Loaded, Machine, Stopped, load
from ..ur_controller.urscript.values import ScriptError

SETTLE = 2.0
"""Time for which the simulation continues after a program's end [s]: of 40 products that were dropped into a basket last of all, six
still rocked after 1 s."""
STOPPED = 0.5
"""Time that a watched arm takes to brake [s], before the decision how to continue."""
PATIENCE = 5.0
"""Time for which a stopped arm waits for readings [s]."""
BEFORE = 0.5  # the world settles for this long before the program starts [s]


def execute(
    text: str,
    world: World,
    robots: Mapping[str, Robot],
    *,
    mount: str,
    seed: int = 0,
    time_limit: float = 120.0,
    settle: float = SETTLE,
    force_noise: float = 0.0,
    safety: Safety | None = None,
    limits: Limits | None = None,
    watch: Watch | None = None,
) -> Rollout:
    """Run a program from the robot's home posture to its end.

    Args:
        text: the program: URScript, or a typed program as JSON, which begins with a brace.
        robots: descriptions by type, for the world's mounts.
        mount: name of the robot that runs the program.
        seed, force_noise: of the wrist sensor's noise; standard deviation [N].
        time_limit: without a line that no earlier one came behind, in simulated time [s]: a program of many tasks goes on and on,
            one that hangs or loops for ever does not.
        settle: how long to go on recording after its end [s].
        safety: limits that end in a protective stop.
        limits: limits of the URScript interpreter.
        watch: is shown readings; the arm brakes when it notices something.

    Returns:
        A rollout whose outcome is "finished", "halted" (the reason is the program's last message), "noticed" (by ``watch``),
        "protective stop", "killed", "timeout" or "error"; ``lines`` are those of the outermost function, or of the steps.

    Raises:
        UserError: the text is no program for this robot, or the world has no such robot.
    """
    compiled = compile_world(world, robots)
    if mount not in compiled.robots:
        raise UserError(f"the world has no robot '{mount}'; {nearest(mount, compiled.robots)}")
    typed = is_program_text(text)
    drive = GripperDrive if typed else GripperServer
    run = _Run(compiled, mount, force_noise, seed, safety or Safety(), drive, text)
    machine = _typed(run, text) if typed else _urscript(run, text, limits)
    _come_to_rest(run)
    run.start()
    outcome, reason = run.play(machine, time_limit, watch)
    _stand_still(run, settle, watch)
    return replace(run.recorder.rollout(outcome, reason), faults=tuple(run.faults.happened), **run.peaks.arrays())


def _come_to_rest(run: _Run) -> None:
    """Let the world settle while the arm holds still, without MuJoCo's no-slip iterations, to save time.

    They take four fifths of a step with sixteen vessels. Things may creep by 0.03 mm/s meanwhile.
    """
    options = run.controller.model.opt
    firm, options.noslip_iterations = options.noslip_iterations, 0
    for _ in range(round(BEFORE / run.controller.period)):
        run.controller.hold()
    options.noslip_iterations = firm
    if reason := unstable(run.controller.diverged):
        raise UserError(f"the world does not come to rest before the program starts: {reason}")


def _stand_still(run: _Run, settle: float, watch: Watch | None) -> None:
    """Continue the simulation after the program's end; a watched arm brakes, and its watcher gets the readings at rest."""
    for _ in range(round((settle if watch is None else STOPPED) / run.controller.period)):
        run.hold()
    if watch is not None:
        run.await_readings()
        watch.rest(run.read(0))


class _Runner(Protocol):
    """A program in execution, in whatever language it is written."""

    main_line: int

    @property
    def finished(self) -> bool: ...
    def cycle(self) -> None: ...
    def remember(self) -> None:
        """Record a control cycle, after the arm has moved."""
        ...

    def close(self) -> None: ...


@lru_cache(maxsize=4)
def _loaded(text: str) -> Loaded:
    """Compile a text once for its runs in several worlds."""
    return load(text, known_functions())


class _Script(Machine):
    """URScript interpreter of one run, with the functions of its controller."""

    def __init__(self, text: str, functions: Functions, limits: Limits | None) -> None:
        super().__init__(_loaded(text), functions.library(), limits, functions.finish)
        self.functions = functions

    def cycle(self) -> None:
        super().cycle()
        self.functions.check()

    def remember(self) -> None:
        self.functions.settings.remember()


def _urscript(run: _Run, text: str, limits: Limits | None) -> _Runner:
    return _Script(text, Functions(run.controller, run.log, run.poses, lambda: float(run.data.time)), limits)


def _typed(run: _Run, text: str) -> _Runner:
    return ProgramMachine(load_program(text, run.controller.arm), run.controller, run.log)


def _across(arm: Controller) -> Vector3:
    """Unit vector from one pad to the other, in the world."""
    left, right = (arm.data.geom_xpos[list(pads)].mean(axis=0) for pads in (arm.index.left, arm.index.right))
    return vector3((left - right) / max(float(np.linalg.norm(left - right)), 1e-9))


class _Run:
    """One execution: controller, recorder and clock."""

    def __init__(
        self, compiled: Compiled, mount: str, noise: float, seed: int, safety: Safety, drive: type[GripperDrive], text: str
    ) -> None:
        index, off = compiled.robots[mount], compiled.world.disturbance
        misbuild(compiled, mount, off)
        self.data = compiled.data()
        self.recorder = Recorder(compiled, mount, wrench=False)
        base = next(m.base for m in compiled.world.robots if m.name == mount)
        self.controller = Controller(compiled.model, self.data, index, base, safety, noise, seed, drive=drive)
        self.controller.disturb(off)
        self.holds = next(m.holds for m in compiled.world.robots if m.name == mount)
        if self.holds is not None:
            self.controller.gripper.grip(self.holds.force)
        self.controller.let_sleep()
        self.no_slip = NoSlip(compiled, mount)
        self.poses = PoseServer(compiled, self.data, base, seed)
        self.machine: _Runner | None = None
        self.compiled, self.read_at = compiled, 0.0
        self.readings: Readings | None = None
        self.faults = FaultsToCome(compiled, self.data, self.controller, text)
        self.peaks = Peaks(self.recorder.period)

    def start(self) -> None:
        """Begin the recording, at time 0."""
        self.data.time = 0.0
        self.observe(0)

    def observe(self, line: int) -> None:
        """Check which grips need MuJoCo's no-slip iterations; record a sample if it is time for one."""
        self.no_slip.look(self.data)
        self.peaks.see(self.data.time, self.controller)
        self.recorder.observe(self.data, line)

    def shown(self, watch: Watch, line: int) -> Notice | None:
        """Pass the robot's sensor readings to the watcher of the run when they are due; return its notice or None.

        A notice stops the arm.
        """
        now = float(self.data.time)
        if now < self.read_at - 1e-9:
            return None
        self.read_at = now + watch.period
        if self.readings is None or now >= self.faults.frozen_until:
            self.readings = self.read(line)
        return watch.see(replace(self.readings, time=now, line=line, goal=self.faults.goal))

    def hold(self) -> None:
        """Advance the simulation by a cycle after the program's end."""
        self.controller.hold()
        self.faults.keep_away()
        self.observe(0)

    def await_readings(self) -> None:
        """Hold the arm still while a fault withholds or freezes the sensor readings, for at most ``PATIENCE`` [s]."""
        until = float(self.data.time) + PATIENCE
        while self.data.time < min(until, max(self.faults.lost_until, self.faults.frozen_until)):
            self.hold()

    def read(self, line: int) -> Readings:
        """Return the present readings of the robot and of the things around it, without the errors of
        sensors."""
        arm, compiled = self.controller, self.compiled
        seen = [t.name for t in compiled.world.things if t.movable and t.name not in self.faults.away]
        poses = {n: compiled.pose(self.data, n) for n in seen} if self.data.time >= self.faults.lost_until else None
        return Readings(
            float(self.data.time), line, tuple(arm.actual_joints().tolist()), arm.gripper.opening, arm.force(),
            arm.gripper.pressing, arm.base * arm.actual_tcp(), _across(arm), poses, self.faults.goal,
        )  # fmt: skip

    def log(self, text: str) -> None:
        self.recorder.message(float(self.data.time), text, self.machine.main_line if self.machine else 0)

    def play(self, machine: _Runner, time_limit: float, watch: Watch | None) -> tuple[str, str]:
        """Run program and physics, cycle by cycle, to the program's end; return its outcome and the reason."""
        self.machine = machine
        farthest, since = machine.main_line, 0.0
        try:
            while self.data.time < since + time_limit:
                self.faults.due(float(self.data.time), machine.main_line, self.controller.force())
                machine.cycle()
                if machine.finished:
                    return "finished", ""
                if machine.main_line > farthest:
                    farthest, since = machine.main_line, float(self.data.time)
                self.controller.cycle()
                machine.remember()
                self.observe(machine.main_line)
                if watch is not None and (notice := self.shown(watch, machine.main_line)):
                    return "noticed", str(notice)
            ran = f"the program still ran after {self.data.time:.0f} s"
            return "timeout", f"line {machine.main_line}: {ran} and reached no further line in the last {time_limit:g} s"
        except Halted:
            said = [m.text.removeprefix("cramlite abort: ") for m in self.recorder.messages[-1:]]
            return "halted", said[0] if said else f"line {machine.main_line}: halt, without a message"
        except ProtectiveStop as stop:
            return "protective stop", f"line {machine.main_line}: {stop}"
        except Killed:
            return "killed", f"line {machine.main_line}: the program was ended from outside"
        except Stopped as stop:
            return "error", str(stop)
        except ScriptError as error:
            return "error", f"line {machine.main_line}: {error}"
        finally:
            machine.close()

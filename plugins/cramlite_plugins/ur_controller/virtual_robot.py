"""The virtual robot behind the ports: a world in MuJoCo, the controller, and the program that runs on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from cramlite.model import FaultKind, Robot, World
from cramlite.plugin import UserError, nearest

from ..simulation.controller.controller import Controller
from ..simulation.controller.halted import Halted
from ..simulation.controller.protective_stop import ProtectiveStop, Safety
from ..simulation.faults import ORDERS, READINGS, FaultsToCome, Killed
from ..simulation.model.compile import compile_world, misbuild
from .functions import Functions
from .pose_server import PoseServer
from .registers import Registers
from .urscript.interpreter import Machine, Stopped, load
from .urscript.values import ScriptError, from_pose

SETTLE = 0.5  # the world comes to rest before anything runs [s]
NORMAL, PROTECTIVE = 1, 3  # safety_mode (RTDE Guide)
POWER_OFF, IDLE, RUNNING = 3, 5, 7  # robot_mode (RTDE Guide)
LOCKED = 5.0
"""Least time between a protective stop and its release [s] (Dashboard Server, e-Series: "unlock protective stop")."""


class VirtualRobot:
    """A virtual robot: a controller at 500 Hz that waits for programs, and a world in MuJoCo.

    Args:
        mount: name of the robot in the world.
        say: called with every line that programs and controller log.
        noise, seed: of the wrist sensor [N].

    Raises:
        UserError: the world has no such robot, or cannot be simulated.
    """

    def __init__(
        self,
        world: World,
        robots: Mapping[str, Robot],
        mount: str,
        say: Callable[[str], None],
        noise: float = 0.0,
        seed: int = 0,
    ) -> None:
        compiled, off = compile_world(world, robots), world.disturbance
        _refuse(world)
        if mount not in compiled.robots:
            raise UserError(f"the world has no robot '{mount}'; {nearest(mount, compiled.robots)}")
        misbuild(compiled, mount, off)
        self.compiled, self.data, self.say = compiled, compiled.data(), say
        base = next(m.base for m in world.robots if m.name == mount)
        index = compiled.robots[mount]
        self.model_name = index.robot.type.split("_")[0].upper()
        self.arm = Controller(compiled.model, self.data, index, base, Safety(), noise, seed, steps=1)
        self.arm.disturb(off)
        self.arm.let_sleep()
        self.machine: Machine | None = None
        self.secondary: Machine | None = None
        self.stopped, self.stopped_at, self.mode = "", 0.0, RUNNING
        self.faults, self.away = FaultsToCome(compiled, self.data, self.arm), [f for f in world.faults if f.kind is FaultKind.CONNECTION]
        self.functions = Functions(self.arm, self.log, PoseServer(compiled, self.data, base, seed), lambda: self.time)
        for _ in range(round(SETTLE / self.arm.period)):
            self.arm.hold()
        self.data.time = 0.0

    # Programs

    @property
    def running(self) -> bool:
        """Check whether a program is running."""
        return self.machine is not None

    @property
    def registers(self) -> Registers:
        """Return the registers that programs and clients share."""
        return self.functions.registers

    @property
    def time(self) -> float:
        """Return the simulated time [s]."""
        return float(self.data.time)

    def log(self, text: str) -> None:
        """Log a line with its time."""
        self.say(f"{self.time:9.3f} s  {text}")

    def receive(self, text: str) -> None:
        """Run a program text as a robot controller does: ``def`` replaces the running program, ``sec`` runs
        in parallel with it."""
        library = self.functions.library()
        secondary = text.lstrip().startswith("sec")
        try:
            machine = Machine(load(_as_program(text), library), library, last=self.functions.finish)
        except UserError as error:
            self.log(f"a program was refused: {error}")
            return
        if secondary:
            self.secondary = machine
            return
        self.stop_program("replaced by a new program")
        if self.stopped:
            self.log(f"a program was refused: protective stop ({self.stopped}); unlock it at the dashboard")
            return
        if self.mode != RUNNING:
            self.log("a program was refused: the brakes are on; 'power on' and 'brake release' at the dashboard")
            return
        self.registers.watched.clear()
        self.machine = machine

    def stop_program(self, why: str) -> None:
        """Stop the running program; the arm comes to rest."""
        if self.machine is not None:
            self.log(f"program stopped: {why}")
            self.machine.close()
        self.machine = None
        self.functions.forget()
        self.arm.freedrive = False

    def unlock(self) -> bool:
        """Release the protective stop, unless it began less than ``LOCKED`` seconds ago; return whether it is
        released."""
        if self.stopped and self.time < self.stopped_at + LOCKED:
            return False
        self.stopped = ""
        self.arm.q = self.arm.actual_joints()
        self.arm.motion = None
        return True

    def restart(self) -> None:
        """Restart the safety system: release a protective stop at once, and power the arm off."""
        self.stopped_at = -LOCKED
        self.unlock()
        self.power(POWER_OFF)

    def power(self, mode: int) -> None:
        """Power the arm, or release its brakes: ``POWER_OFF``, ``IDLE`` or ``RUNNING``; its brakes hold it in all but the last."""
        if mode != RUNNING:
            self.stop_program("the arm is powered off" if mode == POWER_OFF else "the brakes are on")
        self.mode = mode

    @property
    def reachable(self) -> bool:
        """Check whether clients can reach the controller."""
        return not any(f.after <= self.time < f.after + f.lasts for f in self.away)

    @property
    def safety_status(self) -> str:
        """Return the robot's safety status, "PROTECTIVE_STOP" or "NORMAL"."""
        return "PROTECTIVE_STOP" if self.stopped else "NORMAL"

    # Time

    def cycle(self) -> None:
        """Advance by a control cycle of 2 ms: programs, motion, physics."""
        try:
            self.faults.due(self.time, 0, self.arm.force())
            self._run_secondary()
            if self.machine is None:
                self.arm.hold()
            else:
                self._run(self.machine)
        except Killed:
            self.stop_program("killed")
        except ProtectiveStop as stop:
            self.stopped, self.stopped_at = str(stop), self.time
            self.stop_program(f"protective stop: {stop}")
        self.functions.settings.remember()

    def _run(self, machine: Machine) -> None:
        try:
            machine.cycle()
            self.functions.check()
        except Halted:
            self.stop_program("halt")
            return
        except (Stopped, ScriptError) as stop:
            self.stop_program(str(stop))
            return
        if machine.finished:
            self.machine = None
        self.arm.cycle()

    def _run_secondary(self) -> None:
        if self.secondary is None:
            return
        try:
            self.secondary.cycle()
        except (Halted, Stopped) as stop:
            self.log(f"secondary program ended: {stop}")
            self.secondary = None
            return
        if self.secondary.finished:
            self.secondary = None

    # What clients may ask for

    def field(self, name: str) -> Any:
        """Return the value of an RTDE output; None, which is sent as 0, for outputs that are not modelled, such
        as temperatures."""
        if name in self.registers.fields:
            return self.registers.fields[name]
        get = _FIELDS.get(name)
        return None if get is None else get(self)


def _as_program(text: str) -> str:
    """Return a client's text as a program: a line outside of def and sec is wrapped into a program of its own."""
    if text.lstrip().startswith(("def", "sec")):
        return text
    return f"def unnamed():\n{text.strip()}\nend\n"


def _floats(values: Any) -> list[float]:
    return [float(v) for v in values]


_FIELDS: dict[str, Callable[[VirtualRobot], Any]] = {
    "timestamp": lambda r: r.time,
    "target_q": lambda r: _floats(r.arm.q),
    "target_qd": lambda r: _floats(r.arm.rate),
    "actual_q": lambda r: _floats(r.arm.actual_joints()),
    "actual_qd": lambda r: _floats(r.arm.actual_speeds()),
    "target_moment": lambda r: _floats(r.arm.joint_torques()),
    "actual_TCP_pose": lambda r: list(from_pose(r.arm.actual_tcp())),
    "target_TCP_pose": lambda r: list(from_pose(r.arm.kinematics.forward(r.arm.q))),
    "actual_TCP_speed": lambda r: _floats(r.arm.kinematics.speed(r.arm.actual_joints(), r.arm.actual_speeds())),
    "target_TCP_speed": lambda r: _floats(r.arm.tool_speed()),
    "actual_TCP_force": lambda r: _floats(r.arm.wrench()),
    "ft_raw_wrench": lambda r: _floats(r.arm.sensor.raw),
    "tcp_force_scalar": lambda r: float(sum(v * v for v in r.arm.wrench()[:3]) ** 0.5),
    "tcp_offset": lambda r: list(from_pose(r.arm.arm.gripper.tcp)),
    "payload": lambda r: float(r.arm.sensor.mass),
    "payload_cog": lambda r: _floats(r.arm.sensor.center),
    "actual_digital_output_bits": lambda r: r.registers.outputs,
    "speed_scaling": lambda r: 1.0,
    "target_speed_fraction": lambda r: 1.0,
    "robot_mode": lambda r: r.mode,
    "safety_mode": lambda r: PROTECTIVE if r.stopped else NORMAL,
    "safety_status": lambda r: PROTECTIVE if r.stopped else NORMAL,
    "safety_status_bits": lambda r: 4 if r.stopped else 1,
    "robot_status_bits": lambda r: 1 | 2 * r.running,
    "runtime_state": lambda r: 2 if r.running else 1,
    "script_control_line": lambda r: r.machine.main_line if r.machine else 0,
}


def _refuse(world: World) -> None:
    """Refuse injected faults that cannot happen to a client's program: of sensor readings, of goals, or
    triggered at a program line.

    Raises:
        UserError: the world has one.
    """
    for fault in world.faults:
        if fault.kind in READINGS | ORDERS or (fault.trigger and fault.trigger.line):
            why = "they get no readings or goals from the simulation, and their lines are unknown"
            raise UserError(f"Fault '{fault}' cannot happen to programs of clients: {why}.")

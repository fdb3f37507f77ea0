"""URScript functions of the virtual controller: motion, force mode, kinematics and messages.

Names, parameters and defaults: the URScript manual (e-Series 5.x), modules "motion", "internals" and "interfaces".
A method that is a generator blocks the calling thread. Wrong arguments raise ``ScriptError``.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from functools import wraps
from typing import Any

import numpy as np

from cramlite.model import Floats, Pose

from ..kinematics.inverse import nearest_solution
from ..kinematics.timing import profile_for_duration
from ..simulation.controller.controller import ABANDONED, Controller
from ..simulation.controller.force_mode import ForceMode
from ..simulation.controller.halted import Halted
from ..simulation.controller.trajectories import Motion
from .clock import Clock
from .electrics import electrics
from .pose_server import PoseServer
from .registers import Registers
from .settings import SETTINGS, Settings
from .signals import Signals
from .sockets import SOCKETS, Sockets
from .streaming import STREAMING, Streaming
from .urscript.builtins import PURE, Library, blocks
from .urscript.doubts import NO_BLEND
from .urscript.values import PoseValue, ScriptError, as_pose, from_pose, numbers, real, show

Wait = Generator[None, None, None]
NAMES = (
    "movej", "movel", "movep", "movec", "stopj", "stopl", "force_mode", "end_force_mode", "zero_ftsensor", "get_tcp_force", "force",
    "get_actual_tcp_pose", "get_actual_joint_positions", "get_target_tcp_pose", "get_target_joint_positions",
    "get_forward_kin", "get_inverse_kin", "set_tcp", "set_payload", "set_payload_mass", "set_payload_cog", "set_target_payload",
    "is_steady", "sleep", "sync", "get_steptime", "textmsg", "popup", "halt",
)  # fmt: skip
BLENDING = frozenset(("movej", "movep", "textmsg", "popup"))
"""Calls that may stand between two blended motions: all others ask the arm or the world, or move the arm, and wait for the
motion's end."""


def known_functions() -> Library:
    """Return every function that a program may call, for checking only: they are bound to no controller."""
    arm, others = object.__new__(Functions), ((Sockets, SOCKETS), (Streaming, STREAMING), (Settings, SETTINGS))
    own = {name: getattr(part, name) for part, names in ((arm, NAMES), *((object.__new__(c), n) for c, n in others)) for name in names}
    return arm.all_of({**own, **Registers(lambda: 0.0).library(), **Signals().library(), **Clock(lambda: 0.0).library()})


class Functions:
    """URScript functions that a program can call, bound to the controller of one run.

    Args:
        controller: the arm, with a gripper behind its server.
        log: called with each line that the program writes.
        poses: the perception server that it may reach.
        clock: the time since the controller started [s].
    """

    def __init__(
        self,
        controller: Controller,
        log: Callable[[str], None],
        poses: PoseServer | None = None,
        clock: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self.arm, self.log = controller, log
        self.registers, self.signals, self.clock = Registers(clock, log), Signals(log), Clock(clock)
        self.sockets = Sockets(controller.gripper_server, poses)
        self.streaming = Streaming(controller)
        self.settings = Settings(controller)
        self.blending: list[tuple[Floats, tuple[float, float], float]] = []
        self.process: list[tuple[Pose, tuple[float, float], float]] = []
        self._told = set[str]()

    def library(self) -> Library:
        """Return all URScript functions of one run by name, those that need no robot included."""
        parts = ((self, NAMES), (self.sockets, SOCKETS), (self.streaming, STREAMING), (self.settings, SETTINGS))
        bound = {name: getattr(part, name) for part, names in parts for name in names}
        return self.all_of({**bound, **self.registers.library(), **self.signals.library(), **self.clock.library()})

    def all_of(self, bound: Library) -> Library:
        """Join functions of a controller with the pure ones; all that cannot stand between blended motions wait for a motion's end."""
        return {**PURE, **electrics(), **{name: f if name in BLENDING else self._settled(f) for name, f in bound.items()}}

    def _settled(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Wrap a function so that it first executes the motions that are waiting for a next motion to blend
        into, and waits for their end."""

        @wraps(function)
        def call(*arguments: Any, **named: Any) -> Generator[None, None, Any]:
            if self.blending or self.process:
                yield from self.finish()
            result = function(*arguments, **named)
            return (yield from result) if takes_time else result

        takes_time = blocks(function)
        return call

    def finish(self) -> Wait:
        """Execute the motions that are waiting for a next motion to blend into, and wait for their end."""
        yield from self._blended_joints()
        yield from self._blended_process()

    # Motion

    def movej(self, q: Any, a: Any = 1.4, v: Any = 1.05, t: Any = 0, r: Any = 0) -> Wait:
        """Move to joint positions [rad] or a TCP pose, linear in joint space; blend radius ``r`` [m] into the next."""
        yield from self._blended_process()
        goal, radius = self._joints(q, "movej"), real(r, "movej")
        start = self.blending[-1][0] if self.blending else self.arm.q
        rates = _rates(v, a, "movej", t, float(np.abs(goal - start).max()))
        if radius < 0:
            raise ScriptError(f"movej needs a blend radius of 0 or more, not {show(r)}")
        self.streaming.only_mover()
        self.blending.append((goal, rates, radius))
        if radius <= 0:  # else the next movej, in the same cycle, starts the motion
            yield from self._blended_joints()

    def _blended_joints(self) -> Wait:
        if not self.blending:
            return
        goals, laws, radii = map(list, zip(*self.blending, strict=True))
        self.blending.clear()
        try:
            motion = self.arm.move_along(goals, radii[:-1], laws) if len(goals) > 1 else self.arm.move_joints(goals[0], *laws[0])
        except ValueError as error:
            raise ScriptError(f"movej: {error}") from None
        yield from self._follow(motion)

    def movel(self, pose: Any, a: Any = 1.2, v: Any = 0.25, t: Any = 0, r: Any = 0) -> Wait:
        """Move the TCP to a pose on a straight line; it stops there, whatever blend radius ``r`` is given."""
        goal = self._place(pose, "movel")
        self._stops_there("movel", r)
        self.streaming.only_mover()
        yield from self._follow(self.arm.move_linear(goal, *_rates(v, a, "movel", t, self.arm.path_length(goal))))

    def movep(self, pose: Any, a: Any = 1.2, v: Any = 0.25, r: Any = 0) -> Wait:
        """Move the TCP to a pose at constant tool speed; blend radius ``r`` [m] into the next."""
        goal = self._place(pose, "movep")
        yield from self._blended_joints()
        radius, rates = real(r, "movep"), _rates(v, a, "movep", 0, 0.0)
        if radius < 0:
            raise ScriptError(f"movep needs a blend radius of 0 or more, not {show(r)}")
        if any(rates != earlier for _, earlier, _ in self.process):
            raise ScriptError("movep: the tool goes through its blends at one speed: give all of them the same v and a")
        self.streaming.only_mover()
        self.process.append((goal, rates, radius))
        if radius <= 0:  # else the next movep, in the same cycle, starts the motion
            yield from self._blended_process()

    def _blended_process(self) -> Wait:
        if not self.process:
            return
        goals, rates, radii = map(list, zip(*self.process, strict=True))
        self.process.clear()
        try:
            motion = self.arm.move_process(goals, radii[:-1], *rates[0])
        except ValueError as error:
            raise ScriptError(f"movep: {error}") from None
        yield from self._follow(motion)

    def movec(self, pose_via: Any, pose_to: Any, a: Any = 1.2, v: Any = 0.25, r: Any = 0, mode: Any = 0) -> Wait:
        """Move the TCP on an arc through a position to a pose; in ``mode`` 1 the tool keeps its orientation to the tangent."""
        via, goal = self._place(pose_via, "movec"), self._place(pose_to, "movec")
        if mode not in (0, 1):
            raise ScriptError(f"movec: mode is 0, which turns the tool to its goal, or 1, fixed to the tangent; not {show(mode)}")
        self._stops_there("movec", r)
        self.streaming.only_mover()
        try:
            motion = self.arm.move_circular(via.position, goal, *_rates(v, a, "movec", 0, 0.0), fixed=mode == 1)
        except ValueError as error:
            raise ScriptError(f"movec: {error}") from None
        yield from self._follow(motion)

    def _stops_there(self, name: str, r: Any) -> None:
        """Check a blend radius, and log once per function that it is not modelled: the motion stops at its goal."""
        if real(r, name) < 0:
            raise ScriptError(f"{name} needs a blend radius of 0 or more, not {show(r)}")
        if real(r, name) > 0 and name not in self._told:
            self._told.add(name)
            self.log(f"{name}: {NO_BLEND}")

    def stopj(self, a: Any) -> Wait:
        """Stop with a deceleration of the joints [rad/s2]."""
        yield from self._stop(a, "stopj")

    def stopl(self, a: Any, aRot: Any = 0) -> Wait:
        """Stop with a deceleration of the tool [m/s2]."""
        yield from self._stop(a, "stopl")

    def force_mode(self, task_frame: Any, selection_vector: Any, wrench: Any, type: Any, limits: Any) -> None:
        """Switch force mode on; only type 2 is supported, which uses the given frame as it is."""
        if type != 2:
            raise ScriptError(f"force_mode: type {show(type)} is not supported; 2 takes the frame as it is")
        selection = np.array(numbers(selection_vector, 6, "force_mode's selection_vector"))
        if not np.isin(selection, (0, 1)).all():
            raise ScriptError(f"force_mode: the selection_vector holds 0 and 1, not {show(selection_vector)}")
        wanted = np.array(numbers(wrench, 6, "force_mode's wrench"))
        most = np.array(numbers(limits, 6, "force_mode's limits"))
        if (most < 0).any():
            raise ScriptError(f"force_mode: limits must not be negative: {show(limits)}")
        self.arm.start_force_mode(ForceMode(as_pose(task_frame, "force_mode"), selection, wanted, most))

    def end_force_mode(self) -> None:
        """Switch force mode off."""
        self.arm.end_force_mode()

    # Measurements

    def zero_ftsensor(self) -> None:
        """Tare the wrist sensor."""
        self.arm.zero_sensor()

    def get_tcp_force(self) -> PoseValue:
        """Return the wrench (6,) of the environment on the tool, base axes, at the TCP [N, Nm]."""
        return PoseValue(map(float, self.arm.wrench()))

    def force(self) -> float:
        """Return the magnitude of the force at the TCP [N]."""
        return self.arm.force()

    def get_actual_tcp_pose(self) -> PoseValue:
        """Return the TCP pose in the base frame, from the encoders."""
        return from_pose(self.arm.actual_tcp())

    def get_actual_joint_positions(self) -> list[float]:
        """Return the joint positions that the encoders measure [rad]."""
        return [float(v) for v in self.arm.actual_joints()]

    def get_target_tcp_pose(self) -> PoseValue:
        """Return the commanded TCP pose in the base frame."""
        return from_pose(self.arm.kinematics.forward(self.arm.q))

    def get_target_joint_positions(self) -> list[float]:
        """Return the commanded joint positions [rad]."""
        return [float(v) for v in self.arm.q]

    def get_forward_kin(self, q: Any = None, tcp: Any = None) -> PoseValue:
        """Solve forward kinematics for joint positions and a tool offset, by default the actual ones."""
        place = self.arm.actual_tcp() if q is None else self._tcp_at(q, "get_forward_kin")
        active = self.arm.arm.gripper.tcp
        return from_pose(place if tcp is None else place * active.inverse() * as_pose(tcp, "get_forward_kin"))

    def get_inverse_kin(
        self, x: Any, qnear: Any = None, maxPositionError: Any = 1e-10, maxOrientationError: Any = 1e-10, tcp: Any = None
    ) -> list[float]:
        """Solve inverse kinematics near joint positions, by default the commanded ones."""
        near = self.arm.q if qnear is None else self._joints(qnear, "get_inverse_kin")
        place = as_pose(x, "get_inverse_kin")
        if tcp is not None:
            place = place * as_pose(tcp, "get_inverse_kin").inverse() * self.arm.arm.gripper.tcp
        return [float(v) for v in self._solved(place, near, "get_inverse_kin")]

    def is_steady(self) -> bool:
        """Check whether the arm is at rest."""
        return self.arm.motion is None

    # Settings

    def set_tcp(self, pose: Any, tcp_name: Any = "") -> None:
        """Set the tool centre point in the flange frame; the name, for PolyScope's screen, is ignored."""
        self.arm.set_tcp(as_pose(pose, "set_tcp"))

    def set_payload(self, m: Any, cog: Any = None) -> None:
        """Set mass [kg] and centre of gravity [m] of the payload."""
        self.set_target_payload(m, [0.0, 0.0, 0.0] if cog is None else cog)

    def set_payload_mass(self, m: Any) -> None:
        """Set the mass of the payload [kg]; its centre of gravity stays."""
        self.set_target_payload(m, [float(v) for v in self.arm.sensor.center])

    def set_payload_cog(self, CoG: Any) -> None:
        """Set the centre of gravity of the payload [m]; its mass stays."""
        self.set_target_payload(float(self.arm.sensor.mass), CoG)

    def set_target_payload(self, m: Any, cog: Any, inertia: Any = None, transition_time: Any = 0) -> None:
        """Set mass [kg] and centre of gravity [m] of the payload, at once; its inertia is not used."""
        mass = real(m, "set_target_payload")
        if not 0 <= mass <= self.arm.arm.payload:
            raise ScriptError(f"payload {mass:.3f} kg is outside 0 .. {self.arm.arm.payload} kg")
        self.arm.set_payload(mass, np.array(numbers(cog, 3, "set_target_payload's centre of gravity")))

    # Time and messages

    def sleep(self, t: Any) -> Wait:
        """Wait for a time [s], at least one control cycle."""
        for _ in range(max(1, round(min(real(t, "sleep"), 1e6) / self.arm.period))):
            yield

    def sync(self) -> Wait:
        """Wait for the next control cycle."""
        yield

    def get_steptime(self) -> float:
        """Return the period of a control cycle [s]."""
        return self.arm.period

    def textmsg(self, s1: Any, s2: Any = "") -> None:
        """Write a line to the log."""
        self.log(show(s1) + show(s2))

    def popup(
        self, s: Any, title: Any = "Popup", warning: Any = False, error: Any = False, blocking: Any = False
    ) -> None:
        """Write a popup's title and text to the log; the program goes on without a confirmation."""
        self.log(f"{show(title)}: {show(s)}")

    def halt(self) -> None:
        """End the program."""
        raise Halted

    # Common parts

    def _follow(self, motion: Motion) -> Wait:
        """Wait for a motion's end; a killed thread leaves the arm to stop by itself."""
        try:
            while self.arm.motion is motion:
                yield
        except GeneratorExit:
            if self.arm.motion is motion:
                self.arm.stop(ABANDONED)
            raise

    def _stop(self, a: Any, name: str) -> Wait:
        deceleration = real(a, name)
        if deceleration <= 0:
            raise ScriptError(f"{name} needs a positive deceleration, not {show(a)}")
        motion = self.arm.stop(deceleration)
        while motion is not None and self.arm.motion is motion:
            yield

    def check(self) -> None:
        """Check, once a cycle, that no thread ended while its motions waited for a next one to blend into,
        and that watched inputs were written in time.

        Raises:
            ScriptError: a thread ended with a movej or movep that is to be blended, or waits for another thread: where in its
                zone the arm would have to be by then is not modelled; or a watchdog's input is late.
        """
        for name, waiting in (("movej", self.blending), ("movep", self.process)):
            if waiting:
                raise ScriptError(f"a {name} with a blend radius must be followed by another {name} in its thread")
        if late := self.registers.late():
            raise ScriptError(f"watchdog: '{late}' was not written in time")

    def forget(self) -> None:
        """Discard motions that still wait for a next motion to blend into, after the end of their program."""
        self.blending.clear()
        self.process.clear()

    def _joints(self, q: Any, where: str) -> Floats:
        if isinstance(q, PoseValue):
            return self._solved(as_pose(q, where), self.arm.q, where)
        return np.array(numbers(q, len(self.arm.q), where))

    def _place(self, target: Any, where: str) -> Pose:
        return as_pose(target, where) if isinstance(target, PoseValue) else self._tcp_at(target, where)

    def _tcp_at(self, q: Any, where: str) -> Pose:
        return self.arm.kinematics.forward(np.array(numbers(q, len(self.arm.q), where)))

    def _solved(self, pose: Pose, near: Floats, where: str) -> Floats:
        found = nearest_solution(self.arm.arm, pose, tuple(near))
        if found is None:
            raise ScriptError(f"{where}: no joint position near the start reaches {show(from_pose(pose))}")
        return np.array(found)


def _rates(v: Any, a: Any, where: str, t: Any, way: float) -> tuple[float, float]:
    """Speed and acceleration of a motion command; a duration ``t`` above 0 determines both (URScript manual,
    movej and movel)."""
    speed, acceleration, time = real(v, where), real(a, where), real(t, where)
    if speed <= 0 or acceleration <= 0 or time < 0:
        raise ScriptError(f"{where} needs a positive speed and acceleration, not v={show(v)}, a={show(a)}, t={show(t)}")
    return (speed, acceleration) if time == 0 or way == 0 else profile_for_duration(way, time, acceleration)

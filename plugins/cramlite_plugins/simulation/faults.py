"""Faults that happen in a simulation while a program runs, each when its trigger holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from functools import cached_property

import mujoco
import numpy as np

from cramlite.model import Fault, FaultKind, Message, Pose, Thing, Trigger, is_program_text
from cramlite.plugin import UserError

from .controller.controller import Controller
from .controller.gripper_drive import GripperDrive
from .controller.protective_stop import ProtectiveStop
from .model.compile import Compiled
from .model.index import Data
from .model.sleep import SLEEP
from .model.world_doubts import TOO_DEEP, overlaps

AWAY = -50.0
"""Height of removed or not yet added things, far below the scene [m]."""
OVER = 2e-3
"""Height above its resting place at which a thing that fell over is put down [m]."""
AGAIN = 0.05
"""Time between two checks whether the place to which a fault moves a thing is free [s]."""
READINGS = frozenset({FaultKind.FROZEN, FaultKind.LOST})
ORDERS = frozenset({FaultKind.GOAL, FaultKind.CANCELLED})


class Killed(Exception):
    """Raised when a fault ends the program from outside; the program did nothing about the fault."""


class FaultsToCome:
    """Faults of a world that wait for their triggers, and those that are under way.

    Args:
        compiled, data: the simulation.
        arm: the controller of the robot whose program they happen to.
        text: of the program; "" where programs come and go.

    Raises:
        UserError: a trigger waits for a line that the text does not have.
    """

    def __init__(self, compiled: Compiled, data: Data, arm: Controller, text: str = "") -> None:
        self.compiled, self.data, self.arm = compiled, data, arm
        self.waiting = list(compiled.world.faults)
        self.since: dict[int, float] = {}
        self.away = {f.thing for f in self.waiting if f.kind is FaultKind.ADDED}
        self.until: list[tuple[float, Callable[[], None]]] = []
        self.happened: list[Message] = []
        self.frozen_until = self.lost_until = -math.inf
        self.goal: tuple[str, ...] | None = None
        self.lines = {t.line: _lines_of(t, text) for f in self.waiting if (t := f.trigger) and t.line}
        self.keep_away()

    def keep_away(self) -> None:
        """Keep things that a fault has removed, or has yet to add, far below the scene."""
        for name in self.away:
            x, y, _ = self.compiled.world.thing(name).pose.position
            self.compiled.place(self.data, name, Pose((x, y, AWAY)))

    def due(self, now: float, line: int, force: float) -> None:
        """Start the faults that are due, and end those whose time is over.

        Args:
            now: since the program's start [s].
            line: that is under execution.
            force: that the program feels [N].

        Raises:
            ProtectiveStop, Killed: a fault does that.
        """
        self.keep_away()
        for end, undo in [u for u in self.until if now >= u[0]]:
            self.until.remove((end, undo))
            undo()
        for fault in tuple(self.waiting):
            if id(fault) not in self.since and self._triggered(fault, line, force):
                self.since[id(fault)] = now if fault.trigger else 0.0
            if now >= self.since.get(id(fault), math.inf) + fault.after:
                if not self._has_room(fault):
                    self.since[id(fault)] = now - fault.after + AGAIN
                    continue
                self.waiting.remove(fault)
                self.happened.append(Message(now, str(fault), line))
                _HAPPENS[fault.kind](self, fault, now)

    def _triggered(self, fault: Fault, line: int, force: float) -> bool:
        if (asked := fault.trigger) is None:
            return True
        if asked.line and line not in self.lines[asked.line]:
            return False
        if asked.force and force < asked.force:
            return False
        if not asked.near:
            return True
        place = self.data.xpos[self.compiled.things[asked.near].body]
        return float(np.linalg.norm(self.arm.index.pose(self.data).position - place)) <= asked.within

    @cached_property
    def _tried(self) -> Data:
        """Scratch state of the simulation for tests whether the place to which a fault moves a thing is free."""
        return self.compiled.data()

    def _has_room(self, fault: Fault) -> bool:
        """Whether the place to which a fault moves a thing is free of fingers and of other things."""
        if fault.kind not in _PLACES:
            return True
        self._tried.qpos[:] = self.data.qpos
        self.compiled.place(self._tried, fault.thing, _PLACES[fault.kind](self, fault))
        mujoco.mj_kinematics(self.arm.model, self._tried)
        mujoco.mj_collision(self.arm.model, self._tried)
        return all(depth <= TOO_DEEP for *pair, depth in overlaps(self.compiled, self._tried) if fault.thing in pair)

    def awake(self) -> None:
        """Keep all things awake from now on: things asleep may have rested on one that a fault moved."""
        self.arm.sleep = None
        self.arm.model.opt.enableflags &= ~SLEEP

    def put(self, name: str, pose: Pose) -> None:
        """Put a thing elsewhere, at rest."""
        self.awake()
        self.compiled.place(self.data, name, pose)

    def ends(self, now: float, fault: Fault, undo: Callable[[], None]) -> None:
        """Undo a fault when it is over."""
        if fault.lasts:
            self.until.append((now + fault.lasts, undo))


def _lines_with(wanted: str, text: str) -> Collection[int]:
    """Numbers of the program lines that contain a text; if a comment contains it, also of the lines of the
    block below the comment."""
    found, heading = set[int](), ""
    for number, row in enumerate(text.splitlines(), 1):
        comment = row.strip().startswith("#")
        if comment and not is_program_text(text):
            heading = row
        if wanted in row or (not comment and wanted in heading and _depth(row) == _depth(heading)):
            found.add(number)
        heading = heading if row.strip() else ""
    return found


def _lines_of(trigger: Trigger, text: str) -> Collection[int]:
    """Line numbers of the program at which the trigger of a fault is reached.

    There may be none if the fault is left over from an earlier program.
    """
    found = _lines_with(trigger.line, text)
    if not found and not trigger.carried_over:
        raise UserError(f"A fault happens at '{trigger.line}', and no line of the program has that text; name a task, such as 'PickingUp'.")
    return found


def _depth(row: str) -> int:
    """Indentation of a program line [characters]."""
    return len(row) - len(row.lstrip())


def _moved(run: FaultsToCome, fault: Fault) -> Pose:
    return Pose(fault.by) * run.compiled.pose(run.data, fault.thing)


def _missing(run: FaultsToCome, fault: Fault, now: float) -> None:
    run.awake()
    run.away.add(fault.thing)
    run.keep_away()


def _added(run: FaultsToCome, fault: Fault) -> Pose:
    return Pose(fault.by) * run.compiled.world.thing(fault.thing).pose


def _fallen(run: FaultsToCome, fault: Fault) -> Pose:
    """Pose of a thing that has fallen over at its place, by a quarter turn away from the robot."""
    pose, thing = run.compiled.pose(run.data, fault.thing), run.compiled.world.thing(fault.thing)
    away = np.subtract(pose.position, run.arm.base.position)
    angle = math.atan2(away[1], away[0]) + math.pi / 2
    turn = Pose.from_rotvec((0, 0, 0), (math.pi / 2 * math.cos(angle), math.pi / 2 * math.sin(angle), 0.0))
    lies = Pose(pose.position, (turn * Pose((0, 0, 0), pose.quaternion)).quaternion)
    up = _lowest(thing, pose) - _lowest(thing, lies) + OVER
    return Pose((0.0, 0.0, up)) * lies


_PLACES: Mapping[FaultKind, Callable[[FaultsToCome, Fault], Pose]] = {
    FaultKind.MOVED: _moved, FaultKind.ADDED: _added, FaultKind.FALLEN: _fallen,
}  # fmt: skip
"""Kind of a fault that puts a thing elsewhere -> the pose that it gets."""


def _displaced(run: FaultsToCome, fault: Fault, now: float) -> None:
    if fault.kind is FaultKind.ADDED:
        run.away.discard(fault.thing)
    run.put(fault.thing, _PLACES[fault.kind](run, fault))


def _lowest(thing: Thing, pose: Pose) -> float:
    """Height of the lowest corner of the boxes around a thing's geoms [m]."""
    placed = [(pose * g.pose, g.half_extents) for g in thing.geoms]
    return min(float(p.position[2] - abs(p.rotation[2]) @ half) for p, half in placed)


def _payload(run: FaultsToCome, fault: Fault, now: float) -> None:
    model, body = run.arm.model, min(run.arm.index.bodies)
    model.body_mass[body] += fault.mass
    mujoco.mj_setConst(model, mujoco.MjData(model))


def _grip_lost(run: FaultsToCome, fault: Fault, now: float) -> None:
    run.arm.gripper.forced = run.arm.gripper.widest
    run.ends(now, fault, lambda: _let(run.arm.gripper))


def _let(gripper: GripperDrive) -> None:
    gripper.forced = None


def _slip(run: FaultsToCome, fault: Fault, now: float) -> None:
    before = run.arm.gripper.strength
    run.arm.gripper.strength = before * fault.share

    def undo() -> None:
        run.arm.gripper.strength = before

    run.ends(now, fault, undo)


def _short(run: FaultsToCome, fault: Fault, now: float) -> None:
    run.arm.gripper.nearest = fault.most


def _sticking(run: FaultsToCome, fault: Fault, now: float) -> None:
    model = run.arm.model
    model.dof_frictionloss[model.joint(model.body(fault.thing).jntadr[0]).dofadr[0]] = fault.most


def _friction(run: FaultsToCome, fault: Fault, now: float) -> None:
    model = run.arm.model
    model.pair_friction[:, :2] *= fault.share
    model.geom_friction[:, 0] *= fault.share


def _frozen(run: FaultsToCome, fault: Fault, now: float) -> None:
    run.frozen_until = now + fault.lasts


def _lost(run: FaultsToCome, fault: Fault, now: float) -> None:
    run.lost_until = now + fault.lasts


def _stop(run: FaultsToCome, fault: Fault, now: float) -> None:
    raise ProtectiveStop(f"a fault declared under 'faults', at {now:.2f} s")


def _killed(run: FaultsToCome, fault: Fault, now: float) -> None:
    raise Killed


def _goal(run: FaultsToCome, fault: Fault, now: float) -> None:
    run.goal = fault.goal


def _nothing(run: FaultsToCome, fault: Fault, now: float) -> None:
    """Do nothing at runtime: faults of this kind take effect before the start, or where clients connect."""


_HAPPENS: Mapping[FaultKind, Callable[[FaultsToCome, Fault, float], None]] = {
    FaultKind.MISSING: _missing, FaultKind.MOVED: _displaced, FaultKind.ADDED: _displaced, FaultKind.FALLEN: _displaced,
    FaultKind.PAYLOAD: _payload, FaultKind.TOOL: _nothing, FaultKind.SENSOR: _nothing, FaultKind.GRIP_LOST: _grip_lost,
    FaultKind.SLIP: _slip, FaultKind.CLOSES_SHORT: _short, FaultKind.STICKING: _sticking, FaultKind.FRICTION: _friction,
    FaultKind.FROZEN: _frozen, FaultKind.LOST: _lost, FaultKind.STOP: _stop, FaultKind.CONNECTION: _nothing,
    FaultKind.KILLED: _killed, FaultKind.GOAL: _goal, FaultKind.CANCELLED: _goal,
}  # fmt: skip

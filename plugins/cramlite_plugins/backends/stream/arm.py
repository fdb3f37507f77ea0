"""The arm of a robot process, as programs command it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Robot

from ...simulation.controller.commanded_arm import CommandedArm
from ...simulation.controller.gripper_order import GripperOrder
from ...simulation.controller.protective_stop import ProtectiveStop, Safety, SafetyWatch
from ...simulation.controller.trajectories import StoppingMotion
from .messages import Action, Hello, Six, State

CYCLE = 0.008
"""Control cycle for which the gain of force mode was chosen (simulation/controller/force_mode.py) [s]; a slower one takes less."""
ARRIVAL = 3.0
"""How long the arm may take to come near enough after a motion should have ended [s]."""
ASTRAY = 0.10
"""A tool that is further off its path than this has left it [m]; at 0.3 m/s, an arm with a lag of 0.16 s is 50 mm behind."""
SLOWEST, FASTER = 0.1, 1.2
"""Motions that want larger deltas than the process takes go on at a lower pace, at least this share, which grows so much a period."""
BEYOND = 0.15
"""How far an encoder may be outside its joint's range [rad]: a range is where motions are planned, not where the stop is. An arm that is
led by its tool alone, as by robosuite's OSC_POSE, keeps its elbow where it likes: it was seen 35 mrad outside."""


class StreamedArm(CommandedArm):
    """Arm that is sent one action a period: joint positions, or deltas of the end effector.

    Motions slow down on their path where the process would have to clip a delta.

    Args:
        hello: what the process said of it.
        step: sends an action and returns what the robot feels after it.
    """

    def __init__(self, robot: Robot, hello: Hello, step: Callable[[Action], State]) -> None:
        super().__init__(robot, np.array(hello.joints), 1.0 / hello.rate)
        self.hello, self.step, self.state = hello, step, State(joints=hello.joints, opening=hello.opening, wrench=hello.wrench)
        self.gripper = GripperOrder(robot.gripper)
        self.gripper.tolerance = hello.fingers or self.gripper.tolerance
        self.gripper.closed = self.gripper.tolerance if hello.closed is None else hello.closed
        self.gripper.patience = hello.hesitation
        self.gripper.opening = self.gripper.goal = self.gripper.command = hello.opening
        self.force_gain = min(1.0, CYCLE / self.period)
        self.watch = SafetyWatch(Safety(), robot, np.ones(len(robot.joints)), self.period)
        self.tare = np.zeros(6)
        self.clock = self.late = 0.0
        self.rate = np.zeros(len(robot.joints))

    # What it measures

    def actual_joints(self) -> Floats:
        """Return the joint encoders (n,) [rad], as the process told them."""
        return np.array(self.state.joints)

    def actual_tcp(self) -> Pose:
        """Return the TCP in the base frame, from the encoders and the nominal kinematics."""
        return self.kinematics.forward(self.actual_joints())

    def wrench(self) -> Floats:
        """Return the wrench (6,) that the process feels, less that of the last tare, base axes, at the TCP [N, Nm]; 0 if none."""
        return np.zeros(6) if self.state.wrench is None else np.array(self.state.wrench) - self.tare

    def force_vector(self) -> Floats:
        """Return the force (3,) of ``wrench`` alone [N]."""
        return self.wrench()[:3]

    def force(self) -> float:
        """Return the magnitude of the force of ``wrench`` [N]."""
        return float(np.linalg.norm(self.force_vector()))

    def zero_sensor(self) -> None:
        """Take what is felt now for nothing."""
        self.tare = np.array(self.state.wrench or (0.0,) * 6)

    def set_payload(self, mass: float, center: Floats) -> None:
        """Do nothing: what the process feels is without the weight of the hand, and it carries what it holds by itself."""

    # One period

    def cycle(self) -> None:
        """Send the next action and take what is felt after it.

        Raises:
            ProtectiveStop: a joint leaves its range or moves too fast, the arm does not follow, or the process stops it.
        """
        before, motion = self.q, self.motion
        self.q = self._command()
        self.watch.command(before, self.q)
        self.state = self.step(self._action((self.q - before) / self.period))
        self.clock += self.period
        self.gripper.follow(self.state.opening, self.period)
        if self.state.stop:
            raise ProtectiveStop(self.state.stop)
        self._check()
        if motion is not None and self.motion is None and not isinstance(motion, StoppingMotion) and self.force_mode is None:
            self.motion = None if self._arrived() else motion

    def _action(self, rate: Floats) -> Action:
        """The action of this period: the command, ahead by the lag and by what inertia leaves it behind, so that it brakes in time."""
        acceleration, self.rate = (rate - self.rate) / self.period, rate
        ahead = self.q + self.hello.lag * rate + (0.0 if self.force_mode else self.hello.inertia) * acceleration
        hand = Action(opening=round(self.gripper.command, 6), grip=self.gripper.force)
        if self.hello.actions == "joints":
            low, high = np.array(self.arm.limits).T
            return replace(hand, joints=tuple(np.clip(ahead, low, high).round(9).tolist()))
        return replace(hand, delta=self._delta(self.kinematics.forward(ahead)))

    def _delta(self, target: Pose) -> Six:
        """From where the tool is to a target, base axes, as large as the process takes."""
        here = self.actual_tcp()
        way = np.subtract(target.position, here.position)
        turn = np.array(here.rotate((here.inverse() * target).rotvec))
        if self.hello.most is not None:
            fit = min(m / max(float(np.linalg.norm(v)), 1e-12) for v, m in zip((way, turn), self.hello.most, strict=True))
            self.pace = max(SLOWEST, fit * self.pace) if fit < 1.0 else min(1.0, FASTER * self.pace)
            way, turn = min(1.0, fit) * way, min(1.0, fit) * turn
        x, y, z, rx, ry, rz = np.concatenate([way, turn]).round(9).tolist()
        return x, y, z, rx, ry, rz

    def _error(self) -> tuple[float, float]:
        """How far the tool is from its command [m, rad]."""
        should, here = self.kinematics.forward(self.q), self.actual_tcp()
        return math.dist(should.position, here.position), float(np.linalg.norm((here.inverse() * should).rotvec))

    def _check(self) -> None:
        for name, q, (low, high) in zip(self.arm.joints, self.state.joints, self.arm.limits, strict=True):
            if not low - BEYOND <= q <= high + BEYOND:
                raise ProtectiveStop(f"joint '{name}' is at {q:.3f} rad, outside {low:.3f} .. {high:.3f}")
        off, _ = self._error()
        if off > ASTRAY:
            raise ProtectiveStop(f"the tool is {1000 * off:.0f} mm off its path, more than {1000 * ASTRAY:.0f} mm: the arm does not follow")

    def _arrived(self) -> bool:
        """Whether the tool is where its motion ends.

        Raises:
            ProtectiveStop: it is not, and had the time.
        """
        (off, turned), (near, straight) = self._error(), self.hello.tolerance
        there = off <= near and turned <= straight
        self.late = 0.0 if there else self.late + self.period
        if self.late > ARRIVAL:
            raise ProtectiveStop(
                f"{ARRIVAL:g} s after it should be there, the tool is {1000 * off:.1f} mm and {turned:.3f} rad off its target, "
                f"more than {1000 * near:g} mm or {straight:g} rad"
            )
        return there

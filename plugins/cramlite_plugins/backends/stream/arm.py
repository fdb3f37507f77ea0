"""Arm of a robot that another process drives, with the commands that programs give to an arm."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Robot

from ...kinematics.forward import conditioning
from ...simulation.controller.commanded_arm import CommandedArm
from ...simulation.controller.gripper_order import GripperOrder
from ...simulation.controller.protective_stop import ProtectiveStop, Safety, SafetyWatch
from ...simulation.controller.trajectories import BlendedMotion, JointMotion, StoppingMotion
from .messages import Action, Hello, State
from .response import Response

CYCLE = 0.008
"""Control cycle for which the gain of force mode was chosen (simulation/controller/force_mode.py) [s]; for a slower cycle the gain is
reduced."""
ARRIVAL = 3.0
"""Longest time from the planned end of a motion until the arm is near enough [s]."""
IN_THE_OPEN = 2.5
"""Factor on the position tolerance at the end of a motion in free space that another motion follows. Such ends are those of motions
between joint positions, which a straight line follows: of 35 in LIBERO the tool was 10 mm off 7 actions before it had come to rest
within 4 mm. And those of straight lines that a transfer follows: the thing that was lifted, or left, is behind the hand; or a guarded
motion, which goes on along them and feels. A program's last motion is awaited."""
ASTRAY = 0.10
"""A tool that is further off its path than this has left it [m]; at 0.3 m/s, an arm with a lag of 0.16 s is 50 mm behind."""
SLOWEST, HALVINGS = 0.1, 8
"""Least pace of a motion whose deltas are too large for the process, and number of bisections that find the pace."""
CALM = 2.0
"""Conditioning, in units of the least that the robot keeps, below which the arm comes nearer to a singularity the more slowly: one that
treats position and rotation of its tool apart hardly brakes there. Three programs for LIBERO with motions that ended at 1.02 to 1.14 ran
into a singularity so (stuck, or with 64 N on a thing), and no longer do; others take at most 2 % more actions."""
BEYOND = 0.15
"""Largest excess of an encoder's value over its joint's range [rad]: the range is where motions are planned, not where the stop is. An arm
that is led by its tool alone, as by robosuite's OSC_POSE, keeps its elbow where it likes: it was seen 35 mrad outside."""


class StreamedArm(CommandedArm):
    """Arm that is sent one action a period: joint positions, or deltas of the end effector.

    Motions slow down on their path where the process would have to clip a delta.

    Args:
        hello: what the process said of it.
        step: sends an action and returns what the robot feels after it.
    """

    carries = True  # told or not, what it holds

    def __init__(self, robot: Robot, hello: Hello, step: Callable[[Action], State]) -> None:
        super().__init__(robot, np.array(hello.joints), 1.0 / hello.rate)
        self.hello, self.step, self.state = hello, step, State(joints=hello.joints, opening=hello.opening, wrench=hello.wrench)
        self.gripper = GripperOrder(robot.gripper)
        self.gripper.tolerance = hello.fingers or self.gripper.tolerance
        self.gripper.closed = self.gripper.tolerance if hello.closed is None else hello.closed
        self.gripper.patience, self.settling = hello.hesitation, hello.settling
        self.gripper.opening = self.gripper.goal = self.gripper.command = hello.opening
        self.force_gain = min(1.0, CYCLE / self.period)
        self.watch = SafetyWatch(Safety(), robot, np.ones(len(robot.joints)), self.period)
        self.tare = np.zeros(6)
        self.clock = self.late = self.distance = 0.0
        self.under_way = False
        self.response = Response(hello.lag, hello.inertia, self.period, len(robot.joints))

    def grip(self, force: float) -> None:
        """Close the fingers further on the payload with a force [N], so that they keep pressing."""
        self.gripper.move(self.gripper.gripper.opening[0], self.gripper.gripper.speed[1], force)
        self.gripper.command = self.gripper.goal

    # What it measures

    def actual_joints(self) -> Floats:
        """Return the joint encoders (n,) [rad], as the process told them."""
        return np.array(self.state.joints)

    def actual_tcp(self) -> Pose:
        """Return the TCP in the base frame, from the encoders and the nominal kinematics."""
        return self.kinematics.forward(self.actual_joints())

    def wrench(self) -> Floats:
        """Return the wrench (6,) that the process measures at the TCP, less its value at the tare, base axes
        [N, Nm]; 0 if none."""
        return np.zeros(6) if self.state.wrench is None else np.array(self.state.wrench) - self.tare

    def force_vector(self) -> Floats:
        """Return the force part (3,) of ``wrench``, without the torque [N]."""
        return self.wrench()[:3]

    def force(self) -> float:
        """Return the magnitude of the force of ``wrench`` [N]."""
        return float(np.linalg.norm(self.force_vector()))

    def zero_sensor(self) -> None:
        """Take the present wrench as zero."""
        self.tare = np.array(self.state.wrench or (0.0,) * 6)

    def set_payload(self, mass: float, center: Floats) -> None:
        """Ignore the payload's mass and centre: the robot process compensates the weight of hand and payload itself."""

    # One period

    def cycle(self) -> None:
        """Send the next action to the robot process, and take over the state of the robot that it answers with.

        Raises:
            ProtectiveStop: a joint leaves its range or moves too fast, the arm does not follow, or the process stops it.
        """
        before, motion, off = self.q, self.motion, self._off()
        correction = self.response.correction(off) if self.force_mode is None else np.zeros(6)
        self.pace = self._pace(correction)
        self.q = self._command()
        self.watch.command(before, self.q)
        rate = (self.q - before) / self.period
        self.state = self.step(self._action(rate, correction))
        self.response.passed(rate, off)
        self.clock += self.period
        self.gripper.follow(self.state.opening, self.period)
        if self.state.stop:
            raise ProtectiveStop(self.state.stop)
        self._check()
        if motion is not None and self.motion is None and not isinstance(motion, StoppingMotion) and self.force_mode is None:
            between = isinstance(motion, JointMotion | BlendedMotion) or self.leads_on
            self.motion = None if self._arrived(IN_THE_OPEN if between else 1.0) else motion
            self.under_way = between and self.motion is None

    def settled(self) -> bool:
        """Return whether the tool has arrived at its last target, within the usual tolerance.

        A motion in free space may end farther off.

        Raises:
            ProtectiveStop: it has not, and had the time.
        """
        return not self.under_way or self._arrived()

    def _action(self, rate: Floats, correction: Floats) -> Action:
        """Return the command for this period, ahead of the planned motion to make up for the arm's lag and inertia."""
        ahead = self.q + self.response.lead(rate, free=self.force_mode is None)
        hand = Action(opening=round(self.gripper.command, 6), grip=self.gripper.force)
        if self.hello.actions == "joints":
            low, high = np.array(self.arm.limits).T
            return replace(hand, joints=tuple(np.clip(ahead, low, high).round(9).tolist()))
        delta = self._way(self.kinematics.forward(ahead)) + correction
        x, y, z, rx, ry, rz = (min(1.0, self._fit(delta)) * delta).round(9).tolist()
        return replace(hand, delta=(x, y, z, rx, ry, rz))

    def _pace(self, correction: Floats) -> float:
        """Share of the planned speed at which the arm goes on."""
        if self.motion is None or self.force_mode is not None:
            return 1.0
        return min(self._accepted(correction), max(self._calm(), SLOWEST))

    def _calm(self) -> float:
        """Share of the planned speed at which the arm may come nearer to a singularity."""
        kept, before = CALM * self.arm.conditioning, self.distance
        self.distance = conditioning(self.arm, self.q.tolist()) if kept else 0.0
        return min(1.0, self.distance / kept) if self.distance < before else 1.0

    def _accepted(self, correction: Floats) -> float:
        """Largest share of the planned speed at which the robot process accepts the next pose change of the
        running motion, found by HALVINGS bisections."""
        if self.hello.most is None or self._fits(1.0, correction):
            return 1.0
        low, high = SLOWEST, 1.0
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if self._fits(middle, correction) else (low, middle)
        return low

    def _fits(self, pace: float, correction: Floats) -> bool:
        """Whether the motion can go on at a share of its speed: the robot process accepts the tool displacement of the next period."""
        assert self.motion is not None
        place = self.motion.at(self.time + pace * self.period)
        q = self.kinematics.follow(place, self.q) if isinstance(place, Pose) else place
        if q is None:
            return True  # _command says what is wrong
        ahead = q + self.response.lead((q - self.q) / self.period)
        return self._fit(self._way(self.kinematics.forward(ahead)) + correction) >= 1.0

    def _fit(self, delta: Floats) -> float:
        """Largest share of a pose change (6,) that the robot process accepts in one period; above 1 if it
        would accept a larger change."""
        most = self.hello.most or (math.inf, math.inf)
        return min(m / max(float(np.linalg.norm(v)), 1e-12) for v, m in zip((delta[:3], delta[3:]), most, strict=True))

    def _way(self, target: Pose) -> Floats:
        """Displacement from the tool to a target (6,), base axes [m, rad]."""
        here = self.actual_tcp()
        return np.concatenate([np.subtract(target.position, here.position), here.rotate((here.inverse() * target).rotvec)])

    def _off(self) -> Floats:
        """Displacement from the tool to its last command (6,), base axes [m, rad]."""
        return self._way(self.kinematics.forward(self.q))

    def _check(self) -> None:
        for name, q, (low, high) in zip(self.arm.joints, self.state.joints, self.arm.limits, strict=True):
            if not low - BEYOND <= q <= high + BEYOND:
                raise ProtectiveStop(f"joint '{name}' is at {q:.3f} rad, outside {low:.3f} .. {high:.3f}")
        off = float(np.linalg.norm(self._off()[:3]))
        if off > ASTRAY:
            raise ProtectiveStop(f"the tool is {1000 * off:.0f} mm off its path, more than {1000 * ASTRAY:.0f} mm: the arm does not follow")

    def _arrived(self, share: float = 1.0) -> bool:
        """Whether the tool is at the end of its motion, within ``share`` times the robot's tolerance, and still will be
        when it has come to rest.

        Raises:
            ProtectiveStop: it is not, and had the time.
        """
        now, (near, straight) = self._off(), (share * t for t in self.hello.tolerance)
        glided = now + self.response.gliding(now)
        there = all(np.linalg.norm(off[:3]) <= near and np.linalg.norm(off[3:]) <= straight for off in (now, glided))
        self.late = 0.0 if there else self.late + self.period
        if self.late > ARRIVAL:
            off, turned = np.linalg.norm(now[:3]), np.linalg.norm(now[3:])
            raise ProtectiveStop(
                f"{ARRIVAL:g} s after it should be there, the tool is {1000 * off:.1f} mm and {turned:.3f} rad off its target, "
                f"more than {1000 * near:g} mm or {straight:g} rad"
            )
        return there

"""The virtual arm controller: it holds a commanded joint position, moves it, and monitors the arm.

It knows its nominal kinematics (the Denavit-Hartenberg table), the joint encoders, the wrist sensor and
the gripper, like a real one; it never reads where objects are. Control runs at 125 Hz over 4 physics steps of
2 ms (docs/explanation/simulation.md), with commands interpolated between.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np

from cramlite.model import GRAVITY, Disturbance, Floats, Pose
from cramlite.plugin import checkpoint

from ...kinematics.inverse import nearest_solution
from ..model.compile import divergence, unstable
from ..model.index import RobotIndex
from ..model.sleep import Sleep
from .arm_errors import ArmErrors
from .commanded_arm import CommandedArm
from .gripper_drive import GripperDrive
from .gripper_server import GripperServer
from .nominal_arm import cross
from .platform_drive import PlatformDrive
from .protective_stop import ProtectiveStop, Safety, SafetyWatch
from .trajectories import CircularMotion, LinearMotion, Motion
from .wrist_sensor import WristSensor

STEPS = 4  # physics steps of one control cycle
ABANDONED = 2.0  # deceleration of a motion whose thread was killed [m/s2 or rad/s2]


class Applied(NamedTuple):
    """Wrench of gripper and payload on their environment, as ``Rollout.wrench``: without the gripper's own
    weight, with the payload's, and not tared.

    Args:
        base: orientation of the arm's base (3, 3) in the world.
        flange: of the sensor (3, 3) in the base.
        weight, center: the gripper's own (3,) [N], and where it acts (3,) [m], sensor axes.
        reading: of the sensor (6,), the wrench of the wrist on the tool [N, Nm].
    """

    base: Floats
    flange: Floats
    weight: Floats
    center: Floats
    reading: Floats

    @property
    def strength(self) -> float:
        """Magnitude of the force of gripper and payload on their environment [N]; most cycles need nothing else."""
        return math.hypot(*(self.reading[:3] + self.weight).tolist())

    @property
    def wrench(self) -> Floats:
        """Wrench (6,) of gripper and payload on their environment, world axes, at the sensor [N, Nm]."""
        turn = self.base.dot(self.flange)
        torque = self.reading[3:] + cross(self.center, self.weight)
        return np.concatenate([turn.dot(self.reading[:3] + self.weight), turn.dot(torque)])


class Controller(CommandedArm):
    """Controller of an arm in a MuJoCo state: it moves arm and gripper, measures forces, and stops on violated limits.

    Args:
        model, data: MuJoCo's; settled, with the arm at rest.
        index: of the robot in the model.
        base: where the robot is bolted down, or its platform stands at first.
        noise, seed: of the wrist sensor.
        steps: physics steps of a control cycle; 1 is the 500 Hz of an e-Series controller.
        drive: what moves the gripper: itself, or with the registers of a make's server in front of it.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        index: RobotIndex,
        base: Pose,
        safety: Safety,
        noise: float = 0.0,
        seed: int = 0,
        steps: int = STEPS,
        drive: type[GripperDrive] = GripperServer,
    ) -> None:
        self.joints = adjacent(index.joints)
        super().__init__(index.robot, np.array(data.qpos[self.joints]), steps * float(model.opt.timestep))
        self.steps = steps
        self.model, self.data, self.index = model, data, index
        self.base = index.robot.arm_at(base)
        self.platform = PlatformDrive(model, data, index, base) if index.platform else None
        self.up = base.inverse().rotate((0.0, 0.0, 1.0))
        self.sensor = WristSensor(self.up, noise, seed)
        self.gripper: GripperDrive = drive(index.robot.gripper, index, model)
        self.gripper.begin_as(data)
        self.gripper_center = _gripper_center(model, data, index)
        self.servos, self.dofs = adjacent(index.actuators), adjacent(index.dofs)
        self.wrist = adjacent([first + k for first in (index.ft_force, index.ft_torque) for k in range(3)])
        self.shares = np.arange(1.0, steps + 1)[:, None] / steps
        self.ctrl, self.qpos, self.readings = data.ctrl, data.qpos, data.sensordata  # MuJoCo's own memory, looked up once
        self.efforts, self.diverged = data.actuator_force, divergence(data)
        self.lag = -model.actuator_biasprm[self.servos, 2] / model.actuator_gainprm[self.servos, 0]
        self.stiffness = model.actuator_gainprm[self.servos, 0].copy()
        torques = model.actuator_forcerange[self.servos, 1].copy()
        self.watch = SafetyWatch(safety, index.robot, torques, self.period)
        self.rate, self.nothing = np.zeros(len(self.q)), np.zeros(len(self.q))
        self.freedrive = False
        self.sleep: Sleep | None = None
        self.errors: ArmErrors | None = None
        self._wrench: Floats | None = None
        self._forget()

    def let_sleep(self) -> None:
        """Allow resting things to sleep from now on: MuJoCo leaves them out until something touches them."""
        self.sleep = Sleep(self.model, self.period)

    def disturb(self, off: Disturbance) -> None:
        """Add errors of joints, sensor and gripper that the controller does not know of.

        Errors of the links are in the MuJoCo model instead.
        """
        self.sensor.disturb(off)
        self.gripper.strength = off.gripper_force
        if off.latency or off.backlash or any(off.joint_zeros):
            self.errors = ArmErrors(off, self.q, self.period)
            self.q = self.actual_joints()
            self.nominal = self.kinematics.forward(self.q)
            self._forget()

    @property
    def gripper_server(self) -> GripperServer:
        """Return the gripper's registers.

        Raises:
            TypeError: it was made without.
        """
        if not isinstance(self.gripper, GripperServer):
            raise TypeError("the gripper of this controller has no GripperServer")
        return self.gripper

    # What a program asks for

    def set_tcp(self, tcp: Pose) -> None:
        """Set the tool centre point in the flange frame."""
        super().set_tcp(tcp)
        self._forget()

    def set_payload(self, mass: float, center: Floats) -> None:
        """Set the payload on the flange: mass [kg], centre of mass (3,) [m] in the flange frame."""
        self.sensor.mass, self.sensor.center = mass, center
        self._forget()

    # What it measures

    def actual_joints(self) -> Floats:
        """Return the joint positions (n,) [rad] that the encoders report to programs."""
        return np.array(self.qpos[self.joints]) if self.errors is None else self.errors.told

    def encoders(self) -> Floats:
        """Return the joint encoders (n,) [rad] as they are at this moment."""
        q = np.array(self.qpos[self.joints])
        return q if self.errors is None else self.errors.encoders(q)

    def actual_speeds(self) -> Floats:
        """Return the joint speeds (n,) [rad/s]."""
        return np.array(self.data.qvel[self.dofs])

    def joint_torques(self) -> Floats:
        """Return the joint torques (n,) of the servos beyond those that hold the arm's own weight [Nm]."""
        return np.array(self.efforts[self.servos])

    def actual_tcp(self) -> Pose:
        """Return the TCP in the base frame, from the encoders and the nominal kinematics."""
        self._measure()
        return Pose.from_matrix(self._flange @ self.kinematics.tcp)

    def tool_speed(self) -> Floats:
        """Return the commanded twist (6,) of the TCP, base axes [m/s, rad/s]."""
        return self.kinematics.speed(self.q, self.rate)

    def wrench(self) -> Floats:
        """Return the wrench (6,) of the environment on the tool, base axes, at the TCP [N, Nm]."""
        self._measure()
        if self._wrench is None:
            tcp = self._flange @ self.kinematics.tcp
            self._wrench = np.concatenate([self._felt, self.sensor.torque(self._flange, tcp, self._felt)])
        return self._wrench

    def force_vector(self) -> Floats:
        """Return the force part (3,) of ``wrench``, without the torque [N]."""
        self._measure()
        return self._felt

    def force(self) -> float:
        """Return the magnitude of the force of ``wrench`` [N]."""
        self._measure()
        return self._force

    def applied(self) -> Applied:
        """Return the wrench of gripper and payload on their environment."""
        self._measure()
        flange = self._flange[:3, :3]
        weight = self.up.dot(flange) * -(self.arm.gripper.mass * GRAVITY)
        return Applied(self.base.rotation, flange, weight, self.gripper_center, self.sensor.raw)

    def zero_sensor(self) -> None:
        """Tare the wrist sensor."""
        self._measure()
        self.sensor.zero(self._flange)
        self._forget()

    # One control cycle

    def cycle(self) -> None:
        """Advance the commanded joint positions by a control cycle, then the physics.

        Raises:
            ProtectiveStop: a limit of the safety configuration, or a target that cannot be followed.
        """
        motion = self.motion
        try:
            goal = self._goal()
            if goal is not self.q:
                self.watch.command(self.q, goal)
        except ProtectiveStop as stop:
            raise ProtectiveStop(f"{self._out_of_reach(motion)}{stop}") from None
        self._apply(goal)
        self._watch()

    def _out_of_reach(self, motion: Motion | None) -> str:
        """Reason why an arm stops on its way along a line or an arc if the end of the way is out of reach; ""
        if the end is within reach."""
        goal = motion.goal if isinstance(motion, LinearMotion | CircularMotion) else None
        if goal is None or nearest_solution(self.arm, goal, tuple(self.q)) is not None:
            return ""
        place = ", ".join(f"{v:.3f}" for v in goal.position)
        return f"the pose at ({place}) m that it moves to is out of reach, and on the way there: "

    def hold(self) -> None:
        """Advance a cycle without a program: a running motion is stopped, and nothing is monitored."""
        self.force_mode = None
        self.stop(ABANDONED)
        if self.platform is not None:
            self.platform.stop()
        try:
            self._apply(self._goal())
        except ProtectiveStop:  # the path cannot be followed any further
            self.motion = None
            self._apply(self.q)

    def _apply(self, goal: Floats) -> None:
        before, self.rate = self.q, (goal - self.q) / self.period
        self.q = goal
        self.gripper.advance(self.data, self.period)
        if self.platform is not None:
            self.platform.advance(self.period)
        self._physics(before)
        if self.sleep is not None:
            self.sleep.look(self.data)
        if self.platform is not None:
            self.base = self.arm.arm_at(self.platform.actual())

    def _goal(self) -> Floats:
        """Joint positions (n,) [rad] to command for the end of this cycle; for an arm that is led by hand
        those that its encoders report."""
        return self.encoders() if self.freedrive and self.motion is None else self._command()

    def _physics(self, before: Floats) -> None:
        """Run the physics steps of a cycle: interpolate commands, add the feed-forward of velocity and payload,
        and average the sensor."""
        checkpoint(float(self.data.time))
        model, data, ctrl, servos, platform = self.model, self.data, self.ctrl, self.servos, self.platform
        readings, wrist, mj_step = self.readings, self.wrist, mujoco.mj_step
        forward_fed = self.lag * self.rate + self._payload()
        goal = self.q
        if self.errors is not None:
            before, goal = self.errors.behind + self.errors.zeros, self.errors.moved(goal)
        reading = np.zeros(6)
        for k, command in enumerate(before + self.shares * (goal - before) + forward_fed, 1):
            ctrl[servos] = command
            if platform is not None:
                platform.apply(k / self.steps)
            mj_step(model, data)
            reading += readings[wrist]
        reading /= self.steps
        if self.errors is not None:
            reading = self.errors.measured(self.encoders(), reading)
        self.sensor.feed(reading, self.period)
        self._forget()

    def _payload(self) -> Floats:
        """Servo offset (n,) [rad] that makes up for the weight of the payload that the program stated, less
        the gripper's mass."""
        mass = self.sensor.mass - self.arm.gripper.mass
        if abs(mass) < 1e-3:
            return self.nothing
        return np.asarray(self.kinematics.lift(self.q, self.sensor.center, self.up * mass * GRAVITY) / self.stiffness)

    def _watch(self) -> None:
        if reason := unstable(self.diverged):
            raise ProtectiveStop(reason)
        error = self.q - (self.qpos[self.joints] if self.errors is None else self.errors.now)
        late = self.platform.late() if self.platform is not None else ""
        self.watch.cycle(self.force(), self.efforts[self.servos], error, late)

    def _forget(self) -> None:
        self._measured = False

    def _measure(self) -> None:
        """Measure pose and force once in a control cycle; further calls in the cycle keep these values."""
        if self._measured:
            return
        self._flange = self.kinematics.flange(self.actual_joints())
        self._felt = self.sensor.force(self._flange)
        self._force = math.hypot(*self._felt.tolist())
        self._wrench = None
        self._measured = True


def adjacent(addresses: Sequence[int]) -> slice | list[int]:
    """Return consecutive array indices as a slice, with which NumPy indexes three times as fast; others as a
    list."""
    first, count = addresses[0], len(addresses)
    return slice(first, first + count) if list(addresses) == list(range(first, first + count)) else list(addresses)


def _gripper_center(model: Any, data: Any, index: RobotIndex) -> Floats:
    """Centre of mass of the gripper in the sensor's frame [m], fingers open."""
    bodies = list(index.bodies)
    mass = model.body_mass[bodies]
    center = mass @ data.xipos[bodies] / mass.sum() - data.site_xpos[index.ft]
    return np.asarray(data.site_xmat[index.ft].reshape(3, 3).T @ center)

"""The arm as programs command it: motions on nominal kinematics, with force mode superposed.

Who carries the commands out is the subclass's: the physics of a world (``controller``), or another process.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from operator import sub

from msgspec.structs import replace

from cramlite.model import Floats, Pose, Robot, Vector3

from .force_mode import ForceMode
from .gripper_order import GripperOrder
from .movep import process_motion
from .nominal_arm import NominalArm
from .platform_drive import PlatformDrive
from .protective_stop import ProtectiveStop
from .trajectories import (
    Motion,
    StoppingMotion,
    blended_motion,
    circular_motion,
    joint_motion,
    linear_motion,
    stopping_motion,
)

NO_WAY = 1e-6
"""Largest difference, along any axis and about any, between two poses that count as the same [m, rad]."""


class CommandedArm(ABC):
    """Arm that executes one motion at a time, each command a joint position at the end of a control cycle.

    Args:
        robot: its description.
        q: where it is commanded to be at first (n,) [rad].
        period: of a control cycle [s].
    """

    gripper: GripperOrder
    carries = False
    """Whether the robot compensates the payload by itself, so that to state the payload takes no time."""
    settling = 0.3
    """How long the arm stands still before its force sensor is tared [s]: the sensor's filter and the arm settle."""

    def __init__(self, robot: Robot, q: Floats, period: float) -> None:
        self.arm, self.kinematics = robot, NominalArm(robot)
        self.platform: PlatformDrive | None = None
        self.period = period
        self.q = q
        self.motion: Motion | None = None
        self.time = 0.0
        self.pace = 1.0  # of motions: a share of the speed that they were planned with
        self.force_mode: ForceMode | None = None
        self.force_gain = 1.0
        self.leads_on = False
        """Whether the next step is a transfer or a guarded motion, so that a straight line ends in free space and not at a contact."""
        self.nominal = self.kinematics.forward(self.q)

    # What it measures

    @abstractmethod
    def actual_joints(self) -> Floats:
        """Return the joint positions (n,) [rad] that the encoders report to programs."""

    @abstractmethod
    def actual_tcp(self) -> Pose:
        """Return the TCP in the base frame, from the encoders and the nominal kinematics."""

    @abstractmethod
    def wrench(self) -> Floats:
        """Return the wrench (6,) of the environment on the tool, base axes, at the TCP [N, Nm]."""

    @abstractmethod
    def force_vector(self) -> Floats:
        """Return the force part (3,) of ``wrench``, without the torque [N]."""

    @abstractmethod
    def force(self) -> float:
        """Return the magnitude of the force of ``wrench`` [N]."""

    @abstractmethod
    def zero_sensor(self) -> None:
        """Tare the wrist sensor."""

    # What a program asks for

    @abstractmethod
    def set_payload(self, mass: float, center: Floats) -> None:
        """Set the payload on the flange: mass [kg], centre of mass (3,) [m] in the flange frame."""

    def set_tcp(self, tcp: Pose) -> None:
        """Set the tool centre point in the flange frame."""
        self.arm = replace(self.arm, gripper=replace(self.arm.gripper, tcp=tcp))
        self.kinematics = NominalArm(self.arm)
        self.nominal = self.kinematics.forward(self.q)

    def move_joints(self, goal: Floats, speed: float, acceleration: float) -> Motion:
        """Start a movej to joint positions (n,) [rad, rad/s, rad/s2]; in force mode compliant axes deviate from it."""
        return self._begin(joint_motion(self.q, goal, speed, acceleration))

    def move_along(self, goals: list[Floats], radii: list[float], rates: list[tuple[float, float]]) -> Motion:
        """Start several movej that blend into one another; ``radii`` [m] are those of all goals but the last.

        Raises:
            ValueError: a radius takes more than half of a motion.
        """
        points = [self.q.copy(), *goals]
        return self._begin(blended_motion(points, radii, rates, lambda q: self.kinematics.place(q)))

    def move_linear(self, goal: Pose, speed: float, acceleration: float) -> Motion:
        """Start a straight motion of the TCP (movel) to a pose, at a speed [m/s] and an acceleration [m/s2].

        In force mode it starts at the nominal end of the last motion, without the deviation of force mode.
        """
        return self._begin(linear_motion(self._start(), goal, speed, acceleration))

    def move_process(self, goals: list[Pose], radii: list[float], speed: float, acceleration: float) -> Motion:
        """Start several movep that blend into one another; ``radii`` [m] are those of all goals but the last.

        A goal at which the tool is already when its turn comes is left out.

        Raises:
            ValueError: the tool turns on the spot, a radius takes more than half of a line, or the way turns straight back.
        """
        start = self._start()
        poses, kept = [start], list[float]()
        for goal, radius in zip(goals, (*radii, 0.0), strict=True):
            if max(map(abs, (*map(sub, goal.position, poses[-1].position), *(poses[-1].inverse() * goal).rotvec))) > NO_WAY:
                poses, kept = [*poses, goal], [*kept, radius]
        if len(poses) == 1:
            return self._begin(linear_motion(start, start, speed, acceleration))
        return self._begin(process_motion(poses, kept[:-1], speed, acceleration))

    def move_circular(self, via: Vector3, goal: Pose, speed: float, acceleration: float, fixed: bool) -> Motion:
        """Start a movec [m/s, m/s2] over the position ``via``; ``fixed`` keeps the tool's orientation to the tangent.

        Raises:
            ValueError: no circle goes through start, ``via`` and goal.
        """
        return self._begin(circular_motion(self._start(), via, goal, speed, acceleration, fixed))

    def path_length(self, goal: Pose) -> float:
        """Compute the path length of a movel [m]: the distance, or ``RADIAN`` times the angle of its rotation
        if that is longer."""
        return linear_motion(self._start(), goal, 1.0, 1.0).way

    def _start(self) -> Pose:
        return self.nominal if self.force_mode else self.kinematics.forward(self.q)

    def follow(self, motion: Motion) -> Motion:
        """Start a motion that the caller has planned, such as a speedj, from where the arm is now."""
        return self._begin(motion)

    def stop(self, deceleration: float) -> Motion | None:
        """Stop the running motion on its own path, with a deceleration in m/s2 or rad/s2, whichever the motion uses."""
        if self.motion is None or isinstance(self.motion, StoppingMotion):
            return self.motion
        return self._begin(stopping_motion(self.motion, self.time, deceleration))

    def start_force_mode(self, mode: ForceMode) -> None:
        """Switch force mode on; if it was on, the arm's present offset from its commanded path is kept."""
        if self.force_mode is None:
            self.nominal = self.kinematics.forward(self.q)
        else:
            mode.offset = self.force_mode.offset
        self.force_mode = mode

    def end_force_mode(self) -> None:
        """Switch force mode off: the arm stays where it is."""
        if self.force_mode is not None:
            self.force_mode, self.motion = None, None

    # One control cycle

    def _begin(self, motion: Motion) -> Motion:
        self.motion, self.time = motion, 0.0
        return motion

    def _command(self) -> Floats:
        """Joint positions (n,) [rad] to command for the end of this control cycle."""
        place: Floats | Pose | None = None
        if self.motion is not None:
            self.time += self.pace * self.period
            place = self.motion.at(self.time)
            if self.time >= self.motion.duration:
                self.motion = None
        if self.force_mode is None:
            return self.q if place is None else self._inverse(place) if isinstance(place, Pose) else place
        if place is not None:
            self.nominal = place if isinstance(place, Pose) else self.kinematics.forward(place)
        self.force_mode.advance(-self.wrench(), self.period, self.force_gain)
        return self._inverse(self.force_mode.target(self.nominal))

    def _inverse(self, target: Pose) -> Floats:
        found = self.kinematics.follow(target, self.q)
        if found is None:
            place = ", ".join(f"{v:.3f}" for v in target.position)
            raise ProtectiveStop(f"no inverse kinematics for the TCP at ({place}) m: out of reach or singular")
        return found

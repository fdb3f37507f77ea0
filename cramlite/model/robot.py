"""What a robot plugin declares: kinematics, limits, gripper and model."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ..base.value import Value
from .geometry import Pose

if TYPE_CHECKING:
    from .world import RobotMount


class Gripper(Value):
    """A parallel gripper.

    Args:
        type: e.g. "robotiq_2f85".
        opening: smallest and largest distance between the pads [m].
        pad: pad width (across the closing direction) and length (along the fingers) [m].
        depth: from the pinch point back to the palm [m]: how deep an object may reach into the hand.
        mass: [kg].
        tcp: the pinch point in the flange frame; tcp z is the approach direction, tcp y the closing direction.
        force: lowest and highest grip force that can be commanded [N].
        speed: lowest and highest speed of the pads towards each other that can be commanded [m/s].
    """

    type: str
    opening: tuple[float, float]
    pad: tuple[float, float]
    depth: float
    mass: float
    tcp: Pose
    force: tuple[float, float]
    speed: tuple[float, float]


class Platform(Value):
    """A mobile base that carries an arm: it drives on the floor in any direction, and turns.

    Its frame is in the middle of it on the floor, x forwards, z up.

    Args:
        body: its name in the model.
        joints: names of the joints in the model, and of their position actuators: x and y [m], then the turn about z
            [rad], of the frame in the one where the model was put.
        arm: where the arm's base is on it.
        size: length, width and height [m].
        speed: highest [m/s, rad/s].
        acceleration: highest [m/s2, rad/s2].
    """

    body: str
    joints: tuple[str, str, str]
    arm: Pose
    size: tuple[float, float, float]
    speed: tuple[float, float]
    acceleration: tuple[float, float]


class Robot(Value):
    """A robot arm with its gripper.

    Args:
        type: the name that scenarios use, e.g. "ur5e".
        joints: joint names, base to flange.
        dh: rows (a, d, alpha) of the standard Denavit-Hartenberg parameters, T = Rz(q) Tz(d) Tx(a) Rx(alpha)
            [m, rad]; None for arms without.
        limits: (lower, upper) of each joint [rad].
        velocity, acceleration: of each joint, used for timing and as validator limits [rad/s, rad/s2].
        home: a parked joint position [rad].
        reach: from the base axis to the flange [m].
        payload: [kg], gripper included.
        gripper: what is bolted to the flange.
        sensor: where the force-torque sensor is, e.g. "flange", "axia80"; None if there is none.
        backend: who writes its programs, by backend name: its native language, where there is one.
        mjcf: returns the model of arm and gripper as MJCF text. Names in it: joints and position actuators as in
            ``joints``; bodies as the links; actuator "gripper" (0 open .. 255 closed); sites "flange", "tcp", "ft";
            sensors "ft_force", "ft_torque"; pad geoms "left_pad*" and "right_pad*".
        platform: what drives the arm around; None for one that is bolted down.
    """

    type: str
    joints: tuple[str, ...]
    dh: tuple[tuple[float, float, float], ...] | None
    limits: tuple[tuple[float, float], ...]
    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    home: tuple[float, ...]
    reach: float
    payload: float
    gripper: Gripper
    sensor: str | None
    backend: str
    mjcf: Callable[[], str]
    platform: Platform | None = None

    def start(self, mount: RobotMount) -> tuple[tuple[float, ...], float]:
        """Joints and opening of the gripper at the start, where the robot is mounted: at home and open, else as the mount says."""
        return mount.joints or self.home, self.gripper.opening[1] if mount.opening is None else mount.opening

    def arm_at(self, stand: Pose) -> Pose:
        """Where the arm's base is in the world when the robot stands somewhere: a platform's frame, or the arm itself."""
        return stand * self.platform.arm if self.platform else stand

    def stand_of(self, arm: Pose) -> Pose:
        """The inverse of ``arm_at``."""
        return arm * self.platform.arm.inverse() if self.platform else arm

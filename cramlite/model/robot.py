"""Robot models, as plugins declare them: kinematics, limits, gripper and MJCF."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from ..base.value import Value
from .geometry import Pose
from .linkage import Linkage
from .sensor_errors import SensorErrors

if TYPE_CHECKING:
    from .world.world import RobotMount

FORCE_LIMIT, HIGHEST_FORCE_LIMIT, FASTEST = 60.0, 150.0, 5.0
"""Protective limit on the TCP force where nobody declares another, and the highest that may be declared [N]. The first is
ours: force-controlled steps stop at 25 N, jammed ones reached 31 N in simulation. The second is the safety configuration of the
controller model (docs/reference/robot_code.md)."""
WRIST_TURN = math.radians(150)
"""Largest turn of a wrist in one grasp [rad]. A wrist with a range of 330 deg can turn so far from at least one of the two ways in which
a symmetric gripper takes a grasp."""


class Gripper(Value):
    """Parallel gripper.

    Args:
        type: e.g. "robotiq_2f85".
        opening: smallest and largest distance between the pads [m].
        pad: pad width (across the closing direction) and length (along the fingers) [m].
        depth: from the pinch point back to the palm [m]: how deep an object may reach into the hand.
        mass: [kg].
        tcp: the pinch point in the flange frame; tcp z is the approach direction, tcp y the closing direction.
        force: lowest and highest grip force that can be commanded [N].
        speed: lowest and highest speed of the pads towards each other that can be commanded [m/s].
        linkage: what moves the pads, where the model is that of a file; None for two slides that share the opening, which the
            actuator "gripper" closes (0 open .. 255 closed).
        friction: sliding friction coefficient of the pads, where the model's file states it; None leaves it to the world's physics.
    """

    type: str
    opening: tuple[float, float]
    pad: tuple[float, float]
    depth: float
    mass: float
    tcp: Pose
    force: tuple[float, float]
    speed: tuple[float, float]
    linkage: Linkage | None = None
    friction: float | None = None


class Platform(Value):
    """Omnidirectional mobile base that carries an arm.

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
    """Robot arm with its gripper.

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
        axis_zeros: angle of each joint, as ``joints`` and ``dh`` count it, at which the maker counts zero [rad]; a backend whose
            language takes the maker's angles subtracts it. None where nobody needs it: such a backend then refuses the robot.
        controller: generation of its controller, in the words of the backend that writes for it, e.g. "CB3", "e-Series"; "" where
            no backend asks.
        force_limit: protective limit on the TCP force of its programs, unless a scenario sets another [N], up to
            ``HIGHEST_FORCE_LIMIT``.
        sensor_errors: of its force-torque sensor: what proofs under doubt reckon with.
        pace: how many times as fast as by default it moves where it touches nothing, and lowers what it holds; 2.5 is 0.25 m/s on
            straight lines, the reduced speed of ISO 10218, and 25 mm/s until contact.
        posture: joint position that its own controller holds as nearly as the pose of the tool allows (weighted by inertia) [rad], where it
            is the tool that it leads, and not the joints; None where programs command the joints.
        conditioning: the smallest singular value of the Jacobian at the TCP, lengths in units of ``reach``, that it keeps where it stops
            and on straight lines. More than 0 for an arm whose controller leads the tool: it comes through a singularity, as with the arm
            stretched, with another posture than it was planned with. One with a self-motion keeps it along that, too.
        root: frame 0 of ``dh`` in the base frame, which is level: not at its origin, or leaning, where the first axis is or does.
        rotors: inertia of each joint's motor behind its gear, as the controller of an arm with a ``posture`` counts
            it [kg m2]; empty where that is what ``mjcf`` says.
        looks: returns what cameras see of it as MJCF text, with the names of ``mjcf``; None where that is the same.

    Raises:
        ValueError: ``axis_zeros`` is not a finite angle for each joint, ``rotors`` not an inertia for each, or
            ``force_limit``, ``pace`` or ``conditioning`` is out of its range.
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
    axis_zeros: tuple[float, ...] | None = None
    controller: str = ""
    force_limit: float = FORCE_LIMIT
    sensor_errors: SensorErrors = SensorErrors()
    pace: float = 1.0
    posture: tuple[float, ...] | None = None
    conditioning: float = 0.0
    root: Pose = Pose()
    rotors: tuple[float, ...] = ()
    looks: Callable[[], str] | None = None

    def __post_init__(self) -> None:
        zeros = self.axis_zeros
        if zeros is not None and (len(zeros) != len(self.joints) or not all(map(math.isfinite, zeros))):
            raise ValueError(f"robot '{self.type}': axis_zeros is a finite angle for each of {len(self.joints)} joints, not {zeros}")
        if self.rotors and not (len(self.rotors) == len(self.joints) and all(0 <= v < math.inf for v in self.rotors)):
            raise ValueError(f"robot '{self.type}': rotors is an inertia for each of {len(self.joints)} joints, not {self.rotors}")
        if not 0 < self.force_limit <= HIGHEST_FORCE_LIMIT:
            raise ValueError(f"robot '{self.type}': force_limit {self.force_limit:g} N is not in 0 .. {HIGHEST_FORCE_LIMIT:g} N")
        if not 0 < self.pace <= FASTEST:
            raise ValueError(f"robot '{self.type}': pace {self.pace:g} is not in 0 .. {FASTEST:g}")
        if not 0 <= self.conditioning < 1:
            raise ValueError(f"robot '{self.type}': conditioning {self.conditioning:g} is not in 0 .. 1")

    def start(self, mount: RobotMount) -> tuple[tuple[float, ...], float]:
        """Return the joint position [rad] and the gripper's opening [m] at the start of a run: as ``mount`` states,
        else the home position and the open gripper."""
        return mount.joints or self.home, self.gripper.opening[1] if mount.opening is None else mount.opening

    def arm_at(self, stand: Pose) -> Pose:
        """Return the pose of the arm's base in the world from where the robot stands: the pose of its
        platform, or of the arm itself."""
        return stand * self.platform.arm if self.platform else stand

    def stand_of(self, arm: Pose) -> Pose:
        """Return where the robot stands, given the pose of the arm's base in the world: the inverse of ``arm_at``."""
        return arm * self.platform.arm.inverse() if self.platform else arm

"""World models: things, the robots among them, cameras, and the settings of physics.

A world is what a scenario describes, what a simulator compiles, and, written as
JSON, the world file that a controller process is given beside a program.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from msgspec import field
from msgspec.structs import replace

from ...base.value import Value
from ..entity_name import EntityName
from ..fault import Fault
from ..geometry import Pose, Vector3
from ..robot_file import RobotFile
from ..view import D435, Intrinsics
from .thing import Feature, Thing

GRAVITY = 9.81
"""Gravitational acceleration in every world [m/s^2]: MuJoCo's default, which worlds do not change."""


class InHand(Value):
    """Payload of a robot at the start of a run.

    Args:
        thing: its name.
        tcp_to_thing: its pose in the frame of the tool centre point.
        force: that each pad is ordered to press with [N].
    """

    thing: str
    tcp_to_thing: Pose
    force: float


class RobotMount(Value):
    """Robot in a world: which model, and where it is mounted.

    Args:
        name: of the mount, unique in the world.
        type: of the robot, as a plugin declares it.
        base: its base frame in the world.
        joints: where the arm stands at the start [rad]; empty for its home posture.
        opening: of its gripper at the start [m]; None for open.
        file: that the robot comes from, where no plugin declares its type.
        holds: what is in its hand at the start, whose pose in the world agrees; None for nothing.
    """

    name: str
    type: str
    base: Pose = Pose()
    joints: tuple[float, ...] = ()
    opening: float | None = None
    file: RobotFile | None = None
    holds: InHand | None = None


class Physics(Value):
    """Physics settings of the simulation, which scenarios may change.

    Negative controls, which are scenarios that must fail, use other ones.

    Defaults and their measured reasons: docs/explanation/simulation.md.

    Args:
        timestep: of the simulation [s].
        cone: of friction, as MuJoCo names it.
        noslip_iterations: of MuJoCo's no-slip solver.
        impratio: friction to normal impedance.
        pad_friction: sliding friction coefficient of the fingers.
    """

    timestep: float = 0.002
    cone: Literal["elliptic", "pyramidal"] = "elliptic"
    noslip_iterations: int = 5
    impratio: float = 10.0
    pad_friction: float = 0.9


class Disturbance(Value):
    """Errors of a real robot that the robot model used in planning lacks; drawn by cramlite/scenario/twin.py,
    applied by the simulator.

    Args:
        force_noise: standard deviation of each raw reading of the wrist sensor [N]; torques get a twentieth [Nm].
        force_bias: what its zero is off, sensor axes [N]; a tare takes it away.
        force_turning: what it reads as if it were weight, base axes [N]: a tare takes it away until the wrist turns.
        force_drift: how fast its zero wanders, sensor axes [N/s].
        latency: from a measurement to what the program and force mode are told [s].
        links: displacement of each link of the first robot from its nominal place [m].
        joint_zeros: what each joint really stands at, less what its encoder says [rad].
        backlash: width of each joint's play, behind its encoder [rad].
        gripper_force: real grip force as a multiple of the commanded one.
        centres: thing -> how far its centre of mass is from where its shape, or its inertia, has it, in its frame [m].
        flange_mass: what the flange bears beside its gripper, and nobody tells [kg].
        tool: how far the gripper is mounted from where it should be, in the flange's frame [m].
    """

    force_noise: float = 0.0
    force_bias: Vector3 = (0.0, 0.0, 0.0)
    force_turning: Vector3 = (0.0, 0.0, 0.0)
    force_drift: Vector3 = (0.0, 0.0, 0.0)
    latency: float = 0.0
    links: tuple[Vector3, ...] = ()
    joint_zeros: tuple[float, ...] = ()
    backlash: float = 0.0
    gripper_force: float = 1.0
    centres: Mapping[str, Vector3] = field(default_factory=dict)
    flange_mass: float = 0.0
    tool: Vector3 = (0.0, 0.0, 0.0)


class Camera(Value):
    """Depth camera.

    Args:
        pose: its optical frame (z forward, x right, y down) in the world, or in the flange frame of ``mount``.
        mount: the robot whose flange it is on; None for one that is fixed.
        joints: of that robot when it looks [rad].
        intrinsics: of its image.
        noise: errors of its depth and colour, times those of a D435; 0 for none.
        checks: when pictures of an executed program are compared with its proof: never ("none"), at rest ("end"), or after each
            task and at rest ("tasks").
    """

    pose: Pose
    mount: str | None = None
    joints: tuple[float, ...] = ()
    intrinsics: Intrinsics = D435
    noise: float = 1.0
    checks: Literal["none", "end", "tasks"] = "none"

    @property
    def name(self) -> str:
        """Name of the camera in runs and episodes; no thing may have this name."""
        return str(EntityName(self.mount or "world", "camera"))


class World(Value):
    """World model: all that a simulator needs to know of a scene, and nothing of how a task in it is solved.

    Args:
        things: furniture before what stands on it.
        robots: the first one acts.
        physics: settings of the simulation.
        disturbance: what a real robot has and a planned one has not.
        cameras: depth cameras, fixed ones and those on flanges.
        poses: "camera" where nobody knows of anything that can be moved where it is, until a camera has seen it.
        notes: what of a scene file could not be taken over, for people.
        faults: that happen while a program runs.
    """

    things: tuple[Thing, ...]
    robots: tuple[RobotMount, ...] = ()
    physics: Physics = Physics()
    disturbance: Disturbance = Disturbance()
    cameras: tuple[Camera, ...] = ()
    poses: Literal["known", "camera"] = "known"
    notes: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()

    def thing(self, name: str) -> Thing:
        """Return the thing with a given name.

        Raises:
            KeyError: there is none; the message lists those there are.
        """
        for thing in self.things:
            if thing.name == name:
                return thing
        raise KeyError(f"no thing '{name}' in the world; there are: {', '.join(t.name for t in self.things)}")

    def mounted_on(self, name: str) -> tuple[Thing, ...]:
        """Return the things on joints that move along with a thing on a joint, such as the lever of a door."""
        if self.thing(name).joint is None:
            return ()
        return tuple(t for t in self.things if t.joint is not None and t.joint.parent == name)

    def features_of(self, name: str) -> tuple[Feature, ...]:
        """Return the features of a thing, then those of the things that are mounted on it by joints and move along
        with it."""
        return tuple(f for t in (self.thing(name), *self.mounted_on(name)) for f in t.features)

    def carrier_shift(self, name: str, poses: Mapping[str, Pose]) -> Pose:
        """Return the displacement, in the world frame, of the body in which a thing on a joint is mounted; the
        identity if no such body has moved.

        Args:
            poses: of things now, in the world frame.
        """
        joint = self.thing(name).joint
        if joint is None or joint.parent not in poses:
            return Pose()
        return poses[joint.parent] * self.thing(joint.parent).pose.inverse()

    def put(self, poses: Mapping[str, Pose]) -> World:
        """Return the world with some things at other poses, and joint values that agree with them."""
        things = (t.moved_to(poses[t.name], self.carrier_shift(t.name, poses)) if t.name in poses else t for t in self.things)
        return replace(self, things=tuple(things))

    def moved(self, poses: dict[str, Pose]) -> World:
        """Return the world with some things at other poses."""
        return replace(self, things=tuple(replace(t, pose=poses[t.name]) if t.name in poses else t for t in self.things))

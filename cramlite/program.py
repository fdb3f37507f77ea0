"""A typed robot program: the steps that backends turn into code.

All lengths are metres, angles radians, times seconds, forces newtons. Cartesian
targets are poses of the tool centre point (TCP) in the robot's base frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from .geometry import Pose, Vector3

Joints = tuple[float, ...]


@dataclass(frozen=True)
class Step:
    """Common to all steps.

    Args:
        origin: the designator that this step grounds, e.g. "3.Grasping/approach"; a code line leads back to it.
        comment: one clause for the reader of the code.
    """

    origin: str = field(default="", kw_only=True)
    comment: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class MoveJoints(Step):
    """Joint-space motion through via points, stopping at each; the path was checked as straight joint-space lines.

    Args:
        path: one or more joint positions, the start excluded [rad].
        speed, acceleration: of the leading axis [rad/s, rad/s2].
    """

    path: tuple[Joints, ...]
    speed: float
    acceleration: float


@dataclass(frozen=True)
class MoveLinear(Step):
    """Straight TCP motion. ``joints`` is the inverse solution at the target, for checks.

    Args:
        target: TCP in base.
        speed, acceleration: of the TCP [m/s, m/s2].
    """

    target: Pose
    speed: float
    acceleration: float
    joints: Joints = ()


@dataclass(frozen=True)
class MoveUntilContact(Step):
    """Straight TCP motion that ends on contact: guarded motion.

    Args:
        direction: unit vector, base frame.
        speed: <= 0.02 m/s, where inertial forces stay below the threshold (docs/explanation/simulation.md).
        force: contact is found when the reaction along ``direction`` exceeds this [N].
        distance: how far to go at most [m].
        expect: "contact": not finding one is an error; "any": both ends are fine.
        timeout: [s].
        joints: inverse solution at the far end, for checks.
    """

    direction: Vector3
    speed: float
    force: float
    distance: float
    timeout: float
    expect: Literal["contact", "any"] = "contact"
    joints: Joints = ()


@dataclass(frozen=True)
class ForceMove(Step):
    """Straight TCP motion along waypoints while some axes comply: force mode around linear motion.

    Args:
        waypoints: TCP in base.
        frame: orientation of the compliance frame in base (its position is ignored).
        compliant: which of x, y, z, rx, ry, rz of ``frame`` comply.
        wrench: target force on the compliant axes [N, Nm], what the robot applies.
        limits: compliant axes: highest TCP speed [m/s, rad/s]; others: highest deviation [m, rad].
        speed: along the path [m/s].
        force_limit: abort when the force magnitude exceeds this [N].
        timeout: [s].
        joints: inverse solution at the last waypoint, for checks.
    """

    waypoints: tuple[Pose, ...]
    frame: Pose
    compliant: tuple[bool, bool, bool, bool, bool, bool]
    wrench: tuple[float, float, float, float, float, float]
    limits: tuple[float, float, float, float, float, float]
    speed: float
    force_limit: float
    timeout: float
    joints: Joints = ()


@dataclass(frozen=True)
class SpiralSearch(Step):
    """Look for an opening by touch: press along an axis and move across it on an Archimedean spiral until it gives way,
    or until a rim holds it: a force across of more than twice ``force``, which the friction of no face explains.

    Aborts when the spiral ends, the force limit is exceeded or the time is over without that.

    Args:
        frame: orientation of the search in base (its position is ignored); z is the direction of pressing.
        force: pressed with [N].
        pitch: between neighbouring turns [m]; at most the play of what is searched for.
        radius: of the last turn [m].
        speed: along the spiral [m/s].
        advance: along z, from the start of the search, that means that the opening was found [m].
        force_limit: abort when the force magnitude exceeds this [N].
        timeout: [s].
        joints: inverse solution at the middle, for checks.
    """

    frame: Pose
    force: float
    pitch: float
    radius: float
    speed: float
    advance: float
    force_limit: float
    timeout: float
    joints: Joints = ()


@dataclass(frozen=True)
class ForceInsert(Step):
    """Push along an axis with a force, giving way sideways, until a depth is reached.

    Nothing is commanded but forces: what guides the tool is what it is pushed along. Aborts when the force limit is
    exceeded or the depth is not reached in time (something jams).

    Args:
        frame: orientation in base (its position is ignored); z is the direction of pushing.
        force: pushed with [N].
        depth: along z, from where it starts [m].
        speed: highest TCP speed on each axis [m/s].
        force_limit: abort when the force magnitude exceeds this [N].
        timeout: [s].
        joints: inverse solution at the end, for checks.
    """

    frame: Pose
    force: float
    depth: float
    speed: float
    force_limit: float
    timeout: float
    joints: Joints = ()


@dataclass(frozen=True)
class SetGripper(Step):
    """Move the gripper and wait.

    Args:
        opening: distance between the pads to go to [m].
        speed: of the pads [m/s].
        force: grip force [N].
        expect: "object": stopping before ``opening`` on an object is required; "none": reaching it is; "any".
        timeout: [s].
    """

    opening: float
    speed: float
    force: float
    expect: Literal["object", "none", "any"] = "any"
    timeout: float = 3.0


@dataclass(frozen=True)
class SetPayload(Step):
    """Tell the controller what hangs on the flange (gripper and object): mass [kg], centre of gravity in the flange frame [m]."""

    mass: float
    center: Vector3


@dataclass(frozen=True)
class ZeroSensor(Step):
    """Tare the force-torque sensor; the arm must stand still."""


@dataclass(frozen=True)
class Wait(Step):
    """Stand still [s]."""

    duration: float


AnyStep = (
    MoveJoints
    | MoveLinear
    | MoveUntilContact
    | ForceMove
    | SpiralSearch
    | ForceInsert
    | SetGripper
    | SetPayload
    | ZeroSensor
    | Wait
)


@dataclass(frozen=True)
class Section:
    """The steps of one task: ``steps`` [first, last).

    Args:
        task: the task designator's name, e.g. "3.Grasping".
        title: what it does in words, with the grounded objects.
    """

    task: str
    title: str
    first: int
    last: int


@dataclass(frozen=True)
class Snapshot:
    """A pose that the program relies on: snapshot mode states each in the code's header.

    Args:
        thing: name in the robot's world.
        pose: in the robot's base frame.
        source: who said so, e.g. "known from the scenario".
        age: [s] at planning.
    """

    thing: str
    pose: Pose
    source: str
    age: float = 0.0


@dataclass(frozen=True)
class Program:
    """A program for one robot.

    Args:
        name: an identifier, used as the name of the code's function.
        robot: the mount's name in the world.
        robot_type: e.g. "ur5e".
        tcp: pinch point in the flange frame.
        start: joint position it must be started from [rad].
        steps, sections: in order of execution.
        snapshots: poses that were bound at plan time.
        force_limit: protective limit on the TCP force over the whole program [N].
        mass, center: the gripper's payload [kg, m in the flange frame].
    """

    name: str
    robot: str
    robot_type: str
    tcp: Pose
    start: Joints
    steps: tuple[AnyStep, ...]
    sections: tuple[Section, ...]
    snapshots: tuple[Snapshot, ...] = ()
    force_limit: float = 60.0
    mass: float = 0.0
    center: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Code:
    """A program's text.

    Args:
        language: e.g. "urscript".
        text: what a robot is given.
        origins: line (from 1) -> origin of the step it came from.
        suffix: of its file, e.g. ".script".
    """

    language: str
    text: str
    origins: dict[int, str]
    suffix: str

    def task_of(self, line: int) -> str:
        """The task whose code the line is in: the last origin at or before it."""
        before = [k for k in self.origins if k <= line]
        return self.origins[max(before)].split("/")[0] if before else ""

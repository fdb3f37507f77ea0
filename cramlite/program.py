"""A typed robot program: the steps that backends turn into code.

All lengths are metres, angles radians, times seconds, forces newtons. Cartesian
targets are poses of the tool centre point (TCP) in the frame of the arm's base, wherever
a platform has driven it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

from .force_steps import CompliantSlide, ForceExtract, ForceInsert, ForceMove, MoveUntilContact, SpiralSearch
from .geometry import Pose, Vector3
from .step import Joints, Step
from .value import Value

__all__ = [
    "AnyStep", "CompliantSlide", "Control", "Drive", "ForceExtract", "ForceInsert", "ForceMove", "Joints", "LatePose", "Monitor",
    "MoveJoints", "MoveLinear", "MoveUntilContact", "Parallel", "Program", "Repeat", "Section", "SetGripper",
    "SetPayload", "Snapshot", "SpiralSearch", "Step", "TryInOrder", "Wait", "ZeroSensor", "branches", "clash",
    "uses_arm", "walk",
]  # fmt: skip


class MoveJoints(Step):
    """Joint-space motion through via points; the path was checked as straight joint-space lines with rounded corners.

    Args:
        path: one or more joint positions, the start excluded [rad].
        speed, acceleration: of the leading axis [rad/s, rad/s2].
        radii: for each point but the last, how far from it the TCP may leave the lines to round the corner [m]; 0 is
            a stop. Empty: it stops at all of them.
    """

    path: tuple[Joints, ...]
    speed: float
    acceleration: float
    radii: tuple[float, ...] = ()


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


class SetPayload(Step):
    """Tell the controller what hangs on the flange: gripper and object.

    Args:
        mass: [kg].
        center: of gravity, in the flange frame [m].
    """

    mass: float
    center: Vector3


class ZeroSensor(Step):
    """Tare the force-torque sensor; the arm must stand still."""


class Wait(Step):
    """Stand still.

    Args:
        duration: [s].
    """

    duration: float


class Drive(Step):
    """Drive the platform along straight legs; it may turn on each, and stops where they meet.

    Args:
        legs: x, y [m] and turn about z [rad] of the platform in the world at the end of each leg; each turns the
            shorter way round.
        speed, acceleration: of its frame [m/s, m/s2].
        turn_speed, turn_acceleration: [rad/s, rad/s2].
    """

    legs: tuple[Vector3, ...]
    speed: float
    acceleration: float
    turn_speed: float
    turn_acceleration: float


class TryInOrder(Step):
    """Branches, tried one after the other while the program runs, until one succeeds.

    A branch fails when one of its steps would have aborted the program. Each branch but the first begins with the steps
    that lead back to where the first began. All branches end at the same place. If the last one fails, so does this.
    """

    branches: tuple[tuple[AnyStep, ...], ...]


class Parallel(Step):
    """Branches that run at the same time; one at most moves the arm, one at most the gripper.

    The ``branches`` begin together. ``until`` "all": it succeeds when all have; the first failure stops the others.
    "first": it succeeds when one has, and this stops the others; it fails when all have failed.
    """

    branches: tuple[tuple[AnyStep, ...], ...]
    until: Literal["all", "first"] = "all"


class Repeat(Step):
    """Steps ``count`` times over; they end where they begin. The first failure ends it, as a failure."""

    steps: tuple[AnyStep, ...]
    count: int


class Monitor(Step):
    """Steps while something is watched; when it happens they are stopped, and this fails with what was seen.

    Args:
        force: magnitude of the TCP force that may not be exceeded [N]; None is not watched, as below.
        slip: how far the fingers may close further, from when it begins [m]: what they held is leaving.
        time: how long the steps may take [s].
    """

    steps: tuple[AnyStep, ...]
    force: float | None = None
    slip: float | None = None
    time: float | None = None


Control = TryInOrder | Parallel | Repeat | Monitor
"""Steps that hold steps."""

AnyStep = (
    MoveJoints
    | MoveLinear
    | MoveUntilContact
    | ForceMove
    | SpiralSearch
    | ForceInsert
    | ForceExtract
    | CompliantSlide
    | SetGripper
    | SetPayload
    | ZeroSensor
    | Wait
    | Drive
    | Control
)


def branches(step: Control) -> tuple[tuple[AnyStep, ...], ...]:
    """The steps that a control step holds."""
    return step.branches if isinstance(step, TryInOrder | Parallel) else (step.steps,)


def uses_arm(steps: Iterable[AnyStep]) -> bool:
    """Whether steps need the arm: all but those of the gripper and standing still; a
    platform that drives moves the arm."""
    return any(not isinstance(s, SetGripper | Wait) for s in steps)


def clash(branches: Iterable[Iterable[AnyStep]]) -> str:
    """Why branches cannot run at the same time; empty when they can."""
    flat = [list(walk(b)) for b in branches]
    grip = [any(isinstance(s, SetGripper) for s in b) for b in flat]
    if sum(map(uses_arm, flat)) > 1:
        return "more than one branch needs the arm, which does one thing at a time"
    return "more than one branch moves the gripper" if sum(grip) > 1 else ""


def walk(steps: Iterable[AnyStep]) -> Iterator[AnyStep]:
    """Every step, those inside control steps after the step that holds them."""
    for step in steps:
        yield step
        if isinstance(step, Control):
            for branch in branches(step):
                yield from walk(branch)


class Section(Value):
    """The steps of one task: ``steps`` [first, last).

    Args:
        task: the task designator's name, e.g. "3.Grasping".
        title: what it does in words, with the grounded objects.
    """

    task: str
    title: str
    first: int
    last: int


class Snapshot(Value):
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


class LatePose(Value):
    """A pose that the program asks for when it runs: parametric mode.

    Args:
        thing: name, as the perception server knows it.
        pose: where it was when this was planned, in the robot's base frame.
        tolerance: how far from there the program works, and is refused beyond [m, rad].
    """

    thing: str
    pose: Pose
    tolerance: tuple[float, float]


class Program(Value):
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
        late: poses that are bound at run time.
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
    late: tuple[LatePose, ...] = ()

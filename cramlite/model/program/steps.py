"""Steps of a typed program: one motion, force motion or control construct each.

All lengths are metres, angles radians, times seconds, forces newtons. Cartesian
targets are poses of the tool centre point (TCP) in the frame of the arm's base, wherever
a platform has driven it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

from ...base.value import Value
from ..geometry import Pose, Vector3
from .swing import Swing

Joints = tuple[float, ...]
"""Joint position, base to flange [rad]."""


class Step(Value, kw_only=True):
    """Base class of all steps of typed programs.

    Args:
        origin: the designator that this step grounds, e.g. "3.Grasping/approach"; a code line leads back to it.
        comment: one clause for the reader of the code.
        relative: a thing whose pose is late: targets and directions move along with it; "" for none.
    """

    origin: str = ""
    comment: str = ""
    relative: str = ""


class MoveUntilContact(Step):
    """Guarded motion: a straight TCP motion that ends on contact.

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


class ForceMove(Step):
    """Hybrid force/position motion: a straight TCP motion along waypoints while some axes comply.

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


class SpiralSearch(Step):
    """Spiral search for a hole: press along an axis and move across it on an Archimedean spiral.

    It ends when the surface gives way, or when a rim holds the tool: a force across of more than twice ``force``, which
    the friction of no face explains.

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


class ForceInsert(Step):
    """Force-controlled insertion: push along an axis, compliant sideways, until a depth is reached.

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


class ForceExtract(Step):
    """Force-controlled extraction: pull along an axis, compliant sideways, until the tool has moved a given
    distance.

    Nothing is commanded but forces: what guides the tool is what it is pulled along, so that the pull can never be
    harder than ``force``, however the thing jams. Aborts when the force limit is exceeded or the way is not done in time.

    Args:
        frame: z is the direction of pulling.
        force: pulled with [N].
        across: forces on x and y of the frame [N]: the weight that rests on the peg when the sensor is tared.
        way: along z, from where it starts [m].
        speed: highest TCP speed on each axis [m/s].
        force_limit: abort when the force magnitude exceeds this [N].
        timeout: [s].
        joints: inverse solution at the end, for checks.
    """

    frame: Pose
    force: float
    across: tuple[float, float]
    way: float
    speed: float
    force_limit: float
    timeout: float
    joints: Joints = ()


class CompliantSlide(Step):
    """Sliding under force control: a straight TCP motion along waypoints on a surface, pressing on it and following its height.

    Aborts when the force limit is exceeded (what slides is stuck), when the contact is lost for longer than ``lost``
    (the surface has ended), or the time is over.

    Args:
        waypoints: TCP in base.
        frame: z is the direction of pressing; only this axis complies.
        force: pressed with [N].
        speed: along the path [m/s].
        lost: how long the reaction may be under a quarter of ``force`` [s].
        force_limit: abort when the force magnitude exceeds this [N].
        timeout: [s].
        joints: inverse solution at the last waypoint, for checks.
    """

    waypoints: tuple[Pose, ...]
    frame: Pose
    force: float
    speed: float
    lost: float
    force_limit: float
    timeout: float
    joints: Joints = ()


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
    """Straight TCP motion to a pose.

    ``joints`` is the inverse solution at the target, for checks.

    Args:
        target: TCP in base.
        speed, acceleration: of the TCP [m/s, m/s2].
        swing: what is held turns so between the pads meanwhile; None where it stays as it is.
    """

    target: Pose
    speed: float
    acceleration: float
    joints: Joints = ()
    swing: Swing | None = None


class SetGripper(Step):
    """Gripper motion to an opening; the next step begins when the motion has ended.

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
    """Payload setting: the load on the flange, gripper and object, for the controller.

    Args:
        mass: [kg].
        center: of gravity, in the flange frame [m].
    """

    mass: float
    center: Vector3


class ZeroSensor(Step):
    """Tare of the force-torque sensor; the arm must stand still."""


class Wait(Step):
    """Dwell: stand still for a time.

    Args:
        duration: [s].
    """

    duration: float


class Drive(Step):
    """Platform motion along straight legs; it may turn on each, and stops where they meet.

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


class Fallback(Step):
    """Branches, tried one after the other while the program runs, until one succeeds: a behaviour tree's fallback.

    A branch fails when one of its steps would have aborted the program. Each branch but the first begins with the steps
    that lead back to where the first began. All branches end at the same place. If the last one fails, so does this.
    """

    branches: tuple[tuple[AnyStep, ...], ...]


class Parallel(Step):
    """Parallel branches; one at most moves the arm, one at most the gripper.

    The ``branches`` begin together. ``until`` "all": it succeeds when all have; the first failure stops the others.
    "first": it succeeds when one has, and this stops the others; it fails when all have failed.
    """

    branches: tuple[tuple[AnyStep, ...], ...]
    until: Literal["all", "first"] = "all"


class Repeat(Step):
    """Loop that runs its steps ``count`` times and fails at the first failure; each round ends with the arm where it started."""

    steps: tuple[AnyStep, ...]
    count: int


class Monitor(Step):
    """Steps that are stopped when a watched quantity exceeds its limit; the control step then fails with
    the measured value.

    Args:
        force: magnitude of the TCP force that may not be exceeded [N]; None is not watched, as below.
        slip: how far the fingers may close further, from when it begins [m]: what they held is leaving.
        time: how long the steps may take [s].
    """

    steps: tuple[AnyStep, ...]
    force: float | None = None
    slip: float | None = None
    time: float | None = None


Control = Fallback | Parallel | Repeat | Monitor
"""Control step of a program: a step that contains other steps."""
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
"""Any step of a typed program."""


def branches(step: Control) -> tuple[tuple[AnyStep, ...], ...]:
    """Return the lists of steps inside a control step: each branch, or its only list."""
    return step.branches if isinstance(step, Fallback | Parallel) else (step.steps,)


def uses_arm(steps: Iterable[AnyStep]) -> bool:
    """Check whether any of some program steps needs the arm; all kinds do except gripper motions and dwells.

    A driving platform moves the arm, too.
    """
    return any(not isinstance(s, SetGripper | Wait) for s in steps)


def branch_conflict(branches: Iterable[Iterable[AnyStep]]) -> str:
    """Return why branches cannot run in parallel; "" when they can."""
    flat = [list(walk(b)) for b in branches]
    grip = [any(isinstance(s, SetGripper) for s in b) for b in flat]
    if sum(map(uses_arm, flat)) > 1:
        return "more than one branch needs the arm, which does one thing at a time"
    return "more than one branch moves the gripper" if sum(grip) > 1 else ""


def walk(steps: Iterable[AnyStep]) -> Iterator[AnyStep]:
    """Yield every step in depth-first order: a control step before the steps inside it."""
    for step in steps:
        yield step
        if isinstance(step, Control):
            for branch in branches(step):
                yield from walk(branch)

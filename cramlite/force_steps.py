"""Force-controlled steps of a typed program: motions that feel and give way.

All abort: when a force limit is exceeded, when the time is over, and for the reasons that each one names
(docs/reference/motions.md). Forces are what the robot applies to its environment [N]; frames are orientations in the
robot's base (their positions are ignored).
"""

from __future__ import annotations

from typing import Literal

from .geometry import Pose, Vector3
from .step import Joints, Step


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


class ForceExtract(Step):
    """Pull along an axis with a force, giving way sideways, until it is out.

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
    """Straight TCP motion along waypoints on a surface, pressing on it with a force and following its height.

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

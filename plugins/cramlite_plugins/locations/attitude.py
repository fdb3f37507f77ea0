"""How what is held is turned when it is put somewhere: as it is asked for, so that it stands, or as it is."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Belief, Location, Pose
from cramlite.plugin import Context, Unresolvable

from ..motion_planning.reach import held_pose, taken_at
from ..shapes.standing_up import stood_up
from .parameters import Where
from .place_filters import Wanted

TURNLESS = 1e-6  # what is turned by less is as it was: rounding [rad]
PALM_UP = math.sin(math.radians(20.0))
"""Of the hand's approach, upwards: with more of it the hand would be under what it holds, and in what that is put on."""


def held_now(belief: Belief, context: Context) -> Pose:
    """Return the current pose of what is held, in the base frame."""
    return held_pose(belief, context)


def put_down(wanted: Wanted, location: Location) -> Pose:
    """Return the pose of what is held as it is put somewhere, in the base frame: turned as it is asked for, else as it is; what leans and
    is put onto something, so that it stands. What is in it stays as level as it was."""
    now = held_now(wanted.belief, wanted.context)
    if location.relation == "on" and not wanted.where.attitude and wanted.thing.filling is None:
        return stood_up(wanted.thing, now)
    return as_asked(now, wanted.where)


def as_asked(now: Pose, where: Where) -> Pose:
    """Return a pose in the base frame turned the shortest way so that its z axis points up or down, where ``attitude`` wants it."""
    if not where.attitude:
        return now
    up, axis = now.rotate((0.0, 0.0, 1.0)), {"upright": 1.0, "upside down": -1.0}[where.attitude]
    way = np.cross(up, (0.0, 0.0, axis))
    sine = float(np.linalg.norm(way))
    angle = math.atan2(sine, axis * float(up[2]))
    if sine < TURNLESS:  # half a turn is as short about any level axis
        way, sine = now.rotate((1.0, 0.0, 0.0)), 1.0
    x, y, z = (way / sine * angle).tolist()
    turned = Pose.from_rotvec((0, 0, 0), (x, y, z)) * Pose((0, 0, 0), now.quaternion)
    return Pose(now.position, turned.quaternion)


def check_turn(now: Pose, asked: Pose, wanted: Wanted) -> None:
    """Check that what is held can be brought to the attitude that is asked for, as it is held.

    Raises:
        Unresolvable: what is in it would be spilled, or the hand would come under it; then another grasp may do.
    """
    held, (turn, context) = wanted.belief.held, (now.inverse() * asked, wanted.context)
    if held is None or math.hypot(*turn.rotvec) < TURNLESS:  # rounding turns nothing
        return
    if wanted.thing.filling is not None:
        raise Unresolvable(f"'{wanted.thing.name}' holds something that would be spilled", (wanted.entity,))
    rise = float((asked * held.tcp_to_thing.inverse()).rotate((0.0, 0.0, 1.0))[2])
    if rise > PALM_UP:

        said = f"turned so, the hand would be under '{held.thing}' and reach up by {math.degrees(math.asin(min(rise, 1.0))):.0f} deg"
        raise Unresolvable(said, taken_at(wanted.belief, context))

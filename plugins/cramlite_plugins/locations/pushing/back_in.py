"""Pushing of a thing that toppled into a shelf or cabinet and sticks out, or was set down before it: fingers
come down in front of it and push its outer end to where that shall be.

What was let go of to tip over comes out with the hand, by more or less: wherever it is on their way, the
fingers bring it to where it should be.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, CarriedAlong, Floats, Location, Place, vector3
from cramlite.plugin import Answer, Context, Grounding, Refused

from ...motion_planning.reach import bound, reference_pose, shift
from ..parameters import Begun, asked
from ..reached import Arm, Leg
from .contacts import free_ahead, hands_behind
from .straight import ABOVE, SPOT

APART = 0.6
"""Opening of the fingers, as a share of the thing's width: two fingers that touch the thing keep it from
turning away."""

CAME_OUT = 0.1
"""Largest way by which a released thing came out with the hand [m]: with pads whose friction is 2 LIBERO's
book came out by 48 mm."""
FURTHER = 0.008
"""Distance that the fingers go on beyond the believed pose of the thing [m]: it may lie a little farther in,
and the fingers have to touch it in the end."""
LEANS = (0.0, 30.0, 45.0, 60.0)  # of a hand whose fingers point ahead, from pointing down [deg]
AHEAD = 0.1  # of a thing, a point that gives the way [m]


def pushed_in(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate poses of the fingers behind a thing that was released, from which they push it along the
    hand's approach.

    The ``path`` ends where the thing is believed to be, or where its release said that it shall come.
    """
    entity, begin = bound(context, location.of), asked(location, Begun).begin
    reference_pose(belief, location, context)
    ways = ways_in(entity, *_way(begin, entity, belief, context), belief, context)
    for k, (turn, found) in enumerate(ways):
        if isinstance(found, Refused):
            yield replace(found.of(turn), because=(begin,))  # elsewhere the arm may have room
        else:
            yield Grounding(found, f"push '{entity}' in, {turn}", 0.1 * k, key=turn, anew=True)


def _way(begin: str, entity: str, belief: Belief, context: Context) -> tuple[Floats, float]:
    """Return the direction (3,) in which a thing is pushed from where it was released, and how far beyond its
    believed place [m]."""
    begun: Place = context.bindings[begin]
    if begun.carried is None or begun.carried.to_m is None:
        return np.asarray(begun.approach), 0.0
    way = np.array([*np.subtract(begun.carried.to_m, belief.pose(entity).position[:2]), 0.0])
    return way, float(np.linalg.norm(way))


def ways_in(
    entity: str, ahead: Floats, far: float, belief: Belief, context: Context
) -> Iterator[tuple[str, Place | Refused]]:
    """Yield hand poses from which fingers push a thing along a level direction (3,), or why the arm cannot.

    Args:
        far: from its believed place [m]; 0 to bring it there from wherever it came out to.
    """
    thing, pose = belief.thing(entity), belief.pose(entity)
    way = np.array([*ahead[:2], 0.0]) / math.hypot(*ahead[:2])
    back, on = (0.0, far) if far else (CAME_OUT, FURTHER)
    there, gripper = shift(pose, AHEAD * way), context.robot.gripper
    for _, near, opening, turn in hands_behind(thing, pose, APART, gripper, SPOT, there, (0.0,), LEANS):
        gap = free_ahead(thing, pose, near, way, opening, gripper)
        at, end = shift(near, -back * way), shift(near, (gap + on) * way)
        before, along = shift(at, (0.0, 0.0, ABOVE)), CarriedAlong(far)
        place = Place(at, before, opening, vector3(way), (end,), thing=entity, carried=along)
        yield f"hand {turn}", _not_led(place, belief, context) or place


def _not_led(place: Place, belief: Belief, context: Context) -> Refused | None:
    """Return the reason why the arm cannot lead the fingers down to a place and along the path of the push;
    None if it can."""
    down = Leg(place.before, (place.thing,), place.opening, along=(place.pose, *place.path))
    led = Arm(belief, context).led((Leg(place.before, (), place.opening), down))
    return led if isinstance(led, Refused) else None

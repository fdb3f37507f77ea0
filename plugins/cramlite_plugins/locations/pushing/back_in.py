"""Pushing of a thing that toppled into a shelf or cabinet and sticks out: fingers come down in front of it
and push its outer end to where the belief has that end.

What was let go of to tip over comes out with the hand, by more or less: wherever it is on their way, the
fingers bring it to where it should be.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Location, Place, Vector3
from cramlite.plugin import Context, Grounding, Refused

from ...motion_planning.reach import bound, reference_pose, shift
from ..parameters import Begun, asked
from ..reached import Arm, Leg
from .contacts import GAP, hands_behind
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
AHEAD = 0.1  # of a thing, a point that gives the way [m]


def pushed_in(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate poses of the fingers behind a thing that was released, from which they push it along the
    hand's approach.

    The ``path`` ends where the thing is believed to be.
    """
    entity, begin = bound(context, location.of), asked(location, Begun).begin
    reference_pose(belief, location, context)
    for k, (turn, found) in enumerate(ways_in(entity, context.bindings[begin].approach, belief, context)):
        if isinstance(found, Refused):
            yield replace(found.of(turn), because=(begin,))  # elsewhere the arm may have room
        else:
            yield Grounding(
                found,
                f"push '{entity}' back in from {1000 * CAME_OUT:.0f} mm behind it, {turn}",
                0.1 * k,
                key=turn,
                anew=True,
            )


def ways_in(
    entity: str, ahead: Vector3, belief: Belief, context: Context
) -> Iterator[tuple[str, Place | Refused]]:
    """Yield hand poses from which fingers push a thing along a level unit vector to its believed place, or
    why the arm cannot."""
    thing, pose, way = belief.thing(entity), belief.pose(entity), np.asarray(ahead)
    there = shift(pose, AHEAD * way)
    for _, near, opening, turn in hands_behind(
        thing, pose, APART, context.robot.gripper, SPOT, there, (0.0,)
    ):
        at, end = shift(near, -CAME_OUT * way), shift(near, (GAP + FURTHER) * way)
        place = Place(at, shift(at, (0.0, 0.0, ABOVE)), opening, (0.0, 0.0, -1.0), (end,), thing=entity)
        yield f"hand {turn}", _not_led(place, belief, context) or place


def _not_led(place: Place, belief: Belief, context: Context) -> Refused | None:
    """Return the reason why the arm cannot lead the fingers down to a place and along the path of the push;
    None if it can."""
    down = Leg(place.before, (place.thing,), place.opening, along=(place.pose, *place.path))
    led = Arm(belief, context).led((Leg(place.before, (), place.opening), down))
    return led if isinstance(led, Refused) else None

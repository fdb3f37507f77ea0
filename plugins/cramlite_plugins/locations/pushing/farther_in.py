"""Pushing a thing farther in under a roof, if it was released so near the front that a door or drawer which a
later task closes would hit it.

A hand is as high as it is long, and comes no farther in with what it holds; the ends of its closed fingers
do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Floats, Location, Place, Pose, thing_of
from cramlite.plugin import Answer, Context, Grounding, Refused, Unresolvable

from ...motion_planning.reach import bound, make_scene, shift, tcp
from ...motions.gripping import LET_GO
from ...shapes.carried_along import gone_along
from ...shapes.surfaces import resting_height
from ..jointed.room_to_close import first_met
from .contacts import STEEP
from .straight import gap_before, pushed_straight

# Between the ways that are looked at, back and in [m]: as well as it is known where something was let go of
STEP = 0.005
FARTHEST = 0.06  # in [m]: three times what a mug in a microwave needs, whose handle sticks out
BACK = 0.12  # distance that hands go back from a released payload, as elsewhere [m]


def off(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate a place for the hand, moved back horizontally from the thing that it released, at which its
    closed fingers touch nothing.

    From there the fingers push the thing farther in.
    """
    entity, ahead = bound(context, location.of), _ahead(belief, context)
    way, here = _needed(entity, ahead, belief, context), tcp(belief, context)
    closed = context.robot.gripper.opening[0]
    shut = make_scene(belief, context, (), closed, LET_GO)
    for back in np.arange(STEP, BACK, STEP).tolist():
        there = shift(here, -back * ahead)
        no = shut.met(belief.base() * there)
        if no is None:
            said = f"{1000 * back:.0f} mm back, to push '{entity}' farther in by {1000 * way:.0f} mm"
            yield Grounding(Place(there, there, closed, thing=entity), said, key="off")
            return
    said = f"closed fingers collide up to {1000 * BACK:.0f} mm straight back from '{entity}'"
    yield Refused("off", f"{said}: {no.reason if no else ''}")


def deeper(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate the place to which the fingers push a released thing, straight ahead, so that it is clear
    of the thing that a later task closes."""
    entity, ahead = bound(context, location.of), _ahead(belief, context)
    way, (x, y, _) = _needed(entity, ahead, belief, context), belief.pose(entity).position
    to = x + way * float(ahead[0]), y + way * float(ahead[1])
    gap = gap_before(belief, context, entity, to, context.robot.gripper.opening[0])
    there = pushed_straight(belief, context, entity, [to], gap)
    if isinstance(there, Refused):
        yield there.of("in")
    else:
        said = f"push '{entity}' farther in by {1000 * way:.0f} mm, from {1000 * gap:.0f} mm in front of it"
        yield Grounding(there, said, key="in")


def _ahead(belief: Belief, context: Context) -> Floats:
    """Horizontal unit vector (3,) of the direction in which the hand points.

    Raises:
        Unresolvable: it points down or up.
    """
    hand = tcp(belief, context)
    if (level := level_ahead(hand)) is not None:
        return level
    way = "down" if hand.rotate((0.0, 0.0, 1.0))[2] < 0 else "up"
    reason = f"the hand points {way}; only a level hand can push a thing farther in"
    raise Unresolvable(reason, (), blocking=())


def level_ahead(hand: Pose) -> Floats | None:
    """Return the level unit vector (3,) along which a hand at a pose points; None if it points down or up."""
    ahead = np.asarray(hand.rotate((0.0, 0.0, 1.0)))
    if abs(ahead[2]) > STEEP:
        return None
    level: Floats = np.array([ahead[0], ahead[1], 0.0]) / math.hypot(ahead[0], ahead[1])
    return level


def _needed(entity: str, ahead: Floats, belief: Belief, context: Context) -> float:
    """Distance that a thing has to go in a direction (3,) to be clear of all that later tasks close [m].

    Raises:
        Unresolvable: it is, or it would not be as far in as something carries it.
    """
    name = thing_of(entity)
    met = first_met(name, belief, context, LET_GO)
    if met is None:
        reason = f"'{entity}' is not in the way of a drawer or door that a later task closes"
        raise Unresolvable(reason, (), blocking=())
    way = clearing_way(name, ahead, belief, context)
    if way is None:
        reason = f"'{entity}' cannot be pushed in so far that it is out of the way: {met.reason}"
        raise Unresolvable(reason, (), blocking=())
    return way


def clearing_way(name: str, ahead: Floats, belief: Belief, context: Context) -> float | None:
    """Return the level distance after which a pushed thing is clear of all that later tasks close [m];
    None if it never is while supported."""
    for way in np.arange(STEP, FARTHEST, STEP).tolist():
        gone = gone_along(belief, name, way * ahead)
        if not _carried(name, gone):
            break
        if first_met(name, gone, context, LET_GO) is None:
            return float(way)
    return None


def _carried(name: str, belief: Belief) -> bool:
    """Whether a thing has another one right below it."""
    others = [(belief.world.thing(n), belief.poses[n].pose) for n in belief.poses if n != name]
    return math.isfinite(resting_height(belief.world.thing(name), belief.poses[name].pose, others)[0])

"""Grasps that suit the place to which a later task brings a thing: tilted into an opening, under an overhang,
or laid on a side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Belief, Held, Thing
from cramlite.plugin import Context

from ...motion_planning.reach import tcp
from ...shapes.bounds import corners, height
from ...shapes.roofs import has_own_roof
from ..later import brings
from ..parameters import Where
from ..pinching.hand_room import Taken
from ..reached import Arm
from .access import COVERS
from .attitudes import POINTS_DOWN, sides_down
from .demands import stops
from .positions import free_area
from .query import Query, covers, openings
from .sideways import comes_in

Suits = Callable[[Thing, Belief, Context, Taken], "NDArray[np.bool_] | None"]
"""Which grasps (n) of a thing, as it stands now, suit what later tasks do with it; None if all do."""


def suits_later(thing: Thing, belief: Belief, context: Context, taken: Taken) -> NDArray[np.bool_]:
    """Check which grasps (n) suit the places to which later tasks bring a thing; what no grasp suits is left
    out."""
    found = np.ones(len(taken.openings), bool)
    for one in SUITS:
        mask = one(thing, belief, context, taken)
        if mask is not None and (found & mask).any():
            found &= mask
    return found


def leans(thing: Thing, belief: Belief, context: Context, taken: Taken) -> NDArray[np.bool_] | None:
    """Check which grasps (n) are those of leaning hands; None if no later task brings the thing into an
    opening that is too covered for a way straight from above."""
    others = (name for name in belief.poses if name != thing.name)
    narrow = [name for name in others if _too_narrow(thing, name, belief, context)]
    if not narrow:
        return None  # later tasks are not looked at, so that what follows from this holds whatever they are
    later = any(onto.thing in narrow for onto, *_ in brings(thing.name, belief, context))
    return taken.leaning if later else None


def _too_narrow(thing: Thing, into: str, belief: Belief, context: Context) -> bool:
    """Whether only overhangs keep a thing, in its present orientation, out of an opening."""
    half = float(np.min(np.ptp(corners(thing, belief.pose(thing.name)), axis=0)[:2])) / 2
    for target, depth in openings(belief.thing(into), belief.pose(into)):
        bare = Query(thing, into, target, Arm(belief, context), Where(), depth=depth)
        core = target.area.buffer(-half)
        if not core.is_empty and free_area(core, [o.area for o in covers(bare, COVERS)], half).is_empty:
            return True
    return False


def lays_down(thing: Thing, belief: Belief, context: Context, taken: Taken) -> NDArray[np.bool_] | None:
    """Check with which grasps (n) a thing, as it stands now, can be laid on a side; None if no later task
    needs that: it would be in the way of a drawer or door there if it stood."""
    if not _stops(thing, belief, context):
        return None
    now, found = belief.pose(thing.name), np.zeros(len(taken.openings), bool)
    for turned in sides_down(thing, now):
        found |= taken.hands.approach @ (turned.rotation @ now.rotation.T)[2] <= POINTS_DOWN
    return found


def _stops(thing: Thing, belief: Belief, context: Context) -> bool:
    """Whether a thing would stop what later tasks move if it stood in the opening to which a task before them
    brings it."""
    now = belief.pose(thing.name)
    high = [
        name
        for name in belief.poses
        if any(depth < height(thing, now) for _, depth in openings(belief.thing(name), belief.pose(name)))
    ]
    if not high or all(belief.thing(name).joint is None for name in belief.poses):
        return False  # later tasks are not looked at, so that what follows from this holds whatever they are
    held = belief.grasped(Held(thing.name, tcp(belief, context).inverse() * now, 0.0))
    return any(
        stops(Query(thing, onto.thing, opening, Arm(held, then), Where(), depth=depth), now)
        for onto, region, then in brings(thing.name, belief, context)
        for opening, depth in openings(belief.thing(onto.thing), belief.pose(onto.thing), region)
        if onto.thing in high and not has_own_roof(belief.thing(onto.thing), belief.pose(onto.thing), region)
    )


SUITS: tuple[Suits, ...] = (leans, comes_in, lays_down)
"""Another way to put something that needs a grasp of its own is another function here."""

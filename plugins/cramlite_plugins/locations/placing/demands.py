"""Demands of later tasks on a placement: that a door or drawer can still be closed or opened, that the hand
can leave, and that fingers can push in a payload that topples at its release, or is released before it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Estimate, Pose, Remedy, thing_of
from cramlite.plugin import Refused

from ...kinematics.inverse import inverse
from ...motion_planning.reach import shift
from ...motions.gripping import LET_GO, fallen
from ...shapes.bounds import corners
from ...shapes.itself import Itself
from ...shapes.roofs import roofed
from ..jointed.room_to_close import first_met, opens_beside
from ..later import retracts_from
from ..places import ways_back
from ..pushing.back_in import ways_in
from ..pushing.farther_in import clearing_way, level_ahead
from ..reached import Arm, Leg
from .checks.hand import lowered
from .checks.order import Check, first_objection
from .query import Placement, Query

# Cost of a place that comes after all others, since it leaves little room for what is to be closed
TIGHT = 100.0
# Heights of a payload's lowest point over the floor of a cavity, which may be a little higher than stated [m]
LOWS = (0.01, 0.02, 0.03)


def room_to_close(placement: Placement, query: Query) -> str | Refused:
    """Check that doors and drawers that later tasks close still have room to close after this placement, with
    what is in them, and those that later tasks open have room past a container with the payload in it.

    What the hand pushes farther in, before it leaves, may stand in the way until then. Later tasks are looked
    at only where something would be met, so that what follows elsewhere holds whatever they are.
    """
    no = first_met(query.thing.name, let_go(placement, query), query.context, None)
    return "" if no is None or _goes_farther_in(placement, query) else no


def stops(query: Query, turned: Pose, offset: tuple[float, float] = (0.0, 0.0)) -> Refused | None:
    """Return the refusal if a payload over a position of an opening, the middle by default, stops what later
    tasks move; it is turned as at a pose."""
    there = over_floor(query, turned, offset, LOWS[0])
    at = query.hand(there)
    return first_objection(Placement("amid", there, at, at, LOWS[0]), query, OUT_OF_THE_WAY)


def over_floor(query: Query, turned: Pose, offset: tuple[float, float], over: float) -> Pose:
    """Return the pose in the base frame of a thing with a given orientation, its outline's middle over a
    position of an opening, its lowest point at a height over the floor [m]."""
    points = corners(query.thing, Pose.at((0.0, 0.0, 0.0), turned))
    low, high = points.min(axis=0), points.max(axis=0)
    foot = np.array([*(low + high)[:2] / 2, low[2]])
    return Pose.at(query.target.pose.apply((*offset, over - query.depth)) - foot, turned)


def _goes_farther_in(placement: Placement, query: Query) -> bool:
    """Whether the hand that put the payload under a roof can push it on until it is clear of what later
    tasks close."""
    if not (math.isfinite(query.room) and retracts_from(query.thing.name, query.context)):
        return False
    if (ahead := level_ahead(placement.pose)) is None:
        return False
    after, base = let_go(placement, query), query.belief.base()
    way = clearing_way(query.thing.name, base.rotate(ahead), after, query.context)
    there = base * query.hand(shift(placement.thing, (way or 0.0) * ahead))
    return way is not None and query.scene.met(there, hand=False) is None


def is_tight(placement: Placement, query: Query) -> bool:
    """Check whether the payload would stop a drawer or door that later tasks close, at its place or after
    a small shift at its release, or be too near to one that they open."""
    beside = opens_beside(query.thing.name, let_go(placement, query), query.context)
    return beside is not None or _closed_over(Itself(placement), Itself(query))


@lru_cache(maxsize=1)
def _closed_over(placement: Itself[Placement], query: Itself[Query]) -> bool:
    after = let_go(placement.it, query.it)
    return first_met(query.it.thing.name, after, query.it.context, LET_GO) is not None


def let_go(placement: Placement, query: Query) -> Belief:
    """Return the belief after the payload's release at the placement."""
    return _let_go(Itself(placement), Itself(query))


@lru_cache(maxsize=1)
def _let_go(placement: Itself[Placement], query: Itself[Query]) -> Belief:
    belief, to = query.it.belief, query.it.entity
    pose = fallen(belief, belief.base() * placement.it.rests)
    after = belief.released(Estimate(pose, 0.0, "predicted: let go there"), query.it.held.opening)
    return after.related(("in" if query.it.depth else "on", query.it.thing.name, thing_of(to)))


def room_to_leave(placement: Placement, query: Query) -> str | Refused:
    """Check that the open hand has room at the end of at least one retreat from the place.

    Contacts are allowed here; the search of that way, later, keeps a distance.

    What a later task closes over a thing is left out: the hand pushes the thing farther in first, and leaves
    from there. So is what swings in the hand. Later tasks are looked at only where no way is free, so that
    what follows elsewhere holds whatever they are.
    """
    if query.held.swing is not None or placement.back is not None:
        return ""
    blocked = _blocked(placement, query)
    if blocked is None or not retracts_from(query.thing.name, query.context):
        return ""
    return "" if _closed_over(Itself(placement), Itself(query)) else blocked


def _blocked(placement: Placement, query: Query) -> Refused | None:
    """Refusal of the retreat on which the hand collides least deeply; None if some retreat is free of
    collision."""
    after, thing, opening = Arm(let_go(placement, query), query.context), query.thing.name, query.openings[-1]
    found = list[Refused]()
    for name, pose in reversed(ways_back(lowered(placement, query))):  # the shortest, with most room, first
        there = after.at(Leg(pose, (thing,), opening, 0.0))
        if not isinstance(there, Refused):
            return None
        found.append(replace(there, reason=f"{name} {there.reason}"))
    least = min(found, key=lambda no: no.collision.depth if no.collision else float("inf"))
    return replace(least, remedy=_remedy(least, query) or least.remedy)


def _remedy(no: Refused, query: Query) -> Remedy | None:
    """Return the advice if the retreating hand would meet the payload's support or container; None if it
    would meet something else."""
    if no.collision is None or thing_of(query.entity) not in {thing_of(name) for name in no.collision.pair}:
        return None
    into, more = query.belief.thing(query.entity), max(1.0, 1000 * no.collision.depth)
    what, heights = f"beside '{query.entity}'", [room for _, room in roofed(into, query.at)]
    if heights:
        what = f"the opening of '{query.entity}' is {1000 * max(heights):.0f} mm high, and"
    says = f"{what} the hand needs at least {more:.0f} mm more room to come back from '{query.thing.name}'"
    cure = "take it from another side, or name another place"
    return Remedy(f"leave {query.entity}", f"{says}: {cure}", no.collision.depth)


def pushed_in(placement: Placement, query: Query) -> str | Refused:
    """Check that fingers can push in a payload that is released before an overhang, or again one that tips
    over and comes out a little with the hand."""
    if placement.back is None:
        return ""
    lies, pushed, stuck = placement.lies or placement.thing, placement.pushed, list[Refused]()
    after = query.belief.released(Estimate(query.belief.base() * lies, 0.0, "let go of"), query.openings[0])
    after = after.moved(inverse(query.context.robot, placement.back, seed=query.belief.joints)[0])
    begin, end = (lies, pushed) if pushed else (placement.before, placement.pose)
    way = np.subtract(end.position, begin.position)
    far = float(np.linalg.norm(way)) if pushed else 0.0
    for _, found in ways_in(query.thing.name, way, far, after, query.context):
        if not isinstance(found, Refused):
            return ""
        stuck.append(found)
    return stuck[0]


OUT_OF_THE_WAY: Mapping[str, Check] = {"out of the way": room_to_close}
"""Check of a payload at its place alone, whatever holds it: it is made before those with hand and arm."""
DEMANDS: Mapping[str, Check] = {"free to leave": room_to_leave, "pushed in": pushed_in}
"""Checks of a placement against the demands of later tasks on the hand, made after all other checks."""

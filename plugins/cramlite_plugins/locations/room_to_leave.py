"""Room for the empty hand to come back from a place, where the next task after letting go retracts it."""

from __future__ import annotations

from msgspec.structs import replace

from cramlite.model import Remedy, thing_of
from cramlite.plugin import Refused

from ..motion_planning.reach import collision_free_ik, make_scene, shift
from ..shapes.roofs import roofed
from .later import retracts_from
from .place_filters import Spot, Wanted
from .places import ways_back
from .room_to_close import is_tight, let_go


def room_to_leave(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that the open hand has an end of a way back from the place, with no more than no contact there: a later search of that way
    keeps a distance, and finds no more.

    What a later task closes over a thing is left out: the hand pushes the thing farther in first, and leaves from there. So is what swings
    in the hand. Later tasks are looked at only where no way is free, so that what follows elsewhere holds whatever they are.
    """
    if wanted.belief.held is None or wanted.belief.held.swing is not None:
        return ""
    blocked = _blocked(spot, wanted)
    if blocked is None or not retracts_from(wanted.thing.name, wanted.context) or is_tight(spot, wanted):
        return ""
    return blocked


def _blocked(spot: Spot, wanted: Wanted) -> Refused | None:
    """What is in the way of the hand on the way back that lacks least; None where one is free."""
    low = spot.pose if wanted.depth else shift(spot.pose, (0.0, 0.0, -spot.height))
    opening = wanted.opened[-1].opening if wanted.opened else None
    scene, found = make_scene(let_go(spot, wanted), wanted.context, (wanted.thing.name,), opening, 0.0), list[Refused]()
    for name, pose in reversed(ways_back(low)):  # the shortest first, which has most room
        there = collision_free_ik(scene, wanted.context, pose, wanted.belief.joints)
        if not isinstance(there, Refused):
            return None
        found.append(replace(there, reason=f"{name} {there.reason}"))
    least = min(found, key=lambda no: no.collision.depth if no.collision else float("inf"))
    return replace(least, remedy=_remedy(least, wanted) or least.remedy)


def _remedy(no: Refused, wanted: Wanted) -> Remedy | None:
    """What to try, where the hand meets what it puts the thing onto or into."""
    if no.collision is None or thing_of(wanted.entity) not in {thing_of(name) for name in no.collision.pair}:
        return None
    into, more = wanted.belief.thing(wanted.entity), max(1.0, 1000 * no.collision.depth)
    heights = [room for _, room in roofed(into, wanted.belief.pose(into.name))]
    what = f"the opening of '{wanted.entity}' is {1000 * max(heights):.0f} mm high, and" if heights else f"beside '{wanted.entity}'"
    says = f"{what} the hand needs at least {more:.0f} mm more room to come back from '{wanted.thing.name}'"
    return Remedy(f"leave {wanted.entity}", f"{says}: take it from another side, or name another place", no.collision.depth)

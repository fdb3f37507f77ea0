"""Checks of a payload's shape at its target, whatever hand and arm do; all work in the robot's base frame."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Pose, Remedy, thing_of
from cramlite.plugin import SIDES, Refused

from ....motion_planning.postures import CLEARANCE
from ....motion_planning.space import refusal
from ....shapes.bounds import centre_of_mass, support
from ....shapes.surfaces import FLAT, footprint, inset, standing
from ..opening import wider
from ..query import Placement, Query

ASIDE = 0.02  # what is left of a thing is so by at least this [m]
OFF_WALLS = 0.008
"""Distance of an outline from the walls between which the thing is let down [m]: a streamed arm is up to 5
mm off its path."""
# Distance of an origin from the edge of its region [m]: a thing that is let go shifts by a few millimetres
WELL_IN = 0.008
# Distance of an origin at rest from both ends of its region's height [m]: the validator of goals asks for
# half of that
WITHIN = 0.002
# Angle of closing or approach direction from level, up to which something falls out of a hand [deg]: friction
# of 1 holds on less
LEVEL = 45.0


def supported(placement: Placement, query: Query) -> str:
    """Check that the thing's centre of mass is above the part of the surface that it would touch."""
    local = query.target.pose.inverse() * placement.thing
    inside, least = inset(standing(query.thing, local), query.target.area)
    if inside >= least or _sunk(placement, query):
        return ""
    if not math.isfinite(inside):
        return f"nothing of '{query.entity}' would be under the payload's foot"
    side = f"{-1000 * inside:.0f} mm beyond" if inside < 0 else f"only {1000 * inside:.0f} mm from"
    return (
        f"its centre of mass would be {side} the edge of '{query.entity}'; {1000 * least:.0f} mm inside is "
        "needed"
    )


def _sunk(placement: Placement, query: Query) -> bool:
    """Whether the payload's centre of mass comes to rest below the rim of a hollow, so that it cannot fall
    out."""
    hollow = query.under.feature("cram:Cavity") if query.under else None
    if query.under is None or hollow is None:
        return False
    centre = placement.thing.apply(centre_of_mass(query.thing)) - np.array([0.0, 0.0, placement.height])
    x, y, z = (query.belief.pose(query.under.name) * hollow.pose).inverse().apply(centre)
    half = [hollow.size.get("radius", hollow.size.get(name, 0.0) / 2) for name in ("width", "depth")]
    return bool(z < 0 and abs(x) < half[0] / 2 and abs(y) < half[1] / 2)


def clear(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload's outline from above, taken up to the height of each obstacle, does not overlap
    that obstacle's."""
    there = query.target.pose.inverse() * placement.thing
    foot = -support(query.thing, there, (0.0, 0.0, -1.0))  # it may still be above where it will stand
    for found in query.obstacles:
        outline = footprint(query.thing, there, high=foot + found.top)
        if (overlap := float(outline.intersection(found.area).area)) > 0:
            return _no_room(found.name, overlap, query)
    return ""


def _no_room(other: str, overlap: float, query: Query) -> Refused:
    """Refusal of a payload whose outline and the gap around it overlap an obstacle's [m2]."""
    by = f"by {1e4 * overlap:.1f} cm2"
    beside = f"beside '{other}' on or in '{query.entity}'"
    says = (
        f"there is no room for '{query.thing.name}' {beside}: their outlines and the gap between them "
        f"overlap {by}: have '{other}' put elsewhere, or name another place"
    )
    return refusal(
        f"its outline would overlap that of '{other}' and the gap around it {by}",
        blocking=query.standing_there(),
        remedy=Remedy(f"room {query.entity}", says, overlap),
    )


def inside(placement: Placement, query: Query) -> str | Refused:
    """Check that all of the payload is over the container's opening, and keeps a gap from its walls where
    there is room for one."""
    outline = footprint(query.thing, query.target.pose.inverse() * placement.thing)
    (low, left, high, right), (x, y, x1, y1) = outline.bounds, query.target.area.bounds
    gap = _gap(outline, query)
    if query.target.area.buffer(-gap).covers(outline):
        return ""
    if query.target.area.covers(outline):
        least = 1000 * query.target.area.boundary.distance(outline)
        return f"only {least:.0f} mm from the walls of '{query.entity}', {1000 * gap:.0f} mm is needed"
    out, across, room, side = max(
        (max(x - low, high - x1), high - low, x1 - x, "width"),
        (max(y - left, right - y1), right - left, y1 - y, "depth"),
    )
    if out <= 0:
        beside = 1e4 * float(outline.difference(query.target.area).area)
        return f"{beside:.1f} cm2 of the payload would be beside the opening of '{query.entity}'"
    said = (
        f"it takes {1000 * across:.0f} mm of the {1000 * room:.0f} mm {side} of '{query.entity}' and sticks "
        f"out by {1000 * out:.0f} mm"
    )
    return refusal(said, blocking=query.standing_there(), remedy=wider(outline, query))


def _gap(outline: Any, query: Query) -> float:
    """Distance of an outline from walls that is asked for [m]: with half of the room to choose from."""
    return min(OFF_WALLS, *(max(0.0, room) / 4 for room in _play(outline, query)))


def snug(query: Query, pose: Pose) -> Query:
    """Return the placing problem of an opening, with as little clearance as a payload at a pose has there:
    with more it would be let go of above the rim, and fall farther."""
    gap = _gap(footprint(query.thing, query.target.pose.inverse() * pose), query)
    return query if query.clearance is not None or gap >= CLEARANCE else replace(query, clearance=gap)


def _play(outline: Any, query: Query) -> tuple[float, float]:
    """Return how far an outline could be shifted along x and along y between the walls and the obstacles
    beside it [m]."""
    ends = np.reshape(query.target.area.bounds, (2, 2))
    low, high = np.reshape(outline.bounds, (2, 2))
    found = ends[1] - ends[0] - (high - low)
    for a, b in (np.reshape(o.area.bounds, (2, 2)) for o in query.obstacles):
        for k in (0, 1):
            if a[1 - k] < high[1 - k] and b[1 - k] > low[1 - k]:  # side by side
                found[k] -= min(b[k], ends[1, k]) - max(a[k], ends[0, k])
    return float(found[0]), float(found[1])


def falls(placement: Placement, query: Query) -> str:
    """Check that the released payload falls out of the hand, and stays neither on the lower finger nor on
    the palm."""
    fingers, ahead = (float(placement.pose.rotate(axis)[2]) for axis in ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    for what, up in (("the lower finger", abs(fingers)), ("the palm below it", ahead)):
        if (steep := math.degrees(math.asin(max(-1.0, min(1.0, up))))) > LEVEL:
            return (
                f"it would stay on {what}, since the hand is turned up by {steep:.0f} deg; up to "
                f"{LEVEL:.0f} deg it falls"
            )
    return ""


def falls_in(placement: Placement, query: Query) -> str | Refused:
    """Check that the released payload falls into the container, and not onto an obstacle, such as the cabinet
    of a closed drawer."""
    belief, to = query.belief, query.target.pose.inverse()
    for name in (o.name for o in query.covers) if placement.height > 0 else ():
        between = footprint(belief.world.thing(name), to * belief.pose(name), 2 * FLAT, placement.height)
        if (overlap := float(footprint(query.thing, to * placement.thing).intersection(between).area)) > 0:
            said = (
                f"'{name}' is between the payload and '{query.entity}' over {1e4 * overlap:.1f} cm2: the "
                f"payload would rest on '{name}'"
            )
            return refusal(said, blocking=(name,))
    return ""


def in_region(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload's origin is over the wanted region, a little inside since a released payload may
    shift, and between the lowest and highest level of the region."""
    return region_missed(placement.thing, placement.height, query) if query.where.region else ""


def region_missed(thing: Pose, height: float, query: Query) -> str | Refused:
    """Return why a payload's origin, once lowered by a height [m], would be outside the wanted region; ""
    if it would be inside."""
    region, (x, y, z) = query.where.region, (query.target.pose.inverse() * thing).position
    at, area = shapely.Point(x, y), query.target.area
    by = float(area.boundary.distance(at)) if area.covers(at) else -float(area.distance(at))
    if by < WELL_IN:
        said = f"{-1000 * by:.0f} mm beside" if by < 0 else f"only {1000 * by:.0f} mm from the edge of"
        return f"its origin would be {said} '{region}'; {1000 * WELL_IN:.0f} mm inside is needed"
    feature = next(f for f in query.belief.thing(thing_of(query.entity)).features if f.name == region)
    if low := _too_low(query, z - height):
        return low
    over = 0.0 if query.depth else z - height - feature.size.get("height", math.inf) + WITHIN
    if over <= 0:
        return ""
    what = f"'{thing_of(query.entity)}/{region}'"
    reaches = f"reaches {1000 * feature.size['height']:.0f} mm above the surface under it"
    more = f"{what} {reaches}, {1000 * over:.0f} mm too little for the origin of '{query.thing.name}'"
    says = f"{more}: name the thing itself or a higher region, or make the site of this region higher"
    said = f"its origin would be {1000 * over:.0f} mm too high for {what}, which {reaches}"
    return refusal(said, blocking=(), remedy=Remedy(f"region {what[1:-1]}", says, over))


def over_region(placement: Placement, query: Query) -> str:
    """Check that the payload's origin is over the wanted region, whose surface may lean.

    The origin may be at the border: a payload that was released there and has come to rest shifts no more.
    """
    resting = np.asarray(placement.thing.position) - (0.0, 0.0, placement.height)
    x, y, z = map(float, query.target.pose.inverse().apply(resting))
    if low := _too_low(query, z):
        return low
    at = shapely.Point(x, y)
    if not query.where.region or query.target.area.covers(at):
        return ""
    return f"its origin would be {1000 * query.target.area.distance(at):.0f} mm beside '{query.where.region}'"


def _too_low(query: Query, z: float) -> str:
    """Reason why a payload's origin at a height ``z`` over the target's face [m] is too low for the wanted
    region, which may begin above the face; "" if it is not."""
    low = query.lowest + WITHIN - z if query.lowest else 0.0
    if low <= 0:
        return ""
    return f"its origin would be {1000 * low:.0f} mm too low for '{query.where.region}' in this orientation"


def near(placement: Placement, query: Query) -> str:
    """Check that the payload comes to rest near another thing, from middle to middle, seen from above."""
    other = query.where.near
    if not other:
        return ""
    gap = math.dist(placement.rests.position[:2], query.belief.pose(other).position[:2])
    if gap <= query.where.within:
        return ""
    return f"{1000 * gap:.0f} mm from '{other}', up to {1000 * query.where.within:.0f} mm are near"


def beside(placement: Placement, query: Query) -> str:
    """Check that the payload comes to rest on the side of other things that the query asks for, in the base
    frame: x forwards, y to the left."""
    for side, (axis, sign) in SIDES.items():
        other = getattr(query.where, side)
        if not other:
            continue
        by = sign * (placement.rests.position[axis] - query.belief.pose(other).position[axis])
        if by < ASIDE:
            said = side.replace("_", " ")
            return f"{1000 * by:.0f} mm {said} '{other}', at least {1000 * ASIDE:.0f} mm is needed"
    return ""

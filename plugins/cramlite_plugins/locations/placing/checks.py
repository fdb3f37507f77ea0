"""Checks of placements: pure functions, each returns a reason with numbers, or nothing.

Those of the shapes alone are asked before the arm is; all work in the robot's base frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Pose, Remedy, Stage, thing_of
from cramlite.plugin import Refused, checkpoint

from ...kinematics.inverse import inverse, why_no_inverse
from ...kinematics.reach import reach_shortfall
from ...motion_planning.postures import CLEARANCE
from ...motion_planning.reach import shift
from ...motion_planning.space import refusal
from ...motion_planning.too_far import no_inverse
from ...shapes.bounds import centre_of_mass, support
from ...shapes.standing_up import stood_up
from ...shapes.surfaces import FLAT, footprint, inset, standing
from ...simulation.resting import rests
from ..pushing.around import CLEAR, LIFT
from ..reached import Leg
from .opening import wider
from .query import PARTS, Placement, Query
from .visibility import visible

ASIDE = 0.02  # what is left of a thing is so by at least this [m]
SIDES: Mapping[str, tuple[int, float]] = {
    "left_of": (1, 1.0), "right_of": (1, -1.0), "behind": (0, 1.0), "in_front_of": (0, -1.0)
}  # fmt: skip
"""Axis of the robot's base, and the sign along it, of the places on each side of a thing: x leads forwards, y
to the left."""
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
STANDS = math.radians(3.0)  # what leans by no more has come to stand
OFF_PATH = 0.004  # how far beside its place what is let go may be [m]: where an arm has arrived

Check = Callable[[Placement, Query], "str | Refused"]
"""Check of a placement: returns the reason for an objection, with the obstacles if the check looks for them;
"" without an objection."""


def first_objection(placement: Placement, query: Query, checks: Mapping[str, Check]) -> Refused | None:
    """Return the refusal of a placement by the first check that objects, with the number of checks passed
    before; None if all pass.

    What stands on the target is blamed whenever nothing else is: it takes away positions that are not even
    looked at.
    """
    checkpoint()
    for passed, (name, objects) in enumerate(checks.items()):
        no = objects(placement, query)
        if no:
            why = no if isinstance(no, Refused) else refusal(no, blocking=query.standing_there())
            return replace(why, reason=f"not {name}: {why.reason}", check=name).of(placement.name, passed)
    return None


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
            said = (
                f"its outline would overlap that of '{found.name}' and the gap around it by "
                f"{1e4 * overlap:.1f} cm2"
            )
            more = (
                f"there is no room for '{query.thing.name}' beside '{found.name}' on or in "
                f"'{query.entity}': their outlines and the gap"
            )
            says = (
                f"{more} between them overlap by {1e4 * overlap:.1f} cm2: have '{found.name}' put "
                "elsewhere, or name another place"
            )
            return refusal(
                said, blocking=query.standing_there(), remedy=Remedy(f"room {query.entity}", says, overlap)
            )
    return ""


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
    return _region_missed(placement.thing, placement.height, query) if query.where.region else ""


def _region_missed(thing: Pose, height: float, query: Query) -> str | Refused:
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
    what, reaches = (
        f"'{thing_of(query.entity)}/{region}'",
        f"reaches {1000 * feature.size['height']:.0f} mm above the surface under it",
    )
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
    return (
        f"its origin would be {1000 * low:.0f} mm too low for '{query.where.region}' in this orientation"
        if low > 0
        else ""
    )


def near(placement: Placement, query: Query) -> str:
    """Check that the payload comes to rest near another thing, from middle to middle, seen from above."""
    other = query.where.near
    if not other:
        return ""
    gap = math.dist(placement.rests.position[:2], query.belief.pose(other).position[:2])
    within = query.where.within
    return (
        "" if gap <= within else f"{1000 * gap:.0f} mm from '{other}', up to {1000 * within:.0f} mm are near"
    )


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


def let_in(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload alone, whatever the grasp, has room on a way that leads in from the side."""
    return (placement.led and _met(placement, query, False)) or ""


def pushed_way(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload has room on its way in along the floor."""
    inside, close = shift(placement.rests, LIFT), replace(query, clearance=CLEAR)
    ends = query.hand(inside), query.hand(shift(placement.lies or placement.thing, LIFT))
    return let_in(Placement(placement.name, inside, *ends, float(LIFT[2]), led=True), close)


def room(placement: Placement, query: Query) -> str | Refused:
    """Check that hand and payload have room at the placement and at its stand-off, wherever the arm is; under
    an overhang also at points between the two."""
    no = _met(placement, query, True)
    if no is not None or placement.led or not query.covers:
        return no or ""
    out, over = (
        np.subtract(placement.before.position, placement.pose.position),
        query.arm.scene(clearance=0.0),
    )
    ways = (query.belief.base() * shift(placement.pose, part * out) for part in PARTS[1:-1])
    no = next((no for way in ways if (no := over.met(way)) is not None), None)
    return replace(no, reason=f"on its way down: {no.reason}", where=Stage.BEFORE) if no else ""


def _met(placement: Placement, query: Query, hand: bool) -> Refused | None:
    """Return a refusal if the payload (or the hand, if ``hand``) would meet an obstacle on the way to the
    place.

    A pose out of reach is left to another check.
    """
    for pose, far in placement.way:
        short = not placement.led and reach_shortfall(query.context.robot, pose)
        no: Refused | None = None if short else query.scene.met(query.belief.base() * pose, hand)
        if no is not None and not placement.led:
            return _at(placement, pose, no)
        if no is not None:
            return replace(no, reason=f"{1000 * far:.0f} mm from the place: {no.reason}") if far else no
    return None


def _at(placement: Placement, pose: Pose, no: Refused) -> Refused:
    """Prefix the reason of a refusal with the pose of a placement that it is about: "at the stand-off" or
    "at the place"."""
    where = Stage.BEFORE if pose == placement.before else Stage.POSE
    return replace(
        no,
        reason=f"{'at the stand-off' if where is Stage.BEFORE else 'at the place'}: {no.reason}",
        where=where,
    )


def reachable(placement: Placement, query: Query) -> str | Refused:
    """Check that inverse kinematics has solutions for the placement and its approach, whatever is in the
    way."""
    robot = query.context.robot
    for pose in (placement.before, placement.pose):
        if not inverse(robot, pose, seed=query.belief.joints):
            no = refusal(
                why_no_inverse(robot, pose), blocking=query.standing_there(), remedy=no_inverse(robot, pose)
            )
            return _at(placement, pose, no)
    return ""


def collision_free(placement: Placement, query: Query) -> str | Refused:
    """Check that arm and payload are free of collision at the placement and above it; on a way that leads
    aside or turns, all along it."""
    pose, before, back = placement.pose, placement.before, placement.back
    if placement.led:
        legs = [Leg(pose, along=(*reversed(placement.through), before), said="on its way out")]
    else:
        legs = [Leg(before, said="above it", where=Stage.BEFORE), Leg(pose, said="at it", where=Stage.POSE)]
    legs += [Leg(pose, along=(back,), said="back from it")] if back else []
    led = query.arm.led(replace(leg, clearance=query.clearance) for leg in legs)
    return led if isinstance(led, Refused) else ""


def room_to_open(placement: Placement, query: Query) -> str | Refused:
    """Check that the fingers have room to open for the release: beside the fingers there may be less room
    than around the payload."""
    found = opened(placement, query)
    return replace(found, reason=f"with open fingers {found.reason}") if isinstance(found, Refused) else ""


def opened(placement: Placement, query: Query) -> float | Refused:
    """Return the widest opening of the fingers [m] for which they have room to release the payload; or the
    refusal at the narrowest."""
    low = lowered(placement, query)
    found = [(width, query.arm.at(query.let_down(low, width))) for width in query.openings[:1]]
    for width in query.openings[1:]:
        found += (
            [(width, query.arm.at(query.let_down(low, width)))] if isinstance(found[-1][1], Refused) else []
        )
    width, there = found[-1]
    return there if isinstance(there, Refused) else width


def lowered(placement: Placement, query: Query) -> Pose:
    """Return the TCP pose at the release; before it, a payload that is put onto something is lowered to
    its support."""
    return placement.pose if query.depth else shift(placement.pose, (0.0, 0.0, -placement.height))


def hand_off(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload comes to rest on its uneven support before the hand meets the support. A payload
    that is laid down is checked elsewhere, along its whole path."""
    if not query.settles or query.held.swing is not None:
        return ""
    there = query.arm.at(query.let_down(lowered(placement, query)))
    return replace(there, reason=f"lowered {there.reason}") if isinstance(there, Refused) else ""


def rests_there(placement: Placement, query: Query) -> str | Refused:
    """Check in simulation that a payload which is released leaning, or dropped, comes to rest in the
    opening or at its place, wherever it is released nearby."""
    there = placement.kind == "dropped"
    if placement.lies is None or placement.kind not in ("in", "dropped"):
        return ""
    below = query.around if there else query.whole
    for end in rests(query.thing, placement.thing, below, query.at, OFF_PATH, there):
        if no := (_astray(end, query) if there else _leaning(end, query)):
            return no
    return ""


def _leaning(end: Pose | None, query: Query) -> str:
    """Reason why a payload at rest does not stand in an opening; "" if it does."""
    stands = end is not None and end.distance(stood_up(query.thing, end))[1] <= STANDS
    if end and stands and query.target.area.covers(footprint(query.thing, query.target.pose.inverse() * end)):
        return ""
    return f"'{query.thing.name}' may come to rest in another pose than standing when it is released"


def at_rest(placement: Placement, query: Query) -> Placement:
    """Return the placement of a dropped payload, completed by its simulated rest pose if it has one.

    Unchanged if there is no room for it, or the arm does not reach the pose of its release.
    """
    if room(placement, query) or not inverse(query.context.robot, placement.pose, seed=query.belief.joints):
        return placement  # checks say so
    return replace(
        placement,
        lies=next(rests(query.thing, placement.thing, query.around, query.at, OFF_PATH, there=True)),
    )


def dropped(placement: Placement, query: Query) -> str | Refused:
    """Check that a payload which is released in another pose than it stands in comes to rest at its place."""
    if placement.kind != "dropped" or (placement.lies is None and room(placement, query)):
        return ""
    return _astray(placement.lies, query)


def _astray(end: Pose | None, query: Query) -> str | Refused:
    """Say why a payload would come to rest at a wrong place; "" if the place is right.

    Its origin must be in the wanted region, or, where no region is wanted, its centre of mass over the
    target.
    """
    if end is None:
        return "it may come to rest nowhere near"
    to = query.target.pose.inverse() * end
    if query.where.region:
        sunk = query.depth and not -query.depth <= to.position[2] <= 0.0
        return (
            "its origin comes to rest above or below its region" if sunk else _region_missed(end, 0.0, query)
        )
    centre = shapely.Point(*to.apply(centre_of_mass(query.thing))[:2])
    return "" if query.target.area.covers(centre) else f"it comes to rest beside '{query.entity}'"


def lying_there(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload has room at its rest pose, however it was released."""
    lying = shift(placement.rests, (0.0, 0.0, placement.height))
    no: Refused | None = query.scene.met(query.belief.base() * query.hand(lying), False)
    return no or ""


SHAPES: Mapping[str, Mapping[str, Check]] = {
    "on": {
        "supported": supported,
        "clear": clear,
        "near": near,
        "beside": beside,
        "in its region": in_region,
        "let in": let_in,
    },
    "in": {"inside": inside, "falls": falls, "near": near, "beside": beside, "in its region": in_region},
    "within": {"near": near, "beside": beside, "in its region": in_region, "let in": let_in},
    "dropped": {"near": near, "beside": beside, "let in": let_in},
    "at rest": {"near": near, "beside": beside, "over its region": over_region},
    "toppled": {"lying there": lying_there, "near": near, "beside": beside},
    "before": {"near": near, "beside": beside, "let in": pushed_way},
}
"""Checks of the payload and its surroundings without hand and arm, by kind of stable pose. For "at rest", on
a support that is not level, simulation has already shown what supports the payload."""
REACHED: Mapping[str, Check] = {
    "at rest": dropped, "free to fall": falls_in, "collision-free": room, "reachable": reachable,
    "visible": visible, "collision-free with the arm": collision_free, "free to open": room_to_open,
    "let down by the thing alone": hand_off, "at rest there": rests_there,
}  # fmt: skip
"""Checks of a placement with the hand, the arm and the camera, in their order."""

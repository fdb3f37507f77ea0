"""Stable poses of a payload: upright on a face, nested in an uneven support, at rest or leaning as simulated,
and toppled.

Each is generated lazily, best first; what costs a simulation is let go of only where it would be near the
floor or in line with what is below.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Pose, Thing, Value, Vector3
from cramlite.plugin import Refused, Unresolvable

from ...motion_planning.reach import shift, taken_at, tcp
from ...shapes.bounds import corners, lowest, support
from ...shapes.front import front
from ...shapes.nesting import nested
from ...shapes.standing_up import stood_up
from ...shapes.surfaces import footprint, resting_height
from ...shapes.tipping_over import tipped_over
from ..parameters import Where
from .at_rest import CLOSE, DROPS, PALM_UP, is_uneven, leaning, must_lean, resting_poses
from .checks.rest import stays
from .checks.shapes import OFF_WALLS, WELL_IN, clear, near, supported
from .opening import TURNS, lacking
from .positions import Offset, free_for, middle, positions_on, rectangle
from .query import Placement, Query, standing_on

FEW_YAWS = (0.0, 90.0, -45.0)  # away from the middle of a surface [deg]
# Turns about the vertical that are tried first [deg]
YAWS = (0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0, 135.0, -135.0, 180.0)
FACING = (0.0, 6.0, -6.0)
"""Headings to be tried for a payload that shall face another thing, relative to facing it exactly [deg]: 15
deg count as facing, and the release may turn the payload."""
GOLDEN = 137.5077640500378  # of one further turn, another one everywhere: the golden angle [deg]
STRAIGHT = 0.99  # of the rectangle about an outline, of one that is that rectangle
PER_PLACE, PER_TURN = 0.5, 0.1  # cost of each position that comes before, and of a radian of turn
ONTO = ((0.02, 0.06), (0.01, 0.015))
"""Height of the payload's lowest point above a surface at which its guarded motion begins, and the height of
the stand-off above that [m]; the second pair is for places with little room above."""
NESTED = ((0.02, 0.06), (0.035, 0.045), (0.05, 0.03))
"""Heights as in ``ONTO`` for a payload that is let down between steep walls [m]: 20 mm higher, a bowl is 4 mm
from the sides of the bowl around it, 35 mm higher a bottle 5 mm from the rim of a ramekin; paths keep
more clearance."""
# Lowest point above a container's floor when let go, and steps up from there [m]
OFF_FLOOR, RISE = 0.01, 0.015
ABOVE = 0.06  # stand-off above a rim, or above a payload on a floor [m]
TURNLESS = 1e-6  # what is turned by less is as it was: rounding [rad]
LET_GO = 0.004
"""Height of the release [m] above the pose that is 3 to 6 mm over the first contact."""
# How far a centre of mass is beyond the edge that a thing topples over, at least [m]: the finger below it
# holds it up at first
BEYOND = 0.01
DEEPEST, STEP = 0.06, 0.005  # of the origin of what toppled in its region, and between positions [m]
ACROSS = (0.0, 0.4, -0.4)  # positions across the way in, as shares of half of the room


class Rest(Value):
    """Stable pose of a payload on or in the target of a placing problem.

    Args:
        query: with the surface that carries it.
        thing: the payload there, in the base frame.
        name: for people.
        kind: which checks of the shapes there are.
        heights: of its lowest point over that at which it may be let go of, and stand-offs above these [m].
        cost: as of groundings.
        reorients: whether it is turned.
    """

    query: Query
    thing: Pose
    name: str
    kind: str
    heights: Sequence[tuple[float, float]]
    cost: float = 0.0
    reorients: bool = False


def stable_poses(queries: list[Query], now: Pose) -> Iterator[Rest | Refused]:
    """Generate stable poses to which a payload is let down from above.

    Args:
        now: of the payload in the base frame, turned as it is put down.
    """
    first = queries[0]
    if is_uneven(first):
        lowered = replace(first, settles=True)
        none = f"it would slide or fall off '{first.entity}', let go of in any of {DROPS} ways"
        yield from _simulated(lowered, resting_poses(lowered, now), now, ONTO, none)
    if first.uneven:
        return
    if not (why := must_lean(first, now)):
        if first.under and not any(_stands(rest) for rest in _upright(queries[:1], now)):
            none = f"nor would it come to rest on '{first.entity}', let go of in any of {DROPS} ways"
            yield from _upright(queries[:1], now)
            yield from _simulated(first, resting_poses(first, now), now, NESTED, none)
            queries = queries[1:]
        yield from _upright(queries, now)
        return
    if not first.depth:
        none = f"{why}; nor would it come to rest in the region, released in any of {DROPS} ways"
        yield from _simulated(replace(first, settles=True), resting_poses(first, now), now, ONTO, none)
        return
    close = replace(first, clearance=CLOSE)
    none = f"{why}; nor would it rest in the region if it leaned against a wall"
    yield from _simulated(close, leaning(close, now), now, ((LET_GO, close.depth + ABOVE),), none)


def _simulated(
    query: Query, found: Iterator[Pose], now: Pose, heights: Sequence[tuple[float, float]], none: str
) -> Iterator[Rest | Refused]:
    """Yield the stable poses that a simulation found; a refusal if it found none."""
    pose = None
    for pose in found:
        x, y, z = (1000 * v for v in pose.position)
        turn = PER_TURN * math.hypot(*(now.inverse() * pose).rotvec)
        name = f"at rest at ({x:+.0f} {y:+.0f} {z:+.0f}) mm from the robot"
        yield Rest(query, pose, name, "at rest", heights, turn, True)
    if pose is None:
        yield Refused("anywhere", f"not at rest: {none}")


def _upright(queries: list[Query], now: Pose) -> Iterator[Rest]:
    """Stable poses of an upright payload at the positions on all surfaces, taking one position of each
    surface in turn, with several turns each."""
    streams = [zip(itertools.repeat(q), positions_on(q, now)) for q in queries]
    every = (found for row in itertools.zip_longest(*streams) for found in row if found is not None)
    for k, (query, offset) in enumerate(every):
        yaws = turns(query, now, offset, YAWS if k < len(queries) else FEW_YAWS)
        for yaw in FACING if query.where.facing else (*yaws, *((GOLDEN * k % 360,) if k else ())):
            yield standing_at(query, now, offset, yaw, PER_PLACE * k)
            if query.under and (other := query.where.near):
                yield standing_at(query, now, _over(other, query, now, yaw), yaw, PER_PLACE)
        yield from _askew(query, now) if query.depth and k < len(queries) else ()


def _askew(query: Query, now: Pose) -> Iterator[Rest]:
    """Yield stable poses of an upright payload that fits between the walls of an opening askew alone, such as
    a mug with its handle in a corner: in the middle of its room, whatever holds it."""
    to, amid = query.target.pose.inverse(), stood(query, now, (0.0, 0.0), 0.0)
    _, lacks = lacking(footprint(query.thing, to * amid), query)
    along, best = turns(query, now, (0.0, 0.0), ()), float(TURNS[lacks.argmin()])
    if lacks.min() > 0 or any(lacks[round(yaw) % len(lacks)] <= 0 for yaw in along):
        return
    for yaw in (best, best + 180.0):
        rest = standing_at(query, now, (0.0, 0.0), yaw)
        ends = [
            np.reshape(a.bounds, (2, 2)) for a in (query.target.area, footprint(query.thing, to * rest.thing))
        ]
        x, y = (ends[0] - ends[1]).mean(axis=0)
        thing = shift(rest.thing, query.target.pose.rotate((float(x), float(y), 0.0)))
        yield replace(rest, thing=thing, name=f"{rest.name}, in the middle of its room")


def _over(other: str, query: Query, now: Pose, yaw: float) -> Offset:
    """Position at which the origin of a payload, turned by ``yaw`` [deg], is over that of another thing:
    their middles may be elsewhere, as those of mugs with handles."""
    there, amid = query.belief.pose(other).position, stood(query, now, (0.0, 0.0), yaw).position
    x, y, _ = query.target.pose.inverse().rotate(np.subtract(there, amid)).tolist()
    return x, y


def _stands(rest: Rest) -> bool:
    """Whether the support carries the payload in a stable pose near enough to the wanted place."""
    here = Placement(rest.name, rest.thing, rest.thing, rest.thing, 0.0)
    return not any(objects(here, rest.query) for objects in (supported, near, stays))


def standing_at(query: Query, now: Pose, offset: Offset, yaw: float = 0.0, cost: float = 0.0) -> Rest:
    """Return the stable pose of a payload over a position, turned by ``yaw`` [deg] about the vertical."""
    settled = _settled(query, now, offset, yaw)
    at = offset if settled is query else (0.0, 0.0)
    turn, asked = PER_TURN * abs(math.radians(math.remainder(yaw, 360.0))), query.where.attitude is not None
    there = f"({1000 * offset[0]:+.0f} {1000 * offset[1]:+.0f}) mm from its middle, " if any(offset) else ""
    name, thing = f"{there}turned {math.remainder(yaw, 360.0):+.0f} deg", stood(settled, now, at, yaw)
    return Rest(settled, thing, name, "in" if query.depth else "on", heights(query, now), cost + turn, asked)


def turns(query: Query, now: Pose, offset: Offset, few: tuple[float, ...]) -> tuple[float, ...]:
    """Return the rotations of a payload about the vertical [deg] to try: ``few`` and, among the first, those
    that align its straight sides with the target's."""
    area = query.target.area
    if not (query.depth or query.where.region) or area.area < STRAIGHT * shapely.box(*area.bounds).area:
        return few  # nothing marks its sides, or its opening is round
    there, axis = stood(query, now, offset, 0.0), query.target.pose.rotate((1.0, 0.0, 0.0))
    side = np.subtract(*rectangle(query, there)[:2])
    apart = math.degrees(math.atan2(axis[1], axis[0]) - math.atan2(side[1], side[0]))
    along = sorted(
        (round(math.remainder(apart + quarter, 360.0), 2) for quarter in (0.0, 90.0, 180.0, 270.0)), key=abs
    )
    seen = footprint(query.thing, query.target.pose.inverse() * there)
    straight = seen.area > STRAIGHT * shapely.minimum_rotated_rectangle(seen).area
    if not query.depth:
        return tuple(dict.fromkeys((*along[:1], *few))) if straight else few
    narrow = straight or not area.buffer(-OFF_WALLS).covers(seen)
    return (*along, *few) if narrow else (*few[:1], *along, *few[1:])


def _settled(query: Query, now: Pose, offset: Offset, yaw: float) -> Query:
    """Return a placing problem whose target is the part of an uneven support that will carry the payload.

    The payload is let down over a position, turned by ``yaw``.

    The same problem if its support is level, or if no part of it carries the payload.
    """
    if query.under is None:
        return query
    there = stood(query, now, offset, yaw)
    found = nested(query.thing, there, query.under, query.belief.pose(query.under.name))
    return replace(query, target=found) if found else query


def stood(query: Query, now: Pose, offset: Offset, yaw: float) -> Pose:
    """Return the pose of a payload that stands on its target with its middle over a position.

    It is turned by an angle [deg] from facing the robot as it does now, or from facing what it shall face.
    """
    hand, target = tcp(query.belief, query.context), query.target.pose.apply((*offset, 0.0))
    facing = math.atan2(target[1], target[0]) - math.atan2(hand.position[1], hand.position[0])
    if other := query.where.facing:
        ahead, to = now.rotate(front(query.thing.features)), query.belief.pose(other).position - target
        facing = math.atan2(to[1], to[0]) - math.atan2(ahead[1], ahead[0])
    turned = about_vertical(now, facing + math.radians(yaw))
    x, y = target[:2] - middle(query, turned)
    return Pose.at((x, y, target[2] + support(query.thing, turned, (0, 0, -1))), turned)


def about_vertical(pose: Pose, angle: float) -> Pose:
    """Return the orientation of a pose, turned about the vertical by an angle [rad], as a pose at the
    origin."""
    return Pose.at((0, 0, 0), Pose.from_rotvec((0, 0, 0), (0, 0, angle)) * pose)


def heights(query: Query, now: Pose) -> list[tuple[float, float]]:
    """Return release heights of a payload's lowest point above its target, and stand-offs above these [m].

    Over a container from its floor up to where the whole hand is over the rim, however it holds the payload.
    """
    if not query.depth:
        return list(NESTED if query.under else ONTO)
    gripper, hand = query.context.robot.gripper, query.hand(now)
    ball = math.hypot(*gripper.tcp.position) + gripper.pad[1]  # about the TCP, that holds the hand
    low = -query.depth + OFF_FLOOR
    high = ball - (hand.position[2] + support(query.thing, now, (0.0, 0.0, -1.0)))
    return [(float(h), max(ABOVE - float(h), ABOVE)) for h in np.arange(low, max(high, 0.0) + RISE, RISE)]


def put_down(query: Query) -> Pose:
    """Return the payload's orientation for the placement, in the base frame: the asked one, else the present
    one; a leaning payload is stood up, unless it goes into something or has contents."""
    if not query.depth and not query.where.attitude and query.thing.filling is None:
        return stood_up(query.thing, query.now)
    return as_asked(query.now, query.where)


def as_asked(now: Pose, where: Where) -> Pose:
    """Return a pose in the base frame, turned the shortest way until its z axis points up or down as
    ``attitude`` asks."""
    if not where.attitude:
        return now
    up, axis = now.rotate((0.0, 0.0, 1.0)), {"upright": 1.0, "upside down": -1.0}[where.attitude]
    way = np.cross(up, (0.0, 0.0, axis))
    sine = float(np.linalg.norm(way))
    angle = math.atan2(sine, axis * float(up[2]))
    if sine < TURNLESS:  # half a turn is as short about any level axis
        way, sine = now.rotate((1.0, 0.0, 0.0)), 1.0
    return Pose.at(now.position, Pose.from_rotvec((0, 0, 0), way / sine * angle) * now)


def check_turn(query: Query, asked: Pose) -> None:
    """Check that a payload can be turned to the orientation of a pose, with the present grasp.

    Raises:
        Unresolvable: what is in it would be spilled, or the hand would come under it; then another grasp may
            do.
    """
    if math.hypot(*(query.now.inverse() * asked).rotvec) < TURNLESS:  # rounding turns nothing
        return
    if query.thing.filling is not None:
        raise Unresolvable(f"'{query.thing.name}' holds something that would be spilled", (query.entity,))
    rise = float(query.hand(asked).rotate((0.0, 0.0, 1.0))[2])
    if rise > PALM_UP:
        up = math.degrees(math.asin(min(rise, 1.0)))
        said = f"turned so, the hand would be under '{query.thing.name}' and reach up by {up:.0f} deg"
        raise Unresolvable(said, taken_at(query.belief, query.context))


def with_middle(bare: list[Query]) -> list[Query]:
    """Return the placing problems to try, one for each surface with the obstacles on it; on a movable support
    with a rim, its middle is tried first.

    Of a movable support with a rim, such as a plate: the middle of its largest surface, then that surface if
    it has room elsewhere.
    """
    level = [replace(q, obstacles=standing_on(q)) for q in bare]
    first, thing = level[0], level[0].whole
    if thing.furniture or first.where.region or not any(o.name == thing.name for o in first.obstacles):
        return level
    hollow, others = thing.feature("cram:Cavity"), tuple(o for o in first.obstacles if o.name != thing.name)
    x, y, _ = (first.at * hollow.pose if hollow else first.target.pose).position
    target = replace(first.target, pose=Pose((x, y, first.target.pose.position[2])))
    amid, now = replace(first, target=target, obstacles=others, under=thing, settles=True), put_down(first)
    own = replace(first, obstacles=tuple(o for o in first.obstacles if o.name == thing.name))
    spots = (shift(stood(own, now, (0.0, 0.0), yaw), (0.0, 0.0, ONTO[0][0])) for yaw in YAWS)
    within = any(not clear(Placement("", spot, spot, spot, ONTO[0][0]), own) for spot in spots)
    return [amid, replace(first, settles=True)] if within and not free_for(first, now).is_empty else [amid]


def toppled(query: Query, upright: Pose, out: Floats, lean: float) -> Iterator[tuple[Pose, Pose, str]]:
    """Generate poses in which to release a payload that leans out of an opening by an angle [deg], with the
    pose to which it falls.

    It topples over its lowest edge, and its origin is then in the region.

    Those farthest in come first.

    Args:
        upright: attitude of the payload.
        out: level unit vector (3,).
    """
    tilt = math.radians(lean) * np.cross((0.0, 0.0, 1.0), out)
    turned = Pose.at((0.0, 0.0, 0.0), Pose.from_rotvec((0.0, 0.0, 0.0), tilt) * upright)
    over = tipped_over(query.thing, turned)
    if over is None or over[1] < BEYOND or (low := _floor(query, over[0])) is None:
        return
    for deep, share in product(np.arange(DEEPEST, WELL_IN, -STEP).tolist(), ACROSS):
        by = inside_from(query, out, deep, share) - over[0].position
        by[2] = low - lowest(query.thing, turned)
        lies = shift(over[0], by)
        if well_in(query, lies):
            said = f"leaning out by {lean:.0f} deg, to lie {1000 * deep:.0f} mm in"
            yield shift(turned, by), lies, f"{said}, at {100 * share:+.0f} % across"


def well_in(query: Query, lies: Pose) -> bool:
    """Check that a payload's origin at a pose is in an opening, and not near its sides."""
    x, y, z = map(float, query.target.pose.inverse().apply(lies.position))
    area = query.target.area.buffer(-WELL_IN)
    return -query.depth <= z <= 0.0 and bool(area.covers(shapely.Point(x, y)))


def _floor(query: Query, lying: Pose) -> float | None:
    x, y, z = map(float, query.target.pose.apply((0.0, 0.0, -query.depth / 2)))
    return carried_at(query.thing, lying, (x, y, z), query.belief)


def carried_at(thing: Thing, turned: Pose, point: Vector3, belief: Belief) -> float | None:
    """Return the height at which a thing rests on what is below it, with its middle over or under a point of
    the base frame [m].

    The thing is turned as in ``turned``; None if nothing is below it.
    """
    points = corners(thing, turned)
    middle = np.asarray(point) - (points.min(axis=0) + points.max(axis=0)) / 2
    there = Pose.at(turned.position + middle, turned)
    others = [(belief.thing(n), belief.pose(n)) for n in belief.poses if n != thing.name]
    height, _ = resting_height(thing, there, others)
    return height if math.isfinite(height) else None


def inside_from(query: Query, out: Floats, deep: float, share: float) -> Floats:
    """Return a point (3,) of an opening in the base frame [m], ``deep`` inside the opening's edge on the side
    of the direction ``out``.

    Along that edge it is off the middle by a share of half the width.
    """
    low, high = np.reshape(query.target.area.bounds, (2, 2))
    way = query.target.pose.inverse().rotate(out)[:2]
    across = np.array([-way[1], way[0]])
    half, middle = (high - low) / 2, (low + high) / 2
    x, y = middle + (np.abs(way) @ half - deep) * way + share * (np.abs(across) @ half) * across
    found: Floats = query.target.pose.apply((float(x), float(y), 0.0))
    return found

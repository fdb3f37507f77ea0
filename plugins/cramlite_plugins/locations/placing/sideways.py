"""Ways out from under a roof through an open side, such as out of a microwave, with room for hand and
payload, whatever the arm does."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from cramlite.model import Belief, Floats, Pose, Remedy, Thing
from cramlite.plugin import Context, Refused, Unresolvable

from ...kinematics.reach import reach_gap, reach_shortfall
from ...motion_planning.postures import CLEARANCE
from ...motion_planning.reach import SIGMAS, shift, taken_at
from ...shapes.bounds import box_around, centre_of_mass, corners, height, lowest, support
from ...shapes.box_overlaps import overlaps
from ...shapes.roofs import has_a_roof, open_sides
from ...shapes.standing_up import stood_up
from ...shapes.surfaces import Surface, footprint, surfaces
from ..later import brings
from ..pinching.antipodal import Hands
from ..pinching.hand_room import HandRoom, Taken
from ..pushing.contacts import STEEP
from ..reached import Arm
from .attitudes import attitudes
from .checks.rest import at_rest
from .floors import ASIDE, HIGH, Floor, levels
from .query import Groups, Placement, Query, roof_above
from .stable_poses import TURNLESS, about_vertical, as_asked, check_turn

BEFORE_IT = 0.02  # between the payload and the thing that it goes into, where a level way begins [m]
TURNS = (0.0, 10.0, -10.0, 20.0, -20.0, 5.0, -5.0)  # of the hand from pointing straight inwards [deg]
PARTS = (0.0, 0.15, 0.4, 1.0)  # of a way out at which boxes about hand and payload have to be free
PIECES = 12  # of a payload at most, each of which is looked at
FEW = 2  # steps of one, where all grips of a thing are looked at
COARSE = 0.01  # between openings of hands that are looked at together [m]
HAND = 0.25  # room that a hand needs along itself [m]
MANY = 6  # placements of each step outwards that are looked at, of what is not simulated
BEYOND = 0.05  # by so much a way may begin out of reach and another one still in reach [m]
SOME = 8  # placements at which the hand itself is looked at, where boxes about it have no room at any


def sideways(asked: list[Query]) -> Groups:
    """Generate placements under an overhang by a level way through an open side, those farthest in first.

    The payload is carried upright, or held by a hand that points inwards and released to come to rest.

    Those at which boxes about hand and payload have room come first; others, upright, only where there are
    none.

    Raises:
        Unresolvable: the payload is too high, or no side is open.
    """
    first, low, found, none = asked[0], list[float](), False, True
    upright = first.now
    if first.thing.filling is None:
        upright = as_asked(stood_up(first.thing, first.now), first.where)
    if first.where.attitude:
        check_turn(first, upright)
    for kind, now in _kinds(first, upright):
        tall = height(first.thing, now) + 2 * HIGH
        for query, floor in _floors(asked, now, tall, low):
            found = True
            there = _over_all(query, floor) if query.roof and kind == "dropped" else query
            for placement in _level(there, floor, now, kind):
                none = False
                yield iter([(there, placement)])
    if found and none:
        said = "the bounding boxes of hand and payload fit nowhere on the floor of the target"
        yield Refused("anywhere", said)
    if not found:
        raise _too_high(first, max(low, default=0.0), height(first.thing, upright) + 2 * HIGH)


def _kinds(query: Query, upright: Pose) -> Iterator[tuple[str, Pose]]:
    """Pairs of a placement's kind and the payload's attitude, to be tried on a floor under a roof.

    Upon a thing under a roof, the payload may come to rest of itself where shapes alone do not show
    that it stands, such as on the rim of a bowl.
    """
    for kind, now in attitudes(query, upright):
        yield kind, now
        if query.roof and kind != "dropped":
            yield "dropped", now


def _over_all(query: Query, floor: Floor) -> Query:
    """Return the placing problem whose target is the outline of the whole thing below the payload, instead of
    the part that the payload touches first."""
    seen = floor.surface.pose.inverse() * query.at
    return replace(query, target=Surface(floor.surface.pose, footprint(query.whole, seen)))


def _floors(
    asked: Sequence[Query], now: Pose, tall: float, low: list[float]
) -> Iterator[tuple[Query, Floor]]:
    """Yield each floor with room enough under its roof for a payload, once for each open side, with the
    placement problem.

    The payload is turned as at the pose ``now``.

    The height of the room over each floor that was looked at is appended to ``low`` [m].
    """
    for query in asked[:1] if asked[0].roof else asked:
        whole, at = query.roofing, query.belief.pose(query.roofing.name)
        for surface, over, high in levels(
            query.thing, now, query.whole, query.region, query.belief, query.depth > 0
        ):
            low.append(over)
            more = _raised(query, surface, over - tall)
            there = replace(query, target=surface, under=query.whole, settles=True) if query.roof else query
            for out in open_sides(whole, at, surface, tall / 2 - HIGH) if tall <= over else ():
                yield there, Floor(whole, at, surface, over - more, out, high + more)


def _raised(query: Query, floor: Surface, spare: float) -> float:
    """How much higher above a floor a level way is for the errors of twins [m]: as far as these move
    floor and payload, up to the middle of the ``spare`` height under the roof."""
    errors = query.context.errors
    if errors is None or spare <= 0:
        return 0.0
    deep = float(np.ptp(np.reshape(floor.area.bounds, (2, 2)), axis=0).max())
    away = math.hypot(errors.sigma(query.whole.name, deep), errors.sigma(query.thing.name, deep / 2))
    return min(SIGMAS * away, spare / 2)


def _too_high(query: Query, room: float, needed: float) -> Unresolvable:
    """Refusal of a payload that is too high for the room under an overhang, or of a target without an open
    side; it names the grasp as a cause if a lying payload would fit."""
    low = room - needed + 2 * HIGH
    if low >= 2 * HIGH:
        return Unresolvable(f"no side of '{query.entity}' is open", blocking=())
    more = f"{1000 * low:.0f} mm higher than '{query.thing.name}', {2000 * HIGH:.0f} mm is needed"
    says = (
        f"the opening of '{query.entity}' is {1000 * room:.0f} mm high, '{query.thing.name}' needs "
        f"{1000 * needed:.0f} mm with the gap around it: take a lower thing, lay it down, or name another "
        "place"
    )
    remedy = Remedy(f"room {query.entity}", says, needed - room)
    said = f"the room under the roof of '{query.entity}' is {more}"
    low_side = float(np.min(np.ptp(corners(query.thing, Pose()), axis=0)))
    lies = low_side + 2 * HIGH <= room and not query.where.attitude and query.thing.filling is None
    grasps = taken_at(query.belief, query.context) if lies else ()
    return Unresolvable(said, grasps, blocking=(), remedy=remedy)


def _level(query: Query, floor: Floor, now: Pose, kind: str) -> Iterator[Placement]:
    """Generate placements on a floor under a roof, from its middle to its open side, with the hand pointing
    in through that side.

    A payload that is not released upright gets its simulated rest pose. If all are out of reach, one is kept
    for the refusal.
    """
    few = 1 if kind != "dropped" else FEW
    first = _at(query, floor, now, kind, floor.spots()[0], 0.0)
    if reach_gap(query.context.robot, first.before)[0] > BEYOND:
        yield first
        return
    turns, spots = TURNS if few == 1 else TURNS[:3], floor.spots(few)
    around = HandRoom.amid(floor.whole.name, query.thing.name, query.belief, query.arm.scene())
    hands, opening = Hands.at([query.hand(now)]), np.array([query.held.opening])
    free = _free(floor, around, query.thing, now, hands, opening, np.radians(turns), few)[0]
    rows = np.argwhere(free) if free.any() or few > 1 else np.argwhere(~free)[:SOME]
    found = [_at(query, floor, now, kind, spots[k], turns[turn]) for k, turn in _of_each_step(rows, few)]
    short, robot = reach_shortfall, query.context.robot
    near = [one for one in found if not short(robot, one.pose) and not short(robot, one.before)]
    for placement in near or found[:1]:
        yield placement if kind != "dropped" else at_rest(placement, query)


def _of_each_step(rows: NDArray[np.intp], few: int) -> list[list[int]]:
    """Limit the pairs (spot, turn of the hand) to try at each distance from a floor's middle: to ``MANY``, or
    to one if ``few`` > 1 asks for few trials.

    To simulate how a payload comes to rest at one spot takes some ten runs.
    """
    steps = rows[:, 0] // (len(ASIDE) if few == 1 else len(ASIDE[:3]))
    before = np.arange(len(rows)) - np.searchsorted(steps, steps)
    found: list[list[int]] = rows[before < (MANY if few == 1 else 1)].tolist()
    return found


def _at(query: Query, floor: Floor, now: Pose, kind: str, spot: tuple[Floats, str], turn: float) -> Placement:
    """Placement of a payload at a spot of a floor, turned by ``turn`` [deg] from where the hand points
    straight in through the floor's open side."""
    ahead, (point, name) = query.hand(now).rotate((0.0, 0.0, 1.0)), spot
    spin = math.atan2(-floor.out[1], -floor.out[0]) - math.atan2(ahead[1], ahead[0]) + math.radians(turn)
    turned = about_vertical(now, spin)
    over = point - turned.apply(centre_of_mass(query.thing)) * (1.0, 1.0, 0.0)
    thing = shift(shift(turned, over), (0.0, 0.0, floor.high + support(query.thing, turned, (0, 0, -1))))
    far = support(floor.whole, floor.at, floor.out) + support(query.thing, thing, -floor.out) + BEFORE_IT
    pose, said = query.hand(thing), f"{name}, turned {turn:+.0f} deg, through its side"
    reorients = turned.distance(about_vertical(query.now, spin))[1] > TURNLESS
    said += f", as a hand holds it that points down by {_down(pose):.0f} deg" if reorients else ""
    before = shift(pose, far * floor.out)
    return Placement(said, thing, pose, before, floor.high, kind, led=True, reorients=reorients)


def _down(hand: Pose) -> float:
    """Angle of a hand below the level [deg]."""
    down = -float(hand.rotate((0.0, 0.0, 1.0))[2])
    return round(math.degrees(math.asin(max(-1.0, min(1.0, down)))), 3) + 0.0


def _free(
    floor: Floor,
    around: HandRoom,
    thing: Thing,
    now: Pose,
    hands: Hands,
    openings: Floats,
    turns: Floats,
    few: int,
) -> NDArray[np.bool_]:
    """Check whether boxes around hand and payload have room on the level way out, for each hand pose, spot
    and turn: (n, spots, turns).

    Args:
        now: of the payload in the base frame, with the hands (n) at it.
        openings: of the fingers (n,) [m].
        turns: of the hands from pointing straight inwards [rad].
    """
    points = np.array([point for point, _ in floor.spots(few)])
    shape = (len(openings), len(points), len(turns))
    if not len(openings):
        return np.zeros(shape, bool)
    spin = _inwards(floor, hands, turns)
    x, y, _ = centre_of_mass(thing) @ now.rotation.T + now.position
    foot = np.array([x, y, now.position[2] + lowest(thing, now) - floor.high])

    def spread(vectors: Floats) -> Floats:
        """Move points (n, 3) of the payload or hand, relative to the payload's foot, to each spot, turned by
        each angle: (n * spots * turns, 3)."""
        found: Floats = np.einsum("ntij,nj->nti", spin, vectors)[:, None] + points[:, None, :]
        return found.reshape(-1, 3)

    def turned(axes: Floats) -> Floats:
        found = np.einsum("ntij,njk->ntik", spin, axes)[:, None]
        return np.broadcast_to(found, (*shape, 3, 3)).reshape(-1, 3, 3)

    boxes = [
        (spread(np.tile(m - foot, (*shape[:1], 1))), turned(np.tile(t, (*shape[:1], 1, 1))), half)
        for m, t, half in _boxes(thing, now)
    ]
    reached = Hands(spread(hands.positions - foot), turned(hands.turns))
    wide = np.repeat(openings, len(points) * len(turns))
    return _clear_out(floor, around, boxes, reached, wide).reshape(shape)


def _clear_out(
    floor: Floor, around: HandRoom, boxes: Sequence[tuple[Floats, Floats, Floats]], hands: Hands, wide: Floats
) -> NDArray[np.bool_]:
    """Check for each of n hand poses whether boxes around payload and hand have room on the level way out: a
    mask (n,).

    Args:
        boxes: middles (n, 3), axes (n, 3, 3) and half sizes of the box around the payload, then of its parts.
        wide: openings of the fingers (n,) [m].
    """
    (whole, axes, half), *parts = boxes
    far = support(floor.whole, floor.at, floor.out) + BEFORE_IT - whole @ floor.out
    far += np.abs(np.einsum("nij,i->nj", axes, floor.out)) @ half
    rows = np.arange(len(far))
    for part in PARTS:
        by = part * far[rows, None] * floor.out
        met = np.asarray(overlaps(around.others, whole[rows] + by, axes[rows], half + CLEARANCE).any(axis=1))
        if parts and met.any():
            met[met] = _any_met(around, parts, rows[met], by[met])
        rows = rows[~met]
        some = hands.of(rows)
        some = Hands(some.positions + part * far[rows, None] * floor.out, some.turns)
        rows = rows[~around.meets(around.others, some, wide[rows], CLEARANCE)]
    free = np.zeros(len(far), bool)
    free[rows] = True
    return free


def _inwards(floor: Floor, hands: Hands, turns: Floats) -> Floats:
    """Rotations about the vertical, (n, turns, 3, 3), that point each hand (n) in through a floor's open
    side, then add each of ``turns`` [rad]."""
    facing = math.atan2(-floor.out[1], -floor.out[0]) - np.arctan2(hands.approach[:, 1], hands.approach[:, 0])
    angles = facing[:, None] + turns
    c, s, zero = np.cos(angles), np.sin(angles), np.zeros(angles.shape)
    found: Floats = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1.0], -1).reshape(
        *angles.shape, 3, 3
    )
    return found


def _any_met(
    around: HandRoom, parts: Sequence[tuple[Floats, Floats, Floats]], rows: NDArray[np.intp], by: Floats
) -> NDArray[np.bool_]:
    """Whether a box of a payload's parts overlaps a thing, for each chosen pose (``rows``) shifted by a
    vector (n, 3) [m]."""
    met = (overlaps(around.others, m[rows] + by, t[rows], half + CLEARANCE) for m, t, half in parts)
    return np.asarray(np.any([one.any(axis=1) for one in met], axis=0))


def _boxes(thing: Thing, now: Pose) -> list[tuple[Floats, Floats, Floats]]:
    """Boxes about a payload at a pose: one about all of it, then one about each of its parts if they are few.

    A box about a round or hollow thing that leans reaches lower than the thing.

    Returns:
        Of each the centre (3,), axes as columns (3, 3), and halved side lengths (3,), in the base frame [m].
    """
    low, high = box_around(thing.geoms)
    few = thing.geoms if len(thing.geoms) <= PIECES else ()
    parts = ((now * g.pose, np.asarray(g.half_extents, float)) for g in few)
    whole = now.apply((low + high) / 2), now.rotation, (high - low) / 2
    return [whole, *((np.asarray(p.position), p.rotation, half) for p, half in parts)]


def comes_in(thing: Thing, belief: Belief, context: Context, taken: Taken) -> NDArray[np.bool_] | None:
    """Check with which grasps (n) a thing, as it stands now, fits under the overhang of the place where a
    later task puts it; None if no later task puts it under one.

    Later tasks are looked at only where there is a roof, so that what follows elsewhere holds whatever they
    are. A table's board near the floor is not meant by the table, off which a thing is picked up.
    """
    now, hands, openings = belief.pose(thing.name), taken.hands, taken.openings
    others = (name for name in belief.poses if name != thing.name)
    if not any(has_a_roof(belief.thing(other), belief.pose(other)) for other in others):
        return None
    floors = [f for f in _floors_later(thing, now, belief, context) if _in_reach(f, context)]
    scene = Arm(belief, context).scene()
    found = np.zeros(len(openings), bool)
    for floor in floors:
        around = HandRoom.amid(floor.whole.name, thing.name, belief, scene)
        level = np.flatnonzero(taken.free & ((hands.approach[:, 2] > -STEEP) | (floor.room > HAND)))
        wide, turns = np.ceil(openings[level] / COARSE) * COARSE, np.radians(TURNS[:3])
        found[level] |= _free(floor, around, thing, now, hands.of(level), wide, turns, FEW).any(axis=(1, 2))
    return found if floors else None


def _in_reach(floor: Floor, context: Context) -> bool:
    """Whether a hand that points in through the open side of a floor, or down where it has room, reaches the
    outermost spots of the floor."""
    (point, _), up = floor.spots(FEW)[-len(ASIDE[:3])], np.array((0.0, 0.0, 1.0))
    aims = [(-floor.out, up), *([(-up, floor.out)] if floor.room > HAND else [])]
    return any(reach_gap(context.robot, Pose.from_axes(point, z, x))[0] <= BEYOND for z, x in aims)


def _floors_later(thing: Thing, now: Pose, belief: Belief, context: Context) -> Iterator[Floor]:
    """Floors under a roof to which later tasks bring a thing."""
    for onto, region, _ in brings(thing.name, belief, context):
        whole = belief.thing(onto.thing)
        above = roof_above(whole, belief)
        roof, at = belief.thing(above or whole.name), belief.pose(above or whole.name)
        if not (region or above) and surfaces(whole, at):
            continue
        for within in (False, True):
            for surface, over, high in levels(thing, now, whole, region, belief, within):
                for out in open_sides(roof, at, surface, height(thing, now) / 2):
                    yield Floor(roof, at, surface, over, out, high)

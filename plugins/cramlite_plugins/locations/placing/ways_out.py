"""Ways of a payload out of a stable pose into the open, planned backwards: up, obliquely, through a side, tilted first, and toppling.

Each is a generator of placements for the one driver, which checks hand and payload, arm, and what later tasks need. Another way
to put something is another function here, and an entry of ``WAYS``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Pose, Remedy, Value
from cramlite.plugin import Context, Refused, Unresolvable, checkpoint

from ...kinematics.kinematics import inverse
from ...motion_planning.cartesian import interpolate
from ...motion_planning.reach import shift, taken_at, tcp
from ...shapes import ray_casting as rays
from ...shapes.bounds import centre_of_mass, corners, height, support
from ...shapes.roofs import has_a_roof, open_sides, roofed
from ...shapes.standing_up import stood_up
from ...shapes.surfaces import surfaces
from ..from_aside import slants
from ..later import brings
from ..parameters import Where
from ..reached import Arm
from .checks import OFF_WALLS, SHAPES, first_objection
from .positions import free_area, free_for, positions_on, radius
from .query import Placement, Query, covers, is_roofed, lying_in, openings, standing_on
from .stable_poses import (
    Rest,
    about_vertical,
    along_walls,
    check_turn,
    extent,
    heights,
    put_down,
    stable_poses,
    standing_at,
    toppled,
    with_middle,
)

PER_HEIGHT = 0.02  # cost of each height above the lowest
BETWEEN = (1.0, 0.67, 0.33)  # parts of a way down from aside that are looked at first
OUT = 1.0  # from the middle of a surface to the outside of what it is in, at most [m]
HAND = 0.25
"""Room that a hand needs along itself: what it holds is at one end of that, the arm at the other [m]."""
WAYS_OUT, BESIDE = 1000, math.cos(math.radians(8.0))
"""Directions in which a way out is looked for, 6 deg between neighbours, and the cosine of the angle around one in which all must be
free: a gap of less than 30 mm at 0.1 m, such as around the front of a drawer, is no way out for a hand."""
RISE = 0.12
"""Of a way into an opening [m]: twice as deep as drawers of desks are."""
PARTS = (0.0, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0)  # of such a way that have to be free
LOWS = (0.01, 0.02, 0.03)  # of its lowest point over the floor of a cavity at the end of one, which may be a little higher than stated [m]
PITCH = 0.02  # between positions in an opening at which one is looked for [m]

LEVELLY = (0.0, 0.33, 0.67, 1.0)  # parts of a level way out that are looked at before the arm is
HIGH = 0.010  # lowest point above a surface on a level way [m]
BEFORE_IT = 0.02  # between the payload and the thing that it goes into, where a level way begins [m]
STEP = 0.01  # between positions, from the middle of a surface outwards [m]
ASIDE = (0.0, 0.3, -0.3, 0.1, -0.1, 0.2, -0.2)
"""Positions across the way in, as shares of half the width: in a microwave beside its open door a hand had room on 15 mm of it."""
TURNS = (0.0, 10.0, -10.0, 20.0, -20.0, 5.0, -5.0)  # of the hand from pointing straight inwards [deg]
STEEP = 0.85  # of the hand's approach, downwards, from which on it points nowhere: it would be as high as it is long

TILTS = (25.0, 30.0, 20.0)
"""From upright [deg]: between handles and wall a bowl of 107 mm has more room the more it leans, and the hand at its rim less."""
LEFT = 12.0
"""Of that when it is let go of [deg]: upright, a hand that leans by 30 deg would be in the wall; from there a bowl stands up."""
SHARES = (0.75, 1.0, 0.5)  # of its height that a way in leads aside, below what it comes in under
INWARDS = (0.012, 0.006, 0.018, 0.0)  # from where it would stand as far out as it can [m]: farther in it is farther from the wall
ACROSS = (0.0, 0.6, -0.6)  # of the room to each side, across the way that it leans
FARTHER = (0.024, 0.016, 0.008)  # how much farther out it leans more [m]
OVER = (0.02, 0.03, 0.01)  # how much higher its lowest point is there [m]
HEADINGS, FIRST = 24, 3
"""Turns of a thing about its own axis, and how many are tried: those at which the hand is nearest to pointing straight down as it leans."""
STRAIGHTEN = (0.25, 0.5, 0.75)  # parts of its turn at which all has to be free
LEAST = 0.01  # from the middle of an opening to that of what covers it, by which it is on one side [m]
COVERS = 0.3  # over an opening what covers it is looked for [m]: as high as a thing is carried

LEANS = (55.0, 50.0, 45.0, 40.0, 35.0, 30.0)
"""From upright [deg]: the more it leans, the farther in its foot can be and the less it falls; from 58 deg on a Panda's hand that
holds a book of 120 mm by its end is in the table."""
KEPT = 0.008  # lowest point over what carries what topples, on the way in [m]: what paths keep, and a little more
CLEAR = 0.03  # how far out from under the roof its foot is at the stand-off [m]
BACK = 0.12
"""How far the hand goes back the way it points [m]: from under what topples onto its lower finger, and takes that along a little,
LIBERO's book by 48 mm, as its Panda's pads have a friction of 2."""

Found = tuple[Query, Placement]
Groups = Iterator[Iterator[Found] | Refused]
"""Groups of candidates one of which is enough, best first; a refusal where there is no candidate to look at."""


class WayOut(Value):
    """Way of a payload out of a target.

    Args:
        name: for people.
        rank: of the way among others for some queries, the lowest first; None where it leads nowhere.
        groups: generator of candidates.
        endless: whether there are always further candidates, up to the samples of a query.
        by_hand: whether what there is to look at depends on the grasp.
    """

    name: str
    rank: Callable[[Sequence[Query]], int | None]
    groups: Callable[[list[Query]], Groups]
    endless: bool = False
    by_hand: bool = False


def up(asked: list[Query]) -> Groups:
    """Generate placements from above, and of what has no room above some from aside."""
    asked = prepared(asked)
    now = put_down(asked[0])
    check_turn(asked[0], now)
    _check_way_in(asked[0], now)
    none = True
    for rest in stable_poses(asked, now):
        none = False
        yield rest if isinstance(rest, Refused) else _from_above(rest)
    if none:
        yield from _at_best(asked, now)


def _from_above(rest: Rest) -> Iterator[Found]:
    """Heights at which it is let go of, and at each the ways from above and aside: a drawer under another one has no room above,
    and some before it."""
    query = rest.query
    for k, (over, above) in enumerate(rest.heights):
        thing = shift(rest.thing, (0.0, 0.0, over))
        pose, name = query.hand(thing), f"{rest.name}, lowest point {1000 * over:+.0f} mm from it"
        straight = Placement(
            name, thing, pose, shift(pose, (0.0, 0.0, above)), over, rest.kind, cost=rest.cost + PER_HEIGHT * k,
            reorients=rest.reorients, opens=query.settles,
        )  # fmt: skip
        yield query, straight
        if rest.kind == "in" and _may_be_there(straight, query):
            for side, way in slants(above):
                yield query, replace(straight, name=f"{name}, from {side}", before=shift(pose, way), parts=BETWEEN, aside=True)


def _may_be_there(placement: Placement, query: Query) -> bool:
    """Whether hand and payload have room at a place that is within reach, wherever they come from."""
    if not inverse(query.context.robot, placement.pose, seed=query.belief.joints):
        return False
    return query.scene.met(query.belief.base() * placement.pose) is None


def _at_best(asked: list[Query], now: Pose) -> Iterator[Refused]:
    """What objects at the best position of each target, where there is not one free position."""
    for query in asked:
        offset = next(positions_on(replace(query, where=Where(), obstacles=()), now), (0.0, 0.0))
        _, found = next(_from_above(standing_at(query, now, offset)))
        said = f"not clear: nowhere is a disc of {2000 * radius(query, now):.0f} mm free, which its outline holds"
        no = first_objection(found, query, SHAPES[found.kind])
        yield no or Refused(found.name, said, 0, blocking=query.standing_there())


def check_open(asked: Sequence[Query]) -> None:
    """Check that hands come to surfaces under a roof of their own thing, and to an opening that something is over, whatever they hold.

    Raises:
        Unresolvable: there is no way out: a door is shut, or what is over an opening is on all sides.
    """
    first = asked[0]
    doors = [t.name for t in first.belief.world.things if t.joint is not None and t.name in first.belief.poses]
    if doors and all(math.isfinite(q.room) for q in asked):
        amid = (replace(q, target=replace(q.target, pose=q.target.pose * Pose((0.0, 0.0, q.room / 2)))) for q in asked)
        around, what = [closed_in(q, [first.whole.name, *doors], OUT) for q in amid], "it"
    elif first.depth and not is_roofed(first) and _covered(first).covers:
        around, what = [closed_in(first)], "its opening"
    else:
        return
    if all(around):
        names = tuple(dict.fromkeys(name for one in around for name in one))
        said = f"no hand comes into '{first.entity}': {' and '.join(map(repr, names))} are on all sides of {what}"
        raise Unresolvable(said, blocking=names)


def prepared(bare: list[Query]) -> list[Query]:
    """Return the targets of what comes from above: with what stands there; of an opening beside what lies in it and is over it, and
    anywhere."""
    if not bare[0].depth:
        return bare if bare[0].uneven else with_middle([replace(q, obstacles=standing_on(q)) for q in bare])
    covered = [_covered(q) for q in bare]
    beside_it = [replace(q, obstacles=(*lying_in(q), *q.covers)) for q in covered]
    return [*(q for q in beside_it if q.obstacles), *covered]


def _covered(query: Query) -> Query:
    """With what is over an opening, as high as things are let go of over it."""
    return replace(query, covers=covers(query, heights(query, query.now)[-1][0]))


def _check_way_in(query: Query, now: Pose) -> None:
    """Check that what covers an opening leaves room to get in as it is turned, whatever holds it.

    Raises:
        Unresolvable: it does not; tilted it may.
    """
    if query.covers and free_for(query, now).is_empty and not goes_in_upright(query, now):
        over = [o.name for o in query.covers]
        said = f"'{query.thing.name}' does not get into '{query.entity}' upright: {' and '.join(map(repr, over))} are over it"
        raise Unresolvable(said, blocking=tuple(over))


def closed_in(query: Query, by: Sequence[str] = (), far: float = HAND) -> tuple[str, ...]:
    """Return what stands around a covered opening so that no hand can hold anything in or over it; nothing where there is a way out.

    Ways are straight, as long as a hand, as thick as fingers, from the middle of the opening and of its quarters, in all directions.

    Args:
        by: what is looked at; everything by default.
        far: how long ways are [m].
    """
    x, y, x1, y1 = (bound / 2 for bound in query.target.area.bounds)
    starts = query.target.pose.apply(np.array([(0.0, 0.0, 0.0), (x, y, 0.0), (x, y1, 0.0), (x1, y, 0.0), (x1, y1, 0.0)]))
    directions = _directions()
    points, ways = np.repeat(starts, WAYS_OUT, axis=0), np.tile(directions, (len(starts), 1))
    stopped, around = np.zeros(len(points), dtype=bool), list[str]()
    for name in sorted(by or query.belief.poses.keys() - {query.thing.name}):
        to = query.belief.pose(name).inverse()
        low, high = rays.intervals(rays.body(query.belief.world.thing(name).geoms), to.apply(points), to.rotate(ways))
        met = ((low < far) & (high > 0.0)).any(axis=1)
        around += [name] if met.any() else []
        stopped |= met
    blocked = (directions @ directions.T > BESIDE).astype(np.float32) @ stopped.reshape(len(starts), WAYS_OUT).T.astype(np.float32)
    return tuple(around) if (blocked > 0).all() else ()


def _directions() -> Floats:
    """Unit vectors (n, 3), evenly spread: a spiral by the golden angle from pole to pole."""
    k = np.arange(WAYS_OUT) + 0.5
    z, turn = 1.0 - 2.0 * k / WAYS_OUT, math.pi * (3.0 - math.sqrt(5.0)) * k
    level = np.sqrt(1.0 - z * z)
    return np.column_stack([level * np.cos(turn), level * np.sin(turn), z])


def over_floor(query: Query, turned: Pose, offset: tuple[float, float], over: float) -> Pose:
    """Return the pose in the base frame of a thing, turned so, the middle of whose outline is over a position of an opening and whose
    lowest point is so far over the floor [m]."""
    points = corners(query.thing, Pose((0.0, 0.0, 0.0), turned.quaternion))
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = query.target.pose.apply((*offset, over - query.depth))
    return Pose((float(x - (low + high)[0] / 2), float(y - (low + high)[1] / 2), float(z - low[2])), turned.quaternion)


def free_on_way(query: Query, pose: Pose, out: Floats, hand: bool = True) -> bool:
    """Check whether what is held has room at a pose in the base frame and on the straight way out (3,) [m], with the hand or without it."""
    base, at = query.belief.base(), query.hand(pose)
    return all(query.scene.met(base * shift(at, part * out), hand) is None for part in PARTS)


def goes_in_upright(query: Query, now: Pose) -> bool:
    """Check whether what is held, turned as at a pose in the base frame, gets into an opening from above or aside, whatever holds it."""
    points = corners(query.thing, Pose((0.0, 0.0, 0.0), now.quaternion))
    half = float(np.min(np.ptp(points, axis=0)[:2])) / 2  # of the narrower side
    low, high = np.reshape(query.target.area.buffer(-half).bounds or (0.0,) * 4, (2, 2))
    ways = [np.array((0.0, 0.0, RISE)), *(way for _, way in slants(RISE))]
    spots = product(*(np.arange(low[k], high[k] + PITCH, PITCH).tolist() for k in (0, 1)))
    ends = (over_floor(query, now, spot, over) for spot, over in product(spots, LOWS))
    return any(free_on_way(query, end, way, hand=False) for end in ends for way in ways)


def sideways(asked: list[Query]) -> Groups:
    """Generate placements under a roof, such as in a microwave or on a level of a shelf: carried in level through a side that is open.

    The hand points inwards, so that it stays before the opening or is no higher than what it holds; of the positions those come
    first that are farthest in.

    Raises:
        Unresolvable: the hand points down, the payload is too high, or no side is open.
    """
    first = asked[0]
    if (down := _down(first)) > STEEP:
        said = f"the hand points down by {math.degrees(math.asin(min(down, 1.0))):.0f} deg, and would be higher than what it brings"
        raise Unresolvable(said, taken_at(first.belief, first.context), blocking=())
    under, tall = [q for q in asked if math.isfinite(q.room)], height(first.thing, first.now) + 2 * HIGH
    ways = [(q, out) for q in under if tall <= q.room for out in open_sides(q.whole, q.at, q.target, tall / 2 - HIGH)]
    if not ways:
        raise _too_high(max(under, key=lambda q: q.room), tall)
    for query, out in ways:
        yield from (iter([(query, placement)]) for placement in _level(query, out))


def _down(query: Query) -> float:
    return -float(tcp(query.belief, query.context).rotate((0.0, 0.0, 1.0))[2])


def _too_high(query: Query, needed: float) -> Unresolvable:
    """What to say where a payload is too high for the room under a roof, or no side is open."""
    low = query.room - needed + 2 * HIGH
    if low >= 2 * HIGH:
        return Unresolvable(f"no side of '{query.entity}' is open", blocking=())
    more = f"{1000 * low:.0f} mm higher than '{query.thing.name}', {2000 * HIGH:.0f} mm is needed"
    says = (
        f"the opening of '{query.entity}' is {1000 * query.room:.0f} mm high, '{query.thing.name}' needs {1000 * needed:.0f} mm with "
        "the gap around it: take a lower thing, lay it down, or name another place"
    )
    remedy = Remedy(f"room {query.entity}", says, needed - query.room)
    return Unresolvable(f"the room under the roof of '{query.entity}' is {more}", blocking=(), remedy=remedy)


def _level(query: Query, out: Floats) -> Iterator[Placement]:
    """Positions from the middle outwards, at each the turns at which the hand points inwards."""
    ahead = tcp(query.belief, query.context).rotate((0.0, 0.0, 1.0))
    facing = math.atan2(-out[1], -out[0]) - math.atan2(ahead[1], ahead[0])
    low, high = np.reshape(query.target.area.bounds, (2, 2))
    way = query.target.pose.inverse().rotate(out)[:2]
    across, half = np.array([-way[1], way[0]]), (high - low) / 2
    deep, wide = float(np.abs(way) @ half), float(np.abs(across) @ half)
    for gone, share, yaw in product(np.arange(0.0, deep, STEP).tolist(), ASIDE, TURNS):
        turned = about_vertical(query.now, facing + math.radians(yaw))
        x, y = gone * way + share * wide * across
        over = query.target.pose.apply((float(x), float(y), 0.0)) - turned.apply(centre_of_mass(query.thing)) * (1.0, 1.0, 0.0)
        thing = shift(shift(turned, over), (0.0, 0.0, HIGH + support(query.thing, turned, (0, 0, -1))))
        far = support(query.whole, query.at, out) + support(query.thing, thing, -out) + BEFORE_IT
        pose, aside = query.hand(thing), f"{1000 * share * wide:+.0f} mm aside, turned {yaw:+.0f} deg"
        name = f"{1000 * gone:.0f} mm out from its middle, {aside}, through its side"
        yield Placement(name, thing, pose, shift(pose, far * out), HIGH, parts=LEVELLY)


def tilted(asked: list[Query]) -> Groups:
    """Generate placements in an opening that is partly covered, such as that of a drawer under the handles of others, of what does
    not get in upright: let down leaning, so that its edge comes in under what is over the opening, and straightened in there.

    Raises:
        Unresolvable: something is in the payload, and would fall out.
    """
    query, none = replace(asked[0], covers=covers(asked[0], COVERS)), True
    _check_empty(query, "leans")
    for placement in _leaning_in(query):
        none = False
        yield iter([(query, placement)])
    if none:
        yield Refused("tilted", "hand and thing have no way in between what is over it and its walls")


def _check_empty(query: Query, does: str) -> None:
    if query.thing.filling is not None or query.held.carries:
        raise Unresolvable(f"'{query.thing.name}' holds something that would fall out as it {does}", taken_at(query.belief, query.context))


def _leaning_in(query: Query) -> Iterator[Placement]:
    """Ways in that are free for hand and payload, wherever the arm is: where it is let go of nearly upright, where it leans on the way
    there, and the way out from that."""
    for towards, tilt in product(_under(query), TILTS):
        turns = _hand_down(query, _lean(towards, tilt))
        for offset, turned in product(_offsets(query, towards), turns):
            lows = ((low, over_floor(query, _lean(towards, LEFT) * turned, offset, low)) for low in LOWS)
            low, left = next(((low, pose) for low, pose in lows if not _met(query, pose)), (0.0, None))
            for back, over in product(FARTHER, OVER) if left else ():
                at = over_floor(query, _lean(towards, tilt) * turned, _moved(query, offset, -back * towards), low + over)
                out = next((o for o in _up_and_away(towards) if free_on_way(query, at, o)), None)
                if left is not None and out is not None and _straightens(query, at, left):
                    x, y = (1000 * v for v in offset)
                    said = f"({x:+.0f} {y:+.0f}) mm from its middle, let down leaning by {tilt:.0f} deg, {1000 * back:.0f} mm farther out"
                    leaning, name = query.hand(at), f"{said}, {1000 * over:.0f} mm higher"
                    yield Placement(
                        name, left, query.hand(left), shift(leaning, out), LOWS[0] - query.depth, "in", (leaning,), PARTS,
                        stood_up(query.thing, left), reorients=True, opens=True,
                    )  # fmt: skip
                    break


def _lean(towards: Floats, degrees: float) -> Pose:
    """The turn by which something leans a level way."""
    axis = np.cross((0.0, 0.0, 1.0), towards)
    return Pose.from_rotvec((0.0, 0.0, 0.0), tuple((math.radians(degrees) * axis).tolist()))


def _up_and_away(towards: Floats) -> Iterator[Floats]:
    """Ways up and away from what is over an opening."""
    for share in SHARES:
        yield RISE * (np.array([0.0, 0.0, 1.0]) - share * towards)


def _under(query: Query) -> list[Floats]:
    """Unit vectors along the opening's sides towards what is over it, the most direct one first, in the base frame."""
    over = shapely.union_all([o.area for o in query.covers]).intersection(query.target.area).centroid
    middle = query.target.area.centroid
    to = query.target.pose.rotate((over.x - middle.x, over.y - middle.y, 0.0))
    axes = [sign * query.target.pose.rotate(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) for sign in (1.0, -1.0)]
    return sorted((a for a in axes if a @ to > LEAST), key=lambda a: -float(a @ to))


def _hand_down(query: Query, lean: Pose) -> list[Pose]:
    """Attitudes of a thing turned about its own upright axis, those first at which the hand points straight down when it leans."""
    found = []
    for k in range(HEADINGS):
        turned = about_vertical(query.now, math.tau * k / HEADINGS)
        found.append((round(float(query.hand(lean * turned).rotate((0.0, 0.0, 1.0))[2]), 3), k, turned))
    return [turned for _, _, turned in sorted(found, key=lambda f: f[:2])[:FIRST]]


def _offsets(query: Query, towards: Floats) -> Iterator[tuple[float, float]]:
    """Positions in an opening, in its frame, at which a thing stands as far out from under what is over it as it can, or nearly [m]."""
    frame = query.target.pose.inverse()
    way = frame.rotate(towards)[:2]
    across = np.array([-way[1], way[0]])
    points = frame.rotate(corners(query.thing, Pose((0.0, 0.0, 0.0), query.now.quaternion)))[:, :2]
    low, high = np.reshape(query.target.area.bounds, (2, 2))
    deep, wide = ((np.abs(v) @ (high - low) - np.ptp(points @ v)) / 2 - OFF_WALLS for v in (way, across))
    for share, gone in product(ACROSS, INWARDS):
        if deep > 0 and wide > 0:
            x, y = (low + high) / 2 + (gone - deep) * way + share * wide * across
            yield float(x), float(y)


def _moved(query: Query, offset: tuple[float, float], by: Floats) -> tuple[float, float]:
    """A position in an opening, moved by a vector (3,) of the base frame."""
    x, y, _ = query.target.pose.inverse().rotate(by)
    return offset[0] + float(x), offset[1] + float(y)


def _met(query: Query, pose: Pose) -> bool:
    """Whether hand or thing meet something with the thing at a pose, wherever the arm is."""
    checkpoint()
    return query.scene.met(query.belief.base() * query.hand(pose)) is not None


def _straightens(query: Query, leaning: Pose, left: Pose) -> bool:
    """Whether hand and thing are free as it leans less and less."""
    ways = (interpolate(query.hand(leaning), query.hand(left), part) for part in STRAIGHTEN)
    return not any(_met(query, pose * query.held.tcp_to_thing) for pose in ways)


def toppling(asked: list[Query]) -> Groups:
    """Generate placements under a roof that is too low for the payload, such as of a book under a shelf: its foot goes in there, leaning
    out, and when it is let go of it topples about that and lies there.

    The hand stays before the roof; what lies there sticks out.

    Raises:
        Unresolvable: something is in the payload, and would fall out.
    """
    query, none = asked[0], True
    _check_empty(query, "topples")
    sides = open_sides(query.whole, query.at, query.target, -query.depth / 2)
    for out, upright in product(sides, along_walls(query, query.now)):
        low, high = extent(query, upright)
        deep = np.abs(query.target.pose.inverse().rotate(out)[:2])
        if deep @ (high - low)[:2] > (1.0 - deep) @ (high - low)[:2]:
            continue  # it would topple over its broad side
        for lean in LEANS:
            for leaning, lies, name in toppled(query, upright, out, lean):
                none = False
                yield iter([(query, _foot_in(query, shift(leaning, (0.0, 0.0, KEPT)), lies, out, name))])
    if none:
        yield Refused("toppling", "no foot of it is far enough in where it would topple")


def _foot_in(query: Query, leaning: Pose, lies: Pose, out: Floats, name: str) -> Placement:
    """The placement where it is let go of; its stand-off is level before that, all of it before the roof."""
    area = query.target.pose.apply(np.insert(np.reshape(query.target.area.bounds, (2, 2)), 2, 0.0, axis=1))
    far, pose = CLEAR + float((area @ out).max()) + support(query.thing, leaning, -out), query.hand(leaning)
    back = pose * Pose((0.0, 0.0, -BACK))
    return Placement(
        name, leaning, pose, shift(pose, far * out), KEPT, "toppled", (), LEVELLY, lies, back, reorients=True, opens=True
    )  # fmt: skip


def goes_in_tilted(thing: str, belief: Belief, context: Context) -> bool:
    """Check whether a later task brings a thing into an opening that is covered so far that it does not get in straight from above."""
    narrow = [name for name in belief.poses if name != thing and _too_narrow(thing, name, belief, context)]
    if not narrow:
        return False  # later tasks are not looked at, so that what follows from this holds whatever they are
    return any(onto.thing in narrow for onto, _ in brings(thing, belief, context))


def _too_narrow(thing: str, into: str, belief: Belief, context: Context) -> bool:
    """Whether a thing, turned as it is, goes into an opening, but for what is over that."""
    held, now = belief.thing(thing), belief.pose(thing)
    half = float(np.min(np.ptp(corners(held, now), axis=0)[:2])) / 2
    for target, depth in openings(belief.thing(into), belief.pose(into)):
        core, bare = target.area.buffer(-half), Query(held, into, target, Arm(belief, context), Where(), depth=depth)
        if not core.is_empty and free_area(core, [o.area for o in covers(bare, COVERS)], half).is_empty:
            return True
    return False


def goes_under_a_roof(thing: str, belief: Belief, context: Context) -> bool:
    """Check whether a later task brings a thing onto a surface that nothing is put on from above: a named one, or of what has no other. A
    table's board near the floor is not meant by the table, off which a thing is picked up."""
    if not any(has_a_roof(belief.thing(other), belief.pose(other)) for other in belief.poses if other != thing):
        return False  # later tasks are not looked at, so that what follows from this holds whatever they are
    for onto, region in brings(thing, belief, context):
        there, at = belief.thing(onto.thing), belief.pose(onto.thing)
        if (region or not surfaces(there, at)) and any(roofed(there, at, region)):
            return True
    return False


def _rank_up(asked: Sequence[Query]) -> int | None:
    return None if is_roofed(asked[0]) else 0


def _rank_sideways(asked: Sequence[Query]) -> int | None:
    """Of what is all under a roof first, with a hand that points inwards."""
    under = [math.isfinite(q.room) for q in asked]
    return (-1 if all(under) and _down(asked[0]) <= STEEP else 1) if any(under) else None


def _rank_tilted(asked: Sequence[Query]) -> int | None:
    return 1 if not is_roofed(asked[0]) and covers(asked[0], COVERS) else None


def _rank_toppling(asked: Sequence[Query]) -> int | None:
    return 0 if is_roofed(asked[0]) else None


WAYS: Mapping[str, tuple[WayOut, ...]] = {
    "on": (WayOut("from above", _rank_up, up, endless=True), WayOut("through its sides", _rank_sideways, sideways)),
    "in": (
        WayOut("from above", _rank_up, up, endless=True), WayOut("tilted", _rank_tilted, tilted, by_hand=True),
        WayOut("toppling", _rank_toppling, toppling),
    ),
}  # fmt: skip
"""Ways out by relation."""

"""Stable poses that are simulated: at rest on supports that are not level, such as racks, cradles and bars,
and leaning between walls."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice, product

import numpy as np
import shapely

from cramlite.model import EntityName, Floats, Pose

from ...predicates.places import RIM
from ...shapes.bounds import corners, support
from ...shapes.surfaces import footprint, resting_height
from ...simulation.resting import let_down, resting_pose, rests
from .query import Query

QUARTER = math.pi / 2
TURNS = ((0, 0, 0), (QUARTER, 0, 0), (-QUARTER, 0, 0), (0, QUARTER, 0), (0, -QUARTER, 0), (math.pi, 0, 0))
SIDES_DOWN = tuple(Pose.from_rotvec((0.0, 0.0, 0.0), turn) for turn in TURNS)
"""Turns of a thing by which each side of the box around it comes to face down."""
SHARES = (0.0, 0.15, -0.15, 0.3, -0.3, 0.45, -0.45)
"""Release positions of a thing above its support, from the support's middle, as shares of its length and
width."""
DROPS = 80
"""Largest number of drops that are simulated for one query, at some 30 ms each."""
LARGE = 0.5
"""Share of a support's outline that its level surface must cover for an even support: a table or a shelf
reaches it, and a rack does not."""
SURE = 0.002
"""Least distance of a resting payload's origin from each side of its region [m]: contacts give way by some
0.5 mm, in one simulator by more than in another."""
LEANS = (16.0, 20.0, 24.0, 12.0)  # from upright [deg]
PITCH = 0.002  # between positions across a cavity [m]
ASTRAY = 0.003
"""Error of the place at which a thing is let go of [m]: an arm has arrived within 4 mm, and mostly is
nearer."""
LEANING_DROPS = 60
"""Largest number of leaning release poses that are simulated for one query, each with up to ten drops of some
10 ms."""
NEAR_FLOOR = 0.03
"""Largest height of a payload's lowest point over the floor of an opening at its release [m]: a payload that
would lie on the walls is higher."""
CLOSE = 0.001
"""Clearance from the walls at the release [m]: afterwards the thing leans against them."""
PALM_UP = math.sin(math.radians(20.0))
"""Largest upward component of the hand's unit approach vector: a hand that points up more steeply would be
under the payload, and in the support."""


def is_uneven(query: Query) -> bool:
    """Check whether a support has no level surface that is large in comparison with its own outline from
    above."""
    if query.uneven:
        return True
    if query.depth or query.under is not None or query.where.region or EntityName.parse(query.entity).part:
        return False
    below = query.belief.thing(query.entity)
    if not below.furniture:
        return False
    outline = footprint(below, query.belief.pose(below.name))
    return bool(query.target.area.area < LARGE * outline.area)


def resting_poses(query: Query, now: Pose) -> Iterator[Pose]:
    """Generate poses in the base frame in which the payload stays on its support.

    Args:
        now: of what is held, in the base frame.
    """
    below, at = query.whole, query.at
    starts = [(x, y, turned) for (x, y), turned in product(_over(query), _attitudes(query, now, at))]
    for x, y, turned in starts[:DROPS]:
        if found := resting_pose(query.thing, Pose((x, y, 0.0), turned.quaternion), below, at):
            yield found


def _over(query: Query) -> list[tuple[float, float]]:
    """Return positions over a thing or a region of it, in the base frame [m]: along the centre lines of its
    box, from its middle out, or around the origin of the thing that the payload has to be near."""
    below, at, target = query.whole, query.at, query.target
    frame = _level(at)
    corners_of_it = np.insert(shapely.get_coordinates(target.area), 2, 0.0, axis=1)
    points: Floats = (
        frame.inverse().apply(target.pose.apply(corners_of_it))
        if query.uneven
        else corners(below, frame.inverse() * at)
    )
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = (low + high) / 2, high - low
    if other := query.where.near:
        middle = frame.inverse().apply(query.belief.pose(other).position)
        size = np.minimum(size, query.where.within / max(SHARES))
    shifts = dict.fromkeys(shift for s in SHARES for shift in ((0.0, s), (s, 0.0)))
    there = (frame.apply(middle + size * np.array((*shift, 0.0))) for shift in shifts)
    return [(round(float(p[0]), 4), round(float(p[1]), 4)) for p in there]


def _level(at: Pose) -> Pose:
    """Orientation with z upwards, turned about the vertical to the heading of the pose ``at``."""
    x, y, _ = at.rotate((1.0, 0.0, 0.0) if abs(at.rotation[2, 0]) < math.sqrt(0.5) else (0.0, 1.0, 0.0))
    return Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, math.atan2(y, x)))


def _attitudes(query: Query, now: Pose, at: Pose) -> list[Pose]:
    """Orientations of the payload, aligned with its support, in which the hand is not under it; the least
    turn of the hand first."""
    frame = _level(at)
    found: list[tuple[float, int, Pose]] = []
    for side, quarter in product(SIDES_DOWN, range(4)):
        turned = frame * Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, quarter * QUARTER)) * side
        if float(query.hand(turned).rotate((0.0, 0.0, 1.0))[2]) <= PALM_UP:
            found.append((round(math.hypot(*(now.inverse() * turned).rotvec), 3), len(found), turned))
    return [turned for _, _, turned in sorted(found, key=lambda f: f[:2])]


def must_lean(query: Query, now: Pose) -> str:
    """Return why the origin of a thing on the floor of its region, turned as at a pose in the base frame, is
    below the region; "" if it is not.

    What counts is where its origin is, and that may be below its foot.
    """
    if not (query.depth or query.lowest) or not query.where.region:
        return ""
    below, top = query.whole, query.target.pose.position[2]
    height, _ = resting_height(query.thing, Pose.at(query.target.pose.position, now), [(below, query.at)])
    foot = support(query.thing, Pose.at((0.0, 0.0, 0.0), now), (0.0, 0.0, -1.0))
    by = height + foot - top + query.depth - query.lowest
    if by >= 0 or not math.isfinite(by):
        return ""
    return (
        f"its origin would be {-1000 * by:.0f} mm below '{query.where.region}' of '{below.name}' if it "
        "stood there in this orientation"
    )


def leaning(query: Query, now: Pose) -> Iterator[Pose]:
    """Generate release poses in the base frame after which the payload rests leaning, with its origin at
    least ``SURE`` inside the region, even if it is released up to ``ASTRAY`` off.

    Args:
        now: of what is held, in the base frame.
    """
    below, at = query.whole, query.at
    let_go = (let_down(query.thing, start, below, at) for start in _starts(query, now))
    for pose in islice((p for p in let_go if p is not None and _stands(query, p)), LEANING_DROPS):
        ends = rests(query.thing, pose, below, at, ASTRAY)
        if all(end is not None and _inside(query, end) for end in ends):
            yield pose


def _starts(query: Query, now: Pose) -> Iterator[Pose]:
    """Yield poses of the payload tilted in the direction of its smaller width, at positions across the
    target's opening.

    Those nearest to the middle of the opening come first.
    """
    for upright, lean, sign in product(along_walls(query, now), LEANS, (1.0, -1.0)):
        low, high = extent(query, upright)
        narrow = int(np.argmin((high - low)[:2]))
        axis = query.target.pose.rotate(np.eye(3)[1 - narrow]) * sign * math.radians(lean)
        turned = Pose.from_rotvec((0.0, 0.0, 0.0), tuple(axis.tolist())) * upright
        low, high = extent(query, turned)
        room = np.reshape(query.target.area.bounds, (2, 2))[:, narrow]
        for k in sorted(range(math.ceil(room[0] / PITCH), math.floor(room[1] / PITCH) + 1), key=abs):
            to = np.zeros(3)
            to[narrow] = PITCH * k
            yield Pose.at(query.target.pose.apply(to - (low + high) / 2), turned)


def along_walls(query: Query, now: Pose) -> list[Pose]:
    """Return orientations, turned about the vertical, in which the payload's outline is parallel to the walls
    and fits between them; the nearest to the present one first."""
    frame, here = query.target.pose, Pose.at((0.0, 0.0, 0.0), now)
    a, b = shapely.get_coordinates(shapely.minimum_rotated_rectangle(footprint(query.thing, here)))[:2]
    x, y, _ = frame.rotate((1.0, 0.0, 0.0))
    apart = math.atan2(y, x) - math.atan2(*(b - a)[::-1])
    turns = sorted((math.remainder(apart + k * math.pi / 2, 2 * math.pi) for k in range(4)), key=abs)
    room = np.reshape(query.target.area.bounds, (2, 2))
    found = [Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, turn)) * here for turn in turns]
    return [p for p in found if (np.subtract(*extent(query, p)[::-1])[:2] <= room[1] - room[0]).all()]


def extent(query: Query, turned: Pose) -> tuple[Floats, Floats]:
    """Return the lowest and highest corner (3,) [m] of the turned payload along the opening's axes, from
    the payload's origin."""
    to = Pose.at((0.0, 0.0, 0.0), query.target.pose).inverse()
    points = corners(query.thing, to * Pose.at((0.0, 0.0, 0.0), turned))
    return points.min(axis=0), points.max(axis=0)


def _stands(query: Query, pose: Pose) -> bool:
    """Whether a payload's lowest point is near the floor of the opening."""
    lowest = float(corners(query.thing, query.target.pose.inverse() * pose)[:, 2].min())
    return lowest + query.depth <= NEAR_FLOOR


def _inside(query: Query, end: Pose) -> bool:
    """Whether the origin of a payload at rest is inside its region by at least ``SURE``."""
    x, y, z = map(float, query.target.pose.inverse().apply(end.position))
    area = query.target.area.buffer(-SURE)
    return SURE - query.depth <= z <= RIM - SURE and bool(area.covers(shapely.Point(x, y)))

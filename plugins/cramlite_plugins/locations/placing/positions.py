"""Positions at which a payload has room on a surface or in an opening, in the order in which to try them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from cramlite.model import Floats, Pose
from cramlite.plugin import SIDES

from ...kinematics.forward import forward
from ...shapes.bounds import centre_of_mass, support
from ...shapes.surfaces import filled, footprint, inset, standing
from ..later import goes_on, puts_into
from ..parameters import Where
from .checks.shapes import ASIDE, OFF_WALLS, WELL_IN
from .query import GAP, Query, lying_in

Offset = tuple[float, float]
"""x and y in the frame of a surface [m]."""
FIRST = 16
"""Number of positions in the first round; each further round has twice as many."""
AROUND = 0.1  # distance from the position straight beside a thing within which others are tried first [m]
QUARTERS = (0.0, 0.25, 0.5, 0.75)
SMALL = 1e-6
"""Least size of a part of an area in which more than the middle is tried [m2]."""

INSET = 0.12  # of what is nearest to a robot that drove, from the edge [m]
ROUNDED = 0.0002  # twice what positions are rounded by [m]
# Distance of positions from walls [m]: what leans a little is nearer to one farther up
BESIDE_WALLS = OFF_WALLS + 0.001
FAR = 0.01  # share of its way from the middle by which the centre of an overhang is away from the best place
ALIKE = 0.002  # radii of discs that are as good as one another [m]
TRIED = 32  # corners that are looked at, of a round opening evenly spaced ones
AWAY = 0.1
"""Gap between a payload that is put aside and its old place [m]: half a hand. Before something is opened a
payload goes farther."""


def positions_on(query: Query, now: Pose) -> Iterator[Offset]:
    """Generate the positions of a payload, turned as at a pose in the base frame, best first.

    Of what is not level the middle alone, where things are least likely to tip or to slide. Of what stood
    over the surface, and is put aside before other things are handled, first those beside where it stood; on
    a side of a thing first those within ``AROUND`` of the one straight beside it.
    """
    if query.under:
        return iter([(0.0, 0.0)])
    free = free_for(query, now)
    best = _aside_for_more(query, free) or anchor(query, now)
    if _beside(query, now) is not None:
        near = free.intersection(shapely.Point(best).buffer(AROUND))
        straight = itertools.chain(inwards(near, best), positions(near, best))
        tried = dict.fromkeys(itertools.islice(straight, FIRST))
        return itertools.chain(tried, (p for p in positions(free, best) if p not in tried))
    if not query.depth and query.where == Where():
        first = beside_where_it_stood(query, free, radius(query, now))
        return itertools.chain(first, positions(free, best))
    return positions(free, best)


def free_for(query: Query, now: Pose) -> Any:
    """Return positions for the payload's middle: on its support, apart from obstacles, and where ``where``
    wants it."""
    wide, area, where = radius(query, now), query.target.area, query.where
    _, least = inset(standing(query.thing, now), area)
    cores = [area.convex_hull.buffer(-least - ROUNDED)]
    if query.depth:
        cores = [area.buffer(-wide - BESIDE_WALLS), area.buffer(-wide)]
    grown = [o.area.buffer(radius(query, now, o.top)) for o in query.obstacles]
    found = [free_area(core, grown, 0.0) for core in cores]
    free = next((a for a in found if not a.is_empty), found[-1])
    to = query.target.pose.inverse()
    for side, (axis, sign) in SIDES.items():
        if other := getattr(where, side):
            way = sign * query.target.pose.rotation[axis, :2]
            apart = query.belief.pose(other).position[axis] - query.target.pose.position[axis]
            free = beside(free, (float(way[0]), float(way[1])), sign * apart + ASIDE)
    if where.near:
        there = to.apply(query.belief.pose(where.near).position)[:2]
        free = free.intersection(shapely.Point(*there).buffer(where.within))
    return free


def positions_along(query: Query, now: Pose) -> Iterator[Offset]:
    """Generate positions of a payload whose sides are along those of an opening, best first: the rectangle
    around it is in there, apart from the contents and from what is over them.

    The first are farthest from what is over the opening, which is in the hand's way.

    Args:
        now: of the payload in the base frame, so turned.
    """
    area, seen = query.target.area, footprint(query.thing, query.target.pose.inverse() * now)
    low, high = np.reshape(seen.bounds, (2, 2))
    half, room = (high - low) / 2, np.subtract(*np.reshape(area.bounds, (2, 2))[::-1]) - (high - low)
    core = area.buffer(-max(0.0, min(BESIDE_WALLS, float(room.min()) / 4)))
    signs = itertools.product((-1.0, 1.0), repeat=2)
    moved = [shapely.affinity.translate(core, *(half * sign)) for sign in signs]
    ends = [np.reshape(o.area.bounds, (2, 2)) for o in (*lying_in(query), *query.covers)]
    taken = shapely.union_all([shapely.box(*(a - half), *np.add(b, half)) for a, b in ends])
    over = shapely.union_all([o.area for o in query.covers]).intersection(area).centroid
    away = (0.0, 0.0) if over.is_empty else (-over.x / FAR, -over.y / FAR)
    yield from positions(shapely.intersection_all(moved).difference(taken), away)


def radius(query: Query, now: Pose, top: float = math.inf) -> float:
    """Return the radius [m] of the largest disc about the payload's middle that is inside its outline; 0
    if the middle is outside.

    The outline, seen from above, is that of the parts up to ``top`` [m] above the payload's lowest point.
    """
    low = -support(query.thing, now, (0.0, 0.0, -1.0))
    outline, at = filled(footprint(query.thing, now, high=low + top)), shapely.Point(*middle(query, now))
    return float(outline.boundary.distance(at)) if outline.covers(at) else 0.0


def anchor(query: Query, now: Pose) -> Offset:
    """Return the position on the target [m] that would suit a payload best if no obstacle were there.

    The middle; straight beside or near a thing that is asked for; for a robot that drove there the position
    nearest to it, as a table's middle may be out of reach from all sides; in a container where the rest finds
    room.
    """
    to, at, beside_it = query.target.pose.inverse(), np.zeros(2), _beside(query, now)
    if query.depth and not query.where.near:
        return _with_room(query, now)
    if beside_it is not None:
        at = to.apply(beside_it)[:2]
    elif other := query.where.near:
        at = to.apply(query.belief.pose(other).position)[:2]
    elif query.belief.at is not None:
        low, high = np.reshape(query.target.area.bounds, (2, 2))
        base = to.apply((0.0, 0.0, 0.0))[:2]
        at = np.clip(base, np.minimum(low + INSET, 0.0), np.maximum(high - INSET, 0.0))
    return float(at[0]), float(at[1])


def _beside(query: Query, now: Pose) -> Floats | None:
    """Point straight beside the thing on one side of which a payload is asked for, as near as any turn of it
    allows [m]; None if no side is asked for."""
    corners = rectangle(query, now)
    wide = math.dist(corners[0], corners[2]) / 2
    for side, (axis, sign) in SIDES.items():
        if other := getattr(query.where, side):
            there, way = query.belief.pose(other), sign * np.eye(3)[axis]
            at = np.array(there.position)
            at[axis] = sign * (support(query.belief.thing(other), there, way) + wide + GAP)
            return at
    return None


def _aside_for_more(query: Query, free: Any) -> Offset | None:
    """Corner of the free positions well in a region of a surface that is farthest from the robot, if later
    tasks put more payloads there; None if they do not."""
    where, inner = query.where, free.buffer(-WELL_IN)
    if query.depth or inner.is_empty or not where.region or where != Where(region=where.region):
        return None
    if not puts_into(query.entity, query.belief, query.context, where.region):
        return None
    base = query.target.pose.inverse().apply((0.0, 0.0, 0.0))[:2]
    x, y = max(shapely.get_coordinates(inner).tolist(), key=lambda p: round(math.dist(p, base), 4))
    return float(x), float(y)


def _with_room(query: Query, now: Pose) -> Offset:
    """Best position for a payload in an opening: in a corner if later tasks put more payloads in, else in the
    middle of the room that the contents leave, which is the middle of an empty container."""
    lying = [o.area for o in lying_in(query, sure=True)]
    left = free_area(query.target.area, lying, 0.0)
    if left.is_empty:
        return 0.0, 0.0
    if puts_into(query.entity, query.belief, query.context):
        x, y, _ = query.target.pose.inverse().apply((0.0, 0.0, 0.0)).tolist()
        a, b, c, _ = rectangle(query, now)
        sides = math.dist(a, b), math.dist(b, c)
        return corner(query.target.area.buffer(-BESIDE_WALLS), left, sides, (x, y))
    return roomiest(left) if lying else (0.0, 0.0)


def rectangle(query: Query, now: Pose) -> Floats:
    """Return the corners (4, 2) of the smallest rectangle around the payload's outline at a pose, from above
    [m]."""
    corners: Floats = shapely.get_coordinates(shapely.minimum_rotated_rectangle(footprint(query.thing, now)))[
        :4
    ]
    return corners


def middle(query: Query, now: Pose) -> Floats:
    """Return the point of a payload that goes over a position (2,) [m]: its centre of mass, which needs
    support; between walls of a container the middle of its outline, which has to get past them."""
    if query.depth:
        found: Floats = rectangle(query, now).mean(axis=0)
        return found
    return np.asarray(now.apply(centre_of_mass(query.thing)))[:2]


def beside_where_it_stood(query: Query, free: Any, wide: float) -> Iterator[Offset]:
    """Generate positions in a free area of a surface beside the place over which the payload stood before,
    nearest to the robot first; none unless other things are handled afterwards.

    Args:
        wide: radius of the disc in the payload's outline [m].
    """
    stood = _stood(query)
    if stood is not None and goes_on(query.thing.name, query.context):
        x, y, _ = query.target.pose.inverse().apply((0.0, 0.0, 0.0)).tolist()
        yield from around(free, stood, 2 * wide + AWAY, (x, y))


def _stood(query: Query) -> Offset | None:
    """Position over a surface at which the payload was grasped, in the surface's frame [m]; None if it was
    elsewhere, or the robot drove since."""
    held = query.held
    if not held.joints or query.belief.at is not None:
        return None
    there = forward(query.context.robot, held.joints) * held.tcp_to_thing
    x, y, _ = query.target.pose.inverse().apply(there.position).tolist()
    return (x, y) if query.target.area.covers(shapely.Point(x, y)) else None


def free_area(core: Any, obstacles: Iterable[Any], radius: float) -> Any:
    """Return where the centre of a disc may be: the part of the area ``core`` that is at least the disc's
    radius off all obstacles.

    Args:
        core, obstacles: shapely areas [m].
        radius: of the largest disc in the outline of what is put there, so that any turn of it needs as much
            [m].
    """
    grown = [o.buffer(radius) for o in obstacles if not o.is_empty]
    return core.difference(shapely.union_all(grown)) if grown else core


def beside(area: Any, axis: Offset, least: float) -> Any:
    """Return the part of an area [m] in which the dot product of a point with ``axis`` is at least
    ``least``."""
    along, far = np.asarray(axis, dtype=float), 100.0
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return area
    along = along / length
    across, start = np.array([-along[1], along[0]]), along * least / length
    low, high = start - across * far, start + across * far
    return area.intersection(shapely.Polygon([high, low, low + along * far, high + along * far]))


def positions(area: Any, anchor: Offset) -> Iterator[Offset]:
    """Generate positions inside an area: the one nearest to an anchor, the middles of its pieces, then ever
    denser ones, endlessly.

    The last are a Halton sequence (J. H. Halton, On the efficiency of certain quasi-random sequences,
    Numerische Mathematik 2, 1960), which comes nowhere twice. They come in batches of doubling size, each
    from the anchor outwards.
    """
    if area.is_empty:
        return
    nearest = shapely.shortest_line(shapely.Point(anchor), area).coords[-1]
    middles = [shapely.maximum_inscribed_circle(p).coords[0] for p in shapely.get_parts(area) if p.area > 0]
    middles = sorted(map(_rounded, middles), key=lambda p: (math.dist(p, anchor), p))
    yield from dict.fromkeys([_rounded(nearest), *middles])
    rounds = [_rounds(p) for p in shapely.get_parts(area) if p.area > SMALL]
    for parts in zip(*rounds, strict=True) if rounds else ():
        points = [_rounded(p) for part in parts for p in part.tolist()]
        yield from sorted(points, key=lambda p: (round(math.dist(p, anchor), 4), p))


def inwards(area: Any, anchor: Offset) -> Iterator[Offset]:
    """Generate positions from the one of an area that is nearest to an anchor towards the middle of its
    piece, in quarters: each has more room than the one before, and is farther from the anchor."""
    if area.is_empty:
        return
    piece = min(shapely.get_parts(area), key=lambda p: float(p.distance(shapely.Point(anchor))))
    begin = np.asarray(shapely.shortest_line(shapely.Point(anchor), piece).coords[-1])
    way = np.asarray(shapely.maximum_inscribed_circle(piece).coords[0]) - begin
    for share in QUARTERS:
        point = _rounded(begin + share * way)
        if area.covers(shapely.Point(point).buffer(ROUNDED)) or share == 0:
            yield point


def around(area: Any, middle: Offset, distance: float, to: Offset) -> Iterator[Offset]:
    """Generate those points at a distance from ``middle`` [m] that are in an area, in eight directions,
    beginning with the direction to the point ``to``."""
    first = math.atan2(to[1] - middle[1], to[0] - middle[0])
    for turn in (0, 1, -1, 2, -2, 3, -3, 4):
        angle = first + turn * math.pi / 4
        point = _rounded((middle[0] + distance * math.cos(angle), middle[1] + distance * math.sin(angle)))
        if area.covers(shapely.Point(point)):
            yield point


def _rounded(point: Iterable[float]) -> Offset:
    x, y = (round(float(v), 4) + 0.0 for v in point)
    return x, y


def _rounds(area: Any) -> Iterator[Floats]:
    """Yield points (n, 2) of a Halton sequence over an area's bounding box, those inside the area only, in
    blocks of doubling size."""
    low, high = np.reshape(area.bounds, (2, 2))
    first = 1  # the point before that is a corner
    for k in itertools.count():
        count = FIRST * 2 ** min(k, 10)
        points = low + halton(first, count) * (high - low)
        first += count
        yield points[shapely.contains_xy(area, points)]


def halton(first: int, count: int) -> Floats:
    """Return points (count, 2) of the Halton sequence in bases 2 and 3, from index ``first`` on; the sequence
    begins at 0.

    SciPy has the same, in a package whose import takes longer than many a query.
    """
    return np.stack([_mirrored(np.arange(first, first + count), base) for base in (2, 3)], axis=1)


def _mirrored(numbers: NDArray[np.int_], base: int) -> Floats:
    """Radical inverse of integers in a base: their digits mirrored about the radix point."""
    found, worth = np.zeros(len(numbers)), 1.0 / base
    while numbers.any():
        numbers, digits = np.divmod(numbers, base)
        found += worth * digits
        worth /= base
    return found


def roomiest(area: Any) -> Offset:
    """Return the middle of the largest disc in an area [m], or in its largest part."""
    largest = max(shapely.get_parts(area), key=lambda p: float(p.area))
    x, y = shapely.maximum_inscribed_circle(largest).coords[0]
    return x, y


def corner(area: Any, left: Any, sides: tuple[float, float], near: Offset) -> Offset:
    """Return the position of a rectangle, along an area's axes or across them, that leaves the largest disc
    free beside it; of equal ones the nearest to a point.

    Args:
        area: convex, that it has to be in.
        left: what of that is free.
        sides: of the rectangle [m].
        near: x and y in the same frame [m].
    """
    x, y = sides
    found = [(*p, *turned) for turned in dict.fromkeys(((x, y), (y, x))) for p in _corners(area, turned)]
    boxes = ((a, b, shapely.box(a - u / 2, b - v / 2, a + u / 2, b + v / 2)) for a, b, u, v in found)
    fits = ((a, b, box) for a, b, box in boxes if box.intersection(left).area > 0.9 * box.area)
    discs = [((a, b), _largest(left.difference(box))) for a, b, box in fits]
    if not discs:
        return roomiest(left)
    best = max(disc for _, disc in discs)
    equal = (spot for spot, disc in discs if disc >= best - ALIKE)
    return min(equal, key=lambda p: (round(math.dist(p, near), 3), p))


def _corners(area: Any, sides: tuple[float, float]) -> list[Offset]:
    """Return the extreme positions of a rectangle's middle at which all of its corners are in a convex
    area."""
    x, y = sides[0] / 2, sides[1] / 2
    moved = [shapely.affinity.translate(area, a * x, b * y) for a in (-1, 1) for b in (-1, 1)]
    points = shapely.get_coordinates(shapely.intersection_all(moved)).round(4).tolist()
    found = list(dict.fromkeys((float(a), float(b)) for a, b in points))
    return found[:: max(1, len(found) // TRIED)]


def _largest(area: Any) -> float:
    """Radius of the largest disc in an area [m]."""
    circles = (shapely.maximum_inscribed_circle(p) for p in shapely.get_parts(area) if p.area > 0)
    return max((float(circle.length) for circle in circles), default=0.0)

"""Way of a thing that is pushed: corners in the plane between its place and an area, around obstacles, on its
support."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, lru_cache

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Estimate, Held, Pose, Relation, World
from cramlite.plugin import Context, Refused

from ...motion_planning.reach import make_scene, shift
from ...motion_planning.space import all_of, refusal
from ...shapes.carried_along import carried_along
from ...shapes.itself import Itself
from ...shapes.surfaces import resting_height

STEP = 0.02  # of the lattice of places that a way is looked for on [m]
SIDES = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))
"""Steps from a lattice cell to its eight neighbours."""
ASIDE = (1, 2)  # steps of the lattice
MOST = 1500  # places that are looked at: a square of 0.7 m
# Extra length of a way around that is preferred to a movable obstacle being elsewhere by then [m]
SHOVED = 0.3
TAKEN_ASIDE = 0.3  # extra length of a way around worth moving one thing [m]: half of 10 s at 60 mm/s
# While its way is checked, above what it slides along, and from all else [m]
LIFT, CLEAR = np.array([0.0, 0.0, 0.003]), 0.002

Point = tuple[float, float]
Side = tuple[int, int]
Met = Callable[[Point], Refused | None]
"""Function that returns a refusal with what a thing would meet at a point of the base's x-y plane [m]; None
if it meets nothing."""
Left = Callable[[Point], float]
"""Function that returns the distance of a point from an area [m]; 0 in it."""


def way_around(start: Point, left: Left, met: Met, cleared: bool = False) -> list[Point] | Refused:
    """Find the shortest way of a pushed thing on a lattice (A*, Hart, Nilsson and Raphael 1968): its corners
    and its end, without its start.

    Args:
        cleared: whether each movable thing on it costs what taking it aside does, however long the way is
            through it; else so much for each place where it is met that nearly any free way is preferred.

    Returns:
        A refusal where there is none while movable things are where they are: it names those on the way that
            would be the best
        without them; where nothing that tasks move is to blame, it names none.
    """
    queue: list[tuple[float, int, float, Side, Side | None]] = [(left(start), 0, 0.0, (0, 0), None)]
    came: dict[Side, Side | None] = {}
    blame: dict[tuple[Side, Side], Refused] = {}
    pushed = itertools.count(1)
    while queue and len(came) < MOST:
        _, _, gone, here, before = heapq.heappop(queue)
        if here in came:
            continue
        came[here] = before
        if before is not None and not left(_spot(start, here)):
            return _traced(start, here, came, blame)
        for there, cost, no in _steps(start, here, met, cleared):
            if there not in came:
                if no is not None:
                    blame[here, there] = no
                ahead = gone + cost
                heapq.heappush(queue, (ahead + left(_spot(start, there)), next(pushed), ahead, there, here))
    return refusal(f"no way around fixed obstacles was found; {len(came)} places were looked at")


def way_straight(start: Point, end: Point, met: Met) -> list[Point] | Refused:
    """Check the straight way of a pushed thing between two points: return the end, or a refusal with all
    loose obstacles on the way, or with the first fixed one."""
    stopped = [no for no in map(met, _between(start, end)) if no is not None]
    fixed = next((no for no in stopped if not no.blocking), None)
    if not stopped or fixed:
        return fixed or [end]
    return replace(stopped[0], blocking=all_of(stopped))


def _between(start: Point, end: Point) -> Iterator[Point]:
    """Points of a straight way at most STEP apart, without its start and with its end."""
    parts, (x, y) = math.ceil(math.dist(start, end) / STEP), start
    shares = (k / parts for k in range(1, parts + 1))
    return ((x + share * (end[0] - x), y + share * (end[1] - y)) for share in shares)


def _spot(start: Point, cell: Side) -> Point:
    return start[0] + STEP * cell[0], start[1] + STEP * cell[1]


def _steps(start: Point, here: Side, met: Met, cleared: bool) -> Iterator[tuple[Side, float, Refused | None]]:
    """Yield the neighbouring lattice cells to which a thing can be pushed, each with its cost [m], and a
    refusal that names the movable things in the cell; None if there are none."""
    around = met(_spot(start, here)) if cleared else None
    gone = around.in_the_way if around else frozenset()
    for side in SIDES:
        there = (here[0] + side[0], here[1] + side[1])
        no = met(_spot(start, there))
        if no is None or no.blocking:
            more = (TAKEN_ASIDE * len(no.in_the_way - gone) if cleared else SHOVED) if no else 0.0
            yield there, STEP * math.hypot(*side) + more, no


def _traced(
    start: Point, end: Side, came: dict[Side, Side | None], blame: dict[tuple[Side, Side], Refused]
) -> list[Point] | Refused:
    """Corners and end of the way that a grid search found for a pushed thing; or a refusal that names the
    movable things on the way."""
    cells, before = [end], came[end]
    while before is not None:
        cells.append(before)
        before = came[before]
    cells.reverse()
    pairs = list(itertools.pairwise(cells))
    stopped = [blame[pair] for pair in pairs if pair in blame]
    if stopped:
        return replace(stopped[0], blocking=all_of(stopped))
    ways = [(b[0] - a[0], b[1] - a[1]) for a, b in pairs]
    turns = zip(cells[1:], ways, [*ways[1:], None], strict=True)
    return [_spot(start, cell) for cell, way, after in turns if way != after]


def ways_around(
    start: Point, left: Left, alone: Met, hand: Met
) -> Iterator[tuple[int, list[Point]]] | Refused:
    """Find paths of a pushed thing around obstacles, each with the number of lattice steps that are free on
    either side of it.

    How far it lags behind, and where it is in a corner, depends on whether it sticks to the fingers: one with
    a hollow of 40 mm was seen 15 mm off its way.

    Args:
        alone, hand: what the thing meets, and the hand that takes it along.
    """
    narrow = cache(lambda spot: alone(spot) or hand(spot))
    found = way_around(start, left, narrow)
    return found if isinstance(found, Refused) else _wider(start, left, alone, hand, found, narrow)


def _wider(
    start: Point, left: Left, alone: Met, hand: Met, narrowest: list[Point], narrow: Met
) -> Iterator[tuple[int, list[Point]]]:
    for steps in ASIDE:
        aside = [(k * x, k * y) for k in range(1, steps + 1) for x, y in SIDES]

        def roomy(spot: Point, aside: Sequence[Side] = ((0, 0), *aside)) -> Refused | None:
            return next((no for side in aside if (no := alone(_spot(spot, side)))), None) or hand(spot)

        met = cache(roomy)
        way = way_around(start, left, met)
        if not isinstance(way, Refused):
            yield steps, _shortened(start, way, met)
    yield 0, _shortened(start, narrowest, narrow)


def on_a_shorter_way(start: Point, left: Left, alone: Met, hand: Met) -> Refused | None:
    """Return a refusal with the movable obstacles whose removal shortens a way by more than it costs; None if
    there are none."""
    found = way_around(start, left, cache(lambda spot: alone(spot) or hand(spot)), cleared=True)
    return found if isinstance(found, Refused) and found.blocking else None


def _shortened(start: Point, corners: list[Point], met: Met) -> list[Point]:
    """Remove corners from a path wherever the straight line past them is free."""
    found: list[Point] = []
    while corners:
        straight = [not any(map(met, _between(start, to))) for to in corners]
        furthest = max((k for k, free in enumerate(straight) if free), default=0)
        start, corners = corners[furthest], corners[furthest + 1 :]
        found.append(start)
    return found


def met_alone(belief: Belief, context: Context, entity: str) -> Met:
    """Return a function that refuses spots where a thing and its content, without a hand, meet obstacles or
    fall off their support.

    What moves the thing is left out.
    """
    thing, pose = belief.thing(entity), belief.pose(entity)
    beside = (t for t in belief.world.things if t.name in belief.poses and t.name != entity)
    others = [(t, belief.pose(t.name)) for t in beside]
    owner = resting_height(thing, pose, others)[1]
    under, meets = [(t, at) for t, at in others if t.name == owner], _meets(belief, context, entity, pose)
    known = _known(Itself(belief.world), Itself(belief.poses), belief.relations, belief.base(), entity)

    def met(spot: Point) -> Refused | None:
        if spot not in known:
            there = shift(pose, (spot[0] - pose.position[0], spot[1] - pose.position[1], 0.0))
            falls = bool(under) and not resting_height(thing, there, under)[1]
            known[spot] = refusal(f"it would fall off '{owner}'") if falls else meets(spot)
        return known[spot]

    return met


@lru_cache(maxsize=4)
def _known(
    world: Itself[World],
    poses: Itself[Mapping[str, Estimate]],
    relations: frozenset[Relation],
    base: Pose,
    entity: str,
) -> dict[Point, Refused | None]:
    """Return an empty cache for the obstacles that a pushed thing, without the hand, would meet at each point
    of the plane.

    All hand poses share it.

    It is valid for one state of the world.
    """
    return {}


def met_with_hand(belief: Belief, context: Context, entity: str, hand: Pose) -> Met:
    """Return a cached collision check at spots (x, y) for a pushed thing together with the hand that pushes
    it.

    ``hand`` is the pose of the TCP in the base frame at the thing's present place.
    """
    return cache(_meets(belief, context, entity, hand))


def _meets(belief: Belief, context: Context, entity: str, tcp: Pose) -> Met:
    """Return a collision check at spots (x, y) for a pushed thing together with the hand that pushes it.

    The hand is left out if the TCP is at the thing's origin.
    """
    pose, base = belief.pose(entity), belief.base()
    held = Held(entity, tcp.inverse() * shift(pose, LIFT), 0.0, carries=carried_along(belief, entity))
    scene, hand = make_scene(belief.grasped(held), context, [entity], clearance=CLEAR), tcp != pose

    def met(spot: Point) -> Refused | None:
        return scene.met(
            base * shift(tcp, (spot[0] - pose.position[0], spot[1] - pose.position[1], 0.0)), hand
        )

    return met

"""Ways of a payload out of a stable pose into the open, planned backwards: up, obliquely, through a side,
tilted first, toppling, and pushed in.

Each is a generator of placements for the one driver, which checks hand and payload, arm, and what later tasks
need. Another way to put something is another function here, and an entry of ``WAYS``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain, islice

from msgspec.structs import replace

from cramlite.model import Pose, Value
from cramlite.plugin import Refused, Unresolvable

from ...kinematics.inverse import inverse
from ...motion_planning.reach import shift
from ..parameters import Where
from ..places import slants
from .access import COVERS, covered, goes_in_upright
from .at_rest import CLOSE
from .attitudes import lying
from .before_roof import before_roof
from .checks.order import SHAPES, first_objection
from .checks.rest import at_rest
from .checks.shapes import snug
from .demands import stops
from .edge_first import edge_first
from .positions import free_for, positions_along, positions_on, radius, rectangle
from .query import Found, Groups, Placement, Query, covers, is_roofed, lying_in
from .sideways import sideways
from .stable_poses import Rest, check_turn, put_down, stable_poses, standing_at, stood, turns, with_middle
from .tilting import tilted, toppling

PER_HEIGHT = 0.01  # cost of each height above the lowest
LONG = 1.5  # the ratio of the sides of what is long
LAID_AT = 6  # positions of a payload on each of its sides, in each turn, that are tried


class WayOut(Value):
    """Kind of way on which a payload can leave a target, such as up or through an open side.

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
    """Generate placements with a way straight down from above, and some with an oblique way where there is no
    room above."""
    asked = prepared(asked)
    now = put_down(asked[0])
    check_turn(asked[0], now)
    _check_way_in(asked[0], now)
    none = True
    for rest in chain(along_sides(asked[-1], now), stable_poses(asked, now)):
        none = False
        yield rest if isinstance(rest, Refused) else _from_above(rest)
    if none:
        yield from _at_best(asked, now)


def along_sides(query: Query, now: Pose) -> Iterator[Rest]:
    """Generate stable poses of a payload in a container, with its sides along those of the container.

    In the orientation ``now`` where something is over the opening and the payload is long, since a disc in
    its outline says little of the room that it needs; on a side where it would stop what a later task moves
    if it stood, but not if it lies.
    """
    if query.depth and query.covers and _is_long(query, now):
        yield from _in_rows(query, now)
    kept = query.thing.filling is not None or query.held.carries or query.held.swing or query.where.attitude
    if not query.depth or kept or not stops(query, now):
        return
    for k, turned in enumerate(side for side in lying(query) if not stops(query, side)):
        for rest in _in_rows(query, turned):
            yield replace(rest, name=f"laid on side {k + 1}, {rest.name}", reorients=True)


def _is_long(query: Query, now: Pose) -> bool:
    """Whether one side of the rectangle around a payload's outline is ``LONG`` times the other."""
    a, b, c, _ = rectangle(query, now)
    sides = sorted((math.dist(a, b), math.dist(b, c)))
    return sides[1] > LONG * sides[0]


def _in_rows(query: Query, turned: Pose) -> Iterator[Rest]:
    """Yield stable poses of a payload with an orientation, turned about the vertical until its sides are
    along the container's."""
    for yaw in turns(query, turned, (0.0, 0.0), ()):
        amid = stood(query, turned, (0.0, 0.0), yaw)
        for offset in islice(positions_along(query, amid), LAID_AT):
            again = turns(query, turned, offset, ())  # elsewhere it faces the robot elsewhere
            alike = min(again, key=lambda one: abs(math.remainder(one - yaw, 360.0)))
            yield standing_at(query, turned, offset, alike)


def _from_above(rest: Rest) -> Iterator[Found]:
    """Yield placements of a stable pose at each release height, with a way straight down and oblique ways.

    Under another drawer, a drawer has room only for oblique ways.
    """
    query = snug(rest.query, rest.thing) if rest.kind == "in" else rest.query
    for k, (over, above) in enumerate(rest.heights):
        thing = shift(rest.thing, (0.0, 0.0, over))
        pose, name = query.hand(thing), f"{rest.name}, lowest point {1000 * over:+.0f} mm from it"
        straight = Placement(
            name, thing, pose, shift(pose, (0.0, 0.0, above)), over, rest.kind,
            cost=rest.cost + PER_HEIGHT * k, reorients=rest.reorients, opens=query.settles,
        )  # fmt: skip
        if query.depth and query.held.swing is not None:
            straight = at_rest(replace(straight, kind="dropped"), query)
        yield query, straight
        if rest.kind == "in" and _may_be_there(straight, query):
            for side, way in slants(above):
                said, before = f"{name}, from {side}", shift(pose, way)
                yield query, replace(straight, name=said, before=before, led=True, aside=True)


def _may_be_there(placement: Placement, query: Query) -> bool:
    """Whether the arm reaches a placement, with hand and payload free of collision there, whatever the way
    to it."""
    if not inverse(query.context.robot, placement.pose, seed=query.belief.joints):
        return False
    return query.scene.met(query.belief.base() * placement.pose) is None


def _at_best(asked: list[Query], now: Pose) -> Iterator[Refused]:
    """Refusals of targets that have no free position: for each target the first objection to its best
    position."""
    for query in asked:
        offset = next(positions_on(replace(query, where=Where(), obstacles=()), now), (0.0, 0.0))
        _, found = next(_from_above(standing_at(query, now, offset)))
        said = (
            f"not clear: the largest disc in its outline, of {2000 * radius(query, now):.0f} mm, has no "
            "free position"
        )
        no = first_objection(found, query, SHAPES[found.kind])
        yield no or Refused(found.name, said, 0, blocking=query.standing_there())


def prepared(bare: list[Query]) -> list[Query]:
    """Return the placing problems (target and constraints) for placements from above, with the obstacles at
    each target.

    An opening has two queries: one for positions beside its contents and its overhang, one for positions
    anywhere.
    """
    if not bare[0].depth:
        return bare if bare[0].uneven else with_middle(bare)
    anywhere = [covered(q) for q in bare]
    return [*(beside_content(q) for q in anywhere if lying_in(q) or q.covers), *anywhere]


def beside_content(query: Query) -> Query:
    """Return the placing problem of an opening with the opening's contents and overhangs as obstacles.

    A smaller clearance is kept from them if there is no room for the payload otherwise.
    """
    apart = replace(query, obstacles=(*lying_in(query), *query.covers))
    close = replace(query, obstacles=(*lying_in(query, sure=True), *query.covers), clearance=CLOSE)
    now = put_down(query)
    return close if free_for(apart, now).is_empty and not free_for(close, now).is_empty else apart


def _check_way_in(query: Query, now: Pose) -> None:
    """Check that the overhang of an opening leaves room for the payload in its orientation, whatever the
    grasp.

    Raises:
        Unresolvable: it does not; tilted it may.
    """
    if query.covers and free_for(query, now).is_empty and not goes_in_upright(query, now):
        over = [o.name for o in query.covers]
        said = (
            f"'{query.thing.name}' does not get into '{query.entity}' upright: "
            f"{' and '.join(map(repr, over))} are over it"
        )
        raise Unresolvable(said, blocking=tuple(over))


def _rank_up(asked: Sequence[Query]) -> int | None:
    return None if is_roofed(asked[0]) or all(math.isfinite(q.room) for q in asked) else 0


def _rank_sideways(asked: Sequence[Query]) -> int | None:
    return 1 if is_roofed(asked[0]) or any(math.isfinite(q.room) for q in asked) else None


def _rank_tilted(asked: Sequence[Query]) -> int | None:
    return 1 if not is_roofed(asked[0]) and covers(asked[0], COVERS) else None


def _rank_edge_first(asked: Sequence[Query]) -> int | None:
    return 0 if any(math.isinf(q.room) for q in asked) and not asked[0].uneven else None


def _rank_roofed(asked: Sequence[Query]) -> int | None:
    return 0 if is_roofed(asked[0]) else None


ABOVE = WayOut("from above", _rank_up, up, endless=True)
SIDEWAYS = WayOut("through its sides", _rank_sideways, sideways, by_hand=True)
LAID, HUNG = (ABOVE,), (SIDEWAYS, WayOut("edge first", _rank_edge_first, edge_first, by_hand=True))
"""Ways onto a thing of a payload that hangs from the fingers: laid down, and released as it hangs."""
WAYS: Mapping[str, tuple[WayOut, ...]] = {
    "on": (ABOVE, SIDEWAYS),
    "in": (ABOVE, WayOut("tilted", _rank_tilted, tilted, by_hand=True), SIDEWAYS),
    "toppled": (WayOut("toppling", _rank_roofed, toppling),),
    "before": (WayOut("pushed in", _rank_roofed, before_roof),),
}  # fmt: skip
"""Ways out of a stable pose, by the relation of the payload to its target."""

"""Placements from above over the far edge of a thing: a hand that points obliquely down puts that edge onto
the support, and lets the thing fall flat, as it lay or turned over.

Where it comes to rest is simulated. On a support that is not level, such as another plate, a thing that is
led down about its far edge slides out of the fingers before it lies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice, product
from typing import Any

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Pose, Vector3
from cramlite.plugin import Refused, Unresolvable

from ...motion_planning.reach import shift
from ...shapes.bounds import centre_of_mass, support
from ...shapes.nesting import room_under
from ..reached import Arm
from .at_rest import must_lean
from .attitudes import far_edge_down, overturned
from .checks import at_rest
from .positions import Offset, free_for, positions_on
from .query import Found, Groups, Placement, Query, standing_on
from .stable_poses import Rest, about_vertical, put_down, standing_at, with_middle

# Of its lowest point over the support where the last line begins, and the stand-off above that [m]
HIGH, ABOVE = 0.010, 0.05
# Of the hand from pointing away from the robot [deg]
TURNS = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
INSIDE = 0.02
"""Distance of an origin from the border of its target where the hand comes over that [m]: what
falls there shifts by some 10 mm."""
FAR = 1.0  # beyond all borders [m]
FEW = 2  # positions on a surface: each with as many as 32 simulated falls, some 30 ms each


def edge_first(asked: list[Query]) -> Groups:
    """Generate placements of a hanging payload whose far edge is put down first, those of the least lean
    first.

    Raises:
        Unresolvable: what stands there leaves it no room to lie, whatever the grasp.
    """
    level = _as_it_lay(asked)
    now, none = put_down(level[0]), True
    spots = [(query, offset) for query in level for offset in islice(positions_on(query, now), FEW)]
    if not spots:
        raise _no_room(level, "edge first")
    for rest in (_lying(query, now, offset, asked[0].arm) for query, offset in spots):
        for (lean, leaning), turn in product(list(far_edge_down(rest.query)), TURNS):
            none = False
            name = (
                f"far edge first, leaning by {math.degrees(lean):.0f} deg, hand turned {turn:+.0f} deg, to "
                f"lie {rest.name}"
            )
            yield _let_fall(rest, leaning, _away(rest.thing.position) + math.radians(turn), name)
    if none:
        yield Refused("edge first", "no tilt at which the hand can hold the payload lets it fall flat")


def turned_over(asked: list[Query]) -> Groups:
    """Generate placements of a payload that falls over its far edge onto the face opposite to the one on
    which it would lie, those of the least lean first.

    It lies at the border over which the hand comes: the hand is then beside the support, below the payload's
    near edge.

    Raises:
        Unresolvable: what stands there leaves it no room to lie, whatever the grasp.
    """
    level = _as_it_lay(asked)
    leans = list(overturned(asked[0], put_down(level[0])))
    if not leans:
        yield Refused("turned over", "no tilt at which the hand can hold the payload turns it over")
        return
    rooms = [(query, free) for query in level if not (free := _inside(query, leans[0][2])).is_empty]
    if not rooms:
        raise _no_room(level, "turned over")
    for (query, free), (lean, leaning, lies) in product(rooms, leans):
        for heading in _headings(query):
            rest = _lying(query, lies, _border(free, query, heading), asked[0].arm)
            name = (
                f"turned over, leaning by {math.degrees(lean):.0f} deg, hand pointing to "
                f"{math.degrees(heading):+.0f} deg, to lie {rest.name}"
            )
            yield _let_fall(rest, leaning, heading, name)


def _inside(query: Query, lies: Pose) -> Any:
    """Return the positions of a payload that are well inside of the border of its target."""
    return free_for(query, lies).intersection(query.target.area.buffer(-INSIDE))


def _headings(query: Query) -> list[float]:
    """Return directions of a hand along and obliquely across the sides of a target, in the base frame [rad];
    that away from the robot first."""
    x, y, _ = query.target.pose.rotate((1.0, 0.0, 0.0))
    away = _away(query.target.pose.position)
    turns = (math.remainder(math.atan2(y, x) + k * math.pi / 4 - away, math.tau) for k in range(8))
    return [away + turn for turn in sorted(turns, key=abs)]


def _border(free: Any, query: Query, heading: float) -> Offset:
    """Return the position from which a hand that points in a direction comes first, straight before the
    middle of an area."""
    ahead = query.target.pose.inverse().rotate((math.cos(heading), math.sin(heading), 0.0))[:2]
    amid = shapely.get_coordinates(free.representative_point())[0]
    way = shapely.LineString([amid, amid - FAR * ahead]).intersection(free)
    x, y = min(shapely.get_coordinates(way).tolist(), key=lambda point: float(np.dot(point, ahead)))
    return x, y


def _away(position: Vector3) -> float:
    """Direction of a position, seen from the robot's base [rad]."""
    return math.atan2(position[1], position[0])


def _no_room(level: list[Query], way: str) -> Unresolvable:
    there = dict.fromkeys(name for query in level for name in query.standing_there())
    return Unresolvable(f"{way}: no room to lie on '{level[0].entity}'", blocking=tuple(there))


def too_low(asked: Sequence[Query]) -> bool:
    """Whether the origin of a payload that lies as it lay, or stands as it is held, is below the region in
    which it is wanted."""
    level = [query for query in asked if query.lowest and math.isinf(query.room)]
    return bool(level) and bool(must_lean(level[0], put_down(_before_swing(level)[0])))


def _as_it_lay(asked: list[Query]) -> list[Query]:
    """Return the placing problems under no roof, of the payload in the pose in which it was grasped."""
    bare = _before_swing([q for q in asked if math.isinf(q.room)])
    return with_middle([replace(q, obstacles=standing_on(q)) for q in bare])


def _before_swing(asked: list[Query]) -> list[Query]:
    """Return placing problems of a payload as it was in the hand before it swung; the same if it did not."""
    belief, context = asked[0].belief, asked[0].context
    if (swing := belief.payload.swing) is None:
        return asked
    arm = Arm(replace(belief, held=replace(belief.payload, tcp_to_thing=swing.start)), context)
    return [replace(q, arm=arm) for q in asked]


def _lying(query: Query, now: Pose, offset: tuple[float, float], arm: Arm) -> Rest:
    """Stable pose in which a payload would lie, with the placing problem of the payload as it hangs."""
    rest = standing_at(query, now, offset)
    return replace(rest, query=replace(rest.query, arm=arm))


def _let_fall(rest: Rest, now: Pose, heading: float, name: str, apart: bool = False) -> Iterator[Found]:
    """Yield placements of a leaning payload that falls flat once released: its far edge is above the place
    where that edge comes to lie.

    Args:
        now: the attitude, the hand pointing along x.
        heading: in which the hand points [rad].
    """
    query, lies = rest.query, rest.thing
    ahead, leaning = np.array([math.cos(heading), math.sin(heading), 0.0]), about_vertical(now, heading)
    leaning = shift(
        leaning, lies.apply(centre_of_mass(query.thing)) - leaning.apply(centre_of_mass(query.thing))
    )
    leaning = shift(
        leaning, (support(query.thing, lies, ahead) - support(query.thing, leaning, ahead)) * ahead
    )
    thing = shift(leaning, (0.0, 0.0, HIGH - room_under(query.thing, leaning, query.whole, query.at)))
    pose = query.hand(thing)
    placement = Placement(name, thing, pose, shift(pose, (0.0, 0.0, ABOVE)), HIGH, "dropped", reorients=True)
    yield query, at_rest(placement, query)

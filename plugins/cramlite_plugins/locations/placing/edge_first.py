"""Placements from above of a thing that hangs from the fingers at its rim: a hand that points obliquely down
puts its far edge onto the support, and lets it fall flat.

Where it comes to rest is simulated. On a support that is not level, such as another plate, a thing that is
led down about its far edge slides out of the fingers before it lies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice, product

import numpy as np
from msgspec.structs import replace

from cramlite.model import Pose
from cramlite.plugin import Refused, Unresolvable

from ...motion_planning.reach import shift
from ...shapes.bounds import centre_of_mass, support
from ...shapes.nesting import room_under
from ..reached import Arm
from .attitudes import far_edge_down
from .checks.rest import at_rest
from .positions import positions_on
from .query import Found, Groups, Placement, Query
from .stable_poses import Rest, about_vertical, put_down, standing_at, with_middle

# Of its lowest point over the support where the last line begins, and the stand-off above that [m]
HIGH, ABOVE = 0.010, 0.05
# Of the hand from pointing away from the robot [deg]
TURNS = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
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
        there = dict.fromkeys(name for query in level for name in query.standing_there())
        raise Unresolvable(f"edge first: no room to lie on '{asked[0].entity}'", blocking=tuple(there))
    for rest in (_lying(query, now, offset, asked[0].arm) for query, offset in spots):
        for (lean, leaning), turn in product(list(far_edge_down(rest.query)), TURNS):
            none = False
            name = (
                f"far edge first, leaning by {math.degrees(lean):.0f} deg, hand turned {turn:+.0f} deg, to "
                f"lie {rest.name}"
            )
            yield _let_fall(rest, leaning, turn, name)
    if none:
        yield Refused("edge first", "no tilt at which the hand can hold the payload lets it fall flat")


def _as_it_lay(asked: list[Query]) -> list[Query]:
    """Return the placing problems under no roof, of the payload in the pose in which it was grasped."""
    belief, context = asked[0].belief, asked[0].context
    swing = belief.payload.swing
    assert swing is not None
    arm = Arm(replace(belief, held=replace(belief.payload, tcp_to_thing=swing.start)), context)
    return with_middle([replace(q, arm=arm) for q in asked if math.isinf(q.room)])


def _lying(query: Query, now: Pose, offset: tuple[float, float], arm: Arm) -> Rest:
    """Stable pose in which a payload would lie, with the placing problem of the payload as it hangs."""
    rest = standing_at(query, now, offset)
    return replace(rest, query=replace(rest.query, arm=arm))


def _let_fall(rest: Rest, now: Pose, turn: float, name: str) -> Iterator[Found]:
    """Yield placements of a leaning payload that falls flat once released: its far edge is above the place
    where that edge comes to lie.

    Args:
        now: the attitude, the hand pointing along x.
        turn: of the hand from pointing away from the robot [deg].
    """
    query, lies = rest.query, rest.thing
    heading = math.atan2(lies.position[1], lies.position[0]) + math.radians(turn)
    ahead, leaning = np.array([math.cos(heading), math.sin(heading), 0.0]), about_vertical(now, heading)
    centre = centre_of_mass(query.thing)
    leaning = shift(leaning, lies.apply(centre) - leaning.apply(centre))
    farther = support(query.thing, lies, ahead) - support(query.thing, leaning, ahead)
    leaning = shift(leaning, farther * ahead)
    thing = shift(leaning, (0.0, 0.0, HIGH - room_under(query.thing, leaning, query.whole, query.at)))
    pose = query.hand(thing)
    placement = Placement(name, thing, pose, shift(pose, (0.0, 0.0, ABOVE)), HIGH, "dropped", reorients=True)
    yield query, at_rest(placement, query)

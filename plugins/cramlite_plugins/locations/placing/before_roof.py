"""Ways under an overhang that has no room for a hand: a payload is set down before the open side, on the
floor that leads in there, and fingers push it in."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from cramlite.model import Floats, Pose
from cramlite.plugin import Refused

from ...motion_planning.reach import shift
from ...shapes.bounds import corners, lowest, support
from ...shapes.roofs import open_sides
from .at_rest import along_walls
from .attitudes import lying
from .checks.shapes import WELL_IN
from .query import Groups, Placement, Query
from .stable_poses import ABOVE, carried_at, inside_from, put_down, well_in
from .tilting import ACROSS, BACK, KEPT

# Height of an edge between the floors before and under an overhang, past which fingers push, at most [m]
EDGE = 0.002
DEEPER, STEP = 0.03, 0.01  # of an origin in its region than it has to be, and between places [m]
APART = (0.03, 0.06, 0.1)  # gaps between the overhang and the payload before it [m]: half of a hand, and more


def before_roof(asked: list[Query]) -> Groups:
    """Generate placements before an overhang, from where fingers push the payload straight in until its
    origin is in its region; those with the shortest way in first."""
    query, none = asked[0], True
    for out in open_sides(query.whole, query.at, query.target, -query.depth / 2):
        for now in (put_down(query), *lying(query)):
            for placement in _set_down(query, now, out):
                none = False
                yield iter([(query, placement)])
    if none:
        yield Refused("before it", "no floor leads straight in under the overhang, with room for the payload")


def _set_down(query: Query, now: Pose, out: Floats) -> Iterator[Placement]:
    """Yield placements of a payload, turned as at a pose, before the side of an opening in the direction
    ``out`` (3,)."""
    deeps = np.arange(WELL_IN + EDGE, WELL_IN + DEEPER, STEP).tolist()
    for deep, share, turned in product(deeps, ACROSS, along_walls(query, now)):
        inside = _on_the_floor(query, turned, inside_from(query, out, deep, share))
        if inside is None or not well_in(query, inside):
            continue
        face = support(query.thing, inside, -out) + support(query.whole, query.at, out)
        for apart in APART:
            there = _on_the_floor(query, turned, inside.position + (face + apart) * out)
            if there is None or abs(there.position[2] - inside.position[2]) > EDGE:
                continue
            said = f"{1000 * apart:.0f} mm before it, to be pushed {1000 * deep:.0f} mm in"
            over = shift(there, (0.0, 0.0, KEPT))
            pose = query.hand(over)
            yield Placement(
                f"{said}, at {100 * share:+.0f} % across", over, pose, shift(pose, (0.0, 0.0, ABOVE)), KEPT,
                "before", lies=there, back=pose * Pose((0.0, 0.0, -BACK)), reorients=True, opens=True,
                pushed=inside,
            )  # fmt: skip


def _on_the_floor(query: Query, turned: Pose, point: Floats) -> Pose | None:
    """Pose of a payload, turned as at a pose, with its origin over or under a point (3,), on what carries it
    there; None if nothing does."""
    there = Pose.at((point[0], point[1], 0.0), turned)
    x, y, _ = corners(query.thing, there).mean(axis=0).tolist()
    z = float(query.target.pose.apply((0.0, 0.0, -query.depth / 2))[2])
    low = carried_at(query.thing, there, (x, y, z), query.belief)
    return None if low is None else shift(there, (0.0, 0.0, low - lowest(query.thing, there)))

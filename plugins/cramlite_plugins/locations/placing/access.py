"""Access of hand and payload to a target: obstacles around it and over it, and whether the payload gets in
upright."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose
from cramlite.plugin import Unresolvable

from ...motion_planning.reach import shift
from ...shapes import ray_casting as rays
from ...shapes.bounds import corners
from ..places import slants
from .checks.hand import let_in
from .demands import LOWS, over_floor
from .query import Placement, Query, covers, is_roofed
from .stable_poses import heights

OUT = 1.0  # from the middle of a surface to the outside of what it is in, at most [m]
HAND = 0.25
"""Length of the straight way out that a hand needs [m]: it holds the payload at one end, and the arm follows
at the other."""
DIRECTIONS, BESIDE = 1000, math.cos(math.radians(8.0))
"""Number of directions in which a straight way out is sought, 6 deg between neighbours, and the cosine of the
angle around a direction within which all others must be free: a gap of less than 30 mm at 0.1 m, such as
around the front of a drawer, is no way out for a hand."""
RISE = 0.12
"""Rise of the ways into an opening that are checked [m]: twice the depth of desk drawers."""
PITCH = 0.02  # between positions in an opening at which one is looked for [m]
COVERS = 0.3  # over an opening what covers it is looked for [m]: as high as a thing is carried


def check_open(asked: Sequence[Query]) -> None:
    """Check that a hand can get to a surface under a roof of the same thing, or to an opening with an
    overhang, whatever it holds.

    Raises:
        Unresolvable: there is no way out: a door is shut, or what is over an opening is on all sides.
    """
    first = asked[0]
    things, known = first.belief.world.things, first.belief.poses
    doors = [t.name for t in things if t.joint is not None and t.name in known]
    if doors and all(math.isfinite(q.room) for q in asked):
        amid = (
            replace(q, target=replace(q.target, pose=q.target.pose * Pose((0.0, 0.0, q.room / 2))))
            for q in asked
        )
        around, what = [closed_in(q, [first.roofing.name, *doors], OUT) for q in amid], "it"
    elif first.depth and not is_roofed(first) and covered(first).covers:
        around, what = [closed_in(first)], "its opening"
    else:
        return
    if all(around):
        names = tuple(dict.fromkeys(name for one in around for name in one))
        said = f"no hand comes into '{first.entity}': {' and '.join(map(repr, names))} are on all sides"
        raise Unresolvable(f"{said} of {what}", blocking=names)


def closed_in(query: Query, by: Sequence[str] = (), far: float = HAND) -> tuple[str, ...]:
    """Return the obstacles around a covered opening that keep every hand out; none if there is a way.

    Ways are straight, as long as a hand, as thick as fingers, from the middle of the opening and of its
    quarters, in all directions.

    Args:
        by: what is looked at; everything by default.
        far: how long ways are [m].
    """
    x, y, x1, y1 = (bound / 2 for bound in query.target.area.bounds)
    spots = ((0.0, 0.0), (x, y), (x, y1), (x1, y), (x1, y1))
    starts = query.target.pose.apply(np.array([(*spot, 0.0) for spot in spots]))
    directions = _directions()
    points, ways = np.repeat(starts, DIRECTIONS, axis=0), np.tile(directions, (len(starts), 1))
    stopped, around = np.zeros(len(points), dtype=bool), list[str]()
    for name in sorted(by or query.belief.poses.keys() - {query.thing.name}):
        to = query.belief.pose(name).inverse()
        body = rays.body(query.belief.world.thing(name).geoms)
        low, high = rays.intervals(body, to.apply(points), to.rotate(ways))
        met = ((low < far) & (high > 0.0)).any(axis=1)
        around += [name] if met.any() else []
        stopped |= met
    beside, met_from = directions @ directions.T > BESIDE, stopped.reshape(len(starts), DIRECTIONS)
    blocked = beside.astype(np.float32) @ met_from.T.astype(np.float32)
    return tuple(around) if (blocked > 0).all() else ()


def _directions() -> Floats:
    """Unit vectors (n, 3), evenly spread: a spiral by the golden angle from pole to pole."""
    k = np.arange(DIRECTIONS) + 0.5
    z, turn = 1.0 - 2.0 * k / DIRECTIONS, math.pi * (3.0 - math.sqrt(5.0)) * k
    level = np.sqrt(1.0 - z * z)
    return np.column_stack([level * np.cos(turn), level * np.sin(turn), z])


def goes_in_upright(query: Query, now: Pose) -> bool:
    """Check whether the payload, in its orientation at a pose in the base frame, gets into an opening
    straight down or at a slant, whatever its grasp."""
    points = corners(query.thing, Pose((0.0, 0.0, 0.0), now.quaternion))
    half = float(np.min(np.ptp(points, axis=0)[:2])) / 2  # of the narrower side
    inner = query.target.area.buffer(-half)  # empty for a wider payload, which is tried over the middle
    low, high = np.reshape((0.0,) * 4 if inner.is_empty else inner.bounds, (2, 2))
    ways = [np.array((0.0, 0.0, RISE)), *(way for _, way in slants(RISE))]
    spots = product(*(np.arange(low[k], high[k] + PITCH, PITCH).tolist() for k in (0, 1)))
    ends = [over_floor(query, now, spot, over) for spot, over in product(spots, LOWS)]
    led = (
        Placement("", end, at := query.hand(end), shift(at, way), 0.0, led=True)
        for end in ends
        for way in ways
    )
    return any(not let_in(one, query) for one in led)


def covered(query: Query) -> Query:
    """Return a placing problem that lists the overhangs above its opening, up to the height of a release."""
    return replace(query, covers=covers(query, heights(query, query.now)[-1][0]))

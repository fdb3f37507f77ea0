"""Placements between walls in which a thing comes to rest leaning, found by letting it go there in simulation: a book in a compartment."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice, product

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Floats, Pose, thing_of

from ..motion_planning.reach import make_scene
from ..predicates.places import RIM
from ..shapes.bounds import corners, support
from ..shapes.surfaces import footprint, resting_height
from ..simulation.resting import let_down, rests
from .place_filters import Wanted

SURE = 0.002
"""Of an origin at rest from each side of its region [m]: contacts give way by some 0.5 mm, one simulator's by more than another's."""
LEANS = (16.0, 20.0, 24.0, 12.0)  # from upright [deg]
PITCH = 0.002  # between positions across a cavity [m]
OFF_PATH = 0.003
"""How far beside its place what is let go may be [m]: 4 mm is where an arm has arrived, and it is nearer than that mostly."""
NEAR_FLOOR = 0.03
"""How high its lowest point may be over the floor where it is let go of [m]: what would lie on the walls is higher."""
DROPS = 60
"""Positions and attitudes that are let go of: up to ten times each, of some 10 ms."""
LET_GO = 0.004
"""Over the 3 to 6 mm above where it first touches [m]: where it is let go of."""
CLOSE = 0.001
"""What is kept from the walls there [m]: it leans against them then."""


def must_lean(wanted: Wanted, now: Pose) -> str:
    """Return why a thing on the floor of its region, turned as at a pose in the base frame, is below that; "" where it is not.

    What counts is where its origin is, and that may be below its foot.
    """
    if not wanted.depth or not wanted.where.region:
        return ""
    below, (x, y, top) = wanted.belief.thing(thing_of(wanted.entity)), wanted.target.pose.position
    height, _ = resting_height(wanted.thing, Pose((x, y, top), now.quaternion), [(below, wanted.belief.pose(below.name))])
    by = height + support(wanted.thing, Pose((0.0, 0.0, 0.0), now.quaternion), (0.0, 0.0, -1.0)) - top + wanted.depth
    if by >= 0 or not math.isfinite(by):
        return ""
    return f"its origin would be {-1000 * by:.0f} mm below '{wanted.where.region}' of '{below.name}', where it stands as it is turned"


def leaning(wanted: Wanted, now: Pose) -> Iterator[Pose]:
    """Generate poses in the base frame in which what is held is let go of, so that it comes to rest leaning, with its origin in the region
    that is asked for, by ``SURE``, wherever it is let go of within ``OFF_PATH``.

    Args:
        now: of what is held, in the base frame.
    """
    below = wanted.belief.thing(thing_of(wanted.entity))
    at = wanted.belief.pose(below.name)
    let_go = (let_down(wanted.thing, start, below, at) for start in _starts(wanted, now))
    for pose in islice((p for p in let_go if p is not None and _stands(wanted, p)), DROPS):
        if all(end is not None and _inside(wanted, end) for end in rests(wanted.thing, pose, below, at, OFF_PATH)):
            yield pose


def close_by(wanted: Wanted) -> Wanted:
    """Return a request whose scene keeps ``CLOSE`` only."""
    return replace(wanted, scene=make_scene(wanted.belief, wanted.context, clearance=CLOSE))


def _starts(wanted: Wanted, now: Pose) -> Iterator[Pose]:
    """Attitudes that lean over the narrow side of what is held, at positions across its opening; the nearest to its middle first."""
    for upright, lean, sign in product(along_walls(wanted, now), LEANS, (1.0, -1.0)):
        low, high = extent(wanted, upright)
        narrow = int(np.argmin((high - low)[:2]))
        axis = wanted.target.pose.rotate(np.eye(3)[1 - narrow]) * sign * math.radians(lean)
        turned = Pose.from_rotvec((0.0, 0.0, 0.0), tuple(axis.tolist())) * upright
        low, high = extent(wanted, turned)
        room = np.reshape(wanted.target.area.bounds, (2, 2))[:, narrow]
        for k in sorted(range(math.ceil(room[0] / PITCH), math.floor(room[1] / PITCH) + 1), key=abs):
            to = np.zeros(3)
            to[narrow] = PITCH * k
            there = wanted.target.pose.apply(to - (low + high) / 2)
            yield Pose(tuple(there.tolist()), turned.quaternion)


def along_walls(wanted: Wanted, now: Pose) -> list[Pose]:
    """Return attitudes, turned about the vertical so that an outline's sides are along the walls and between them, the nearest first."""
    frame, here = wanted.target.pose, Pose((0.0, 0.0, 0.0), now.quaternion)
    a, b = shapely.get_coordinates(shapely.minimum_rotated_rectangle(footprint(wanted.thing, here)))[:2]
    x, y, _ = frame.rotate((1.0, 0.0, 0.0))
    apart = math.atan2(y, x) - math.atan2(*(b - a)[::-1])
    turns = sorted((math.remainder(apart + k * math.pi / 2, 2 * math.pi) for k in range(4)), key=abs)
    room = np.reshape(wanted.target.area.bounds, (2, 2))
    found = [Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, turn)) * here for turn in turns]
    return [p for p in found if (np.subtract(*extent(wanted, p)[::-1])[:2] <= room[1] - room[0]).all()]


def extent(wanted: Wanted, turned: Pose) -> tuple[Floats, Floats]:
    """Return the lowest and highest corner (3,) of what is held with its origin at that of the opening, in the frame of that [m]."""
    to = Pose((0.0, 0.0, 0.0), wanted.target.pose.quaternion).inverse()
    points = corners(wanted.thing, to * Pose((0.0, 0.0, 0.0), turned.quaternion))
    return points.min(axis=0), points.max(axis=0)


def _stands(wanted: Wanted, pose: Pose) -> bool:
    """Whether its lowest point is near the floor."""
    lowest = float(corners(wanted.thing, wanted.target.pose.inverse() * pose)[:, 2].min())
    return lowest + wanted.depth <= NEAR_FLOOR


def _inside(wanted: Wanted, end: Pose) -> bool:
    """Whether an origin at rest is in the region by ``SURE``."""
    x, y, z = map(float, wanted.target.pose.inverse().apply(end.position))
    return SURE - wanted.depth <= z <= RIM - SURE and bool(wanted.target.area.buffer(-SURE).covers(shapely.Point(x, y)))

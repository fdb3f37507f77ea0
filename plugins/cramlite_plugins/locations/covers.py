"""Openings of containers and their covers: what is over an opening, so that a thing let go of above it would come to rest there and not in
it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import shapely

from cramlite.model import Floats, Pose, Thing, thing_of

from ..motion_planning.reach import shift
from ..shapes import ray_casting as rays
from ..shapes.bounds import corners, near
from ..shapes.surfaces import FLAT, Surface, footprint
from .from_aside import slants
from .place_filters import Obstacle, Wanted

GAP = 0.006  # around what is over an opening, as what is let down is kept apart from it [m]
HAND = 0.25
"""Room that a hand needs along itself: what it holds is at one end of that, the arm at the other [m]."""
WAYS, BESIDE = 1000, math.cos(math.radians(8.0))
"""Directions in which a way out is looked for, 6 deg between neighbours, and the cosine of the angle around one in which all must be
free: a gap of less than 30 mm at 0.1 m, such as around the front of a drawer, is no way out for a hand."""
RISE = 0.12
"""Of a way into an opening [m]: twice as deep as drawers of desks are."""
PARTS = (0.0, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0)  # of such a way that have to be free
LOWS = (0.01, 0.02, 0.03)  # of its lowest point over the floor of a cavity at the end of one, which may be a little higher than stated [m]
PITCH = 0.02  # between positions in an opening at which one is looked for [m]


def openings(thing: Thing, pose: Pose, region: str = "") -> list[tuple[Any, float]]:
    """Return the opening of a thing's cavity, the first or the one that is meant, as a surface, and how deep it is [m]."""
    cavity = next((f for f in thing.features if f.type == "cram:Cavity" and region in ("", f.name)), None)
    if cavity is None:
        return []
    size = cavity.size
    half = [size.get(name, math.inf) / 2 for name in ("width", "depth")]
    area = shapely.Point(0, 0).buffer(size["radius"]) if "radius" in size else shapely.box(-half[0], -half[1], *half)
    return [(Surface(pose * cavity.pose, area), size["height"])]


def covers(wanted: Wanted, height: float) -> tuple[Obstacle, ...]:
    """Return the outlines of what is over an opening, with the gap around, up to the height from where a thing is let go [m].

    What reaches through the opening lies in it, and covers nothing.
    """
    belief, to, area = wanted.belief, wanted.target.pose.inverse(), wanted.target.area
    found = []
    for name in belief.poses.keys() - {thing_of(wanted.entity), wanted.thing.name}:
        thing, there = belief.world.thing(name), to * belief.pose(name)
        if not near(thing, there, area.bounds):
            continue
        outline = footprint(thing, there, 2 * FLAT, height)
        if outline.intersects(area) and not footprint(thing, there, -FLAT, 0.0).intersects(area):
            found.append(Obstacle(name, outline.buffer(GAP)))
    return tuple(sorted(found, key=lambda o: o.name))


def closed_in(wanted: Wanted, by: Sequence[str] = (), far: float = HAND) -> tuple[str, ...]:
    """Return what stands around a covered opening so that no hand can hold anything in or over it; nothing where there is a way out.

    Ways are straight, as long as a hand, as thick as fingers, from the middle of the opening and of its quarters, in all directions.

    Args:
        by: what is looked at; everything by default.
        far: how long ways are [m].
    """
    x, y, x1, y1 = (bound / 2 for bound in wanted.target.area.bounds)
    starts = wanted.target.pose.apply(np.array([(0.0, 0.0, 0.0), (x, y, 0.0), (x, y1, 0.0), (x1, y, 0.0), (x1, y1, 0.0)]))
    directions = _directions()
    points, ways = np.repeat(starts, WAYS, axis=0), np.tile(directions, (len(starts), 1))
    stopped, around = np.zeros(len(points), dtype=bool), list[str]()
    for name in sorted(by or wanted.belief.poses.keys() - {wanted.thing.name}):
        to = wanted.belief.pose(name).inverse()
        low, high = rays.intervals(rays.body(wanted.belief.world.thing(name).geoms), to.apply(points), to.rotate(ways))
        met = ((low < far) & (high > 0.0)).any(axis=1)
        around += [name] if met.any() else []
        stopped |= met
    blocked = (directions @ directions.T > BESIDE).astype(np.float32) @ stopped.reshape(len(starts), WAYS).T.astype(np.float32)
    return tuple(around) if (blocked > 0).all() else ()


def _directions() -> Floats:
    """Unit vectors (n, 3), evenly spread: a spiral by the golden angle from pole to pole."""
    k = np.arange(WAYS) + 0.5
    z, turn = 1.0 - 2.0 * k / WAYS, math.pi * (3.0 - math.sqrt(5.0)) * k
    level = np.sqrt(1.0 - z * z)
    return np.column_stack([level * np.cos(turn), level * np.sin(turn), z])


def over_floor(wanted: Wanted, turned: Pose, offset: tuple[float, float], over: float) -> Pose:
    """Return the pose in the base frame of a thing, turned so, the middle of whose outline is over a position of an opening and whose
    lowest point is so far over the floor [m]."""
    points = corners(wanted.thing, Pose((0.0, 0.0, 0.0), turned.quaternion))
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = wanted.target.pose.apply((*offset, over - wanted.depth))
    return Pose((float(x - (low + high)[0] / 2), float(y - (low + high)[1] / 2), float(z - low[2])), turned.quaternion)


def free_on_way(wanted: Wanted, pose: Pose, out: Floats, hand: bool = True) -> bool:
    """Check whether what is held has room at a pose in the base frame and on the straight way out (3,) [m], with the hand or without it."""
    assert wanted.belief.held is not None
    base, at = wanted.belief.base(), pose * wanted.belief.held.tcp_to_thing.inverse()
    return all(wanted.scene.met(base * shift(at, part * out), hand) is None for part in PARTS)


def goes_in_upright(wanted: Wanted, now: Pose) -> bool:
    """Check whether what is held, turned as at a pose in the base frame, gets into an opening from above or aside, whatever holds it."""
    points = corners(wanted.thing, Pose((0.0, 0.0, 0.0), now.quaternion))
    half = float(np.min(np.ptp(points, axis=0)[:2])) / 2  # of the narrower side
    low, high = np.reshape(wanted.target.area.buffer(-half).bounds or (0.0,) * 4, (2, 2))
    ways = [np.array((0.0, 0.0, RISE)), *(way for _, way in slants(RISE))]
    spots = product(*(np.arange(low[k], high[k] + PITCH, PITCH).tolist() for k in (0, 1)))
    ends = (over_floor(wanted, now, spot, over) for spot, over in product(spots, LOWS))
    return any(free_on_way(wanted, end, way, hand=False) for end in ends for way in ways)

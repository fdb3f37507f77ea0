"""Covers: what is over a container's opening, so that a thing let go of above it would come to rest there and not in it."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Floats, thing_of

from ..shapes import ray_casting as rays
from .place_filters import Obstacle, Wanted

GAP = 0.006  # around what is over an opening, as what is let down is kept apart from it [m]
HAND = 0.25
"""Room that a hand needs along itself: what it holds is at one end of that, the arm at the other [m]."""
WAYS, BESIDE = 1000, math.cos(math.radians(8.0))
"""Directions in which a way out is looked for, 6 deg between neighbours, and the cosine of the angle around one in which all must be
free: a gap of less than 30 mm at 0.1 m, such as around the front of a drawer, is no way out for a hand."""


def covers(wanted: Wanted, height: float) -> tuple[Obstacle, ...]:
    """Return the outlines of what is over an opening, with the gap around, up to the height from where a thing is let go [m].

    What reaches through the opening lies in it, and covers nothing.
    """
    from ..shapes.surfaces import FLAT, footprint

    belief, to, area = wanted.belief, wanted.target.pose.inverse(), wanted.target.area
    found = []
    for name in belief.poses.keys() - {thing_of(wanted.entity), wanted.thing.name}:
        thing, there = belief.world.thing(name), to * belief.pose(name)
        outline = footprint(thing, there, 2 * FLAT, height)
        if outline.intersects(area) and not footprint(thing, there, -FLAT, 0.0).intersects(area):
            found.append(Obstacle(name, outline.buffer(GAP)))
    return tuple(sorted(found, key=lambda o: o.name))


def closed_in(wanted: Wanted) -> tuple[str, ...]:
    """Return what stands around a covered opening so that no hand can hold anything in or over it; nothing where there is a way out.

    Ways are straight, as long as a hand, as thick as fingers, from the middle of the opening and of its quarters, in all directions.
    """
    x, y, x1, y1 = (bound / 2 for bound in wanted.target.area.bounds)
    starts = wanted.target.pose.apply(np.array([(0.0, 0.0, 0.0), (x, y, 0.0), (x, y1, 0.0), (x1, y, 0.0), (x1, y1, 0.0)]))
    directions = _directions()
    points, ways = np.repeat(starts, WAYS, axis=0), np.tile(directions, (len(starts), 1))
    stopped, around = np.zeros(len(points), dtype=bool), list[str]()
    for name in sorted(wanted.belief.poses.keys() - {wanted.thing.name}):
        to = wanted.belief.pose(name).inverse()
        low, high = rays.intervals(rays.body(wanted.belief.world.thing(name).geoms), to.apply(points), to.rotate(ways))
        met = ((low < HAND) & (high > 0.0)).any(axis=1)
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

"""Floors under a roof, of furniture or of what stands in it, each with a side that is open."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np
import shapely

from cramlite.model import Belief, Floats, Pose, Thing, Value

from ...motion_planning.reach import shift
from ...shapes.bounds import centre_of_mass, corners
from ...shapes.nesting import nested
from ...shapes.roofs import has_own_roof, roof_over, roofed
from ...shapes.surfaces import Surface
from .query import openings, roof_above
from .stable_poses import carried_at

HIGH = 0.010  # lowest point above a floor on a level way [m]
HIGHER = 0.02  # the same above the top of a thing that can move, whose place is uncertain by some 5 mm [m]
STEP = 0.01  # between positions, from the middle of a floor outwards [m]
OUTERMOST = 0.012  # position from the edge of a floor [m]: what is dropped there shifts by some millimetres
ASIDE = (0.0, 0.3, -0.3, 0.1, -0.1, 0.2, -0.2)
"""Positions across the way in to a floor, as shares of half the floor's width: in a microwave beside its open
door, a hand had room on only 15 mm of that width."""


class Floor(Value):
    """Floor under a roof, with a side that is open.

    Args:
        whole: thing whose roof that is.
        at: its pose in the base frame.
        surface: in the base frame.
        room: up to the roof, with ``high`` in excess of ``HIGH`` taken off [m].
        out: level unit vector (3,) through the open side.
        high: height of a payload's lowest point above it on a level way [m].
    """

    whole: Thing
    at: Pose
    surface: Surface
    room: float
    out: Floats
    high: float = HIGH

    def spots(self, few: int = 1) -> list[tuple[Floats, str]]:
        """Return points (3,) on a floor under a roof, from its middle to its open side, with descriptions;
        fewer of them if ``few`` > 1."""
        low, high = np.reshape(self.surface.area.bounds, (2, 2))
        way = self.surface.pose.inverse().rotate(self.out)[:2]
        across, half = np.array([-way[1], way[0]]), (high - low) / 2
        deep, wide = float(np.abs(way) @ half), float(np.abs(across) @ half)
        found = []
        steps = [*np.arange(0.0, deep - OUTERMOST, few * STEP).tolist(), max(0.0, deep - OUTERMOST)]
        for gone, share in product(steps, ASIDE if few == 1 else ASIDE[:3]):
            x, y = gone * way + share * wide * across
            name = f"{1000 * gone:.0f} mm out from its middle, {1000 * share * wide:+.0f} mm aside"
            found.append((self.surface.pose.apply((float(x), float(y), 0.0)), name))
        return found


def levels(
    thing: Thing, now: Pose, whole: Thing, region: str, belief: Belief, within: bool
) -> Iterator[tuple[Surface, float, float]]:
    """Generate floors under a roof, each with the room up to the roof (``Floor.room``) and the height of a
    level way over the floor (``Floor.high``).

    They are upper faces of a thing, what the payload would rest on in its cavity, or where it would rest on a
    thing that stands under another one's roof.
    """
    at = belief.pose(whole.name)
    if not within and (roof := roof_above(whole, belief)):
        over = belief.pose(roof)
        surface = _upon(thing, now, whole, at, over.rotate((1.0, 0.0, 0.0)))
        if surface is not None:
            high = float(corners(whole, at)[:, 2].max()) - surface.pose.position[2] + HIGHER
            yield surface, roof_over(belief.thing(roof), over, surface.pose.position) - high + HIGH, high
        return
    if not within:
        yield from ((surface, room, HIGH) for surface, room in roofed(whole, at, region))
        return
    for target, depth in openings(whole, at, region) if has_own_roof(whole, at, region) else ():
        x, y, z = map(float, target.pose.apply((0.0, 0.0, -depth / 2)))
        low = carried_at(thing, now, (x, y, z), belief)
        if low is not None:
            floor = Surface(Pose((x, y, low), target.pose.quaternion), target.area)
            yield floor, roof_over(whole, at, (x, y, low)), HIGH


def _upon(thing: Thing, now: Pose, below: Thing, at: Pose, along: Floats) -> Surface | None:
    """Surface of the support of a payload that is let down onto the middle of a thing, in the orientation of
    the pose ``now``; None if the thing does not support it there.

    The x axis of the support's frame is along a direction (3,), seen from above.
    """
    points, angle = corners(below, at), math.atan2(along[1], along[0])
    way = (points.min(axis=0) + points.max(axis=0)) / 2 - now.apply(centre_of_mass(thing))
    found = nested(thing, shift(now, way * (1.0, 1.0, 0.0)), below, at)
    if found is None:
        return None
    area = shapely.affinity.rotate(found.area, -angle, (0.0, 0.0), use_radians=True)
    return Surface(found.pose * Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, angle)), area)

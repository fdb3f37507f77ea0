"""Poses of a held thing at rest on what is not flat, found by letting it go there in simulation: on racks, cradles, bars."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from cramlite.model import EntityName, Floats, Pose, Thing
from cramlite.plugin import Refused

from ..shapes.bounds import corners
from .attitude import PALM_UP
from .place_filters import Wanted

QUARTER = math.pi / 2
SIDES_DOWN = tuple(
    Pose.from_rotvec((0.0, 0.0, 0.0), v)
    for v in ((0, 0, 0), (QUARTER, 0, 0), (-QUARTER, 0, 0), (0, QUARTER, 0), (0, -QUARTER, 0), (math.pi, 0, 0))
)
"""Turns of a thing by which each side of the box around it comes to face down."""
SHARES = (0.0, 0.15, -0.15, 0.3, -0.3, 0.45, -0.45)
"""Of the length and of the width of what is below, from its middle: where a thing is let go of."""
DROPS = 80
"""That a query looks at, of some 30 ms each."""
LARGE = 0.5
"""Share of an outline that is level: what has as much is a table or a shelf rather than a rack."""


def is_uneven(wanted: Wanted) -> bool:
    """Check whether nothing is level of what a thing is put on, or no surface of it is large, against its outline from above."""
    from ..shapes.surfaces import footprint

    if wanted.uneven:
        return True
    if wanted.under is not None or wanted.where.get("region") or EntityName.parse(wanted.entity).part:
        return False
    below = wanted.belief.thing(wanted.entity)
    if not below.furniture:
        return False
    outline = footprint(below, wanted.belief.pose(below.name))
    return bool(wanted.target.area.area < LARGE * outline.area)


def resting_poses(wanted: Wanted, now: Pose) -> Iterator[Pose | Refused]:
    """Generate poses in the base frame in which what is held stays on what it is put on, or why it does not.

    Args:
        now: of what is held, in the base frame.
    """
    from ..simulation.resting import resting_pose

    below = wanted.belief.thing(wanted.entity)
    at = wanted.belief.pose(below.name)
    starts = [(x, y, turned) for (x, y), turned in product(_positions(wanted, below, at), _attitudes(wanted, now, at))]
    for x, y, turned in starts[:DROPS]:
        found = resting_pose(wanted.thing, Pose((x, y, 0.0), turned.quaternion), below, at)
        name = f"let go of at ({1000 * x:+.0f} {1000 * y:+.0f}) mm from the robot"
        yield found or Refused(name, f"not at rest: it would slide or fall off '{wanted.entity}'", 0)


def _positions(wanted: Wanted, below: Thing, at: Pose) -> list[tuple[float, float]]:
    """Positions over a thing or a region of it, in the base frame [m]: along the middles of the box around it, the nearest to its own
    middle first."""
    import shapely

    frame, target = _level(at), wanted.target
    corners_of_it = np.insert(shapely.get_coordinates(target.area), 2, 0.0, axis=1)
    points: Floats = frame.inverse().apply(target.pose.apply(corners_of_it)) if wanted.uneven else corners(below, frame.inverse() * at)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = (low + high) / 2, high - low
    shifts = dict.fromkeys(shift for s in SHARES for shift in ((0.0, s), (s, 0.0)))
    there = (frame.apply(middle + size * np.array((*shift, 0.0))) for shift in shifts)
    return [(round(float(p[0]), 4), round(float(p[1]), 4)) for p in there]


def _level(at: Pose) -> Pose:
    """A frame whose z is up, turned about that as a thing is."""
    x, y, _ = at.rotate((1.0, 0.0, 0.0) if abs(at.rotation[2, 0]) < math.sqrt(0.5) else (0.0, 1.0, 0.0))
    return Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, math.atan2(y, x)))


def _attitudes(wanted: Wanted, now: Pose, at: Pose) -> list[Pose]:
    """Attitudes in line with what is below, those first for which the hand has to turn least; none with the hand under the thing."""
    assert wanted.belief.held is not None
    grip, frame = wanted.belief.held.tcp_to_thing.inverse(), _level(at)
    found: list[tuple[float, int, Pose]] = []
    for side, quarter in product(SIDES_DOWN, range(4)):
        turned = frame * Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, quarter * QUARTER)) * side
        if float((turned * grip).rotate((0.0, 0.0, 1.0))[2]) <= PALM_UP:
            found.append((round(math.hypot(*(now.inverse() * turned).rotvec), 3), len(found), turned))
    return [turned for _, _, turned in sorted(found, key=lambda f: f[:2])]

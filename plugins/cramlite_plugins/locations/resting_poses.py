"""Poses of a held thing at rest on what is not flat, found by letting it go there in simulation: on racks, cradles, bars."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import EntityName, Floats, Pose, Thing, thing_of

from ..motion_planning.reach import make_scene, shift
from ..motions.gripping import release_opening
from ..shapes.bounds import corners
from ..shapes.surfaces import footprint
from ..simulation.resting import resting_pose
from .attitude import PALM_UP
from .grips import SLACK, WIDE
from .place_filters import Spot, Wanted

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
    if wanted.uneven:
        return True
    if wanted.under is not None or wanted.where.region or EntityName.parse(wanted.entity).part:
        return False
    below = wanted.belief.thing(wanted.entity)
    if not below.furniture:
        return False
    outline = footprint(below, wanted.belief.pose(below.name))
    return bool(wanted.target.area.area < LARGE * outline.area)


def resting_poses(wanted: Wanted, now: Pose) -> Iterator[Pose]:
    """Generate poses in the base frame in which what is held stays on what it is put on.

    Args:
        now: of what is held, in the base frame.
    """
    below = wanted.belief.thing(wanted.entity)
    at = wanted.belief.pose(below.name)
    starts = [(x, y, turned) for (x, y), turned in product(_positions(wanted, below, at), _attitudes(wanted, now, at))]
    for x, y, turned in starts[:DROPS]:
        if found := resting_pose(wanted.thing, Pose((x, y, 0.0), turned.quaternion), below, at):
            yield found


def spot_at_rest(wanted: Wanted, there: Pose, height: float, above: float) -> Spot:
    """Return a resting pose as a placement candidate: the thing so far above it [m], and the stand-off so far above that."""
    assert wanted.belief.held is not None
    x, y, z = (1000 * v for v in there.position)
    thing = shift(there, (0.0, 0.0, height))
    pose = thing * wanted.belief.held.tcp_to_thing.inverse()
    name = f"at rest at ({x:+.0f} {y:+.0f} {z:+.0f}) mm from the robot, lowest point {1000 * height:+.0f} mm from it"
    return Spot(name, thing, pose, shift(pose, (0, 0, above)), height)


def lowered_onto(wanted: Wanted) -> Wanted:
    """Return a request with the scenes in which a thing has been let down onto what is not level: it may touch that, the hand may not."""
    held, widest = wanted.belief.held, release_opening(wanted.belief, wanted.context)
    wide = (wanted.belief.opening, widest, *(min(widest, held.opening + more) for more in (WIDE, SLACK) if held))
    down, *opened = (make_scene(wanted.belief, wanted.context, (thing_of(wanted.entity),), w, 0.0, hand=False) for w in wide)
    return replace(wanted, lowered=down, opened=tuple(opened))


def _positions(wanted: Wanted, below: Thing, at: Pose) -> list[tuple[float, float]]:
    """Positions over a thing or a region of it, in the base frame [m]: along the middles of the box around it, the nearest to its own
    middle first."""
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

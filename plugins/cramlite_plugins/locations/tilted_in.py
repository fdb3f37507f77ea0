"""Placements of what does not fit upright between what is over an opening and its walls, such as a bowl in a drawer under the handles of
others: it is let down aslant, leaning so that its edge comes in under them, and stands up when it is let go of, as simulation says."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import product

import numpy as np

from cramlite.model import Floats, Pose, Value, thing_of

from ..shapes.bounds import corners
from ..shapes.standing_up import stood_up
from .from_aside import slants
from .leaning import along_walls
from .place_filters import Wanted

TILTS = (30.0, 40.0, 20.0)
"""From upright [deg]: a bowl of 107 mm has most room between handles and wall at 40, the hand that holds it by its rim at 20."""
SHARES = (0.75, 0.5, 1.0)
"""Of its height that a way in leads aside: towards what it comes in under, below that."""
RISE = 0.12  # of the way in [m]: twice as deep as drawers of desks are
PARTS = (0.0, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0)  # of the way in that have to be free
PITCH = 0.01  # between positions along the way that it leans [m]
ACROSS = (0.0, 0.6, -0.6)  # and across it, as shares of half of the room
OVER_FLOOR = (0.02, 0.03, 0.01)  # of the lowest point where it is let go of [m]
TURNS, FIRST = 24, 5
"""Turns of a thing about its own axis, and how many are tried: those at which the hand is nearest to pointing straight down."""
OFF_PATH = 0.004  # how far beside its place what is let go may be [m]: where an arm has arrived
STANDS = math.radians(3.0)  # what leans by no more has come to stand


class TiltedWay(Value):
    """Way of a leaning thing into an opening.

    Args:
        pose: of the thing in the base frame where it is let go of.
        out: from there to where it is over everything (3,) [m].
        rest: of the thing in the base frame, once it has come to rest.
        name: for people.
    """

    pose: Pose
    out: Floats
    rest: Pose
    name: str


def goes_in_upright(wanted: Wanted, now: Pose) -> bool:
    """Check whether a thing, turned as at a pose in the base frame, gets into an opening straight from above or aslant, whatever holds it."""
    low, high = np.reshape(wanted.target.area.bounds, (2, 2))
    ways = [(0.0, 0.0, RISE), *(way for _, way in slants(RISE))]
    for turned in along_walls(wanted, now)[:2]:
        for x, y in product(np.arange(low[0], high[0], PITCH).tolist(), np.arange(low[1], high[1], PITCH).tolist()):
            at = _over(wanted, turned, (x, y), OVER_FLOOR[2])
            if any(_free(wanted, at, np.asarray(way), hand=False) for way in ways):
                return True
    return False


def ways_in(wanted: Wanted, now: Pose) -> Iterator[TiltedWay]:
    """Generate ways in that are free for thing and hand and at whose end it comes to stand in the container, let go of within ``OFF_PATH``.

    Args:
        now: of what is held, upright, in the base frame.
    """
    for towards, tilt, over in product(_under(wanted), TILTS, OVER_FLOOR):
        lean = Pose.from_rotvec((0.0, 0.0, 0.0), tuple((math.radians(tilt) * np.cross((0.0, 0.0, 1.0), towards)).tolist()))
        first, *_ = turns = [lean * turned for turned in _hand_down(wanted, lean, now)]
        for offset, share in product(_offsets(wanted, towards), SHARES):
            out = RISE * (np.array([0.0, 0.0, 1.0]) - share * towards)
            if not _free(wanted, _over(wanted, first, offset, over), out, hand=False):
                continue
            for turned in turns:
                pose = _over(wanted, turned, offset, over)
                if _free(wanted, pose, out, hand=True) and (rest := _rest(wanted, pose)):
                    x, y = (1000 * v for v in offset)
                    said = f"({x:+.0f} {y:+.0f}) mm from its middle, tilted {tilt:.0f} deg, lowest point {1000 * over:.0f} mm over its floor"
                    yield TiltedWay(pose, out, rest, said)
                    break


def _under(wanted: Wanted) -> Iterable[Floats]:
    """Unit vectors along the opening's sides towards what is over it, the most direct one first, in the base frame."""
    import shapely

    over = shapely.union_all([o.area for o in wanted.covers]).intersection(wanted.target.area).centroid
    middle = wanted.target.area.centroid
    to = wanted.target.pose.rotate((over.x - middle.x, over.y - middle.y, 0.0))
    axes = [sign * wanted.target.pose.rotate(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) for sign in (1.0, -1.0)]
    return sorted((a for a in axes if a @ to > PITCH), key=lambda a: -float(a @ to))


def _hand_down(wanted: Wanted, lean: Pose, now: Pose) -> list[Pose]:
    """Leaning attitudes of a thing that is turned about its own upright axis, those first at which the hand points straight down."""
    assert wanted.belief.held is not None
    grip = wanted.belief.held.tcp_to_thing.inverse()
    found = []
    for k in range(TURNS):
        turn = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, 2.0 * math.pi * k / TURNS))
        turned = lean * turn * Pose((0.0, 0.0, 0.0), now.quaternion)
        found.append((round(float((turned * grip).rotate((0.0, 0.0, 1.0))[2]), 3), k, turned))
    return [turned for _, _, turned in sorted(found, key=lambda f: f[:2])[:FIRST]]


def _offsets(wanted: Wanted, towards: Floats) -> Iterator[tuple[float, float]]:
    """Positions in an opening, in its frame [m]: away from what is over it first."""
    way = wanted.target.pose.inverse().rotate(towards)[:2]
    across = np.array([-way[1], way[0]])
    low, high = np.reshape(wanted.target.area.bounds, (2, 2))
    middle, half = (low + high) / 2, (high - low) / 2
    deep, wide = float(np.abs(way) @ half), float(np.abs(across) @ half)
    for share, gone in product(ACROSS, np.arange(-deep, deep, PITCH).tolist()):
        x, y = middle + gone * way + share * wide * across
        yield float(x), float(y)


def _over(wanted: Wanted, turned: Pose, offset: tuple[float, float], over: float) -> Pose:
    """The pose in the base frame of a thing, turned so, whose outline has its middle over a position and which is so far over the floor."""
    points = corners(wanted.thing, Pose((0.0, 0.0, 0.0), turned.quaternion))
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = wanted.target.pose.apply((*offset, over - wanted.depth))
    return Pose((float(x - (low + high)[0] / 2), float(y - (low + high)[1] / 2), float(z - low[2])), turned.quaternion)


def _free(wanted: Wanted, pose: Pose, out: Floats, hand: bool) -> bool:
    """Whether a thing, with or without the hand, has room at a pose and on the straight way out."""
    from ..motion_planning.reach import shift

    assert wanted.belief.held is not None
    base, at = wanted.belief.base(), pose * wanted.belief.held.tcp_to_thing.inverse()
    return all(wanted.scene.met(base * shift(at, part * out), hand) is None for part in PARTS)


def _rest(wanted: Wanted, pose: Pose) -> Pose | None:
    """Where a thing that is let go of at a pose comes to stand in the container; None where it may come to lie otherwise."""
    from ..simulation.resting import rests

    below = wanted.belief.thing(thing_of(wanted.entity))
    ends = list(rests(wanted.thing, pose, below, wanted.belief.pose(below.name), OFF_PATH))
    return ends[0] if all(end is not None and _stands_inside(wanted, end) for end in ends) else None


def _stands_inside(wanted: Wanted, end: Pose) -> bool:
    """Whether a thing at rest stands, with all of its outline in the opening."""
    from ..shapes.surfaces import footprint

    _, leans = end.distance(stood_up(wanted.thing, end))
    return leans <= STANDS and bool(wanted.target.area.covers(footprint(wanted.thing, wanted.target.pose.inverse() * end)))

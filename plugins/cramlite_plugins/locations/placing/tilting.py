"""Ways through an opening for a payload that does not fit in upright: tilted, or released to topple with
only its foot inside."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Floats, Pose
from cramlite.plugin import Refused, Unresolvable, checkpoint

from ...motion_planning.reach import shift, taken_at
from ...shapes.bounds import corners, support
from ...shapes.roofs import open_sides
from ...shapes.standing_up import stood_up
from .access import COVERS, RISE
from .at_rest import along_walls, extent
from .checks.hand import room
from .checks.shapes import OFF_WALLS
from .demands import LOWS, over_floor, stops
from .query import Groups, Placement, Query, covers
from .stable_poses import about_vertical, toppled

TILTS = (25.0, 30.0, 20.0)
"""Leans of a payload from upright [deg]: between handles and wall a bowl of 107 mm has more room the more
it leans, and the hand at its rim less."""
LEFT = 12.0
"""Lean of a payload from upright at its release [deg]: with an upright payload, the hand, which leans by 30
deg, would be in the wall; from this lean a bowl stands up."""
SHARES = (0.75, 1.0, 0.5)  # of its height that a way in leads aside, below what it comes in under
# Distances inwards from where it would stand as far out as it can [m]: farther in it is farther from the wall
INWARDS = (0.012, 0.006, 0.018, 0.0)
ACROSS = (0.0, 0.6, -0.6)  # of the room to each side, across the way that it leans
FARTHER = (0.024, 0.016, 0.008)  # how much farther out it leans more [m]
OVER = (0.02, 0.03, 0.01)  # how much higher its lowest point is there [m]
HEADINGS, FIRST = 24, 3
"""Number of turns of a payload about its own axis, and how many of them are tried: those at which the leaning
hand points most nearly straight down."""
LEAST = 0.01  # from the middle of an opening to that of what covers it, by which it is on one side [m]
LEANS = (55.0, 50.0, 45.0, 40.0, 35.0, 30.0)
"""Leans of a payload that topples into its place, from upright [deg]: with more lean its foot gets farther in
and it falls less; from 58 deg on, a Panda's hand that holds a book of 120 mm by its end is in the table."""
# Distance of the lowest point over what carries what topples, on the way in [m]: what paths keep, and a
# little more
KEPT = 0.008
CLEAR = 0.03  # how far out from under the roof its foot is at the stand-off [m]
BACK = 0.12
"""Way of the hand back along its approach [m], out from under a thing that toppled onto its lower finger.
The hand takes the thing along a little, LIBERO's book by 48 mm, as its Panda's pads have a friction of 2."""


def tilted(asked: list[Query]) -> Groups:
    """Generate placements in a partly covered opening, such as a drawer under others' handles, of a payload
    that does not get in upright: it is let down leaning, with its edge under the overhang, and straightened
    in there.

    Raises:
        Unresolvable: something is in the payload, and would fall out.
    """
    query, none = replace(asked[0], covers=covers(asked[0], COVERS)), True
    _check_empty(query, "leans")
    if (no := _in_the_way(query)) is not None:
        yield no
        return
    for placement in _leaning_in(query):
        none = False
        yield iter([(query, placement)])
    if none:
        said = "hand and tilted payload fit nowhere between the target's overhang and its walls"
        yield Refused("tilted", said)


def _check_empty(query: Query, does: str) -> None:
    if query.thing.filling is not None or query.held.carries:
        reason = f"'{query.thing.name}' holds something that would fall out as it {does}"
        raise Unresolvable(reason, taken_at(query.belief, query.context))


def _in_the_way(query: Query) -> Refused | None:
    """Refusal if the payload, wherever it stands once straightened, stops what later tasks move; None if it
    does not somewhere."""
    upright = stood_up(query.thing, query.now)
    spots = (spot for towards in _under(query) for spot in _offsets(query, towards))
    no = stops(query, upright)
    return no if no is not None and all(stops(query, upright, spot) for spot in spots) else None


def _leaning_in(query: Query) -> Iterator[Placement]:
    """Yield ways into an opening on which hand and payload are free of collision, whatever the arm's posture.

    Each has a leaning pose on the way, the nearly upright pose of the release, and a way out from that.
    """
    for towards, tilt in product(_under(query), TILTS):
        turns = _hand_down(query, _lean(towards, tilt))
        for offset, turned in product(_offsets(query, towards), turns):
            lows = ((low, over_floor(query, _lean(towards, LEFT) * turned, offset, low)) for low in LOWS)
            low, left = next(((low, pose) for low, pose in lows if not _met(query, pose)), (0.0, None))
            lies = left and stood_up(query.thing, left)
            for back, over in product(FARTHER, OVER) if left else ():
                farther = _moved(query, offset, -back * towards)
                at = over_floor(query, _lean(towards, tilt) * turned, farther, low + over)
                x, y = (1000 * v for v in offset)
                said = f"({x:+.0f} {y:+.0f}) mm from its middle, let down leaning by {tilt:.0f} deg"
                name = f"{said}, {1000 * back:.0f} mm farther out, {1000 * over:.0f} mm higher"
                ends = left or at, lies or at
                found = (_straightened(query, ends, at, out, name) for out in _up_and_away(towards))
                free = next((one for one in found if not room(one, query)), None)
                if free is not None:
                    yield free
                    break


def _straightened(query: Query, ends: tuple[Pose, Pose], at: Pose, out: Floats, name: str) -> Placement:
    """Placement in which the payload passes an opening while it leans, and is straightened for the release;
    ``ends`` are the payload's poses at the release and at rest."""
    leaning, (left, lies) = query.hand(at), ends
    return Placement(
        name, left, query.hand(left), shift(leaning, out), LOWS[0] - query.depth, "in", (leaning,), True,
        lies, reorients=True, opens=True,
    )  # fmt: skip


def _lean(towards: Floats, degrees: float) -> Pose:
    """Rotation that tilts a thing by an angle towards a horizontal direction."""
    axis = np.cross((0.0, 0.0, 1.0), towards)
    return Pose.from_rotvec((0.0, 0.0, 0.0), tuple((math.radians(degrees) * axis).tolist()))


def _up_and_away(towards: Floats) -> Iterator[Floats]:
    """Displacements (3,) [m] that lead a payload up and away from the overhang of an opening."""
    for share in SHARES:
        yield RISE * (np.array([0.0, 0.0, 1.0]) - share * towards)


def _under(query: Query) -> list[Floats]:
    """Return unit vectors along an opening's sides that point towards the overhang above it, the most
    direct one first, in the base frame."""
    over = shapely.union_all([o.area for o in query.covers]).intersection(query.target.area).centroid
    middle = query.target.area.centroid
    to = query.target.pose.rotate((over.x - middle.x, over.y - middle.y, 0.0))
    signs = product(np.eye(3)[:2], (1.0, -1.0))
    axes = [sign * query.target.pose.rotate(axis) for axis, sign in signs]
    return sorted((a for a in axes if a @ to > LEAST), key=lambda a: -float(a @ to))


def _hand_down(query: Query, lean: Pose) -> list[Pose]:
    """Orientations of a thing about its own upright axis, those first at which the hand points most nearly
    straight down while the thing leans."""
    found = []
    for k in range(HEADINGS):
        turned = about_vertical(query.now, math.tau * k / HEADINGS)
        found.append((round(float(query.hand(lean * turned).rotate((0.0, 0.0, 1.0))[2]), 3), k, turned))
    return [turned for _, _, turned in sorted(found, key=lambda f: f[:2])[:FIRST]]


def _offsets(query: Query, towards: Floats) -> Iterator[tuple[float, float]]:
    """Positions [m] in an opening's frame that bring the payload away from under the overhang, as far as the
    walls allow or a little less."""
    frame = query.target.pose.inverse()
    way = frame.rotate(towards)[:2]
    across = np.array([-way[1], way[0]])
    points = frame.rotate(corners(query.thing, Pose((0.0, 0.0, 0.0), query.now.quaternion)))[:, :2]
    low, high = np.reshape(query.target.area.bounds, (2, 2))
    deep, wide = ((np.abs(v) @ (high - low) - np.ptp(points @ v)) / 2 - OFF_WALLS for v in (way, across))
    for share, gone in product(ACROSS, INWARDS):
        if deep > 0 and wide > 0:
            x, y = (low + high) / 2 + (gone - deep) * way + share * wide * across
            yield float(x), float(y)


def _moved(query: Query, offset: tuple[float, float], by: Floats) -> tuple[float, float]:
    """Shift a position (x, y) in an opening's frame by a vector (3,) of the base frame [m]."""
    x, y, _ = query.target.pose.inverse().rotate(by)
    return offset[0] + float(x), offset[1] + float(y)


def _met(query: Query, pose: Pose) -> bool:
    """Whether hand or thing meet something with the thing at a pose, wherever the arm is."""
    checkpoint()
    return query.scene.met(query.belief.base() * query.hand(pose)) is not None


def toppling(asked: list[Query]) -> Groups:
    """Generate placements under an overhang that is too low for the payload, such as a book under a shelf:
    its foot goes in while it leans out; released, it topples about the foot and lies there.

    The hand stays before the roof; what lies there sticks out.

    Raises:
        Unresolvable: something is in the payload, and would fall out.
    """
    query, none = asked[0], True
    _check_empty(query, "topples")
    sides = open_sides(query.whole, query.at, query.target, -query.depth / 2)
    for out, upright in product(sides, along_walls(query, query.now)):
        low, high = extent(query, upright)
        deep = np.abs(query.target.pose.inverse().rotate(out)[:2])
        if deep @ (high - low)[:2] > (1.0 - deep) @ (high - low)[:2]:
            continue  # it would topple over its broad side
        for lean in LEANS:
            for leaning, lies, name in toppled(query, upright, out, lean):
                none = False
                yield iter([(query, _foot_in(query, shift(leaning, (0.0, 0.0, KEPT)), lies, out, name))])
    if none:
        yield Refused(
            "toppling",
            "the payload, released leaning outwards, would nowhere topple and lie with its origin in the "
            "region",
        )


def _foot_in(query: Query, leaning: Pose, lies: Pose, out: Floats, name: str) -> Placement:
    """Placement with the payload's foot under the overhang; its stand-off is at the same height in front of
    the overhang."""
    area = query.target.pose.apply(np.insert(np.reshape(query.target.area.bounds, (2, 2)), 2, 0.0, axis=1))
    far, pose = CLEAR + float((area @ out).max()) + support(query.thing, leaning, -out), query.hand(leaning)
    back = pose * Pose((0.0, 0.0, -BACK))
    return Placement(
        name, leaning, pose, shift(pose, far * out), KEPT, "toppled", (), True, lies, back, reorients=True,
        opens=True,
    )  # fmt: skip

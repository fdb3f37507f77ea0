"""Placements in an opening that is partly covered, such as that of a drawer under the handles of others, of what does not get in upright:
it is let down leaning, so that its edge comes in under what is over the opening, and straightened in there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, EntityName, Floats, Location, Place, Pose, Value, thing_of
from cramlite.plugin import Context, Grounding, Refused, Unresolvable, checkpoint

from ..motion_planning.cartesian import interpolate, plan_straight_line
from ..motion_planning.reach import bound, collision_free_ik, led_by, make_scene, reference_pose, shift, taken_at
from ..motion_planning.space import refusal
from ..motions.gripping import release_opening
from ..shapes.bounds import corners
from ..shapes.standing_up import stood_up
from ..shapes.surfaces import footprint
from ..simulation.resting import rests
from .attitude import held_now
from .covers import LOWS, RISE, covers, free_on_way, openings, over_floor
from .free_area import free_area
from .later import brings
from .parameters import Where, asked
from .place_filters import (
    CHEAP,
    OFF_WALLS,
    Filter,
    Spot,
    Wanted,
    first_objection,
    reachable,
    released,
    room_to_open,
    visible,
)
from .room_to_close import room_to_close

TILTS = (25.0, 30.0, 20.0)
"""From upright [deg]: between handles and wall a bowl of 107 mm has more room the more it leans, and the hand at its rim less."""
LEFT = 12.0
"""Of that when it is let go of [deg]: upright, a hand that leans by 30 deg would be in the wall; from there a bowl stands up."""
SHARES = (0.75, 1.0, 0.5)  # of its height that a way in leads aside, below what it comes in under
INWARDS = (0.012, 0.006, 0.018, 0.0)  # from where it would stand as far out as it can [m]: farther in it is farther from the wall
ACROSS = (0.0, 0.6, -0.6)  # of the room to each side, across the way that it leans
BACK = (0.024, 0.016, 0.008)  # how much farther out it leans more [m]
OVER = (0.02, 0.03, 0.01)  # how much higher its lowest point is there [m]
TURNS, FIRST = 24, 3
"""Turns of a thing about its own axis, and how many are tried: those at which the hand is nearest to pointing straight down as it leans."""
STRAIGHTEN = (0.25, 0.5, 0.75)  # parts of its turn at which all has to be free
OFF_PATH = 0.004  # how far beside its place what is let go may be [m]: where an arm has arrived
STANDS = math.radians(3.0)  # what leans by no more has come to stand
LEAST = 0.01  # from the middle of an opening to that of what covers it, by which it is on one side [m]
COVERS = 0.3  # over an opening what covers it is looked for [m]: as high as a thing is carried


class Entry(Value):
    """Way into a covered opening.

    Args:
        leaning, left: poses of what is held in the base frame, where it leans as it came in, and where it is let go of.
        out: from the former to where it is over everything (3,) [m].
        name: for people.
    """

    leaning: Pose
    left: Pose
    out: Floats
    name: str


def places_aslant(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate placements of what is held in a covered opening, let down leaning; its ``path`` leads on to where it stands.

    Raises:
        Unresolvable: nothing covers the opening, or held so it cannot be brought in.
    """
    wanted = _wanted(location, belief, context)
    found, no = 0, Refused("aslant", "hand and thing have no way in between what is over it and its walls")
    for entry in _entries(wanted, held_now(belief, context)):
        refused = _refusal(entry, wanted)
        if refused is None:
            yield Grounding(_place(entry, wanted), f"'{wanted.entity}', {entry.name}", 0.1 * found, key=entry.name, anew=True)
            found += 1
        else:
            no = refused if refused.passed >= no.passed else no
    if not found:
        because = (location.of or "", *led_by(location, context), *taken_at(belief, context))
        raise Unresolvable(f"aslant: {no.reason}", because, blocking=no.blocking)


def goes_in_aslant(thing: str, belief: Belief, context: Context) -> bool:
    """Check whether a later task brings a thing into an opening that is covered so far that it does not get in straight from above."""
    narrow = [name for name in belief.poses if name != thing and _too_narrow(thing, name, belief, context)]
    if not narrow:
        return False  # later tasks are not looked at, so that what follows from this holds whatever they are
    return any(onto.thing in narrow for onto, _ in brings(thing, belief, context))


def _too_narrow(thing: str, into: str, belief: Belief, context: Context) -> bool:
    """Whether a thing, turned as it is, goes into an opening, but for what is over that."""
    held, now = belief.thing(thing), belief.pose(thing)
    half = float(np.min(np.ptp(corners(held, now), axis=0)[:2])) / 2
    for target, depth in openings(belief.thing(into), belief.pose(into)):
        core, bare = target.area.buffer(-half), Wanted(held, into, target, belief, context, None, Where(), depth=depth)
        if not core.is_empty and free_area(core, [o.area for o in covers(bare, COVERS)], half).is_empty:
            return True
    return False


def _wanted(location: Location, belief: Belief, context: Context) -> Wanted:
    """What is put into which opening, with what is over that.

    Raises:
        Unresolvable: there is no opening, nothing is over it, or nothing is held.
    """
    entity = bound(context, location.of)
    if belief.held is None:
        raise Unresolvable("nothing is held that could be brought there")
    region = asked(location, Where).region or EntityName.parse(entity).part
    found = openings(belief.thing(entity), reference_pose(belief, location, context), region)
    if not found:
        raise Unresolvable(f"'{entity}' has no cavity to put anything in", (location.of or "",), blocking=())
    opened = make_scene(belief, context, (), release_opening(belief, context), 0.0)
    (target, depth), held = found[0], belief.world.thing(belief.held.thing)
    bare = Wanted(held, entity, target, belief, context, make_scene(belief, context), asked(location, Where), depth=depth, opened=(opened,))
    over = covers(bare, COVERS)
    if not over:
        because = (location.of or "", *led_by(location, context))  # straight from above another grasp may do
        raise Unresolvable(f"nothing is over the opening of '{entity}': things go in from above", because, blocking=())
    if held.filling is not None or belief.held.carries:
        because = (location.of or "", *led_by(location, context))
        raise Unresolvable(f"'{held.name}' holds something that would fall out as it leans", because)
    return replace(bare, covers=over)


def _entries(wanted: Wanted, now: Pose) -> Iterator[Entry]:
    """Ways in that are free for hand and thing, wherever the arm is.

    Args:
        now: of what is held, upright, in the base frame.
    """
    for towards, tilt in product(_under(wanted), TILTS):
        turns = _hand_down(wanted, _lean(towards, tilt), now)
        for offset, turned in product(_offsets(wanted, now, towards), turns):
            lows = ((low, over_floor(wanted, _lean(towards, LEFT) * turned, offset, low)) for low in LOWS)
            low, left = next(((low, pose) for low, pose in lows if not _met(wanted, pose)), (0.0, None))
            for back, over in product(BACK, OVER) if left else ():
                at = over_floor(wanted, _lean(towards, tilt) * turned, _moved(wanted, offset, -back * towards), low + over)
                out = next((o for o in _ways_out(towards) if free_on_way(wanted, at, o)), None)
                if left is not None and out is not None and _straightens(wanted, at, left):
                    x, y = (1000 * v for v in offset)
                    said = f"({x:+.0f} {y:+.0f}) mm from its middle, let down leaning by {tilt:.0f} deg, {1000 * back:.0f} mm farther out"
                    yield Entry(at, left, out, f"{said}, {1000 * over:.0f} mm higher")
                    break


def _lean(towards: Floats, degrees: float) -> Pose:
    """The turn by which something leans a level way."""
    axis = np.cross((0.0, 0.0, 1.0), towards)
    return Pose.from_rotvec((0.0, 0.0, 0.0), tuple((math.radians(degrees) * axis).tolist()))


def _ways_out(towards: Floats) -> Iterator[Floats]:
    """Ways up and away from what is over an opening."""
    for share in SHARES:
        yield RISE * (np.array([0.0, 0.0, 1.0]) - share * towards)


def _under(wanted: Wanted) -> list[Floats]:
    """Unit vectors along the opening's sides towards what is over it, the most direct one first, in the base frame."""
    over = shapely.union_all([o.area for o in wanted.covers]).intersection(wanted.target.area).centroid
    middle = wanted.target.area.centroid
    to = wanted.target.pose.rotate((over.x - middle.x, over.y - middle.y, 0.0))
    axes = [sign * wanted.target.pose.rotate(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) for sign in (1.0, -1.0)]
    return sorted((a for a in axes if a @ to > LEAST), key=lambda a: -float(a @ to))


def _hand_down(wanted: Wanted, lean: Pose, now: Pose) -> list[Pose]:
    """Attitudes of a thing turned about its own upright axis, those first at which the hand points straight down when it leans."""
    assert wanted.belief.held is not None
    grip = wanted.belief.held.tcp_to_thing.inverse()
    found = []
    for k in range(TURNS):
        turned = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, 2.0 * math.pi * k / TURNS)) * Pose((0.0, 0.0, 0.0), now.quaternion)
        found.append((round(float((lean * turned * grip).rotate((0.0, 0.0, 1.0))[2]), 3), k, turned))
    return [turned for _, _, turned in sorted(found, key=lambda f: f[:2])[:FIRST]]


def _offsets(wanted: Wanted, now: Pose, towards: Floats) -> Iterator[tuple[float, float]]:
    """Positions in an opening, in its frame, at which a thing stands as far out from under what is over it as it can, or nearly [m]."""
    frame = wanted.target.pose.inverse()
    way = frame.rotate(towards)[:2]
    across = np.array([-way[1], way[0]])
    points = frame.rotate(corners(wanted.thing, Pose((0.0, 0.0, 0.0), now.quaternion)))[:, :2]
    low, high = np.reshape(wanted.target.area.bounds, (2, 2))
    deep, wide = ((np.abs(v) @ (high - low) - np.ptp(points @ v)) / 2 - OFF_WALLS for v in (way, across))
    for share, gone in product(ACROSS, INWARDS):
        if deep > 0 and wide > 0:
            x, y = (low + high) / 2 + (gone - deep) * way + share * wide * across
            yield float(x), float(y)


def _moved(wanted: Wanted, offset: tuple[float, float], by: Floats) -> tuple[float, float]:
    """A position in an opening, moved by a vector (3,) of the base frame."""
    x, y, _ = wanted.target.pose.inverse().rotate(by)
    return offset[0] + float(x), offset[1] + float(y)


def _met(wanted: Wanted, pose: Pose) -> bool:
    """Whether hand or thing meet something with the thing at a pose, wherever the arm is."""
    checkpoint()
    assert wanted.belief.held is not None
    return wanted.scene.met(wanted.belief.base() * pose * wanted.belief.held.tcp_to_thing.inverse()) is not None


def _straightens(wanted: Wanted, leaning: Pose, left: Pose) -> bool:
    """Whether hand and thing are free as it leans less and less."""
    assert wanted.belief.held is not None
    held = wanted.belief.held.tcp_to_thing
    ways = (interpolate(leaning * held.inverse(), left * held.inverse(), part) * held for part in STRAIGHTEN)
    return not any(_met(wanted, pose) for pose in ways)


def _stands_up(wanted: Wanted, left: Pose) -> bool:
    """Whether a thing comes to stand in the opening when it is let go of at a pose, as simulation says."""
    below = wanted.belief.thing(thing_of(wanted.entity))
    for end in rests(wanted.thing, left, below, wanted.belief.pose(below.name), OFF_PATH):
        if end is None or end.distance(stood_up(wanted.thing, end))[1] > STANDS:
            return False
        if not wanted.target.area.covers(footprint(wanted.thing, wanted.target.pose.inverse() * end)):
            return False
    return True


def _spot(entry: Entry, wanted: Wanted) -> Spot:
    assert wanted.belief.held is not None
    grip = wanted.belief.held.tcp_to_thing.inverse()
    return Spot(entry.name, entry.left, entry.left * grip, shift(entry.leaning * grip, entry.out), LOWS[0] - wanted.depth)


def _place(entry: Entry, wanted: Wanted) -> Place:
    assert wanted.belief.held is not None
    spot, way = _spot(entry, wanted), -entry.out / np.linalg.norm(entry.out)
    leaning = entry.leaning * wanted.belief.held.tcp_to_thing.inverse()
    release = released(wanted, spot.height, wanted.opened[0].opening, entry.left.inverse() * stood_up(wanted.thing, entry.left))
    return Place(
        leaning, spot.before, approach=tuple(way.tolist()), path=(spot.pose,), thing=wanted.thing.name, release=release, reorients=True
    )


def _refusal(entry: Entry, wanted: Wanted) -> Refused | None:
    """Which filter objects and why, and how many passed before it; the arm's way in comes last."""
    spot = _spot(entry, wanted)
    if no := first_objection(spot, wanted, FILTERS):
        return no
    stuck = _arm_leads_out(entry, spot, wanted)
    if stuck is None and not _stands_up(wanted, entry.left):
        stuck = refusal(f"'{wanted.thing.name}' may come to lie otherwise than it stands when it is let go of")
    return stuck.of(spot.name, len(FILTERS)) if stuck else None


def _arm_leads_out(entry: Entry, spot: Spot, wanted: Wanted) -> Refused | None:
    """Why the arm cannot lead what it holds out of there again, leaning and straight on; None where it can."""
    assert wanted.belief.held is not None
    there = collision_free_ik(wanted.scene, wanted.context, spot.pose, wanted.belief.joints)
    if isinstance(there, Refused):
        return there
    leaning = entry.leaning * wanted.belief.held.tcp_to_thing.inverse()
    line = plan_straight_line(wanted.scene, wanted.context.robot, there, [leaning, spot.before])
    return replace(line, reason=f"on its way out {line.reason}") if isinstance(line, Refused) else None


def _room_to_close(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that it is in nobody's way once it stands."""
    return room_to_close(replace(spot, thing=stood_up(wanted.thing, spot.thing)), wanted)


FILTERS: Mapping[str, Filter] = {
    **CHEAP["in"], "reachable": reachable, "visible": visible, "free to open": room_to_open, "free to be closed": _room_to_close,
}  # fmt: skip

"""Placements under a roof that is too low for what is held, such as of a book under a shelf: its foot goes in there, leaning out, and when
it is let go of it tips over about that and lies there.

The hand stays before the roof; what lies there sticks out. The hand goes back the way it points, from under what tips over onto its lower
finger, and takes that along a little: LIBERO's book by 48 mm, as its Panda's pads have a friction of 2. ``push_in`` brings it back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, EntityName, Estimate, Floats, Location, Place, Pose, Value, Vector3
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..kinematics.kinematics import inverse
from ..motion_planning.cartesian import plan_straight_line
from ..motion_planning.reach import bound, collision_free_ik, make_scene, reference_pose, shift, taken_at
from ..motions.gripping import release_opening
from ..shapes.bounds import corners, lowest, support
from ..shapes.roofs import has_own_roof, open_sides
from ..shapes.surfaces import resting_height
from ..shapes.tipping_over import tipped_over
from .attitude import held_now
from .covers import openings
from .leaning import along_walls, extent
from .parameters import Where, asked
from .place_filters import (
    WELL_IN,
    Filter,
    Spot,
    Wanted,
    beside,
    first_objection,
    near,
    reachable,
    released,
    room_to_open,
    visible,
)
from .push_in import ways_in

LEANS = (55.0, 50.0, 45.0, 40.0, 35.0, 30.0)
"""From upright [deg]: the more it leans, the farther in its foot can be and the less it falls; from 58 deg on a Panda's hand that holds a
book of 120 mm by its end is in the table."""
BEYOND = 0.01  # its centre of mass is beyond the edge that it tips over, at least [m]: the finger below it holds it up at first
DEEPEST, STEP = 0.06, 0.005  # of an origin in its region, and between positions [m]
ACROSS = (0.0, 0.4, -0.4)  # positions across the way in, as shares of half of the room
OVER = 0.008  # lowest point over what carries it, on the way in [m]: what paths keep, and a little more
OUT = 0.03  # how far out from under the roof its foot is at the stand-off [m]
BACK = 0.12  # how far the hand goes back from under it [m]: the book's end is 40 mm from the pads' middle, as they are in it, and it falls
PARTS = (0.0, 0.33, 0.67, 1.0)  # of the way out that are looked at before the arm is


class Tipping(Value):
    """A way to let something tip over.

    Args:
        leaning, lies: poses of what is held in the base frame, where it is let go of, and where it comes to lie.
        out: the level unit vector (3,) out of there.
        name: for people.
    """

    leaning: Pose
    lies: Pose
    out: Floats
    name: str


LYING = "lying there"
"""Check of the payload alone."""


def places_tipped(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate placements of what is held with its foot under a roof, leaning out; its ``path`` leads back from there.

    Raises:
        Unresolvable: there is no roof, no side is open, or held so it cannot be brought there.
    """
    wanted = _wanted(location, belief, context)
    found, no = 0, Refused("tipped", "no foot of it is far enough in where it would tip over")
    for tipping in _tippings(wanted, held_now(belief, context)):
        refused = _refusal(tipping, wanted)
        if refused is None:
            yield Grounding(_place(tipping, wanted), f"'{wanted.entity}', {tipping.name}", 0.1 * found, key=tipping.name, anew=True)
            found += 1
        else:
            no = refused if refused.passed >= no.passed else no
    if not found:
        grasps = taken_at(belief, context) if no.check not in ("", LYING) else ()  # what has no room itself has none in another hand
        raise Unresolvable(f"tipped: {no.reason}", (location.of or "", *grasps), blocking=no.blocking)


def _wanted(location: Location, belief: Belief, context: Context) -> Wanted:
    """What is put under which roof.

    Raises:
        Unresolvable: nothing is held, or there is no opening with a roof.
    """
    entity = bound(context, location.of)
    if belief.held is None:
        raise Unresolvable("nothing is held that could be brought there")
    region = asked(location, Where).region or EntityName.parse(entity).part
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    found = openings(thing, pose, region)
    opened = make_scene(belief, context, (), release_opening(belief, context), 0.0)
    held, scene = belief.world.thing(belief.held.thing), make_scene(belief, context)
    if not has_own_roof(thing, pose, region):
        raise Unresolvable(f"no opening of '{entity}' has a roof: things go in from above", (location.of or "",), blocking=())
    if held.filling is not None or belief.held.carries:
        raise Unresolvable(f"'{held.name}' holds something that would fall out as it tips over", (location.of or "",))
    target, depth = found[0]
    return Wanted(held, entity, target, belief, context, scene, asked(location, Where), depth=depth, opened=(opened,))


def _tippings(wanted: Wanted, now: Pose) -> Iterator[Tipping]:
    """Ways to let it tip over onto its broad side, out of an open side, with its origin in the region after that; the farthest in first."""
    thing = wanted.belief.thing(wanted.entity)
    sides = open_sides(thing, wanted.belief.pose(thing.name), wanted.target, -wanted.depth / 2)
    for out, upright in product(sides, along_walls(wanted, now)):
        low, high = extent(wanted, upright)
        deep = np.abs(wanted.target.pose.inverse().rotate(out)[:2])
        if deep @ (high - low)[:2] > (1.0 - deep) @ (high - low)[:2]:
            continue  # it would tip over its broad side
        for lean in LEANS:
            yield from _leaning(wanted, upright, out, lean)


def _leaning(wanted: Wanted, upright: Pose, out: Floats, lean: float) -> Iterator[Tipping]:
    """Positions of what leans out by so much [deg], the farthest in first."""
    x, y, z = (math.radians(lean) * np.cross((0.0, 0.0, 1.0), out)).tolist()
    turned = Pose((0.0, 0.0, 0.0), (Pose.from_rotvec((0.0, 0.0, 0.0), (x, y, z)) * upright).quaternion)
    over = tipped_over(wanted.thing, turned)
    if over is None or over[1] < BEYOND or (low := _floor(wanted, over[0])) is None:
        return
    for deep, share in product(np.arange(DEEPEST, WELL_IN, -STEP).tolist(), ACROSS):
        by = _at(wanted, out, deep, share) - over[0].position
        by[2] = low - lowest(wanted.thing, turned)
        leaning, lies = (Pose(tuple((np.asarray(p.position) + by).tolist()), p.quaternion) for p in (turned, over[0]))
        if _inside(wanted, lies):
            name = f"leaning out by {lean:.0f} deg, to lie {1000 * deep:.0f} mm in, at {100 * share:+.0f} % across"
            yield Tipping(_up(leaning, OVER), lies, out, name)


def _hand(tipping: Tipping, wanted: Wanted) -> Pose:
    """The TCP where it is let go of."""
    assert wanted.belief.held is not None
    return tipping.leaning * wanted.belief.held.tcp_to_thing.inverse()


def _floor(wanted: Wanted, lying: Pose) -> float | None:
    """Height of what carries a thing that lies turned so, with its middle in the opening's [m]; None for nothing."""
    points = corners(wanted.thing, lying)
    middle = wanted.target.pose.apply((0.0, 0.0, -wanted.depth / 2)) - (points.min(axis=0) + points.max(axis=0)) / 2
    there = Pose(tuple((np.asarray(lying.position) + middle).tolist()), lying.quaternion)
    height, _ = resting_height(wanted.thing, there, [(wanted.belief.thing(n), wanted.belief.pose(n)) for n in wanted.belief.poses])
    return height if math.isfinite(height) else None


def _at(wanted: Wanted, out: Floats, deep: float, share: float) -> Floats:
    """A position so far inside an opening from its open side, and across that (3,)."""
    low, high = np.reshape(wanted.target.area.bounds, (2, 2))
    way = wanted.target.pose.inverse().rotate(out)[:2]
    across = np.array([-way[1], way[0]])
    half, middle = (high - low) / 2, (low + high) / 2
    x, y = middle + (np.abs(way) @ half - deep) * way + share * (np.abs(across) @ half) * across
    found: Floats = wanted.target.pose.apply((float(x), float(y), 0.0))
    return found


def _inside(wanted: Wanted, lies: Pose) -> bool:
    """Whether an origin is in the region, well in from its sides."""
    x, y, z = map(float, wanted.target.pose.inverse().apply(lies.position))
    return -wanted.depth <= z <= 0.0 and bool(wanted.target.area.buffer(-WELL_IN).covers(shapely.Point(x, y)))


def _up(pose: Pose, by: float) -> Pose:
    x, y, z = pose.position
    return Pose((x, y, z + by), pose.quaternion)


def _spot(tipping: Tipping, wanted: Wanted) -> Spot:
    """The placement where it is let go of; its stand-off is level before that."""
    area = wanted.target.pose.apply(np.insert(np.reshape(wanted.target.area.bounds, (2, 2)), 2, 0.0, axis=1))
    far = OUT + float((area @ tipping.out).max()) + support(wanted.thing, tipping.leaning, -tipping.out)
    pose = _hand(tipping, wanted)
    return Spot(tipping.name, tipping.lies, pose, shift(pose, far * tipping.out), OVER)


def _place(tipping: Tipping, wanted: Wanted) -> Place:
    spot = _spot(tipping, wanted)
    over = tipped_over(wanted.thing, tipping.leaning)
    settles = tipping.leaning.inverse() * over[0] if over else Pose()
    release = released(wanted, OVER, wanted.opened[0].opening, settles)
    return Place(
        spot.pose, spot.before, approach=_inwards(tipping), path=(_back(spot.pose),), thing=wanted.thing.name, release=release,
        reorients=True,
    )


def _refusal(tipping: Tipping, wanted: Wanted) -> Refused | None:
    """Which filter objects and why, and how many passed before it."""
    spot = _spot(tipping, wanted)
    return first_objection(spot, wanted, FILTERS) or _not_pushed_in(tipping, spot, wanted)


def _not_pushed_in(tipping: Tipping, spot: Spot, wanted: Wanted) -> Refused | None:
    """Why the arm could not push it in again; None where it can."""
    ways = [way for _, way in ways_in(wanted.thing.name, _inwards(tipping), _let_go(tipping, spot, wanted), wanted.context)]
    stuck = [way for way in ways if isinstance(way, Refused)]
    if len(stuck) < len(ways):
        return None
    return replace(stuck[0], reason=f"not pushed in: {stuck[0].reason}", check="pushed in").of(spot.name, len(FILTERS))


def _let_go(tipping: Tipping, spot: Spot, wanted: Wanted) -> Belief:
    """The belief with the hand back from what lies there."""
    belief = wanted.belief
    released = belief.released(Estimate(belief.base() * tipping.lies, 0.0, "tipped over"), wanted.opened[0].opening)
    return released.moved(inverse(wanted.context.robot, _back(spot.pose), seed=belief.joints)[0])


def _inwards(tipping: Tipping) -> Vector3:
    return -float(tipping.out[0]), -float(tipping.out[1]), 0.0


def _room(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that hand and thing have room there and on the way out, wherever the arm is."""
    base, way = wanted.belief.base(), np.subtract(spot.before.position, spot.pose.position)
    found: Iterator[Refused | None] = (wanted.scene.met(base * shift(spot.pose, part * way)) for part in PARTS)
    return next((no for no in found if no is not None), "")


def _lies(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that the thing has room where it comes to lie, whatever let go of it."""
    assert wanted.belief.held is not None
    lying = _up(spot.thing, OVER) * wanted.belief.held.tcp_to_thing.inverse()
    no: Refused | None = wanted.scene.met(wanted.belief.base() * lying, False)
    return no or ""


def _way_in(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that the arm is free there, and leads the hand straight out of it and back."""
    out, back = (_led(spot.pose, end, wanted) for end in (spot.before, _back(spot.pose)))
    if out:
        return replace(out, reason=f"on its way out {out.reason}")
    return replace(back, reason=f"back from under it {back.reason}") if back else ""


def _back(hand: Pose) -> Pose:
    return hand * Pose((0.0, 0.0, -BACK))


def _led(start: Pose, end: Pose, wanted: Wanted) -> Refused | None:
    """Why the arm cannot lead what it holds from a TCP pose straight on to another; None where it can."""
    there = collision_free_ik(wanted.scene, wanted.context, start, wanted.belief.joints)
    if isinstance(there, Refused):
        return there
    line = plan_straight_line(wanted.scene, wanted.context.robot, there, end)
    return line if isinstance(line, Refused) else None


FILTERS: Mapping[str, Filter] = {
    LYING: _lies, "near": near, "beside": beside, "collision-free": _room, "reachable": reachable, "visible": visible,
    "led in by the arm": _way_in, "free to open": room_to_open,
}  # fmt: skip

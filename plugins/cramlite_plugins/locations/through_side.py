"""Placements under a roof, such as in a microwave or on a level of a shelf: carried in level through a side that is open.

The hand points inwards, so that it stays before the opening or is no higher than what it holds; of the positions those come first that are
farthest in.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, EntityName, Floats, Location, Place, Pose, Remedy
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..motion_planning.cartesian import plan_straight_line
from ..motion_planning.reach import bound, collision_free_ik, led_by, make_scene, reference_pose, shift, taken_at, tcp
from ..motion_planning.space import refusal
from ..motions.gripping import release_opening
from ..shapes.bounds import centre_of_mass, height, support
from ..shapes.roofs import has_a_roof, open_sides, roofed
from ..shapes.surfaces import surfaces
from .attitude import held_now
from .later import brings
from .parameters import Where, asked
from .place_filters import (
    Filter,
    Spot,
    Wanted,
    beside,
    first_objection,
    in_region,
    near,
    reachable,
    room_to_open,
    supported,
    visible,
)
from .room_to_close import TIGHT, is_tight, room_to_close

HIGH = 0.010  # lowest point above the surface on its way in [m]
OUT = 0.02  # between what is held and the thing that it goes into, where the way in begins [m]
STEP = 0.01  # between positions, from the middle of a surface outwards [m]
ASIDE = (0.0, 0.3, -0.3, 0.1, -0.1, 0.2, -0.2)
"""Positions across the way in, as shares of half the width: in a microwave beside its open door a hand had room on 15 mm of it."""
TURNS = (0.0, 10.0, -10.0, 20.0, -20.0, 5.0, -5.0)  # of the hand from pointing straight inwards [deg]
PARTS = (0.0, 0.33, 0.67, 1.0)  # of the way out that are looked at before the arm is
STEEP = 0.85  # of the hand's approach, downwards, from which on it points nowhere: it would be as high as it is long


def places_through_a_side(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate placements of what is held on surfaces under a roof, best first.

    Raises:
        Unresolvable: there is none. Where what is held has no way in itself, no other grasp helps.
    """
    found, fits, kept, tight, nearest = 0, False, list[Refused](), list[Grounding](), Refused("", "the hand has no way in")
    for wanted, out, now in _ways(location, belief, context):
        for spot in _spots(wanted, out, now):
            no = first_objection(spot, wanted, FILTERS)
            fits = fits or no is None or no.check not in ALONE
            if no is None:
                place = Grounding(_place(spot, wanted, out), f"'{wanted.entity}', {spot.name}", 0.1 * found, key=spot.name, anew=True)
                found += 1
                if is_tight(spot, wanted):
                    tight.append(replace(place, cost=place.cost + TIGHT))
                else:
                    yield place
            elif fits:
                nearest = no if no.check == SHUT else nearest
                yield replace(no, because=taken_at(belief, context))
            else:
                kept.append(no)
    yield from kept if found else ()
    yield from tight
    if not found:
        near = max(kept, key=lambda no: no.passed) if kept and not fits else nearest
        grasps = taken_at(belief, context) if fits or not kept else ()
        because = (location.of or "", *grasps, *brought_there_by(location, belief, context))
        in_the_way = dict.fromkeys(name for no in (*kept, nearest) for name in no.blocking or ())
        raise Unresolvable(f"through its sides: {near.reason}", because, blocking=tuple(in_the_way))


def _ways(location: Location, belief: Belief, context: Context) -> Iterator[tuple[Wanted, Floats, Pose]]:
    """Surfaces with ways out of them on which what is held has room, and where it is now.

    Raises:
        Unresolvable: it is too high for each of them, or no side is open.
    """
    now, low, none, higher = held_now(belief, context), math.inf, True, None
    for wanted, room in _targets(location, belief, context):
        tall = height(wanted.thing, now)
        thing = belief.thing(wanted.entity)
        for out in open_sides(thing, belief.pose(thing.name), wanted.target, tall / 2) if tall + 2 * HIGH <= room else ():
            yield wanted, out, now
            none = False
        higher = _higher(wanted, room, tall + 2 * HIGH) if room < tall + 2 * HIGH else higher
        low = min(low, room - tall)
    if none:
        more = f"{1000 * low:.0f} mm higher than '{belief.held.thing if belief.held else ''}', {2000 * HIGH:.0f} mm is needed"
        said = f"the room under the roof of '{location.of}' is {more}" if low < 2 * HIGH else f"no side of '{location.of}' is open"
        raise Unresolvable(said, (location.of or "", *brought_there_by(location, belief, context)), blocking=(), remedy=higher)


def _higher(wanted: Wanted, room: float, needed: float) -> Remedy:
    """What to try where a thing is too high for the room under a roof."""
    says = (
        f"the opening of '{wanted.entity}' is {1000 * room:.0f} mm high, '{wanted.thing.name}' needs {1000 * needed:.0f} mm with the gap "
        f"around it: take a lower thing, lay it down, or name another place"
    )
    return Remedy(f"room {wanted.entity}", says, needed - room)


def _place(spot: Spot, wanted: Wanted, out: Floats) -> Place:
    x, y, z = spot.pose.position
    low, inwards = Pose((x, y, z - HIGH), spot.pose.quaternion), (-float(out[0]), -float(out[1]), 0.0)
    return Place(spot.pose, spot.before, approach=inwards, path=(low,), thing=wanted.thing.name)


def goes_under_a_roof(thing: str, belief: Belief, context: Context) -> bool:
    """Check whether a later task brings a thing onto a surface that nothing is put on from above: a named one, or of what has no other. A
    table's board near the floor is not meant by the table, off which a thing is picked up."""
    if not any(has_a_roof(belief.thing(other), belief.pose(other)) for other in belief.poses if other != thing):
        return False  # later tasks are not looked at, so that what follows from this holds whatever they are
    for onto, region in brings(thing, belief, context):
        there, at = belief.thing(onto.thing), belief.pose(onto.thing)
        if (region or not surfaces(there, at)) and any(roofed(there, at, region)):
            return True
    return False


def brought_there_by(location: Location, belief: Belief, context: Context) -> tuple[str, ...]:
    """Return the names of the tasks that lead to a location under a roof: what refuses one way there may let in another."""
    entity = EntityName.parse(str(context.bindings.get(location.of or "", "")))
    region = asked(location, Where).region or entity.part
    if entity.thing not in belief.poses or not any(roofed(belief.thing(entity.thing), belief.pose(entity.thing), region)):
        return ()
    return led_by(location, context)


def _targets(location: Location, belief: Belief, context: Context) -> list[tuple[Wanted, float]]:
    """What is put where, and the room over it [m].

    Raises:
        Unresolvable: nothing is held, no surface has a roof, or the hand points downwards.
    """
    entity = bound(context, location.of)
    if belief.held is None:
        raise Unresolvable("nothing is held that could be brought there")
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    region = asked(location, Where).region or EntityName.parse(entity).part
    found = list(roofed(thing, pose, region))
    if not found:
        raise Unresolvable(f"nothing is over a surface of '{entity}': things are put there from above", (location.of or "",), blocking=())
    down = -float(tcp(belief, context).rotate((0.0, 0.0, 1.0))[2])
    if down > STEEP:
        said = f"the hand points down by {math.degrees(math.asin(min(down, 1.0))):.0f} deg, and would be higher than what it brings"
        raise Unresolvable(said, (*taken_at(belief, context), *brought_there_by(location, belief, context)), blocking=())
    held, scene = belief.world.thing(belief.held.thing), make_scene(belief, context)
    opened = (make_scene(belief, context, (entity,), release_opening(belief, context), 0.0),)
    return [(Wanted(held, entity, s, belief, context, scene, asked(location, Where), opened=opened), h) for s, h in found]


def _spots(wanted: Wanted, out: Floats, now: Pose) -> Iterator[Spot]:
    """Positions from the middle outwards, at each the turns at which the hand points inwards."""
    assert wanted.belief.held is not None
    ahead = tcp(wanted.belief, wanted.context).rotate((0.0, 0.0, 1.0))
    facing = math.atan2(-out[1], -out[0]) - math.atan2(ahead[1], ahead[0])
    low, high = np.reshape(wanted.target.area.bounds, (2, 2))
    way = wanted.target.pose.inverse().rotate(out)[:2]
    across, half = np.array([-way[1], way[0]]), (high - low) / 2
    deep, wide = float(np.abs(way) @ half), float(np.abs(across) @ half)
    for gone, share, yaw in itertools.product(np.arange(0.0, deep, STEP).tolist(), ASIDE, TURNS):
        thing = _standing(wanted, now, gone * way + share * wide * across, facing + math.radians(yaw))
        pose = thing * wanted.belief.held.tcp_to_thing.inverse()
        name = f"{1000 * gone:.0f} mm out from its middle, {1000 * share * wide:+.0f} mm aside, turned {yaw:+.0f} deg, through its side"
        yield Spot(name, thing, pose, shift(pose, _stand_off(wanted, thing, out) * out), HIGH)


def _standing(wanted: Wanted, now: Pose, offset: Floats, turn: float) -> Pose:
    """What is held with its centre of mass over a position of the target, turned about the vertical [rad]."""
    turned = Pose((0, 0, 0), (Pose.from_rotvec((0, 0, 0), (0, 0, turn)) * Pose((0, 0, 0), now.quaternion)).quaternion)
    x, y, z = wanted.target.pose.apply((float(offset[0]), float(offset[1]), 0.0))
    at = turned.apply(centre_of_mass(wanted.thing))
    return Pose((float(x - at[0]), float(y - at[1]), float(z) + HIGH + support(wanted.thing, turned, (0, 0, -1))), turned.quaternion)


def _stand_off(wanted: Wanted, thing: Pose, out: Floats) -> float:
    """How far out all of what is held is before the thing that it goes into [m]."""
    into = wanted.belief.thing(wanted.entity)
    return support(into, wanted.belief.pose(into.name), out) + support(wanted.thing, thing, -out) + OUT


def _let_in(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that what is held has room there and on the way out, whatever holds it."""
    return _met(spot, wanted, hand=False)


def _room(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that the hand has, too, wherever the arm is."""
    return _met(spot, wanted, hand=True)


def _met(spot: Spot, wanted: Wanted, hand: bool) -> str | Refused:
    base, way = wanted.belief.base(), np.subtract(spot.before.position, spot.pose.position)
    for part in PARTS:
        no: Refused | None = wanted.scene.met(base * shift(spot.pose, part * way), hand)
        if no is not None:
            gone = 1000 * part * float(np.linalg.norm(way))
            return refusal(f"{gone:.0f} mm before it: {no.reason}" if part else no.reason, blocking=no.blocking, collision=no.collision)
    return ""


def _way_in(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that the arm is free there and leads the hand out of it straight and level."""
    there = collision_free_ik(wanted.scene, wanted.context, spot.pose, wanted.belief.joints)
    if isinstance(there, Refused):
        return there
    line = plan_straight_line(wanted.scene, wanted.context.robot, there, spot.before)
    return replace(line, reason=f"on its way out {line.reason}") if isinstance(line, Refused) else ""


SHUT = "free to be closed"
"""Check of what has a way in, and may be in the way of what a later task closes."""
ALONE: Mapping[str, Filter] = {"supported": supported, "near": near, "beside": beside, "in its region": in_region, "let in": _let_in}
"""Checks of the payload alone; what passes them has room itself, and the hand may not."""
FILTERS: Mapping[str, Filter] = {
    **ALONE, "collision-free": _room, SHUT: room_to_close, "reachable": reachable, "visible": visible, "led in by the arm": _way_in,
    "free to open": room_to_open,
}  # fmt: skip

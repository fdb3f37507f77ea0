"""Placements of a held thing: into a container's opening, or onto any surface of a thing.

Positions are generated best first, lazily and without end (``free_area``); filters (``place_filters``) refuse them, each with
its name and numbers, until the work budget of a query is used up.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import shapely
from msgspec.structs import replace

from cramlite.model import Belief, EntityName, Floats, Location, Place, Pose, Stage, Thing, thing_of
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..kinematics.kinematics import inverse
from ..motion_planning.reach import bound, led_by, make_scene, reference_pose, shift, tcp, uncertainty_margins
from ..motions.gripping import release_opening
from ..shapes.bounds import centre_of_mass, corners, height, support
from ..shapes.front import front
from ..shapes.nesting import nested
from ..shapes.roofs import roofed
from ..shapes.surfaces import FLAT, filled, footprint, inset, outline, standing, stated_surface, surfaces
from .attitude import check_turn, held_now, put_down
from .covers import closed_in, covers, goes_in_upright, openings
from .free_area import Offset, beside, free_area, positions
from .from_aside import is_free, slants
from .later import puts_into
from .laying_down import laid_down
from .leaning import LET_GO, close_by, leaning, must_lean
from .parameters import Where, asked
from .place_filters import (
    ASIDE,
    CHEAP,
    DEAR,
    OFF_WALLS,
    SIDES,
    Filter,
    Obstacle,
    Spot,
    Wanted,
    clear,
    first_objection,
    opened,
    released,
    standing_there,
)
from .put_aside import beside_where_it_stood
from .resting_poses import DROPS, is_uneven, lowered_onto, resting_poses, spot_at_rest
from .room_for_more import corner, roomiest
from .room_to_close import TIGHT, is_tight, room_to_close
from .room_to_leave import room_to_leave
from .through_side import brought_there_by

FEW_YAWS = (0.0, 90.0, -45.0)  # away from the middle of a surface [deg]
GOLDEN = 137.5077640500378  # of one further turn, another one everywhere: the golden angle [deg]
INSET = 0.12  # of what is nearest to a robot that drove, from the edge [m]
GAP = 0.006  # between outlines seen from above [m]: a little more than paths keep
SAME = 1e-6  # stand-offs that are one [m]
ROUNDED = 0.0002  # twice what positions are rounded by [m]
STRAIGHT = 0.99  # of the rectangle about an outline, of one that is that rectangle
PER_PLACE = 0.5  # cost of each position that comes before: more than any turn and height
YAWS = (0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0, 135.0, -135.0, 180.0)  # turns about the vertical that are tried first [deg]
ONTO = ((0.02, 0.06), (0.01, 0.015))
"""Lowest point above a surface from where a guarded motion goes on, and the stand-off above that [m]; the second where there
is little room above."""
NESTED = ((0.02, 0.06), (0.035, 0.045))
"""The same of what is let down between steep walls: 20 mm higher a bowl is 4 mm from the sides of one that holds it, and paths keep
more."""
OFF_FLOOR, RISE = 0.01, 0.03  # lowest point above a container's floor when let go, and steps up from there [m]
ABOVE = 0.06  # stand-off above a rim [m]
BETWEEN = (1.0, 0.67, 0.33)  # parts of a way down from aside that are looked at first
OUT = 1.0  # from the middle of a surface to the outside of what it is in, at most [m]
LAST: Mapping[str, Filter] = {"free to be closed": room_to_close, "free to leave": room_to_leave}  # asked after ``DEAR``
FACING = (0.0, 6.0, -6.0)
"""Turns from facing another thing [deg]: of the 15 deg that are judged, letting go may take some."""
PER_TURN, PER_HEIGHT = 0.1, 0.02  # cost of a radian of turn, and of each height above the lowest
OUTLINE, ARM = 5, 20
"""What a look at the shapes, and one at the arm, take of the samples of a query: so many states does a sampling planner check
in the same time."""


def onto(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate placements on a thing, from above."""
    swings = belief.held is not None and belief.held.swing is not None
    return laid_down(location, belief, context, _spots) if swings else _spots(location, belief, context)


def into(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate placements in a container, from above."""
    return _spots(location, belief, context)


def _spots(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Positions, best first; at each every turn, at the lowest height at which hand and thing are free.

    What shapes refuse is told when the first placement gets past them. If none does, no other grasp would help: it depends on
    the two things alone, and on where tasks have put what stands there.
    """
    targets, cheap = _targets(location, belief, context), len(CHEAP[location.relation])
    now = put_down(targets[0], location)
    check_turn(held_now(belief, context), now, targets[0])
    _check_way_in(targets, now, location)
    work, kept, tight, passed = context.samples, list[Refused](), list[Grounding](), False
    for k, answer in _answers(targets, now, location):
        shapes = isinstance(answer, Refused) and answer.passed < cheap
        work -= OUTLINE if shapes else ARM
        if shapes and not passed:
            kept.append(answer)  # type: ignore[arg-type]
        else:
            yield from kept
            passed, kept = True, []
            later = answer.cost >= TIGHT if isinstance(answer, Grounding) else False
            answer = replace(answer, cost=answer.cost + PER_PLACE * k) if isinstance(answer, Grounding) else answer
            if later and isinstance(answer, Grounding):
                tight.append(answer)
            else:
                yield answer
        if work <= 0 and passed:
            yield from tight
            said = f"{k + 1} positions were looked at, as many as the {context.samples} samples of a query allow"
            because = (location.of or "", *brought_there_by(location, belief, context))
            raise Unresolvable(said, because, blocking=tuple(n for t in targets for n in standing_there(t)))
        if work <= 0:
            break
    yield from tight if work > 0 else ()
    if not passed:
        raise _no_room(kept or list(_at_best(targets, now, location)), targets, location, context)


def _check_way_in(targets: list[Wanted], now: Pose, location: Location) -> None:
    """Check that what covers an opening leaves room to get in as it is turned, whatever holds it.

    Raises:
        Unresolvable: it does not; leaning it may, which another way of the same task tries.
    """
    if not targets[0].covers or not _free(targets[0], now, location).is_empty or goes_in_upright(targets[0], now):
        return

    over = [o.name for o in targets[0].covers]
    said = f"'{targets[0].thing.name}' does not get into '{targets[0].entity}' upright: {' and '.join(map(repr, over))} are over it"
    raise Unresolvable(said, (location.of or "", *led_by(location, targets[0].context)), blocking=tuple(over))


def _answers(targets: list[Wanted], now: Pose, location: Location) -> Iterator[tuple[int, Grounding | Refused]]:
    """Each placement with the number of its position; first of all where it comes to rest on what is not level."""
    if location.relation == "on" and is_uneven(targets[0]):
        yield from ((0, answer) for answer in _at_rest(targets[0], now))
        if targets[0].uneven:
            return
    if location.relation == "in" and (why := must_lean(targets[0], now)):
        yield from ((0, answer) for answer in _leaning(targets[0], now, why))
        return
    for k, (wanted, offset) in enumerate(_interleaved(targets, now, location)):
        few = YAWS if k < len(targets) else FEW_YAWS
        yaws = (*_turns(wanted, now, offset, few), *((GOLDEN * k % 360,) if k else ()))
        for yaw in FACING if wanted.where.facing else yaws:
            yield from ((k, answer) for answer in _turned(wanted, now, offset, yaw, location.relation))


def _turns(wanted: Wanted, now: Pose, offset: Offset, few: tuple[float, ...]) -> tuple[float, ...]:
    """Turns [deg], and between the walls of an opening those by which the sides of what is held are along them: first of all where it would
    else be near a wall."""
    area = wanted.target.area
    if not wanted.depth or area.area < STRAIGHT * shapely.box(*area.bounds).area:
        return few  # nothing is let down, or the opening is round
    there, axis = _spot(wanted, now, offset, 0.0, 0.0, 0.0).thing, wanted.target.pose.rotate((1.0, 0.0, 0.0))
    side = np.subtract(*_rectangle(wanted, there)[:2])
    apart = math.degrees(math.atan2(axis[1], axis[0]) - math.atan2(side[1], side[0]))
    along = sorted((round(math.remainder(apart + quarter, 360.0), 2) for quarter in (0.0, 90.0, 180.0, 270.0)), key=abs)
    seen = footprint(wanted.thing, wanted.target.pose.inverse() * there)
    narrow = not area.buffer(-OFF_WALLS).covers(seen) or seen.area > STRAIGHT * shapely.minimum_rotated_rectangle(seen).area
    return (*along, *few) if narrow else (*few[:1], *along, *few[1:])


def _interleaved(targets: list[Wanted], now: Pose, location: Location) -> Iterator[tuple[Wanted, Offset]]:
    """Positions on all surfaces, in turn."""
    streams = [zip(itertools.repeat(t), _positions(t, now, location)) for t in targets]
    for row in itertools.zip_longest(*streams):
        yield from (found for found in row if found is not None)


def _positions(wanted: Wanted, now: Pose, location: Location) -> Iterator[Offset]:
    """Positions on a surface; of what is not level the middle alone, where things are least likely to tip or to slide. Of what stood on
    the surface, and is put aside so that something can be shut, first those beside where it stood."""
    if wanted.under:
        return iter([(0.0, 0.0)])
    free = _free(wanted, now, location)
    first = beside_where_it_stood(wanted, free, _radius(wanted, now)) if location.relation == "on" and wanted.where == Where() else ()
    return itertools.chain(first, positions(free, _anchor(wanted, now)))


def _at_best(targets: list[Wanted], now: Pose, location: Location) -> Iterator[Refused]:
    """What objects at the best position of each surface, where there is not one free position."""
    for wanted in targets:
        bare = replace(wanted, where=Where(), obstacles=())
        offset = next(_positions(bare, now, location), (0.0, 0.0))
        spot = _spot(wanted, now, offset, 0.0, *_heights(wanted, now, location.relation)[0])
        said = f"not clear: nowhere is a disc of {2000 * _radius(wanted, now):.0f} mm free, which its outline holds"
        yield first_objection(spot, wanted, CHEAP[location.relation]) or Refused(spot.name, said, 0, blocking=standing_there(wanted))


def _no_room(kept: list[Refused], targets: list[Wanted], location: Location, context: Context) -> Unresolvable:
    """What to say where shapes refuse every placement: the first that each filter refused, and the choices that it depends on."""
    there = {name for t in targets for name in standing_there(t)}
    there |= {thing for name in (*SIDES, "near") if (thing := getattr(targets[0].where, name))}
    put = (n for n, v in context.bindings.items() if isinstance(v, Place) and v.thing in there and v.release is not None)
    about = (n for n, v in context.bindings.items() if v in (targets[0].thing.name, *there))
    first = {r.passed: f"{r.value}: {r.reason}" for r in reversed(kept)}
    said = "; ".join(first[passed] for passed in sorted(first, reverse=True))
    turned = any(r.check == "falls" for r in kept)  # another grip turns the hand another way
    grips = (n for n, v in context.bindings.items() if turned and isinstance(v, Place) and v.thing == targets[0].thing.name)
    because = (location.of or "", *put, *about, *grips, *brought_there_by(location, targets[0].belief, context))
    lacks = min((r.remedy for r in kept if r.remedy is not None), key=lambda r: r.missing, default=None)
    return Unresolvable(f"none of {len(kept)} placements fits; {said}", because, blocking=tuple(sorted(there)), remedy=lacks)


def _at_rest(wanted: Wanted, now: Pose) -> Iterator[Grounding | Refused]:
    """Placements in poses in which it stays on what is not level."""
    down, rests = lowered_onto(wanted), False
    for found in resting_poses(wanted, now):
        turn, rests = PER_TURN * math.hypot(*(now.inverse() * found).rotvec), True
        placed = _from_above(down, partial(spot_at_rest, wanted, found), "at rest", turn, attitude=True)
        yield from (replace(a, passed=a.passed + len(CHEAP["on"])) if isinstance(a, Refused) else a for a in placed)
    if not rests:
        yield Refused("anywhere", f"not at rest: it would slide or fall off '{wanted.entity}', let go of in any of {DROPS} ways", 0)


def _leaning(wanted: Wanted, now: Pose, why: str) -> Iterator[Grounding | Refused]:
    """Placements from which it comes to rest leaning, in the region that is asked for."""
    near, rests = close_by(wanted), False
    for found in leaning(wanted, now):
        turn, rests = PER_TURN * math.hypot(*(now.inverse() * found).rotvec), True
        at = partial(spot_at_rest, near, found)
        placed = _from_above(near, at, "at rest", turn, ((LET_GO, wanted.depth + ABOVE),), attitude=True)
        yield from (replace(a, passed=a.passed + len(CHEAP["in"])) if isinstance(a, Refused) else a for a in placed)
    if not rests:
        yield Refused("leaning", f"not at rest: {why}; nor would it be, leaning against a wall", 0)


def _turned(wanted: Wanted, now: Pose, offset: Offset, yaw: float, relation: str) -> Iterator[Grounding | Refused]:
    """The lowest height at which all is free, of a thing that is turned so over a position."""
    wanted = _settled(wanted, now, yaw)
    turn = PER_TURN * abs(math.radians(math.remainder(yaw, 360.0)))
    at, asked = partial(_spot, wanted, now, offset, yaw), wanted.where.attitude is not None
    return _from_above(wanted, at, relation, turn, _heights(wanted, now, relation), asked)


def _from_above(
    wanted: Wanted, at: Callable[[float, float], Spot], relation: str, cost: float, heights: Sequence[tuple[float, float]] = ONTO,
    attitude: bool = False,
) -> Iterator[Grounding | Refused]:
    """The lowest height at which all is free; from a stand-off that is blocked no other height is tried, but from aside."""
    cheap, blocked = len(CHEAP[relation]), None
    reason: Refused | None = None
    for k, (over, above) in enumerate(heights):
        spot = at(over, above)
        again = blocked is not None and blocked.distance(spot.before)[0] < SAME
        reason = reason if again else first_objection(spot, wanted, {**CHEAP[relation], **DEAR, **LAST})
        if relation == "in" and reason is not None and reason.where is Stage.BEFORE and (aside := _from_aside(spot, wanted, above)):
            spot, reason = aside, None
        if reason is None:
            release = released(wanted, over, opened(spot, wanted)[0].opening if wanted.lowered else None)
            place = Place(
                spot.pose, spot.before, approach=(0, 0, -1), thing=wanted.thing.name, release=release, reorients=attitude
            )
            cost += PER_HEIGHT * k + TIGHT * is_tight(spot, wanted)
            yield Grounding(place, f"'{wanted.entity}', {spot.name}", cost, key=spot.name, anew=True)
            return
        if not again:
            yield replace(reason, value=spot.name)
        blocked = spot.before if reason.where is Stage.BEFORE else None
        if reason.passed < cheap:
            return  # no height changes what is seen from above


def _from_aside(spot: Spot, wanted: Wanted, above: float) -> Spot | None:
    """The same placement, brought there from aside: a drawer under another one has no room above, and some before it."""
    reached = inverse(wanted.context.robot, spot.pose, seed=wanted.belief.joints)
    if not reached or wanted.scene.met(wanted.belief.base() * spot.pose) is not None:
        return None  # wherever it comes from
    for side, way in slants(above):
        aside = replace(spot, name=f"{spot.name}, from {side}", before=shift(spot.pose, way))
        free = is_free(wanted.scene, wanted.context, spot.pose, way, BETWEEN, wanted.belief.joints)
        if free and first_objection(aside, wanted, {**DEAR, **LAST}) is None:
            return aside
    return None


def _settled(wanted: Wanted, now: Pose, yaw: float) -> Wanted:
    """With the surface that carries what is held, turned so, on what is not level; as it is where there is none."""
    if wanted.under is None:
        return wanted
    there = _spot(wanted, now, (0.0, 0.0), yaw, 0.0, 0.0).thing
    found = nested(wanted.thing, there, wanted.under, wanted.belief.pose(wanted.under.name))
    return replace(wanted, target=found) if found else wanted


def _targets(location: Location, belief: Belief, context: Context) -> list[Wanted]:
    """What is put where: the opening of a container, where there is room beside what lies in it and anywhere, or every surface of
    a thing or of the part that is meant.

    Raises:
        Unresolvable: there is none, or nothing is held.
    """
    entity = bound(context, location.of)
    if belief.held is None:
        raise Unresolvable("nothing is held that could be brought there")
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    into, region = location.relation == "in", asked(location, Where).region or EntityName.parse(entity).part
    found = openings(thing, pose, region) if into else [(s, 0.0) for s in surfaces(thing, pose, region)]
    uneven = not into and not found and thing.furniture
    if uneven and (whole := stated_surface(thing, pose, region) if region else outline(thing, pose)):
        found = [(whole, 0.0)]
    if not found:
        what = "cavity to put anything in" if into else "level face that looks upwards, to put anything on"
        raise Unresolvable(f"'{entity}' has no {what}{f', called {region!r}' if region else ''}", (location.of or "",), blocking=())
    held, scene = belief.world.thing(belief.held.thing), make_scene(belief, context)
    opened = make_scene(belief, context, () if into else (entity,), release_opening(belief, context), 0.0)
    bare = [Wanted(held, entity, s, belief, context, scene, asked(location, Where), depth=d, opened=(opened,)) for s, d in found]
    if not into:
        if uneven:
            return [replace(bare[0], uneven=True)]
        _check_open(bare, region, location)
        level = [replace(w, obstacles=_obstacles(w, context)) for w in bare]
        middle = _uneven(level[0], thing, pose)
        return [middle, *(w for w in level[:1] if _fits(w, location))] if middle else level
    height = _heights(bare[0], held_now(belief, context), location.relation)[-1][0]
    bare = [replace(w, covers=covers(w, height)) for w in bare]
    if bare[0].covers and (around := closed_in(bare[0])):
        said = f"no hand comes into '{entity}': {' and '.join(map(repr, around))} are on all sides of its opening"
        raise Unresolvable(said, (location.of or "",), blocking=around)
    beside_it = [replace(w, obstacles=(*_lying_in(w), *w.covers)) for w in bare]
    return [*(w for w in beside_it if w.obstacles), *bare]  # beside what lies there and is over it, or anywhere


def _check_open(bare: list[Wanted], region: str, location: Location) -> None:
    """Check that some surface is not under a roof of its own thing, or there is a way out from under that.

    Raises:
        Unresolvable: there is none, whatever holds what is put there: a door is shut.
    """
    belief, thing = bare[0].belief, bare[0].belief.thing(bare[0].entity)
    under = list(roofed(thing, belief.pose(thing.name), region))
    doors = [t.name for t in belief.world.things if t.joint is not None and t.name in belief.poses]
    amid = [replace(w, target=replace(s, pose=s.pose * Pose((0.0, 0.0, room / 2)))) for w, (s, room) in zip(bare, under, strict=False)]
    if doors and len(under) == len(bare) and all(around := [closed_in(w, [thing.name, *doors], OUT) for w in amid]):
        names = tuple(dict.fromkeys(name for one in around for name in one))
        said = f"no hand comes into '{location.of}': {' and '.join(map(repr, names))} are on all sides of it"
        raise Unresolvable(said, (location.of or "",), blocking=names)


def _uneven(first: Wanted, thing: Thing, pose: Pose) -> Wanted | None:
    """The middle of what can be moved itself and whose own shape, such as a plate's rim, stands about its largest surface; else None."""
    if thing.furniture or first.where.region or not any(o.name == thing.name for o in first.obstacles):
        return None
    others = tuple(o for o in first.obstacles if o.name != thing.name)
    hollow = thing.feature("cram:Cavity")
    x, y, _ = (pose * hollow.pose if hollow else first.target.pose).position
    middle = replace(first.target, pose=Pose((x, y, first.target.pose.position[2])))
    return replace(lowered_onto(first), target=middle, obstacles=others, under=thing)


def _fits(wanted: Wanted, location: Location) -> bool:
    """Whether there is room beside what stands on a surface, and within what stands about it, in its middle at some turn."""
    now = put_down(wanted, location)
    own = replace(wanted, obstacles=tuple(o for o in wanted.obstacles if o.name == thing_of(wanted.entity)))
    within = any(not clear(_spot(own, now, (0.0, 0.0), yaw, *ONTO[0]), own) for yaw in YAWS)
    return within and not _free(wanted, now, location).is_empty


def _obstacles(wanted: Wanted, context: Context) -> tuple[Obstacle, ...]:
    """Outlines of what stands on a surface, or hangs down over it, as high as the held thing is; with the gap around."""
    belief, to, margins = wanted.belief, wanted.target.pose.inverse(), uncertainty_margins(wanted.belief)
    high, reach = height(wanted.thing, held_now(belief, context)), wanted.target.area
    found = []
    for name in belief.poses:
        outline = footprint(belief.world.thing(name), to * belief.pose(name), 2 * FLAT, high)
        if not outline.is_empty and outline.distance(reach) < 2 * GAP + high:
            top = float(corners(belief.world.thing(name), to * belief.pose(name))[:, 2].max()) + GAP
            found.append(Obstacle(name, outline.buffer(GAP + margins.get(name, 0.0)), top))
    return tuple(found)


def _lying_in(wanted: Wanted, sure: bool = False) -> tuple[Obstacle, ...]:
    """Outlines of what lies in a cavity, with the gap around, each as much wider as it is not known where it came to rest; or as if that
    were sure."""
    belief, to, margins = wanted.belief, wanted.target.pose.inverse(), {} if sure else uncertainty_margins(wanted.belief)
    found = []
    for name in belief.poses:
        outline = footprint(belief.world.thing(name), to * belief.pose(name), -wanted.depth, 0.0)
        if not outline.is_empty and wanted.target.area.covers(outline):
            found.append(Obstacle(name, outline.buffer(GAP + margins.get(name, 0.0))))
    return tuple(found)


def _free(wanted: Wanted, now: Pose, location: Location) -> Any:
    """Where the centre of mass may be: on what supports it, apart from what stands there, and where ``where`` wants it."""
    radius, area = _radius(wanted, now), wanted.target.area
    _, least = inset(standing(wanted.thing, now), area)
    core = area.buffer(-radius) if location.relation == "in" else area.convex_hull.buffer(-least - ROUNDED)
    free = free_area(core, [o.area.buffer(_radius(wanted, now, o.top)) for o in wanted.obstacles], 0.0)
    to = wanted.target.pose.inverse()
    for side, (axis, sign) in SIDES.items():
        if other := getattr(wanted.where, side):
            way = sign * wanted.target.pose.rotation[axis, :2]
            aside = sign * (wanted.belief.pose(other).position[axis] - wanted.target.pose.position[axis]) + ASIDE
            free = beside(free, (float(way[0]), float(way[1])), aside)
    if other := wanted.where.near:

        middle = shapely.Point(*to.apply(wanted.belief.pose(other).position)[:2])
        free = free.intersection(middle.buffer(wanted.where.within))
    return free


def _radius(wanted: Wanted, now: Pose, top: float = math.inf) -> float:
    """Radius of the largest disc about the middle of the outline of the held thing [m], up to a height over what it stands on;
    0 where that is beside it."""
    low = -support(wanted.thing, now, (0.0, 0.0, -1.0))
    outline, middle = filled(footprint(wanted.thing, now, high=low + top)), shapely.Point(*_middle(wanted, now))
    return float(outline.boundary.distance(middle)) if outline.covers(middle) else 0.0


def _anchor(wanted: Wanted, now: Pose) -> Offset:
    """The best position of all, whether it is free or not: the middle; near a thing that is asked for; for a robot that drove
    there what is nearest to it, as a table's middle may be out of reach from all sides; in a container where the rest finds room."""
    to = wanted.target.pose.inverse()
    at = np.zeros(2)
    if wanted.depth and not wanted.where.near:
        return _with_room(wanted, now)
    if other := wanted.where.near:
        at = to.apply(wanted.belief.pose(other).position)[:2]
    elif wanted.belief.at is not None:
        low, high = np.reshape(wanted.target.area.bounds, (2, 2))
        at = np.clip(to.apply((0.0, 0.0, 0.0))[:2], np.minimum(low + INSET, 0.0), np.maximum(high - INSET, 0.0))
    return float(at[0]), float(at[1])


def _with_room(wanted: Wanted, now: Pose) -> Offset:
    """In a corner where more is to come, else amid the room that what lies there leaves; where nothing does, in the middle."""
    lying = [o.area for o in _lying_in(wanted, sure=True)]
    left = free_area(wanted.target.area, lying, 0.0)
    if left.is_empty:
        return 0.0, 0.0
    if puts_into(wanted.entity, wanted.belief, wanted.context):
        x, y, _ = wanted.target.pose.inverse().apply((0.0, 0.0, 0.0)).tolist()
        a, b, c, _ = _rectangle(wanted, now)
        return corner(wanted.target.area.buffer(-OFF_WALLS), left, (math.dist(a, b), math.dist(b, c)), (x, y))
    return roomiest(left) if lying else (0.0, 0.0)


def _rectangle(wanted: Wanted, now: Pose) -> Floats:
    """Corners (4, 2) of the smallest rectangle around the outline of what is held at a pose, from above [m]."""
    corners: Floats = shapely.get_coordinates(shapely.minimum_rotated_rectangle(footprint(wanted.thing, now)))[:4]
    return corners


def _middle(wanted: Wanted, now: Pose) -> Floats:
    """What of a thing is brought over a position (2,) [m]: its centre of mass, which has to be supported; between walls of a container the
    middle of its outline, which has to get past them."""
    if wanted.depth:
        found: Floats = _rectangle(wanted, now).mean(axis=0)
        return found
    return np.asarray(now.apply(centre_of_mass(wanted.thing)))[:2]


def _heights(wanted: Wanted, now: Pose, relation: str) -> list[tuple[float, float]]:
    """Heights of its lowest point above the target at which it is let go, and stand-offs above these [m].

    Over a container from its floor up to where the whole hand is over the rim, however it holds the thing.
    """
    if relation == "on":
        return list(NESTED if wanted.under else ONTO)
    assert wanted.belief.held is not None
    gripper, hand = wanted.context.robot.gripper, now * wanted.belief.held.tcp_to_thing.inverse()
    ball = math.hypot(*gripper.tcp.position) + gripper.pad[1]  # about the TCP, that holds the hand
    low, high = -wanted.depth + OFF_FLOOR, ball - (hand.position[2] + support(wanted.thing, now, (0.0, 0.0, -1.0)))
    return [(float(h), max(ABOVE - float(h), ABOVE)) for h in np.arange(low, max(high, 0.0) + RISE, RISE)]


def _spot(wanted: Wanted, now: Pose, offset: Offset, yaw: float, height: float, above: float) -> Spot:
    """Its middle over a position of the target, leaning as it is held or as it is asked for, turned by ``yaw`` [deg]: from facing the robot
    as it does now, or from facing what it shall face."""
    assert wanted.belief.held is not None
    hand, target = tcp(wanted.belief, wanted.context), wanted.target.pose.apply((*offset, 0.0))
    facing = math.atan2(target[1], target[0]) - math.atan2(hand.position[1], hand.position[0])
    if other := wanted.where.facing:
        ahead, to = now.rotate(front(wanted.thing.features)), wanted.belief.pose(other).position - target
        facing = math.atan2(to[1], to[0]) - math.atan2(ahead[1], ahead[0])
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, facing + math.radians(yaw)))
    turned = Pose((0, 0, 0), (turn * Pose((0, 0, 0), now.quaternion)).quaternion)
    x, y = target[:2] - _middle(wanted, turned)
    thing = Pose((float(x), float(y), float(target[2]) + height + support(wanted.thing, turned, (0, 0, -1))), turned.quaternion)
    pose = thing * wanted.belief.held.tcp_to_thing.inverse()
    name = f"turned {math.remainder(yaw, 360.0):+.0f} deg, lowest point {1000 * height:+.0f} mm from it"
    if any(offset):
        name = f"{_says(offset)}, {name}"
    return Spot(name, thing, pose, shift(pose, (0, 0, above)), height)


def _says(offset: Offset) -> str:
    return f"({1000 * offset[0]:+.0f} {1000 * offset[1]:+.0f}) mm from its middle"

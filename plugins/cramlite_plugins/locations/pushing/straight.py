"""Straight pushes of loose things: fingers set against a side of the thing, and paths to a region or out
of the way of later tasks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from cramlite.model import (
    Belief,
    CarriedAlong,
    Feature,
    Floats,
    Held,
    Location,
    Place,
    Pose,
    Thing,
    thing_of,
    vector3,
)
from cramlite.plugin import Answer, Context, Grounding, Refused, Unresolvable

from ...motion_planning.cartesian import plan_straight_line
from ...motion_planning.reach import bound, causes, collision_free_ik, make_scene, reference_pose, shift, tcp
from ...shapes.bounds import support
from ...shapes.carried_along import carried_along
from ..parameters import Along, PushedThing, asked
from ..reached import Arm, Candidate, Leg, reached
from .around import (
    CLEAR,
    LIFT,
    STEP,
    Left,
    Point,
    met_alone,
    met_with_hand,
    on_a_shorter_way,
    way_around,
    way_straight,
    ways_around,
)
from .contacts import ALMOST, UP, Hand, free_ahead, hands_behind, hands_in, sides, towards

BEHIND = 0.05  # from a face to the fingers at the stand-off [m]
ABOVE = 0.06  # over the place behind a thing at the stand-off [m]
# Finger tips above what carries the thing; the palm above the thing [m]
OVER_SUPPORT, UNDER_PALM = 0.015, 0.010
INNER = 0.6
"""Share of a region's half side lengths within which ways around obstacles end."""
FARTHER = (1.0, 0.7, 1.5)
"""Factors on the distance by which a thing is pushed aside: a longer push for a thing that is still in the
way, a shorter one where there is less room."""
DIRECTIONS = 16
"""Number of directions in which a thing is pushed aside."""
SHORT = 1e-6  # [m]: no way at all
SPOT = Feature("spot", "vrps:SurfaceFeature", size={"radius": 0.0})  # a region that is a point


def beside(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate one place beside each of the four upright faces of a thing; first that from which it is pushed
    straight away from the robot."""
    entity = bound(context, location.of)
    thing, gripper = belief.thing(entity), context.robot.gripper
    if not thing.movable:
        raise Unresolvable(f"'{entity}' is fixed and cannot be pushed", (location.of or "",))
    pose, shut = reference_pose(belief, location, context), gripper.opening[0]
    low, top = -support(thing, pose, -UP), support(thing, pose, UP)
    height = max(low + OVER_SUPPORT + gripper.pad[1] / 2, top + UNDER_PALM - gripper.depth)

    def towards_the_side(way: Floats) -> Candidate:
        face = support(thing, pose, -way)  # along -way, from the base's origin
        centre = np.asarray(pose.position)
        point = centre - way * (face + float(centre @ way) + gripper.pad[0] / 2 + ALMOST)
        at = Pose.from_axes((float(point[0]), float(point[1]), height), (0, 0, -1), way)
        before, name = shift(at, -BEHIND * way), f"towards ({way[0]:+.2f} {way[1]:+.2f})"
        place = Place(at, before, shut, (float(way[0]), float(way[1]), 0.0), thing=thing.name)
        legs = Leg(before, (), shut), Leg(at, (thing.name,), shut)
        return Candidate(name, place, legs, f"'{entity}' {name}")

    yield from reached(map(towards_the_side, _ways(pose)), Arm(belief, context))


def _ways(pose: Pose) -> list[Floats]:
    """Level directions along a thing's own x and y axes, both signs, those that lead away from the robot
    first."""
    out = np.array([*pose.position[:2], 0.0])
    x = pose.rotate((1.0, 0.0, 0.0))
    angle = math.atan2(float(x[1]), float(x[0]))
    turns = [angle + k * math.pi / 2 for k in range(4)]
    ways = [np.array([math.cos(a), math.sin(a), 0.0]) for a in turns]
    return sorted(ways, key=lambda w: -round(float(w @ out), 6))


def beyond(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate the place at which a push ends: a given distance ahead of the hand, in the direction in
    which the push began."""
    entity, distance = bound(context, location.of), asked(location, Along).distance_m
    start: Place = context.bindings[f"push({location.of})"]
    end = shift(tcp(belief, context), np.asarray(start.approach) * distance)
    there = collision_free_ik(make_scene(belief, context, [entity]), context, end, belief.joints)
    if isinstance(there, Refused):
        raise there.impossible(f"after {1000 * distance:.0f} mm: {there.reason}", causes(location, context))
    yield Grounding(Place(end, end, thing=entity), f"{1000 * distance:.0f} mm on", key="on")


def behind(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate hand poses on the side of a thing opposite to its goal region; those that push to the region's
    middle come first.

    With "inside" they are in the thing, low, and take it along at the inner side of its rim. With "aside_m"
    in the place of a region it shall go about as far as that, in any direction.
    """
    entity, wanted = bound(context, location.of), asked(location, PushedThing)
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    if not thing.movable:
        raise Unresolvable(f"'{entity}' is fixed and cannot be pushed", (location.of or "",))
    hands = (_to_region if wanted.aside_m is None else _aside)(thing, pose, wanted, belief, context)

    def over(hand: Hand | Refused) -> Candidate | Refused:
        if isinstance(hand, Refused):
            return hand
        way, at, opening, turn = hand
        name = f"by ({1000 * way[0]:+.0f} {1000 * way[1]:+.0f}) mm, hand {turn}"
        before, (x, y, _) = shift(at, ABOVE * UP), vector3(way + pose.position)
        along = CarriedAlong(to_m=(x, y))
        place = Place(at, before, opening, (0.0, 0.0, -1.0), thing=thing.name, carried=along)
        legs = Leg(before, (), opening), Leg(at, (entity,) if wanted.inside else (), opening)
        return Candidate(name, place, legs, f"'{entity}' {name}", anew=True)

    yield from reached(map(over, hands), Arm(belief, context))


def _to_region(
    thing: Thing, pose: Pose, wanted: PushedThing, belief: Belief, context: Context
) -> Iterator[Hand | Refused]:
    """Yield hand poses that push a thing to its region.

    With fingers inside the thing, a refusal if the thing itself meets obstacles on the last line of its way.
    """
    area, frame = _region(thing, pose, wanted.region, belief)
    if not wanted.inside:
        yield from hands_behind(thing, pose, wanted.apart, context.robot.gripper, area, frame)
        return
    last = _last(wanted, belief, context, thing.name, area, frame)
    if isinstance(last, Refused):
        yield last.of("by any hand", passed=1)  # says more than where each hand is stopped
        return
    yield from hands_in(thing, pose, context.robot.gripper, towards(pose, area, frame, 0.0), last)


def _aside(
    thing: Thing, pose: Pose, wanted: PushedThing, belief: Belief, context: Context
) -> Iterator[Hand | Refused]:
    """Yield hand poses that push a thing out of the way: one for each free direction, then further ones for
    each.

    Directions away from things of later tasks come first, those towards them last.
    """
    (x, y, z), gripper, met = pose.position, context.robot.gripper, met_alone(belief, context, thing.name)
    found = list[Iterator[Hand]]()
    for farther, (cos, sin) in itertools.product(FARTHER, _directions(pose, belief, context)):
        far = farther * (wanted.aside_m or 0.0)
        way = np.array([far * cos, far * sin, 0.0])
        to = x + far * cos, y + far * sin
        if isinstance(no := way_straight((x, y), to, met), Refused):
            yield no.of(f"by ({1000 * way[0]:+.0f} {1000 * way[1]:+.0f}) mm")
        elif wanted.inside:
            found.append(hands_in(thing, pose, gripper, way, way))
        else:
            found.append(hands_behind(thing, pose, wanted.apart, gripper, SPOT, Pose((*to, z)), (0.0,)))
    yield from (hand for row in itertools.zip_longest(*found) for hand in row if hand is not None)


def _directions(pose: Pose, belief: Belief, context: Context) -> list[Point]:
    """Return horizontal unit vectors in all directions; those that lead away from the things of later tasks
    come first."""
    named = (entity for task in context.later for entity in task.entities.values())
    about = [belief.pose(n).position[:2] for n in dict.fromkeys(map(thing_of, named)) if n in belief.poses]
    off = np.asarray(pose.position[:2]) - np.mean(about, axis=0) if about else np.array([1.0, 0.0])
    angles = np.linspace(0.0, math.tau, DIRECTIONS, endpoint=False).tolist()
    ways = [(math.cos(angle), math.sin(angle)) for angle in angles]
    return sorted(ways, key=lambda way: -round(float(np.dot(way, off)), 6))


def pushed_to(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate paths on which a thing is pushed to its region: straight, or with "around" past obstacles by
    way of corners."""
    entity, wanted = bound(context, location.of), asked(location, PushedThing)
    begun: Place = context.bindings[wanted.begin]
    if wanted.around:
        yield from _around(wanted, belief, context, entity)
        return
    assert begun.carried is not None and begun.carried.to_m is not None
    to = begun.carried.to_m
    gap = gap_before(belief, context, entity, to, begun.opening or 0.0)
    there = pushed_straight(belief, context, entity, [to], gap)
    if isinstance(there, Refused):
        yield _stopped(there, wanted, entity)
    else:
        far = there.carried.pushed_m if there.carried else 0.0
        yield Grounding(there, f"push it {1000 * far:.0f} mm straight on", key="on")


def _stopped(no: Refused, wanted: PushedThing, entity: str, way: str = "on") -> Refused:
    """Refuse a push that obstacles block; the cause is where they and the hand are, not the arm's joint
    positions."""
    return replace(no.of(way), reason=f"'{entity}' cannot be pushed on: {no.reason}", because=(wanted.begin,))


def _around(wanted: PushedThing, belief: Belief, context: Context, entity: str) -> Iterator[Answer]:
    """Yield paths of a pushed thing around obstacles that the arm can follow; if it can follow none, a
    refusal.

    The refusal blames obstacles of a shorter way, too.
    """
    pose, thing = belief.pose(entity), belief.thing(entity)
    left = _left(*_region(thing, pose, wanted.region, belief))
    hand, (x, y, _) = met_with_hand(belief, context, entity, tcp(belief, context)), pose.position
    alone, followed = met_alone(belief, context, entity), False
    ways = ways_around((x, y), left, alone, hand)
    if isinstance(ways, Refused):
        yield _stopped(ways, wanted, entity)
        return
    for k, (steps, corners) in enumerate(ways):
        there, key = pushed_straight(belief, context, entity, corners), f"{1000 * steps * STEP:.0f} mm aside"
        if isinstance(there, Refused):
            yield _stopped(there, wanted, entity, key)
        else:
            followed, said = True, f"a way with {len(corners) - 1} corners, free up to {key}"
            yield Grounding(there, said, 0.1 * k, key=key)
    if not followed and (shorter := on_a_shorter_way((x, y), left, alone, hand)):
        yield _stopped(shorter, wanted, entity)


def _last(
    wanted: PushedThing, belief: Belief, context: Context, entity: str, area: Feature, frame: Pose
) -> Floats | Refused:
    """Return the direction and length (3,) [m] of the last straight stretch on which a thing is pushed to its
    region; a refusal if obstacles stop the thing.

    It is for fingers inside the thing; after a refusal no hand pose need be searched.

    Raises:
        Unresolvable: it is there already.
    """
    pose, met = belief.pose(entity), met_alone(belief, context, entity)
    (x, y, _), way = pose.position, towards(pose, area, frame, 0.0)
    if float(np.linalg.norm(way)) < SHORT:
        raise Unresolvable(f"'{entity}' is in the middle of its region already", (), blocking=())
    found = (
        way_around((x, y), _left(area, frame), met)
        if wanted.around
        else way_straight((x, y), (x + way[0], y + way[1]), met)
    )
    if isinstance(found, Refused):
        return replace(found, reason=f"'{entity}' cannot be pushed there, whatever holds it: {found.reason}")
    (a, b), (c, d) = ((x, y), *found)[-2:]
    return np.array([c - a, d - b, 0.0])


def _left(area: Feature, frame: Pose) -> Left:
    """Distance of points of the base's x-y plane from the middle part of an area [m]."""
    half, back = INNER * np.array(sides(area)) / 2, frame.inverse()
    height = frame.position[2]
    return lambda spot: float(np.linalg.norm(np.maximum(np.abs(back.apply((*spot, height))[:2]) - half, 0.0)))


def pushed_straight(
    belief: Belief, context: Context, entity: str, corners: Sequence[Point], gap: float = 0.0
) -> Place | Refused:
    """Return straight legs on which the fingers push a thing until its origin is at points of the base's x-y
    plane, one after the other.

    Args:
        gap: how far they go straight ahead first until they meet the thing [m].
    """
    here, pose = tcp(belief, context), belief.pose(entity)
    ways = [np.array([x - pose.position[0], y - pose.position[1], 0.0]) for x, y in corners]
    ahead = ways[0] / max(float(np.linalg.norm(ways[0])), SHORT)
    before = here.inverse() * shift(pose, LIFT - gap * ahead)
    held = Held(entity, before, 0.0, carries=carried_along(belief, entity))
    scene = make_scene(belief.grasped(held), context, [entity], clearance=CLEAR)
    path = tuple(shift(here, way + gap * ahead) for way in ways)
    found = plan_straight_line(scene, context.robot, belief.joints, path)
    if isinstance(found, Refused):
        return found
    length = float(np.linalg.norm(ways[-1]))
    way, along = vector3(ways[-1] / max(length, SHORT)), CarriedAlong(length)
    return Place(path[-1], path[-1], approach=way, path=path, thing=entity, carried=along)


def _region(thing: Thing, pose: Pose, name: str, belief: Belief) -> tuple[Feature, Pose]:
    """Surface feature of a given name that is nearest in height to a thing's support, and its pose in the
    base frame.

    Raises:
        Unresolvable: nothing has such an area.
    """
    low = -support(thing, pose, -UP)
    areas = [
        (f, belief.pose(t.name) * f.pose)
        for t in belief.world.things
        for f in t.features
        if f.name == name and t.name in belief.poses and f.type == "vrps:SurfaceFeature"
    ]
    if not areas:
        reason = f"nothing has an area called '{name}' that '{thing.name}' could be pushed to"
        raise Unresolvable(reason, (), blocking=())
    return min(areas, key=lambda one: abs(one[1].position[2] - low))


def gap_before(belief: Belief, context: Context, entity: str, to: Point, opening: float) -> float:
    """Return the gap between the fingers and a thing [m], along the line from the thing to where it is to
    be pushed."""
    pose = belief.pose(entity)
    way = np.array([to[0] - pose.position[0], to[1] - pose.position[1], 0.0])
    ahead = way / max(float(np.linalg.norm(way)), SHORT)
    return free_ahead(belief.thing(entity), pose, tcp(belief, context), ahead, opening, context.robot.gripper)

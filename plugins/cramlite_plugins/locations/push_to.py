"""Pushing to a region, or out of the way: fingers low behind a flat thing, seen from there, or in it behind its rim, and the way that
brings it there."""

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
    Gripper,
    Held,
    Location,
    Place,
    Pose,
    Thing,
    thing_of,
)
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..motion_planning.cartesian import plan_straight_line
from ..motion_planning.reach import bound, collision_free_ik, make_scene, reference_pose, shift, tcp
from ..shapes.bounds import support
from ..shapes.carried_along import carried_along
from ..shapes.ray_casting import body, intervals
from .antipodal import FINGER
from .parameters import PushedThing, asked
from .push_way import (
    CLEAR,
    LIFT,
    STEP,
    Left,
    Spot,
    met_alone,
    met_with_hand,
    on_a_shorter_way,
    way_around,
    way_straight,
    ways_around,
)

ABOVE, GAP = 0.06, 0.01  # over the place behind a thing at the stand-off, and from there to the thing [m]
LOW = 1 / 3  # finger tips over what carries a thing, as a share of its height: under a plate's rim, that they meet
SHARES = (0.0, 0.35, 0.6)
"""Of a region's half sides, towards the thing, from its middle: ends of the way; the rest is left for how far it slips."""
TURNS = (0.0, 180.0)
"""Of the hand about the vertical [deg]: its fingers open across the way."""
EIGHTHS = (0.0, 180.0, 90.0, 270.0, 45.0, 225.0, 135.0, 315.0)
"""The same of closed fingers in a thing."""
SPOTS = ((0.0, 0.0), (0.02, 0.0), (0.0, 0.02), (0.0, -0.02), (-0.02, 0.0))
"""For these, from its middle, ahead and to the left [m]: where the hand is beside what stands beside the thing."""
INNER = 0.6
"""Of a region's half sides, from its middle: where ways around something end."""
FARTHER = (1.0, 0.7, 1.5)
"""Times as far as asked that something is pushed aside: it may be in the way by more, and there may be less room."""
DIRECTIONS = 16
"""In which it is pushed aside."""
OVER, DEEP, PLAY = 0.0005, 0.006, 0.001  # finger tips in a thing, over its floor; the least that its rim stands up; before it [m]
SHORT = 1e-6  # [m]: no way at all
SPOT = Feature("spot", "vrps:SurfaceFeature", size={"radius": 0.0})  # a region that is a point
UP = np.array([0.0, 0.0, 1.0])
Hand = tuple[Floats, Pose, float, str]
"""The level way (3,) of a thing, the TCP from where it begins, how far the fingers are open [m], and how the hand is held."""


def behind(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate fingers on the side of a thing that is opposite to the region that it shall go to; to the region's middle first.

    With "inside" they are in the thing, low, and take it along at the inner side of its rim. With "aside_m" in the place of a region it
    shall go about as far as that, in any direction.
    """
    entity, inside = bound(context, location.of), asked(location, PushedThing).inside
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    if not thing.movable:
        raise Unresolvable(f"'{entity}' is fixed and cannot be pushed", (location.of or "",))
    aside = asked(location, PushedThing).aside_m is not None
    hands = (_aside if aside else _to_region)(thing, pose, location, belief, context)
    for k, hand in enumerate(hands):
        if isinstance(hand, Refused):
            yield hand
            continue
        way, at, opening, turn = hand
        name = f"by ({1000 * way[0]:+.0f} {1000 * way[1]:+.0f}) mm, hand {turn}"
        free = make_scene(belief, context, (), opening)
        near, before = make_scene(belief, context, [entity], opening) if inside else free, shift(at, ABOVE * UP)
        off = collision_free_ik(free, context, before, belief.joints)
        there = off if isinstance(off, Refused) else collision_free_ik(near, context, at, off)
        if isinstance(there, Refused):
            yield there.of(name)
        else:
            x, y, _ = (float(v) for v in way + pose.position)
            place = Place(at, before, opening, (0.0, 0.0, -1.0), thing=thing.name, carried=CarriedAlong(to_m=(x, y)))
            yield Grounding(place, f"'{entity}' {name}", 0.1 * k, key=name, anew=True)


def _to_region(thing: Thing, pose: Pose, location: Location, belief: Belief, context: Context) -> Iterator[Hand | Refused]:
    """Hands that bring a thing to its region; with fingers in it what is in its way, whatever hand that is."""
    area, frame = _region(thing, pose, asked(location, PushedThing).region, belief)
    if not asked(location, PushedThing).inside:
        yield from hands_behind(thing, pose, _apart(location), context.robot.gripper, area, frame)
        return
    last = _last(location, belief, context, thing.name, area, frame)
    if isinstance(last, Refused):
        yield last.of("by any hand", passed=1)  # says more than where each hand is stopped
        return
    yield from _hands_in(thing, pose, context.robot.gripper, _towards(pose, area, frame, 0.0), last)


def _aside(thing: Thing, pose: Pose, location: Location, belief: Belief, context: Context) -> Iterator[Hand | Refused]:
    """Hands that push a thing out of the way, one for each way on which it meets nothing, then another one for each: first away from what
    later tasks are about, last towards that."""
    (x, y, z), gripper, met = pose.position, context.robot.gripper, met_alone(belief, context, thing.name)
    found = list[Iterator[Hand]]()
    for farther, (cos, sin) in itertools.product(FARTHER, _directions(pose, belief, context)):
        far = farther * (asked(location, PushedThing).aside_m or 0.0)
        way = np.array([far * cos, far * sin, 0.0])
        to = x + far * cos, y + far * sin
        if isinstance(no := way_straight((x, y), to, met), Refused):
            yield no.of(f"by ({1000 * way[0]:+.0f} {1000 * way[1]:+.0f}) mm")
        elif asked(location, PushedThing).inside:
            found.append(_hands_in(thing, pose, gripper, way, way))
        else:
            found.append(hands_behind(thing, pose, _apart(location), gripper, SPOT, Pose((*to, z)), (0.0,)))
    yield from (hand for row in itertools.zip_longest(*found) for hand in row if hand is not None)


def _directions(pose: Pose, belief: Belief, context: Context) -> list[Spot]:
    """Level unit vectors all around, those first that lead away from what later tasks are about."""
    named = (entity for task in context.later for entity in task.entities.values())
    about = [belief.pose(n).position[:2] for n in dict.fromkeys(map(thing_of, named)) if n in belief.poses]
    off = np.asarray(pose.position[:2]) - np.mean(about, axis=0) if about else np.array([1.0, 0.0])
    ways = [(math.cos(angle), math.sin(angle)) for angle in np.linspace(0.0, math.tau, DIRECTIONS, endpoint=False).tolist()]
    return sorted(ways, key=lambda way: -round(float(np.dot(way, off)), 6))


def pushed_to(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate ways of a thing to its region: straight, where nothing is in its way, or with "around" by corners around what is."""
    entity = bound(context, location.of)
    begun: Place = context.bindings[asked(location, PushedThing).begin]
    if asked(location, PushedThing).around:
        yield from _around(location, belief, context, entity)
        return
    assert begun.carried is not None and begun.carried.to_m is not None
    to = begun.carried.to_m
    there = pushed_straight(belief, context, entity, [to], gap_before(belief, context, entity, to, begun.opening or 0.0))
    if isinstance(there, Refused):
        yield _stopped(there, location, entity)
    else:
        yield Grounding(there, f"{1000 * there.carried.pushed_m if there.carried else 0.0:.0f} mm straight on", key="on")


def _stopped(no: Refused, location: Location, entity: str, way: str = "on") -> Refused:
    """What is in the way depends on where that is and on the hand, but not on how the arm did what it did before."""
    return replace(no.of(way), reason=f"'{entity}' cannot be pushed on: {no.reason}", because=(asked(location, PushedThing).begin,))


def _around(location: Location, belief: Belief, context: Context, entity: str) -> Iterator[Grounding | Refused]:
    """Ways around what is in the way that the arm can follow; where it can follow none, what is on a shorter way is to blame, too."""
    pose, thing = belief.pose(entity), belief.thing(entity)
    left = _left(*_region(thing, pose, asked(location, PushedThing).region, belief))
    hand, (x, y, _) = met_with_hand(belief, context, entity, tcp(belief, context)), pose.position
    alone, followed = met_alone(belief, context, entity), False
    ways = ways_around((x, y), left, alone, hand)
    if isinstance(ways, Refused):
        yield _stopped(ways, location, entity)
        return
    for k, (steps, corners) in enumerate(ways):
        there, key = pushed_straight(belief, context, entity, corners), f"{1000 * steps * STEP:.0f} mm aside"
        if isinstance(there, Refused):
            yield _stopped(there, location, entity, key)
        else:
            followed = True
            yield Grounding(there, f"{len(corners) - 1} corners, room for {key}", 0.1 * k, key=key)
    if not followed and (shorter := on_a_shorter_way((x, y), left, alone, hand)):
        yield _stopped(shorter, location, entity)


def _last(location: Location, belief: Belief, context: Context, entity: str, area: Feature, frame: Pose) -> Floats | Refused:
    """The last leg (3,) of the way of a thing that fingers in it take along; or what is in the way of the thing alone, so that looking for
    hands is of no use.

    Raises:
        Unresolvable: it is there already.
    """
    pose, met = belief.pose(entity), met_alone(belief, context, entity)
    (x, y, _), way = pose.position, _towards(pose, area, frame, 0.0)
    if float(np.linalg.norm(way)) < SHORT:
        raise Unresolvable(f"'{entity}' is in the middle of its region already", (), blocking=())
    around = asked(location, PushedThing).around
    found = way_around((x, y), _left(area, frame), met) if around else way_straight((x, y), (x + way[0], y + way[1]), met)
    if isinstance(found, Refused):
        return replace(found, reason=f"'{entity}' cannot be pushed there, whatever holds it: {found.reason}")
    (a, b), (c, d) = ((x, y), *found)[-2:]
    return np.array([c - a, d - b, 0.0])


def _left(area: Feature, frame: Pose) -> Left:
    """How far points of the base's x-y plane are from the middle part of an area [m]."""
    half, back = INNER * np.array(_sides(area)) / 2, frame.inverse()
    height = frame.position[2]
    return lambda spot: float(np.linalg.norm(np.maximum(np.abs(back.apply((*spot, height))[:2]) - half, 0.0)))


def pushed_straight(belief: Belief, context: Context, entity: str, corners: Sequence[Spot], gap: float = 0.0) -> Place | Refused:
    """Return straight legs on which fingers bring a thing's origin to points of the base's x-y plane, one after the other.

    Args:
        gap: how far they go straight ahead first until they meet the thing [m].
    """
    here, pose = tcp(belief, context), belief.pose(entity)
    ways = [np.array([x - pose.position[0], y - pose.position[1], 0.0]) for x, y in corners]
    ahead = ways[0] / max(float(np.linalg.norm(ways[0])), SHORT)
    held = Held(entity, here.inverse() * shift(pose, LIFT - gap * ahead), 0.0, carries=carried_along(belief, entity))
    scene = make_scene(belief.grasped(held), context, [entity], clearance=CLEAR)
    path = tuple(shift(here, way + gap * ahead) for way in ways)
    found = plan_straight_line(scene, context.robot, belief.joints, path)
    if isinstance(found, Refused):
        return found
    length = float(np.linalg.norm(ways[-1]))
    x, y, _ = (float(v) for v in ways[-1] / max(length, SHORT))
    return Place(path[-1], path[-1], approach=(x, y, 0.0), path=path, thing=entity, carried=CarriedAlong(length))


def _region(thing: Thing, pose: Pose, name: str, belief: Belief) -> tuple[Feature, Pose]:
    """The area of that name that is nearest in height to what a thing lies on, and its pose in the base frame.

    Raises:
        Unresolvable: nothing has such an area.
    """
    low = -support(thing, pose, -UP)
    named = [(t, f) for t in belief.world.things for f in t.features if f.name == name and t.name in belief.poses]
    areas = [(f, belief.pose(t.name) * f.pose) for t, f in named if f.type == "vrps:SurfaceFeature"]
    if not areas:
        raise Unresolvable(f"nothing has an area called '{name}' that '{thing.name}' could be pushed to", (), blocking=())
    return min(areas, key=lambda one: abs(one[1].position[2] - low))


def _sides(area: Feature) -> list[float]:
    """Of an area, or of the square in a round one [m]."""
    return [area.size["radius"] * math.sqrt(2)] * 2 if "radius" in area.size else [area.size["width"], area.size["depth"]]


def _towards(pose: Pose, area: Feature, frame: Pose, share: float) -> Floats:
    """The level way (3,) [m] of a thing's origin into an area: to its middle, or to a share of its half sides nearer."""
    half, local = share * np.array(_sides(area)) / 2, frame.inverse().apply(pose.position)
    target = frame.apply((*np.clip(local[:2], -half, half), 0.0))
    return np.array([*(target - np.asarray(pose.position))[:2], 0.0])


def hands_behind(
    thing: Thing, pose: Pose, apart: float, gripper: Gripper, area: Feature, frame: Pose, shares: Sequence[float] = SHARES
) -> Iterator[Hand]:
    """Generate hands whose fingers are behind a thing, as far open as a share of the thing's width."""
    low, top = -support(thing, pose, -UP), support(thing, pose, UP)
    for share, turn in itertools.product(shares, TURNS):
        way = _towards(pose, area, frame, share)
        ahead, across, hand = _axes(way, turn)
        back, left, right = (support(thing, pose, v) for v in (-ahead, across, -across))
        opening = min(gripper.opening[1], max(gripper.opening[0], apart * (left + right)))
        start = -(back + GAP + gripper.pad[0] / 2) * ahead + (left - right) / 2 * across
        x, y, z = (float(v) for v in start + (low + LOW * (top - low) + gripper.pad[1] / 2) * UP)
        yield way, replace(hand, position=(x, y, z)), opening, f"turned {turn:.0f} deg"


def _hands_in(thing: Thing, pose: Pose, gripper: Gripper, way: Floats, last: Floats) -> Iterator[Hand]:
    """Hands whose closed fingers are in a thing, over its floor and behind the side of its rim that is ahead on the last leg (3,).

    They stay there where they take it along by friction, and else come there in the end, where the rim stops them.

    Raises:
        Unresolvable: it has no rim there that fingers could take it along at.
    """
    rim, closed = False, gripper.opening[0]
    for spot, turn in itertools.product(SPOTS, EIGHTHS):
        ahead, across, hand = _axes(last, turn)
        left, right, front, back = (support(thing, pose, v) for v in (across, -across, ahead, -ahead))
        x, y, _ = (float(v) for v in ((left - right) / 2 + spot[1]) * across + ((front - back) / 2 + spot[0]) * ahead)
        floor = _floor(thing, pose, replace(hand, position=(x, y, support(thing, pose, UP))), gripper)
        if floor is not None:
            rim, aside = True, f", {1000 * spot[0]:+.0f} {1000 * spot[1]:+.0f} mm from its middle" if any(spot) else ""
            at = replace(hand, position=(x, y, floor + OVER + gripper.pad[1] / 2))
            x, y, z = (float(v) for v in np.asarray(at.position) + max(_free(thing, pose, at, ahead, closed, gripper) - PLAY, 0.0) * ahead)
            yield way, replace(at, position=(x, y, z)), closed, f"turned {turn:.0f} deg{aside}"
    if not rim:
        raise Unresolvable(f"'{thing.name}' has no rim around its middle that fingers in it could push it at", (), blocking=())


def _apart(location: Location) -> float:
    return asked(location, PushedThing).apart


def _axes(way: Floats, turn: float) -> tuple[Floats, Floats, Pose]:
    """Unit vectors (3,) along a level way and to the left of it, and a hand that points down, turned about the vertical [deg]."""
    ahead = way / float(np.linalg.norm(way))
    hand = Pose.from_axes((0, 0, 0), -UP, ahead) * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(turn)))
    return ahead, np.cross(UP, ahead), hand


def _floor(thing: Thing, pose: Pose, over: Pose, gripper: Gripper) -> float | None:
    """The highest of a thing under closed fingers, along z of the base frame [m]; None where its rim hardly stands up from that.

    Args:
        over: of the fingers' tips, as high as the thing's rim.
    """
    half, grid = gripper.opening[0] / 2 + FINGER, np.linspace(-1.0, 1.0, 5)
    tips = over.apply(np.array([(x * gripper.pad[0] / 2, y * half, 0.0) for x in grid for y in grid]))
    to = pose.inverse()
    met = intervals(body(thing.geoms), to.apply(tips), np.tile(to.rotate(-UP), (len(tips), 1)))[0].min()
    return over.position[2] - float(met) if math.isfinite(met) and met >= DEEP else None


def gap_before(belief: Belief, context: Context, entity: str, to: Spot, opening: float) -> float:
    """Return how far fingers go ahead, towards where a thing's origin shall come, until they meet it [m]."""
    pose = belief.pose(entity)
    way = np.array([to[0] - pose.position[0], to[1] - pose.position[1], 0.0])
    ahead = way / max(float(np.linalg.norm(way)), SHORT)
    return _free(belief.thing(entity), pose, tcp(belief, context), ahead, opening, context.robot.gripper)


def _free(thing: Thing, pose: Pose, hand: Pose, ahead: Floats, opening: float, gripper: Gripper) -> float:
    """How far fingers at a TCP pose go straight ahead until they meet a thing [m]; ``GAP`` where they would miss it."""
    reach, long = gripper.pad[0] / 2, gripper.pad[1]
    tips = [(x, s * y, long / 2 - z) for x in (reach, -reach) for s in (-1.0, 1.0)
            for y in np.linspace(opening / 2, opening / 2 + FINGER, 5) for z in np.linspace(0.0, long, 11)]  # fmt: skip
    to = pose.inverse()
    rays = to.apply(hand.apply(np.array(tips))), np.tile(to.rotate(ahead), (len(tips), 1))
    low, high = intervals(body(thing.geoms), *rays)
    met = float(np.where(high > 0.0, low, np.inf).min())
    return max(met, 0.0) if math.isfinite(met) else GAP

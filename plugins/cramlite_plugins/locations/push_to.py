"""Pushing to a region: fingers low behind a flat thing, seen from there, or in it behind its rim, and the way that brings it there."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Feature, Floats, Gripper, Held, Location, Place, Pose, Thing
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

from ..shapes.bounds import support
from ..shapes.carried_along import PUSHED, carried_along, pushed_along
from ..shapes.ray_casting import body, intervals
from .antipodal import FINGER

if TYPE_CHECKING:
    from ..motion_planning.space import Refusal

ABOVE, GAP = 0.06, 0.01  # over the place behind a thing at the stand-off, and from there to the thing [m]
LOW = 1 / 3  # finger tips over what carries a thing, as a share of its height: under a plate's rim, that they meet
LIFT, CLEAR = 0.003, 0.002  # while its way is checked, above what it slides along, and from all else [m]
SHARES = (0.0, 0.35, 0.6)
"""Of a region's half sides, towards the thing, from its middle: ends of the way; the rest is left for how far it slips."""
TURNS = (0.0, 180.0)
"""Of the hand about the vertical [deg]: its fingers open across the way."""
EIGHTHS = (0.0, 180.0, 90.0, 270.0, 45.0, 225.0, 135.0, 315.0)
"""The same of closed fingers in a thing."""
SPOTS = ((0.0, 0.0), (0.02, 0.0), (0.0, 0.02), (0.0, -0.02), (-0.02, 0.0))
"""For these, from its middle, ahead and to the left [m]: where the hand is beside what stands beside the thing."""
ASIDE = (0.06, -0.06, 0.12, -0.12)
"""Corners of a way around something, beside the straight one, to the left [m]."""
OVER, DEEP = 0.002, 0.006  # finger tips in a thing, over its floor; the least that its rim stands up from that [m]
SHORT = 1e-6  # [m]: no way at all
UP = np.array([0.0, 0.0, 1.0])
Spot = tuple[float, float]
Hand = tuple[Floats, Pose, float, str]
"""The level way (3,) of a thing, the TCP from where it begins, how far the fingers are open [m], and how the hand is held."""


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Resolve locations "behind", "pushed_to" and "pushed_around"; None for other relations."""
    finders = {"behind": _behind, "pushed_to": _pushed_to, "pushed_around": _pushed_around}
    finder = finders.get(location.relation)
    return finder(location, belief, context) if finder else None


def _behind(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Fingers on the side of a thing that is opposite to the region that it shall go to; to the region's middle first.

    With "inside" they are in the thing, low, and take it along at the inner side of its rim.
    """
    from ..motion_planning.reach import bound, collision_free_ik, make_scene, reference_pose, shift
    from ..motion_planning.space import Refusal

    entity, inside = bound(context, location.of), bool(location.parameters.get("inside"))
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    if not thing.movable:
        raise Unresolvable(f"'{entity}' is fixed and cannot be pushed", (location.of or "",))
    area, frame = _region(thing, pose, str(location.parameters["region"]), belief)
    hands = _hands_in if inside else _hands_behind
    for k, (way, at, opening, turn) in enumerate(hands(thing, pose, location, context.robot.gripper, area, frame)):
        name = f"by ({1000 * way[0]:+.0f} {1000 * way[1]:+.0f}) mm, hand {turn}"
        free = make_scene(belief, context, (), opening)
        near, before = make_scene(belief, context, [entity], opening) if inside else free, shift(at, ABOVE * UP)
        off = collision_free_ik(free, context, before, belief.joints)
        there = off if isinstance(off, Refusal) else collision_free_ik(near, context, at, off)
        if isinstance(there, Refusal):
            yield there.refused(name)
        else:
            x, y, _ = (float(v) for v in way + pose.position)
            place = Place(at, before, opening, (0.0, 0.0, -1.0), thing=thing.name, values={"x_m": x, "y_m": y})
            yield Grounding(place, f"'{entity}' {name}", 0.1 * k, key=name)


def _pushed_to(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Straight on from where a piece of its way ended or begins until a thing is in its region; nothing may be in its way."""
    from ..motion_planning.reach import bound, causes
    from ..motion_planning.space import Refusal

    entity = bound(context, location.of)
    begun: Place = context.bindings[str(location.parameters["begin"])]
    leg = _leg(belief, context, entity, (begun.values["x_m"], begun.values["y_m"]), begun.opening or 0.0)
    if isinstance(leg, Refusal):
        said = f"'{entity}' cannot be pushed on: {leg.reason}"
        raise Unresolvable(said, causes(location, context), blocking=leg.blocking, collision=leg.collision)
    yield Grounding(leg[0], f"{1000 * leg[0].values[PUSHED]:.0f} mm straight on", key="on")


def _pushed_around(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """To a corner beside the straight way, from which a thing goes straight on into its region: around what is in its way."""
    from ..motion_planning.reach import bound
    from ..motion_planning.space import Refusal

    entity = bound(context, location.of)
    pose, begun = belief.pose(entity), context.bindings[str(location.parameters["begin"])]
    area, frame = _region(belief.thing(entity), pose, str(location.parameters["region"]), belief)
    for k, (corner, end) in enumerate(_corners(np.asarray(pose.position), area, frame)):
        name = f"by way of ({1000 * corner[0]:+.0f} {1000 * corner[1]:+.0f}) mm"
        leg = _leg(belief, context, entity, corner, begun.opening)
        after = leg if isinstance(leg, Refusal) else _leg(pushed_along(leg[1], leg[0]), context, entity, end, begun.opening)
        if isinstance(after, Refusal):
            yield after.refused(name)
        elif not isinstance(leg, Refusal):
            values = {**leg[0].values, "x_m": end[0], "y_m": end[1]}
            yield Grounding(replace(leg[0], opening=begun.opening, values=values), name, 0.1 * k, key=name)


def _leg(belief: Belief, context: Context, entity: str, to: Spot, opening: float) -> tuple[Place, Belief] | Refusal:
    """A straight piece of way on which fingers bring a thing's origin to a point of the base's x-y plane, and the arm at its end."""
    from ..motion_planning.cartesian import plan_straight_line
    from ..motion_planning.reach import make_scene, shift, tcp
    from ..motion_planning.space import Refusal

    here, pose, thing = tcp(belief, context), belief.pose(entity), belief.thing(entity)
    way = np.array([to[0] - pose.position[0], to[1] - pose.position[1], 0.0])
    length = float(np.linalg.norm(way))
    ahead = way / max(length, SHORT)
    gap = _gap(thing, pose, here, ahead, opening, context.robot.gripper)
    end, over = shift(here, way + gap * ahead), shift(pose, LIFT * UP - gap * ahead)
    held = Held(entity, here.inverse() * over, 0.0, carries=carried_along(belief, entity))
    scene = make_scene(belief.grasped(held), context, [entity], clearance=CLEAR)
    found = plan_straight_line(scene, context.robot, belief.joints, [end])
    if isinstance(found, Refusal):
        return found
    x, y, _ = (float(v) for v in ahead)
    return Place(end, end, approach=(x, y, 0.0), thing=entity, values={PUSHED: length}), belief.moved(found.points[-1])


def _corners(start: Floats, area: Feature, frame: Pose) -> Iterator[tuple[Spot, Spot]]:
    """Corners beside the way to an area, and ends in it, the shortest ways first."""
    half = 0.6 * np.array(_sides(area)) / 2
    spots = [frame.apply((*(half * share), 0.0)) for share in itertools.product((0.0, 1.0, -1.0), repeat=2)]
    found = []
    for x, y, _ in (np.asarray(s) for s in spots):
        way = np.array([x, y]) - start[:2]
        left = np.array([-way[1], way[0]]) / max(float(np.linalg.norm(way)), SHORT)
        for share, aside in itertools.product((0.5, 1.0), ASIDE):
            corner = start[:2] + share * way + aside * left
            length = math.dist(corner, start[:2]) + math.dist(corner, (x, y))
            found.append((length, (float(corner[0]), float(corner[1])), (float(x), float(y))))
    yield from ((corner, end) for _, corner, end in sorted(found))


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


def _hands_behind(thing: Thing, pose: Pose, location: Location, gripper: Gripper, area: Feature, frame: Pose) -> Iterator[Hand]:
    """Hands whose fingers are behind a thing, as far open as the location says, as a share of the thing's width."""
    low, top = -support(thing, pose, -UP), support(thing, pose, UP)
    apart = float(location.parameters.get("apart", 0.0))
    for share, turn in itertools.product(SHARES, TURNS):
        way = _towards(pose, area, frame, share)
        ahead, across, hand = _axes(way, turn)
        back, left, right = (support(thing, pose, v) for v in (-ahead, across, -across))
        opening = min(gripper.opening[1], max(gripper.opening[0], apart * (left + right)))
        start = -(back + GAP + gripper.pad[0] / 2) * ahead + (left - right) / 2 * across
        x, y, z = (float(v) for v in start + (low + LOW * (top - low) + gripper.pad[1] / 2) * UP)
        yield way, replace(hand, position=(x, y, z)), opening, f"turned {turn:.0f} deg"


def _hands_in(thing: Thing, pose: Pose, location: Location, gripper: Gripper, area: Feature, frame: Pose) -> Iterator[Hand]:
    """Hands whose closed fingers are in a thing, over its floor.

    Raises:
        Unresolvable: it has no rim there that fingers could take it along at.
    """
    way, rim = _towards(pose, area, frame, 0.0), False
    for spot, turn in itertools.product(SPOTS, EIGHTHS):
        ahead, across, hand = _axes(way, turn)
        left, right, front, back = (support(thing, pose, v) for v in (across, -across, ahead, -ahead))
        x, y, _ = (float(v) for v in ((left - right) / 2 + spot[1]) * across + ((front - back) / 2 + spot[0]) * ahead)
        floor = _floor(thing, pose, replace(hand, position=(x, y, support(thing, pose, UP))), gripper)
        if floor is not None:
            rim, aside = True, f", {1000 * spot[0]:+.0f} {1000 * spot[1]:+.0f} mm from its middle" if any(spot) else ""
            at = replace(hand, position=(x, y, floor + OVER + gripper.pad[1] / 2))
            yield way, at, gripper.opening[0], f"turned {turn:.0f} deg{aside}"
    if not rim:
        raise Unresolvable(f"'{thing.name}' has no rim around its middle that fingers in it could push it at", (), blocking=())


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


def _gap(thing: Thing, pose: Pose, hand: Pose, ahead: Floats, opening: float, gripper: Gripper) -> float:
    """How far fingers at a TCP pose go straight ahead until they meet a thing [m]; ``GAP`` where they would miss it."""
    reach, long = gripper.pad[0] / 2, gripper.pad[1]
    tips = [(x, s * y, long / 2 - z) for x in (reach, -reach) for s in (-1.0, 1.0)
            for y in np.linspace(opening / 2, opening / 2 + FINGER, 5) for z in np.linspace(0.0, long, 11)]  # fmt: skip
    to = pose.inverse()
    rays = to.apply(hand.apply(np.array(tips))), np.tile(to.rotate(ahead), (len(tips), 1))
    low, high = intervals(body(thing.geoms), *rays)
    met = float(np.where(high > 0.0, low, np.inf).min())
    return max(met, 0.0) if math.isfinite(met) else GAP

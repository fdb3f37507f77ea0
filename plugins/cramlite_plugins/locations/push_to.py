"""Pushing to a region: fingers low behind a flat thing, seen from there, and the straight way that brings it into the region."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Feature, Floats, Gripper, Held, Location, Place, Pose, Thing
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

from ..shapes.bounds import support
from ..shapes.carried_along import PUSHED, carried_along
from ..shapes.ray_casting import body, intervals
from .antipodal import FINGER

ABOVE, GAP = 0.06, 0.01  # over the place behind a thing at the stand-off, and from there to the thing [m]
LOW = 1 / 3  # finger tips over what carries a thing, as a share of its height: under a plate's rim, that they meet
LIFT, CLEAR = 0.003, 0.002  # while its way is checked, above what it slides along, and from all else [m]
SHARES = (0.0, 0.35, 0.6)
"""Of a region's half sides, towards the thing, from its middle: ends of the way; the rest is left for how far it slips."""
TURNS = (0.0, 180.0)
"""Of the hand about the vertical [deg]: its fingers open across the way."""
UP = np.array([0.0, 0.0, 1.0])


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Resolve locations "behind" and "pushed_to"; None for other relations."""
    finders = {"behind": _behind, "pushed_to": _pushed_to}
    finder = finders.get(location.relation)
    return finder(location, belief, context) if finder else None


def _behind(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Fingers on the side of a thing that is opposite to the region that it shall go to; to the region's middle first."""
    from ..motion_planning.reach import bound, collision_free_ik, make_scene, reference_pose, shift
    from ..motion_planning.space import Refusal

    entity = bound(context, location.of)
    thing, pose = belief.thing(entity), reference_pose(belief, location, context)
    if not thing.movable:
        raise Unresolvable(f"'{entity}' is fixed and cannot be pushed", (location.of or "",))
    area, frame = _region(thing, pose, str(location.parameters["region"]), belief)
    for k, (share, turn) in enumerate(itertools.product(SHARES, TURNS)):
        way = _towards(pose, area, frame, share)
        at, opening, gap = _against(thing, pose, way, turn, context.robot.gripper, float(location.parameters.get("apart", 0.0)))
        name = f"by ({1000 * way[0]:+.0f} {1000 * way[1]:+.0f}) mm, hand turned {turn:.0f} deg"
        scene, before = make_scene(belief, context, (), opening), shift(at, ABOVE * UP)
        off = collision_free_ik(scene, context, before, belief.joints)
        there = off if isinstance(off, Refusal) else collision_free_ik(scene, context, at, off)
        if isinstance(there, Refusal):
            yield there.refused(name)
        else:
            values = {"x_m": float(way[0]), "y_m": float(way[1]), "gap_m": gap}
            place = Place(at, before, opening, (0.0, 0.0, -1.0), thing=thing.name, values=values)
            yield Grounding(place, f"'{entity}' {name}", 0.1 * k, key=name)


def _pushed_to(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Straight on from behind a thing until that is in its region; nothing may be in its way."""
    from ..motion_planning.cartesian import plan_straight_line
    from ..motion_planning.reach import bound, causes, make_scene, shift, tcp
    from ..motion_planning.space import Refusal

    entity, here = bound(context, location.of), tcp(belief, context)
    begun: Place = context.bindings[f"behind({location.of})"]
    way, gap = np.array([begun.values["x_m"], begun.values["y_m"], 0.0]), begun.values["gap_m"]
    length = float(np.linalg.norm(way))
    ahead = way / length
    end, over = shift(here, way + gap * ahead), shift(belief.pose(entity), LIFT * UP - gap * ahead)
    held = Held(entity, here.inverse() * over, 0.0, carries=carried_along(belief, entity))
    scene = make_scene(belief.grasped(held), context, [entity], clearance=CLEAR)
    found = plan_straight_line(scene, context.robot, belief.joints, [end])
    if isinstance(found, Refusal):
        said = f"'{entity}' cannot be pushed by {1000 * length:.0f} mm: {found.reason}"
        raise Unresolvable(said, causes(location, context), blocking=found.blocking, collision=found.collision)
    x, y, _ = (float(v) for v in ahead)
    place = Place(end, end, approach=(x, y, 0.0), thing=entity, values={PUSHED: length})
    yield Grounding(place, f"{1000 * length:.0f} mm straight on", key="on")


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


def _towards(pose: Pose, area: Feature, frame: Pose, share: float) -> Floats:
    """The level way (3,) [m] of a thing's origin into an area: to its middle, or to a share of its half sides nearer."""
    sides = [area.size.get("radius", 0.0) * math.sqrt(2)] * 2 if "radius" in area.size else [area.size["width"], area.size["depth"]]
    half, local = share * np.array(sides) / 2, frame.inverse().apply(pose.position)
    target = frame.apply((*np.clip(local[:2], -half, half), 0.0))
    return np.array([*(target - np.asarray(pose.position))[:2], 0.0])


def _against(thing: Thing, pose: Pose, way: Floats, turn: float, gripper: Gripper, apart: float) -> tuple[Pose, float, float]:
    """The TCP of fingers behind a thing, how far these are open, and how far they go until they meet it [m].

    Args:
        apart: how far they shall be open, as a share of the thing's width.
    """
    ahead = way / float(np.linalg.norm(way))
    across = np.cross(UP, ahead)
    hand = Pose.from_axes((0, 0, 0), -UP, ahead) * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(turn)))
    low, back, left, right = (support(thing, pose, v) for v in (-UP, -ahead, across, -across))
    height = -low + LOW * (support(thing, pose, UP) + low)
    opening = min(gripper.opening[1], max(gripper.opening[0], apart * (left + right)))
    start = -(back + GAP + gripper.pad[0] / 2) * ahead + (left - right) / 2 * across + height * UP
    tips = [start + gripper.pad[0] / 2 * ahead + s * a * across + z * UP for s in (-1.0, 1.0)
            for a in np.linspace(opening / 2, opening / 2 + FINGER, 5) for z in np.linspace(0.0, gripper.pad[1], 11)]  # fmt: skip
    to = pose.inverse()
    rays = to.apply(np.array(tips)), np.tile(to.rotate(ahead), (len(tips), 1))
    met = float(intervals(body(thing.geoms), *rays)[0].min())
    x, y, z = (float(v) for v in start + gripper.pad[1] / 2 * UP)
    return replace(hand, position=(x, y, z)), opening, met if math.isfinite(met) else GAP

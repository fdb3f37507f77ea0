"""Pushing poses: closed fingers beside one of a thing's faces, low, and then straight on."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Floats, Location, Place, Pose
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

from ..shapes.bounds import support

BEHIND, ALMOST = 0.05, 0.003  # from the face to the fingers at the stand-off, and where feeling begins [m]
LOW, UNDER_PALM = 0.015, 0.010  # finger tips above what carries the thing; the palm above the thing [m]


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Resolve location "push"; None for other relations."""
    finders = {"push": _beside, "pushed": _beyond}
    finder = finders.get(location.relation)
    return finder(location, belief, context) if finder else None


def _beside(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """One place for each of the four upright faces, the one that is pushed straight away from the robot first."""
    from ..motion_planning.reach import bound, collision_free_ik, make_scene, reference_pose, shift
    from ..motion_planning.space import Refusal

    entity = bound(context, location.of)
    thing, gripper = belief.thing(entity), context.robot.gripper
    if not thing.movable:
        raise Unresolvable(f"'{entity}' is fixed and cannot be pushed", (location.of or "",))
    pose, shut = reference_pose(belief, location, context), gripper.opening[0]
    free, near = make_scene(belief, context, (), shut), make_scene(belief, context, [thing.name], shut)
    up = np.array([0.0, 0.0, 1.0])
    low, top = -support(thing, pose, -up), support(thing, pose, up)
    height = max(low + LOW + gripper.pad[1] / 2, top + UNDER_PALM - gripper.depth)
    for k, way in enumerate(_ways(pose)):
        face = support(thing, pose, -way)  # along -way, from the base's origin
        centre = np.asarray(pose.position)
        point = centre - way * (face + float(centre @ way) + gripper.pad[0] / 2 + ALMOST)
        at = Pose.from_axes((float(point[0]), float(point[1]), height), (0, 0, -1), way)
        before, name = shift(at, -BEHIND * way), f"towards ({way[0]:+.2f} {way[1]:+.2f})"
        tried = (
            collision_free_ik(free, context, before, belief.joints),
            collision_free_ik(near, context, at, belief.joints),
        )
        no = next((r for r in tried if isinstance(r, Refusal)), None)
        if no is not None:
            yield no.refused(name)
        else:
            place = Place(at, before, shut, (float(way[0]), float(way[1]), 0.0), thing=thing.name)
            yield Grounding(place, f"'{entity}' {name}", 0.1 * k, key=name)


def _beyond(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Straight on from where the fingers are, in the direction of the place that they push from."""
    from ..motion_planning.reach import bound, causes, collision_free_ik, make_scene, shift, tcp
    from ..motion_planning.space import Refusal

    entity, distance = bound(context, location.of), float(location.parameters["distance_m"])
    start: Place = context.bindings[f"push({location.of})"]
    end = shift(tcp(belief, context), np.asarray(start.approach) * distance)
    there = collision_free_ik(make_scene(belief, context, [entity]), context, end, belief.joints)
    if isinstance(there, Refusal):
        said = f"after {1000 * distance:.0f} mm: {there.reason}"
        raise Unresolvable(said, causes(location, context), blocking=there.blocking, collision=there.collision)
    yield Grounding(Place(end, end, thing=entity), f"{1000 * distance:.0f} mm on", key="on")


def _ways(pose: Pose) -> list[Floats]:
    """The horizontal directions of a thing's own x and y axes, outwards from the robot first."""
    out = np.array([*pose.position[:2], 0.0])
    x = pose.rotate((1.0, 0.0, 0.0))
    angle = math.atan2(float(x[1]), float(x[0]))
    turns = [angle + k * math.pi / 2 for k in range(4)]
    ways = [np.array([math.cos(a), math.sin(a), 0.0]) for a in turns]
    return sorted(ways, key=lambda w: -round(float(w @ out), 6))

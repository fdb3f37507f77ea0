"""Grasps of handles, and the paths along which drawers and doors move them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Location, Place, Pose
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

STANDOFF = 0.08  # in front of the handle [m]: the fingers, open, are clear of the bar
SLACK = 0.05  # how much wider than the bar the fingers open [m]: what is behind it may be off by half of that
STEPS = 0.03, math.radians(5)  # between two corners of a path [m, rad]: a chord is then off its arc by under 0.3 mm
CLOSED = 0.005  # share of the range that a joint is closed to: what friction leaves


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Resolve locations "handle", "opened" and "closed"; None for other relations."""
    finders = {"handle": _grasps, "opened": _path, "closed": _path}
    finder = finders.get(location.relation)
    return finder(location, belief, context) if finder else None


def _grasps(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Straight onto the handle, the fingers across its bar; turned half way round as well."""
    from ..motion_planning.reach import bound, collision_free_ik, make_scene
    from ..motion_planning.space import Refusal

    entity = bound(context, location.of)
    thing, handle = belief.thing(entity), belief.feature(entity, "cram:Handle")
    if handle is None or thing.joint is None:
        lacks = "cram:Handle to hold it by" if handle is None else "joint to open it by"
        raise Unresolvable(f"'{entity}' has no {lacks}", (location.of or "",), blocking=())
    width = 2 * handle.size["radius"]
    opening = min(width + SLACK, context.robot.gripper.opening[1])
    near, free = make_scene(belief, context, [thing.name], opening), make_scene(belief, context, (), opening)
    upright = thing.joint.kind == "hinge"
    for k, turn in enumerate((0.0, 180.0)):
        # the handle's z comes out, its x is up: the tool's z goes in, its y across the bar
        across = handle.pose.rotate((0, 1, 0) if upright else (1, 0, 0))
        into = handle.pose.rotate((0, 0, -1))
        at = belief.pose(thing.name) * Pose.from_axes(handle.pose.position, into, np.cross(across, into))
        at = at * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(turn)))
        name, before = f"across the handle, turned {turn:.0f} deg", at * Pose((0, 0, -STANDOFF))
        there = collision_free_ik(near, context, at, belief.joints)
        off = collision_free_ik(free, context, before, there) if not isinstance(there, Refusal) else there
        if isinstance(off, Refusal):
            yield off.refused(name)
            continue
        place = Place(at, before, opening, tuple(at.rotate((0, 0, 1))), thing=thing.name, values={"width_m": width})
        yield Grounding(place, f"{name}: {1000 * width:.0f} mm wide", 0.1 * k, key=name)



def _path(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """TCP poses that keep the handle in the hand while the joint goes to its goal."""
    from ..motion_planning.reach import bound, causes, held_pose, tcp

    entity = bound(context, location.of)
    thing = belief.thing(entity)
    if thing.joint is None or belief.held is None or belief.held.thing != thing.name:
        raise Unresolvable(f"'{entity}' must have a joint, and be held", causes(location, context), blocking=())
    joint, now = thing.joint, held_pose(belief, context)
    goal = joint.lower + float(location.parameters.get("share", CLOSED)) * (joint.upper - joint.lower)
    value = joint_value(belief, thing.name, belief.base() * now)
    hand, way = now.inverse() * tcp(belief, context), goal - value
    count = max(1, math.ceil(abs(way) / STEPS[joint.kind == "hinge"]))
    path = tuple(joint.moved(now, way * k / count) * hand for k in range(1, count + 1))
    said = f"'{entity}' from {value:.3f} to {goal:.3f} {'m' if joint.kind == 'slide' else 'rad'}"
    yield Grounding(Place(path[-1], path[-1], path=path, thing=thing.name), said, key="path")


def joint_value(belief: Belief, thing: str, pose: Pose) -> float:
    """Return the value of a thing's joint when the thing is at a pose in the world [m, rad]."""
    start = belief.world.thing(thing)
    assert start.joint is not None
    return start.joint.value + start.joint.between(start.pose, pose)

"""Grasps of handles, and the paths along which drawers and doors move them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Feature, Joint, Location, Place, Pose
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

STANDOFF = 0.08  # in front of the handle [m]: the fingers, open, are clear of the bar
SLACK = (0.05, 0.03, 0.016, 0.01)
"""How much wider than the bar the fingers open [m]: it may be off by half of that. The widest that nothing beside it forbids."""
TIPS = 0.006  # how much farther out the pads also take it, where their ends come too near to the front behind [m]
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
    openings = dict.fromkeys(min(width + s, context.robot.gripper.opening[1]) for s in SLACK)
    scenes = [(o, make_scene(belief, context, [thing.name], o), make_scene(belief, context, (), o)) for o in openings]
    for k, (turn, back) in enumerate(itertools.product((0.0, 180.0), (0.0, TIPS))):
        at = belief.pose(thing.name) * _across(thing.joint, handle, turn) * Pose((0, 0, -back))
        name, before, refused = f"across the handle, turned {turn:.0f} deg", at * Pose((0, 0, -STANDOFF)), list[Refusal]()
        name += ", by the tips" if back else ""
        for opening, near, free in scenes:
            there = collision_free_ik(near, context, at, belief.joints)
            off = collision_free_ik(free, context, before, there) if not isinstance(there, Refusal) else there
            if isinstance(off, Refusal):
                refused.append(off)
                continue
            place = Place(at, before, opening, tuple(at.rotate((0, 0, 1))), thing=thing.name, values={"width_m": width})
            yield Grounding(place, f"{name}: {1000 * width:.0f} mm wide, open {1000 * opening:.0f} mm", 0.1 * k, key=name)
            break
        else:
            yield refused[-1].refused(name)


def _across(joint: Joint, handle: Feature, turn: float) -> Pose:
    """The TCP at a handle, in its thing's frame: z into it, y across its bar, turned about z [deg]."""
    # the handle's z comes out, and its x is along the bar of a door, across that of a drawer
    across = handle.pose.rotate((0, 1, 0) if joint.kind == "hinge" else (1, 0, 0))
    into = handle.pose.rotate((0, 0, -1))
    return Pose.from_axes(handle.pose.position, into, np.cross(across, into)) * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(turn)))


def _path(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """TCP poses that keep the handle in the hand while the joint goes to its goal, or to the next of its goals."""
    from ..motion_planning.reach import bound, causes, held_pose, tcp

    entity = bound(context, location.of)
    thing = belief.thing(entity)
    if thing.joint is None or belief.held is None or belief.held.thing != thing.name:
        raise Unresolvable(f"'{entity}' must have a joint, and be held", causes(location, context), blocking=())
    joint, now = thing.joint, held_pose(belief, context)
    value, hand = joint_value(belief, thing.name, belief.base() * now), now.inverse() * tcp(belief, context)
    for k, share in enumerate(location.parameters.get("shares", (CLOSED,))):
        goal = joint.lower + float(share) * (joint.upper - joint.lower)
        count = max(1, math.ceil(abs(goal - value) / STEPS[joint.kind == "hinge"]))
        path = tuple(joint.moved(now, (goal - value) * n / count) * hand for n in range(1, count + 1))
        said = f"'{entity}' from {value:.3f} to {goal:.3f} {'m' if joint.kind == 'slide' else 'rad'}"
        yield Grounding(Place(path[-1], path[-1], path=path, thing=thing.name), said, 0.1 * k, key=f"path to {share:g}")


def joint_value(belief: Belief, thing: str, pose: Pose) -> float:
    """Return the value of a thing's joint when the thing is at a pose in the world [m, rad]."""
    start = belief.world.thing(thing)
    assert start.joint is not None
    return start.joint.value + start.joint.between(start.pose, pose)

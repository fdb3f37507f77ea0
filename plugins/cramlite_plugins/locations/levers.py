"""Levers that are mounted on a door: which one it has, and how far it is turned to free the door's way."""

from __future__ import annotations

import math

from msgspec.structs import replace

from cramlite.model import Belief, Estimate, Location, Pose, Thing
from cramlite.plugin import Context, Unresolvable

from ..shapes.joint_values import joint_value
from .joint_way import met_on_its_way

STEP = math.radians(5.0)
"""Between the angles that are looked at [rad]."""
BEYOND = math.radians(10.0)
"""How much further a lever is turned than to where its door comes free [rad]: a hand that holds it against a spring gives way by some
millimetres, and 10 deg at 75 mm are 13 mm."""


def lever_of(location: Location, thing: Thing, belief: Belief) -> Thing:
    """Return the first lever with a handle that is mounted on a door.

    Raises:
        Unresolvable: it has none.
    """
    for mounted in belief.world.mounted_on(thing.name):
        if mounted.feature("cram:Handle") is not None:
            return mounted
    raise Unresolvable(f"no lever is mounted on '{thing.name}'", (location.of or "",), blocking=())


def freed(location: Location, lever: Thing, least: float, now: Pose, belief: Belief, context: Context) -> float:
    """Return the value to which a lever is turned so that its door can open: ``BEYOND`` the first from which the door's
    way is free [rad].

    Args:
        least: share of the range of the door's joint that it must open to.
        now: of the lever, in the world.

    Raises:
        Unresolvable: no value frees the door, or it is free as it is.
    """
    assert lever.joint is not None
    joint, door = lever.joint, belief.world.thing(lever.joint.parent)
    assert door.joint is not None
    begin = joint_value(belief, lever.name, now)
    there = joint_value(belief, door.name, belief.poses[door.name].pose)
    goal = door.joint.lower + least * (door.joint.upper - door.joint.lower)
    count, met = max(1, math.ceil((joint.upper - begin) / STEP)), None
    for k in range(count + 1):
        value = min(begin + k * STEP, joint.upper)
        turned = Estimate(joint.moved(now, value - begin))
        at = replace(belief, held=None, poses={**belief.poses, lever.name: turned})
        met = met_on_its_way(door, there, goal, at, context)
        if met is None and k == 0:
            raise Unresolvable(f"'{door.name}' is free as '{lever.name}' is", (location.of or "",), blocking=())
        if met is None:
            return min(value + BEYOND, joint.upper)
    said = f"however far '{lever.name}' is turned, '{door.name}' is stopped {met.reason if met else ''}"
    raise Unresolvable(said, (location.of or "",), blocking=met.blocking if met else (), collision=met.collision if met else None)

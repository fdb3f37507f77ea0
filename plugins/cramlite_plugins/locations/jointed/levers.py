"""Levers that are mounted on a door: search for a door's lever, and the joint values at which the lever frees
the door."""

from __future__ import annotations

import math
from functools import partial

from msgspec.structs import replace

from cramlite.model import Belief, Estimate, Location, Pose, Thing
from cramlite.plugin import Context, Refused, Unresolvable

from ...motion_planning.reach import unfit
from ...shapes.joints import joint_value
from .joint_obstacles import met_on_its_way

STEP = math.radians(5.0)
"""Step between the joint values of a lever that are checked [rad]."""
BEYOND = math.radians(10.0)
"""Turn of a lever beyond the angle at which its door comes free [rad]: a hand that holds it against a spring
gives way by some millimetres, and 10 deg at 75 mm are 13 mm."""


def lever_of(location: Location, thing: Thing, belief: Belief) -> Thing:
    """Return the first lever with a handle that is mounted on a door.

    Raises:
        Unresolvable: it has none.
    """
    for mounted in belief.world.mounted_on(thing.name):
        if mounted.feature("cram:Handle") is not None:
            return mounted
    raise unfit(location, f"no lever is mounted on '{thing.name}'")


def freeing(
    location: Location, lever: Thing, least: float, now: Pose, belief: Belief, context: Context
) -> list[float]:
    """Return the values [rad] to which a lever can be turned so that its door can open: at most one upwards
    and one downwards.

    Each is ``BEYOND`` farther than the first value found at which the door's way is free, as far as the
    lever's range allows.

    Args:
        least: share of the range of the door's joint that it must open to.
        now: of the lever, in the world.

    Raises:
        Unresolvable: no value frees the door, or it is free as it is.
    """
    assert lever.joint is not None
    joint, begin = lever.joint, joint_value(belief, lever.name, now)
    met_at = partial(_met, lever, least, now, belief, context)
    if met_at(begin) is None:
        raise unfit(location, f"'{lever.joint.parent}' can be opened with '{lever.name}' as it is")
    found = list[float]()
    for end in (joint.upper, joint.lower):
        way = end - begin
        values = (
            begin + math.copysign(min(k * STEP, abs(way)), way)
            for k in range(1, math.ceil(abs(way) / STEP) + 1)
        )
        free = next((v for v in values if met_at(v) is None), None)
        if free is not None:
            found.append(min(max(free + math.copysign(BEYOND, way), joint.lower), joint.upper))
    if not found:
        met = met_at(joint.upper)
        said = met.reason if met else ""
        reason = f"however far '{lever.name}' is turned, '{joint.parent}' is stopped {said}"
        raise Unresolvable(reason, (location.of or "",), blocking=met.blocking if met else ())
    return found


def _met(
    lever: Thing, least: float, now: Pose, belief: Belief, context: Context, value: float
) -> Refused | None:
    """Refusal of a door's opening motion with the door's lever turned to a joint value; None if nothing is
    in the way."""
    assert lever.joint is not None
    door = belief.world.thing(lever.joint.parent)
    assert door.joint is not None
    turned = Estimate(lever.joint.moved(now, value - joint_value(belief, lever.name, now)))
    there = joint_value(belief, door.name, belief.poses[door.name].pose)
    free = replace(belief, held=None, poses={**belief.poses, lever.name: turned})
    return met_on_its_way(door, there, door.joint.value_at(least), free, context)

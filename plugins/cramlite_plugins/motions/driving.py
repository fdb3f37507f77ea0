"""Driving: motion "drive" of the platform to a pose, on a path that is collision-free for the whole robot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from cramlite.model import Belief, Drive, Motion, Stand
from cramlite.plugin import Answers, Context, Grounding, Unresolvable, hookimpl

from .motion_kinds import value
from .ontology_limits import adapted, noted

if TYPE_CHECKING:
    from ..motion_planning.base_planner import Ground

SAME = 0.005, 0.01  # the platform stands there already within this [m, rad]


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve motion "drive"; None for other kinds."""
    return _drive(adapted(motion, belief, context), belief, context) if motion.kind == "drive" else None


def _drive(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    from ..motion_planning.base_planner import NoBasePath, at, plan_base_path, unwound

    assert motion.to is not None, f"motion '{motion.name}' needs a location"
    stand: Stand = context.bindings[motion.to.name]
    here = at(context.robot.stand_of(belief.base()))
    goal = unwound(at(stand.pose), here)
    if math.dist(here[:2], goal[:2]) < SAME[0] and abs(here[2] - goal[2]) < SAME[1]:
        yield Grounding((), "the platform stands there already", key="there")
        return
    floor = _floor(belief, context)
    legs = plan_base_path(floor, here, goal)
    if isinstance(legs, NoBasePath):
        reason = f"the platform cannot drive to {motion.to}: {legs.reason}"
        raise Unresolvable.because_of_earlier_tasks(reason) if legs.shut_in else Unresolvable(reason)  # no other stand would help
    rates = [value(motion, n) for n in ("speed_m_s", "acceleration_m_s2", "speed_rad_s", "acceleration_rad_s2")]
    step = Drive(tuple(legs), *rates, origin=motion.name, comment=motion.reason)
    metres = sum(math.dist(a[:2], b[:2]) for a, b in pairwise([here, *legs]))
    count = f"{len(legs)} legs" if len(legs) > 1 else "one leg"
    clear = f"{1000 * floor.clearance:.0f} mm or more from everything"
    reason = f"{metres:.2f} m in {count}, {clear}, {floor.checks[0]} places looked at{noted(motion)}"
    yield Grounding((step,), reason, 0.0, belief.driven(context.robot.arm_at(stand.pose)), key="way")


def _floor(belief: Belief, context: Context) -> Ground:
    """Return the planning scene for driving, with the largest clearance at which the robot hits nothing where
    it stands.

    Raises:
        Unresolvable: it stands too near to something, or has no platform.
    """
    from ..motion_planning.base_planner import CLEARANCES, at

    here = at(context.robot.stand_of(belief.base()))
    blocked = ""
    for clearance in CLEARANCES:
        floor = floor_of(belief, context, clearance)
        if not (blocked := floor.hit(here)):
            return floor
    raise Unresolvable(f"the platform cannot start: {blocked}")


def floor_of(belief: Belief, context: Context, clearance: float) -> Ground:
    """Build the planning scene for driving: the whole robot, with its arm at the believed joint positions,
    among things.

    Raises:
        Unresolvable: the robot has no platform.
    """
    from ..motion_planning.base_planner import ground

    if context.robot.platform is None:
        raise Unresolvable(f"'{context.robot.type}' is bolted down; it has no platform to drive", ("",))
    poses = {name: e.pose for name, e in belief.poses.items() if belief.world.thing(name).movable}
    robots = {context.robot.type: context.robot}
    return ground(
        belief.world,
        robots,
        belief.robot,
        belief.joints,
        poses=poses,
        held=belief.in_hand(),
        opening=belief.opening,
        clearance=clearance,
    )

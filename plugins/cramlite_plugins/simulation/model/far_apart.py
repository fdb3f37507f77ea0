"""Things that nothing brings together: they stand apart, and beyond what any robot reaches with whatever it carries."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

from cramlite.model import Robot, RobotMount, Thing, World

from ...shapes.bounds import radius

APART = 0.1
"""What is nearer to each other than this may meet, as a stack does that settles [m]."""


def far_apart(world: World, robots: Mapping[str, Robot]) -> frozenset[frozenset[str]]:
    """Return pairs of names of things that can be moved and that nothing brings together; none where no robot stands.

    Args:
        robots: descriptions by type, for the world's mounts.
    """
    loose = [t for t in world.things if t.movable and t.joint is None]
    if not world.robots or any(robots[m.type].platform for m in world.robots):
        return frozenset()  # hands go anywhere, and so does a robot that drives
    load = 2.0 * max(map(radius, loose), default=0.0)
    far = [t for t in loose if all(_beyond(t, m, robots[m.type], load) for m in world.robots)]
    pairs = itertools.combinations(far, 2)
    return frozenset(frozenset((a.name, b.name)) for a, b in pairs if math.dist(a.pose.position, b.pose.position) > _room(a, b))


def _beyond(thing: Thing, mount: RobotMount, robot: Robot, load: float) -> bool:
    """Whether a thing is farther from the axis of an arm's base than its flange comes, with the gripper and the load."""
    x, y, _ = (robot.arm_at(mount.base) * robot.root).inverse().apply(thing.pose.position).tolist()
    tool = math.hypot(*robot.gripper.tcp.position)
    return math.hypot(x, y) - radius(thing) > robot.reach + tool + load


def _room(one: Thing, other: Thing) -> float:
    return radius(one) + radius(other) + APART

"""Things beyond the reach of every robot with its longest payload, and apart from each other: they can have
no contact."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

from cramlite.model import Robot, RobotMount, Thing, Value, World

from ...shapes.bounds import radius

APART = 0.1
"""Distance below which two things may come into contact, as in a settling stack [m]."""


class Apart(Value):
    """Names of the things that no hand comes near, and the pairs of such things that cannot touch each other.

    Args:
        far: names of things that no hand comes to.
        pairs: of names of things that are both far, and apart from each other.
    """

    far: frozenset[str] = frozenset()
    pairs: frozenset[frozenset[str]] = frozenset()

    def never_meet(self, one: str, other: str, pad: bool) -> bool:
        """Check whether two named bodies can never be in contact; ``pad``: one of them is a finger."""
        return frozenset((one, other)) in self.pairs or (pad and bool({one, other} & self.far))


def far_apart(world: World, robots: Mapping[str, Robot]) -> Apart:
    """Find the movable things that no robot can reach, and the pairs of them that can never touch; none
    without a fixed robot.

    Args:
        robots: descriptions by type, for the world's mounts.
    """
    loose = [t for t in world.things if not t.furniture]
    if not world.robots or any(robots[m.type].platform for m in world.robots):
        return Apart()  # hands go anywhere, and so does a robot that drives
    load = 2.0 * max(map(radius, loose), default=0.0)
    far = [t for t in loose if all(_beyond(t, m, robots[m.type], load) for m in world.robots)]
    pairs = (frozenset((a.name, b.name)) for a, b in itertools.combinations(far, 2) if _far_from_each_other(a, b))
    return Apart(frozenset(t.name for t in far), frozenset(pairs))


def _beyond(thing: Thing, mount: RobotMount, robot: Robot, load: float) -> bool:
    """Whether a thing is farther from the axis of an arm's base than flange, gripper and payload reach."""
    x, y, _ = (robot.arm_at(mount.base) * robot.root).inverse().apply(thing.pose.position).tolist()
    tool = math.hypot(*robot.gripper.tcp.position)
    return math.hypot(x, y) - radius(thing) > robot.reach + tool + load


def _far_from_each_other(one: Thing, other: Thing) -> bool:
    return math.dist(one.pose.position, other.pose.position) > radius(one) + radius(other) + APART

"""Sides of a thing in goals: left, right, in front, behind and near, as seen from the robot's base."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..model.geometry import Pose, Vector3
    from ..model.world.world import World

SIDES: Mapping[str, tuple[int, float]] = {
    "left_of": (1, 1.0), "right_of": (1, -1.0), "behind": (0, 1.0), "in_front_of": (0, -1.0)
}  # fmt: skip
"""Side of a thing -> axis of the robot's base, and sign of the direction to that side: x points forwards, y to the left."""
NEAR = 0.2
"""Largest horizontal distance between the origins of things that are beside one another [m]: the default of ``where: {within}`` of a
task, too."""
ASIDE = 0.01
"""Least distance by which a thing is left, right, in front or behind of another [m]: half of the distance that places are chosen by, as
the release may shift the thing by the rest."""


def wrong_side(side: str, other: str, at: Vector3, others: Vector3, base: Pose) -> str:
    """Describe why a thing is not on a side of another one; "" if it is.

    Args:
        side: of ``SIDES``, or "near".
        other: name of the other thing.
        at, others: positions of both in the world [m].
        base: of the robot in the world.
    """
    one, two = (base.inverse().apply(p) for p in (at, others))
    if side not in SIDES:
        gap = math.dist(one[:2], two[:2])
        return "" if gap <= NEAR else f"it is {1000 * gap:.0f} mm from '{other}', up to {1000 * NEAR:.0f} mm count as near"
    axis, sign = SIDES[side]
    by = sign * float(one[axis] - two[axis])
    said = f"it is {1000 * by:.0f} mm {side.replace('_', ' ')} '{other}', at least {1000 * ASIDE:.0f} mm are needed"
    return "" if by >= ASIDE else said


def is_on_side(world: World, side: str, thing: str, other: str) -> bool:
    """Return whether a thing is on a side of another one in a world, as seen from its first robot."""
    one, two = (world.thing(n).pose.position for n in (thing, other))
    return bool(world.robots) and not wrong_side(side, other, one, two, world.robots[0].base)

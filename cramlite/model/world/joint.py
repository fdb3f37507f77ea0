"""Joints between things and what they are mounted in."""

from __future__ import annotations

import math
from typing import Literal, TypeVar

from ...base.value import Value
from ..geometry import Floats, Pose

V = TypeVar("V", float, Floats)


class Joint(Value):
    """Prismatic or revolute joint between a thing and its carrier: a drawer slides, a door turns.

    Args:
        kind: along, or about, the z axis of ``pose``.
        pose: of the joint, in the thing's frame.
        lower, upper: its range [m, rad]; at the lower end the thing is closed, unless a spring draws it to a ``rest`` between both ends.
        value: at the start, where the thing's own pose says that it is [m, rad].
        parent: the thing that it is mounted in, which stands still, or moves on a joint itself, as a door with its lever; "" for none.
        damping: [N s/m, Nm s/rad].
        friction: dry friction [N, Nm].
        meets: whether it collides with what it is mounted in, as a drawer between the walls of another program's cabinet.
        spring: stiffness of the spring that draws it to ``rest`` [N/m, Nm/rad]; 0 for none.
        rest: value at which the spring is slack [m, rad].
        pitch: way of a hinge along its axis in one turn, as of a thread [m]; 0 for none. Only a thread tells one turn from the next.
    """

    kind: Literal["slide", "hinge"]
    pose: Pose
    lower: float
    upper: float
    value: float = 0.0
    parent: str = ""
    damping: float = 5.0
    friction: float = 1.0
    meets: bool = False
    spring: float = 0.0
    rest: float = 0.0
    pitch: float = 0.0

    def moved(self, thing: Pose, by: float) -> Pose:
        """Return the pose of a thing, now at the pose ``thing``, after its joint has moved by ``by`` [m, rad]."""
        along = by if self.kind == "slide" else self.pitch * by / math.tau
        step = Pose((0.0, 0.0, by)) if self.kind == "slide" else Pose.from_rotvec((0.0, 0.0, along), (0, 0, by))
        return thing * self.pose * step * self.pose.inverse()

    def value_at(self, share: float) -> float:
        """Return the value at a share of the range: 0 at its lower end, 1 at its upper one [m, rad]."""
        return self.lower + share * (self.upper - self.lower)

    def share(self, value: float) -> float:
        """Return the share of the range, from its lower end, at which a value is; the inverse of ``value_at``."""
        return (value - self.lower) / (self.upper - self.lower)

    @property
    def closed(self) -> float:
        """Value at which the thing is closed: the lower end, or the rest of its spring, if that is between the ends [m, rad]."""
        return min(self.rest, self.upper) if self.spring and self.rest > self.lower else self.lower

    def opening(self, value: float) -> float:
        """Return how far the thing is open at a value of its joint, as a share from 0 (closed) to 1."""
        return opened(value, self.lower, self.upper, self.closed)

    def between(self, thing: Pose, other: Pose) -> float:
        """Return the displacement of the joint from one pose of its thing to another [m, rad]."""
        step = (thing * self.pose).inverse() * (other * self.pose)
        if self.kind == "slide":
            return step.position[2]
        turn = float(step.rotvec[2])
        return turn + math.tau * round(step.position[2] / self.pitch - turn / math.tau) if self.pitch else turn


def opened(values: V, lower: float, upper: float, closed: float) -> V:
    """Return how far a thing is open at values of its joint, as shares from 0 (closed) to 1; below its lower end, less than 0.

    Args:
        lower, upper: the range.
        closed: value at which it is closed; if it is between both ends, the thing opens either way.
    """
    if closed <= lower:
        return (values - lower) / ((upper - lower) or 1.0)
    return abs(values - closed) / max(upper - closed, closed - lower)

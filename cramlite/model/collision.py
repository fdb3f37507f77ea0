"""Collision that planning found: two bodies that are too near one another, with the robot's state, so that it
can be drawn."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import field

from ..base.value import Value
from .geometry import Pose


class Collision(Value):
    """Collision of two bodies in a state of a robot among things.

    Args:
        one, other: the bodies, as in ``Touch``: "thing", "thing/part", "effector/left", "mount/link".
        depth: how far they are inside each other; negative for a distance that is too small [m].
        robot: the mount that moves, and ``base``, where it stands in the world.
        joints: of its arm [rad].
        opening: of its fingers [m].
        held: what is in the hand -> its pose in the TCP frame.
        moved: things that are not where the world has them at the start -> pose in the world.
    """

    one: str
    other: str
    depth: float
    robot: str
    base: Pose
    joints: tuple[float, ...]
    opening: float
    held: Mapping[str, Pose] = field(default_factory=dict)
    moved: Mapping[str, Pose] = field(default_factory=dict)

    @property
    def pair(self) -> tuple[str, str]:
        """Return the names of both bodies, sorted."""
        return (self.one, self.other) if self.one <= self.other else (self.other, self.one)

    def __str__(self) -> str:
        if self.depth > 0:
            return f"'{self.one}' is {self.depth * 1e3:.1f} mm inside '{self.other}'"
        return f"'{self.one}' is only {-self.depth * 1e3:.1f} mm from '{self.other}'"

"""Interfaces of the planner's joint space: limits, metric, and the reasons why a joint position is
refused."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Protocol

import numpy as np
from msgspec import field

from cramlite.model import Collision, Floats, Remedy, Value
from cramlite.plugin import InTheWay, Refused

from .joint_line import PROBED

Joints = tuple[float, ...]


class FreeLines(Protocol):
    """Interface of a joint space in which a planner looks for a path and shortens it."""

    def line_free(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> bool:
        """Check whether the straight joint-space line from a free position is free."""


class FreeBlends(FreeLines, Protocol):
    """Interface of a joint space in which the corners of a path are rounded off."""

    def blend_free(self, start: Floats, corner: Floats, goal: Floats) -> bool:
        """Check that the parabola that rounds the corner of a joint path is free; the positions at its
        ends are known to be free."""

    def tip(self, q: Sequence[float] | Floats) -> Floats:
        """Return the position (3,) of the tcp [m]."""


class Space(FreeBlends, Protocol):
    """Interface of a planner's joint space, which ``planning_scene.PlanningScene`` implements."""

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """Return the limits (lower, upper) of each joint [rad]."""

    def line_probed(
        self, a: Sequence[float] | Floats, b: Sequence[float] | Floats, apart: float = PROBED
    ) -> bool:
        """Check the end and some places, at most ``apart`` [rad], of a straight joint-space line from a free
        position: quick, but not every part is checked."""

    def where_blocked(self, lines: Sequence[tuple[Joints, Joints]]) -> list[Joints | None]:
        """Return a blocked joint position on each of some straight joint-space lines from free positions,
        None where one is free."""

    def free(self, q: Sequence[float] | Floats) -> bool:
        """Check whether the arm is inside its limits and keeps its clearance at a joint position [rad]."""

    def blocked(self, a: Sequence[float], b: Sequence[float]) -> float | None:
        """Return the fraction of the straight joint-space line where it is first blocked; None when it is
        free."""

    def why(self, q: Sequence[float]) -> str:
        """Explain in words and numbers why a joint position is not free; "" if it is free."""

    def blocking(self, q: Sequence[float]) -> tuple[str, ...]:
        """Return the things, sorted, all of which must be moved before a joint position can be free; empty
        if moving things cannot free it."""

    def collision(self, q: Sequence[float]) -> Collision | None:
        """Return the deepest collision at a joint position; None without a collision, or outside the joint
        limits."""

    def relaxed(self, anchors: Sequence[Sequence[float]]) -> Space:
        """Return this scene with less clearance required near some joint positions (``anchors``), where the
        arm has less."""


class Probed(Value):
    """Joint space in which lines are checked only at places some distance apart; a path found in it needs a
    full check later.

    Args:
        space: in which states are looked at.
        apart: distance of the places, largest joint difference [rad].
        missed: blocked joint positions between such places; lines are also probed where they come nearest to
            these.
    """

    space: Space
    apart: float
    missed: list[Joints] = field(default_factory=list)

    def line_free(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> bool:
        """Check places on a straight joint-space line from a free position, and its end."""
        return self._beside(a, b) and self.space.line_probed(a, b, self.apart)

    def _beside(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> bool:
        """Whether a line is free where it comes nearest to what probes missed."""
        if not self.missed:
            return True
        start, way = np.asarray(a), np.subtract(b, a)
        parts = ((np.array(self.missed) - start) @ way / max(float(way @ way), 1e-12)).clip(0.0, 1.0)
        return all(map(self.space.free, (start + parts[:, None] * way).tolist()))


class Twice(Value):
    """Joint space in which lines are probed, and then checked all along: probes, which cost less, find most
    blocked lines.

    Args:
        space: in which states are looked at.
    """

    space: Space

    def line_free(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> bool:
        """Check whether the straight joint-space line from a free position is free."""
        return self.space.line_probed(a, b) and self.space.line_free(a, b)


def all_of(stopped: Collection[Refused]) -> tuple[tuple[str, ...], ...]:
    """Return the things that must all be moved to free a way on which several refusals lie, as one set; ()
    if no task can move some obstacle on it."""
    if not all(no.blocking for no in stopped):
        return ()
    return (tuple(sorted(frozenset[str]().union(*(no.in_the_way for no in stopped)))),)


def refusal(
    reason: str,
    *,
    blocking: InTheWay = (),
    collision: Collision | None = None,
    remedy: Remedy | None = None,
    **numbers: float,
) -> Refused:
    """Make a refusal without the name of the alternative that it refuses; the name is added later (see
    ``Refused.of``).

    Args:
        reason: a clause with numbers.
        blocking: the movable things that are in the way; None where that is not known.
        collision: the state that the reason speaks of, where that is a collision.
        remedy: what is missing and what to try.
        numbers: "samples" of a search, "truncated" where the wall clock ended it, "fraction" of a straight
            motion that was reached.
    """
    return Refused("", reason, numbers=numbers, blocking=blocking, collision=collision, remedy=remedy)

"""The joint space that paths are planned in: its limits and metric, and why a state is refused."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from cramlite.model import Floats, Value

Joints = tuple[float, ...]


class Space(Protocol):
    """What a planner needs to know of a scene (``scene.Scene`` is one)."""

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """(lower, upper) of each joint [rad]."""

    def free(self, q: Sequence[float] | Floats) -> bool:
        """Whether the arm is inside its limits and keeps its clearance there."""

    def line_free(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> bool:
        """Whether the straight joint-space line from a free position is free."""

    def blocked(self, a: Sequence[float], b: Sequence[float]) -> float | None:
        """The fraction of the straight joint-space line where it is first blocked; None when it is free."""

    def why(self, q: Sequence[float]) -> str:
        """What is in the way, as a clause with numbers; empty when free."""

    def tip(self, q: Sequence[float] | Floats) -> Floats:
        """The position of the tcp (3,) [m]."""

    def relaxed(self, anchors: Sequence[Sequence[float]]) -> Space:
        """The same scene, asking near each of these positions for no more clearance than there is at it."""


class Refusal(Value):
    """Why there is no path, as a clause with numbers.

    Args:
        samples: tree extensions that were spent.
        truncated: the wall clock ended the search: another run may find a path.
        fraction: of a straight motion, how much of it was reached.
    """

    reason: str
    samples: int = 0
    truncated: bool = False
    fraction: float = 0.0

"""Turns that demonstrations share: the hand turns a thing about an axis farther than a wrist turns, in several grasps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np

from ..base.value import Value
from ..interpretation.turn_predicate import turn_in_hand
from ..model.geometry import Vector3, vector3
from ..model.robot import WRIST_TURN
from .span import Span

LEAST = 1.5 * math.pi
"""Least angle of a learned turn [rad]: no wrist turns so far in one grasp, and known tasks turn things in one grasp."""
ENOUGH, TOO_FAR = 0.75, 1.25
"""Share of the smallest demonstrated turn, and multiple of the largest one, between which a turn counts as the learned one."""
AGREED, ASLANT = 1.5, math.cos(math.radians(15))
"""Largest ratio of the examples' angles of turn, and least cosine of the angle between a turn's axis and the common axis."""


class ShownTurn(Value):
    """Rotation that all examples of a task show: of a thing, about an axis of its own frame.

    Args:
        axis: in the thing's frame, of length 1, about which the turn is positive.
        angle: mean of the examples [rad].
        least, most: between which it is this turn [rad].
        things: that are turned, one for each example.
    """

    axis: Vector3
    angle: float
    least: float
    most: float
    things: tuple[str, ...]

    @property
    def strokes(self) -> int:
        """Number of grasps that a robot needs for the whole shown turn; between them it regrasps the
        thing."""
        return math.ceil(self.angle / WRIST_TURN)


def shown_turn(spans: Sequence[Span]) -> ShownTurn | None:
    """Return the turn that all examples share; None where they share none."""
    each = [{n: turn_in_hand(s.timeline.episode, n, (s.start, s.end)) for n in s.things} for s in spans]
    far = [[n for n, turn in turns.items() if np.linalg.norm(turn) >= LEAST] for turns in each]
    for things in product(*far):
        first = spans[0].timeline.types(things[0])[:1]
        turns = np.array([turns[n] for turns, n in zip(each, things, strict=True)])
        sizes = np.linalg.norm(turns, axis=1)
        mean = (turns / sizes[:, None]).mean(axis=0)
        axis = mean / max(float(np.linalg.norm(mean)), 1e-9)
        alike = all(s.timeline.types(n)[:1] == first for s, n in zip(spans, things, strict=True))
        if alike and (turns @ axis >= ASLANT * sizes).all() and sizes.max() <= AGREED * sizes.min():
            bounds = ENOUGH * float(sizes.min()), TOO_FAR * float(sizes.max())
            way = vector3(np.round(axis, 3) + 0.0)
            return ShownTurn(way, round(float(sizes.mean()), 2), round(bounds[0], 2), round(bounds[1], 2), things)
    return None

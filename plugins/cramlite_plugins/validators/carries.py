"""Carries: times at which the hand takes a thing along by touching it, without holding it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cramlite.model import Pose, Rollout, thing_of

from ..shapes.bounds import corners
from .slides import stretches


class Carry(NamedTuple):
    """Motion of a thing that the hand takes along without holding it.

    Args:
        way: of that point of the thing that is taken farthest [m]: of its way, what points where the hand would lead it, and no more
            than the hand would.
        first, last: samples of the beginning of the touch and of the farthest way.
    """

    way: float
    first: int
    last: int


def carries(rollout: Rollout, thing: str, within: range) -> Iterator[Carry]:
    """Yield how far the hand takes a thing along by touching it, for each stretch of samples with touch; 0
    for a hand at rest."""
    near = [k for k in within if _touched(rollout, thing, k)]
    for stretch in stretches(near, rollout):
        yield _carry(rollout, thing, stretch)


def _touched(rollout: Rollout, thing: str, sample: int) -> bool:
    pairs = ({thing_of(t.a), thing_of(t.b)} for t in rollout.touches[sample])
    return {"effector", thing} in pairs


def _carry(rollout: Rollout, thing: str, stretch: list[int]) -> Carry:
    points = corners(rollout.world.thing(thing), Pose())
    there = np.array([Pose.from_row(rollout.poses[thing][k]).apply(points) for k in stretch])
    in_hand = Pose.from_row(rollout.poses["effector"][stretch[0]]).inverse().apply(there[0])
    led = np.array([Pose.from_row(rollout.poses["effector"][k]).apply(in_hand) for k in stretch]) - there[0]
    far = np.linalg.norm(led, axis=2)
    along = np.sum((there - there[0]) * led, axis=2) / np.maximum(far, 1e-9)
    ways = np.minimum(along, far).max(axis=1)
    k = int(np.argmax(ways))
    return Carry(float(ways[k]), stretch[0], stretch[k])

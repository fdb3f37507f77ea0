"""Slides: stretches in which a payload moves along something that it touches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cramlite.model import Floats, Rollout, thing_of

from ..shapes.mounts import mounts
from .grips import Grip

GAP = 0.2
"""Contact that is lost for less goes on [s]: payloads that slide or rattle leap (as ``collision.GAP``)."""


class Slide(NamedTuple):
    """Way of a payload along something that it touches all the while.

    Args:
        thing, along: the payload, and what it touches.
        way: of the payload's origin in the frame of ``along``, from where the contact began to its furthest point [m].
        first, last: samples of the beginning and of the furthest point.
    """

    thing: str
    along: str
    way: float
    first: int
    last: int


def slides(rollout: Rollout, grip: Grip, within: range) -> Iterator[Slide]:
    """Yield every slide of a grip's payload that begins and ends within some samples."""
    for other, samples in _touched(rollout, grip, within).items():
        for stretch in _stretches(rollout, samples):
            yield _slide(rollout, grip.thing, other, stretch)


def _touched(rollout: Rollout, grip: Grip, within: range) -> dict[str, list[int]]:
    """What the payload touches beside the hand and its own mounts, and at which samples."""
    found = dict[str, list[int]]()
    things = {t.name: t for t in rollout.world.things}
    own = {grip.thing, *mounts(things[grip.thing], rollout.world)}
    for k in range(max(grip.first, within.start), min(grip.last + 1, within.stop)):
        pairs = ((thing_of(t.a), thing_of(t.b)) for t in rollout.touches[k])
        others = {b if a == grip.thing else a for a, b in pairs if grip.thing in (a, b)}
        for other in (others - own) & things.keys():
            found.setdefault(other, []).append(k)
    return found


def _stretches(rollout: Rollout, samples: list[int]) -> Iterator[list[int]]:
    """Samples of a contact, parted where it was lost for longer than ``GAP``."""
    breaks = np.flatnonzero(np.diff(rollout.times[samples]) > GAP) + 1
    yield from (list(map(int, part)) for part in np.split(np.array(samples), breaks))


def _slide(rollout: Rollout, thing: str, along: str, stretch: list[int]) -> Slide:
    track = _in_frame(rollout.poses[along][stretch], rollout.poses[thing][stretch, :3])
    ways = np.linalg.norm(track - track[0], axis=1)
    k = int(np.argmax(ways))
    return Slide(thing, along, float(ways[k]), stretch[0], stretch[k])


def _in_frame(frames: Floats, points: Floats) -> Floats:
    """(N, 3) points in frames (N, 7) that move [m]."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_quat(frames[:, 3:], scalar_first=True).inv()
    found: Floats = turns.apply(points - frames[:, :3])
    return found



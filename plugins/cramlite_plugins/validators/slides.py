"""Slides: stretches in which a payload moves along something that it touches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cramlite.model import Floats, Rollout, thing_of

from ..shapes.bounds import box_around
from ..shapes.mounts import mounts
from .grips import Grip

GAP = 0.2
"""Contact that is lost for less goes on [s]: payloads that slide or rattle leap (as ``collision.GAP``)."""
SKIMS = 0.003
"""A payload that rises by less than this after a contact skims what it touched [m]: a stiff arm leads it 0.1 mm above."""


_CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


class Slide(NamedTuple):
    """Way of a payload along something that it touches all the while.

    Args:
        thing, along: the payload, and what it touches.
        way: in the frame of ``along``, since the contact began, of that point of the payload that moves least [m]: a payload that
            turns about an edge, or on the spot, does not slide.
        first, last: samples of the beginning and of the furthest way.
    """

    thing: str
    along: str
    way: float
    first: int
    last: int


def slides(rollout: Rollout, grip: Grip, within: range) -> Iterator[Slide]:
    """Yield every slide of a grip's payload that begins and ends within some samples."""
    last = min(grip.last, within.stop - 1)
    for other, samples in _touched(rollout, grip, within).items():
        for stretch in _stretches(rollout, samples, grip.thing, last):
            yield _slide(rollout, grip.thing, other, list(stretch))


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


def _stretches(rollout: Rollout, samples: list[int], thing: str, last: int) -> Iterator[range]:
    """Stretches of a contact, up to a last sample: it goes on while the payload skims, or for as long as ``GAP``."""
    heights = rollout.poses[thing][:, 2]
    first = end = samples[0]
    for k in [*samples[1:], last]:
        between = heights[end : k + 1]
        if rollout.times[k] - rollout.times[end] <= GAP or np.abs(between - between[0]).max() < SKIMS:
            end = k
            continue
        yield range(first, _skims(heights, end, k) + 1)
        first = end = k
    if first < end:
        yield range(first, end + 1)


def _skims(heights: Floats, sample: int, until: int) -> int:
    """The last sample up to which a payload stays near the height that it had at another one."""
    risen = np.flatnonzero(np.abs(heights[sample:until] - heights[sample]) >= SKIMS)
    return sample + int(risen[0]) - 1 if len(risen) else until - 1


def _slide(rollout: Rollout, thing: str, along: str, stretch: list[int]) -> Slide:
    low, high = box_around(rollout.world.thing(thing).geoms)
    points = np.vstack([np.zeros(3), low + _CORNERS * (high - low)])
    tracks = np.array([_in_frame(rollout.poses[along][stretch], _of_point(rollout.poses[thing][stretch], p)) for p in points])
    ways = np.linalg.norm(tracks - tracks[:, :1], axis=2).min(axis=0)
    k = int(np.argmax(ways))
    return Slide(thing, along, float(ways[k]), stretch[0], stretch[k])


def _of_point(poses: Floats, point: Floats) -> Floats:
    """(N, 3) a point of a body with poses (N, 7), in the world [m]."""
    from scipy.spatial.transform import Rotation

    found: Floats = Rotation.from_quat(poses[:, 3:], scalar_first=True).apply(point) + poses[:, :3]
    return found


def _in_frame(frames: Floats, points: Floats) -> Floats:
    """(N, 3) points in frames (N, 7) that move [m]."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_quat(frames[:, 3:], scalar_first=True).inv()
    found: Floats = turns.apply(points - frames[:, :3])
    return found

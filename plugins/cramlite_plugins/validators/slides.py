"""Slides: stretches in which a payload moves along something that it touches."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cramlite.model import Pose, Rollout, thing_of

from ..shapes.bounds import corners
from ..shapes.joints import mounts
from .grips import Grip

GAP = 0.2
"""Longest gap in a contact that still continues [s]: sliding and rattling payloads lose contact for moments (as ``collision.GAP``)."""
SKIMS = 0.003
"""Largest rise of a payload after a contact at which it still slides along the touched thing [m]: a stiff arm leads it 0.1 mm above."""


class Slide(NamedTuple):
    """Slide of a payload along a thing while the two stay in contact.

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
    """Yield every slide of a grip's payload that begins and ends within the given samples."""
    rows = [k for k in range(grip.first, grip.last + 1) if k in within]
    touched = _touched(rollout, grip.thing, rows)
    for other in sorted(set().union(*touched)):
        near = _near(rollout, grip.thing, {k for k, names in zip(rows, touched, strict=True) if other in names}, rows)
        for stretch in stretches(near, rollout):
            yield _slide(rollout, grip.thing, other, stretch)


def stretches(near: list[int], rollout: Rollout) -> Iterator[list[int]]:
    """Yield the stretches of samples in contact, divided where contact is lost for longer than ``GAP``."""
    breaks = [n for n, (a, b) in enumerate(pairwise(near), 1) if rollout.times[b] - rollout.times[a] > GAP]
    yield from (near[first:end] for first, end in pairwise((0, *breaks, len(near))) if end > first)


def _touched(rollout: Rollout, thing: str, rows: list[int]) -> list[set[str]]:
    """Names of the things that the payload touches at each of the samples ``rows``, without the hand and the mounts of the payload's
    joint."""
    things = {t.name: t for t in rollout.world.things}
    others = things.keys() - {thing, *mounts(things[thing], rollout.world)}
    pairs = ([{thing_of(t.a), thing_of(t.b)} for t in rollout.touches[k]] for k in rows)
    return [set().union(*(pair for pair in row if thing in pair)) & others for row in pairs]


def _near(rollout: Rollout, thing: str, touching: set[int], rows: list[int]) -> list[int]:
    """Samples at which a payload touches a certain thing, or has moved up or down by less than ``SKIMS``
    since it last touched that thing."""
    near, heights, last = list[int](), rollout.poses[thing][:, 2], -1
    for k in rows:
        last = k if k in touching else last
        if last >= 0 and abs(heights[k] - heights[last]) < SKIMS:
            near.append(k)
        elif rollout.times[k] - rollout.times[last] > GAP:
            last = -1
    return near


def _slide(rollout: Rollout, thing: str, along: str, stretch: list[int]) -> Slide:
    points = np.vstack([np.zeros(3), corners(rollout.world.thing(thing), Pose())])
    track = np.array([_relative(rollout, along, thing, k).apply(points) for k in stretch])
    ways = np.linalg.norm(track - track[0], axis=2).min(axis=1)
    k = int(np.argmax(ways))
    return Slide(thing, along, float(ways[k]), stretch[0], stretch[k])


def _relative(rollout: Rollout, frame: str, thing: str, sample: int) -> Pose:
    """The pose of a thing in the frame of another at a sample."""
    return Pose.from_row(rollout.poses[frame][sample]).inverse() * Pose.from_row(rollout.poses[thing][sample])

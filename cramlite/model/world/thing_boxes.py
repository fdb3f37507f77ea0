"""Axis-aligned boxes around the geoms of a thing, and the size of the thing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..geometry import Pose, Vector3
from .thing import Geom, Thing

CENTRED = 0.5
"""Largest offset of a thing's middle from the axis of its joint, as a share of half its width, at which the thing counts as turning in
place."""
Box = tuple[Vector3, Vector3]
"""Axis-aligned box, given by its lower and its upper corner [m]."""


def boxes(thing: Thing) -> list[Box]:
    """Return the box around each geom of a thing, along the world's axes."""
    return [box(thing.pose * g.pose, g) for g in thing.geoms]


def extents(thing: Thing) -> Vector3:
    """Return the side lengths of the box around a thing with geoms, along its own axes [m]."""
    low, high = around([box(g.pose, g) for g in thing.geoms])
    return (high[0] - low[0], high[1] - low[1], high[2] - low[2])


def turns_in_place(thing: Thing) -> bool:
    """Return whether a thing takes up the same space at any angle of its joint, as a knob does.

    That is assumed if its middle is near the axis.
    """
    if thing.joint is None or thing.joint.kind != "hinge" or not thing.geoms:
        return False
    low, high = around([box(thing.joint.pose.inverse() * g.pose, g) for g in thing.geoms])
    off = math.hypot(low[0] + high[0], low[1] + high[1]) / 2
    return off <= CENTRED * min(high[0] - low[0], high[1] - low[1]) / 2


def around(found: Sequence[Box]) -> Box:
    """Return the smallest box around several boxes, of which there must be at least one."""
    low, high = np.min([b[0] for b in found], axis=0).tolist(), np.max([b[1] for b in found], axis=0).tolist()
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def box(pose: Pose, geom: Geom) -> Box:
    """Return the box around a geom at a pose, along the axes of that pose's parent."""
    reach = abs(pose.rotation) @ geom.half_extents
    low, high = ([p + s * r for p, r in zip(pose.position, reach.tolist(), strict=True)] for s in (-1.0, 1.0))
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])

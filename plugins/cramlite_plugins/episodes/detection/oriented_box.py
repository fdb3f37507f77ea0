"""Oriented bounding boxes of things: distance, overlap and containment.

Separating axes (Gottschalk, Lin, Manocha: OBBTree, SIGGRAPH 1996): two boxes are apart if their projections onto one of
15 directions are, six face normals and nine cross products of edges.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np

from cramlite.model import Entity, Episode, Floats, Value

from ...shapes.bounds import box_around

_UP = np.array([0.0, 0.0, 1.0])


class OrientedBox(Value):
    """Oriented bounding box in the world frame.

    Args:
        corners: (8, 3) [m].
        axes: (3, 3), the directions of its edges as columns.
    """

    corners: Floats
    axes: Floats

    @property
    def low(self) -> float:
        """Height of the box's lowest corner in the world frame [m]."""
        return float(self.corners[:, 2].min())

    @property
    def high(self) -> float:
        """Height of the box's highest corner in the world frame [m]."""
        return float(self.corners[:, 2].max())

    @property
    def centre(self) -> Floats:
        """Centre of the box [m]."""
        middle: Floats = self.corners.mean(axis=0)
        return middle

    def sides(self) -> list[Floats]:
        """Return the horizontal normals of the box's outline seen from above, unit vectors (3,)."""
        return _directions(np.cross(_UP, axis) for axis in self.axes.T)


def box_of(episode: Episode, entity: Entity, time: float) -> OrientedBox | None:
    """Return the bounding box of an entity's primitives, along its own axes; None if its pose or extents are unknown.

    Where only its size is known, the box is taken as centred on its frame.
    """
    pose = episode.pose_at(entity.name, time)
    if pose is None or (entity.size is None and not entity.geoms):
        return None
    if entity.geoms:
        low, high = box_around(entity.geoms)
    else:
        high = np.array(entity.size) / 2
        low = -high
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    return OrientedBox(pose.apply(corners), pose.rotation)


def separation(a: OrientedBox, b: OrientedBox) -> float:
    """Return the separation of two boxes along the axis that separates them most [m]; 0 where they overlap.

    It is never more than their distance, and equals it where a face looks at a corner, or corner at corner.
    """
    offsets = b.corners[None] - a.corners[:, None]
    nearest = offsets.reshape(-1, 3)[np.argmin(np.sum(offsets**2, axis=2))]
    crossed = (np.cross(p, q) for p, q in itertools.product(a.axes.T, b.axes.T))
    return max(0.0, _separation(a, b, [*a.axes.T, *b.axes.T, *_directions([*crossed, nearest])]))


def over(a: OrientedBox, b: OrientedBox) -> bool:
    """Check whether two boxes overlap, seen from above."""
    return _separation(a, b, [*a.sides(), *b.sides()]) < 0


def is_inside_outline(inner: OrientedBox, outer: OrientedBox, slack: float) -> bool:
    """Check whether one box is inside the outline of another, seen from above, with a tolerance [m]."""
    return all(
        float((outer.corners @ n).min()) - slack <= float((inner.corners @ n).min())
        and float((inner.corners @ n).max()) <= float((outer.corners @ n).max()) + slack
        for n in outer.sides()
    )


def _separation(a: OrientedBox, b: OrientedBox, directions: Iterable[Floats]) -> float:
    """Return the widest gap between two boxes along one of several directions [m]; negative if they overlap
    along all."""
    found = []
    for n in directions:
        p, q = a.corners @ n, b.corners @ n
        found.append(max(float(p.min() - q.max()), float(q.min() - p.max())))
    return max(found)


def _directions(vectors: Iterable[Floats]) -> list[Floats]:
    """Vectors scaled to length 1; those shorter than 1e-9 are left out, such as the cross product of parallel
    edges."""
    lengths = [(v, float(np.linalg.norm(v))) for v in vectors]
    return [v / length for v, length in lengths if length > 1e-9]

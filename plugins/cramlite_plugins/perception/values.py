"""Values that perception experts exchange: boxes, clouds, planes, segments, extents."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Value

if TYPE_CHECKING:
    from cramlite.model import Mask

Points32 = NDArray[np.float32]


class Box(Value):
    """Axis-aligned box of the world frame: lower and upper corner [m]."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]

    def contains(self, points: NDArray[np.floating]) -> Mask:
        """Check which of the points (..., 3) are inside of the box; NaN is outside."""
        inside = (points >= np.array(self.low)) & (points <= np.array(self.high))
        return np.asarray(inside.all(axis=-1))


class Cloud(Value, eq=False):
    """Organised point cloud: (height, width, 3) points of the world frame [m], and the mask of the points of
    interest."""

    points: Points32
    mask: Mask


class Plane(Value, eq=False):
    """Plane n . p = offset [m] whose normal points to the camera; ``share`` of the points lies on it, over ``extent`` [m]."""

    normal: Points32
    offset: float
    share: float
    extent: float

    def distance(self, points: NDArray[np.floating]) -> NDArray[np.floating]:
        """Return the signed distances (...) of points (..., 3) from the plane [m], positive on the camera's side."""
        return np.asarray(points @ self.normal.astype(points.dtype) - points.dtype.type(self.offset))


class Segment(Value, eq=False, dict=True):
    """Image segment that may be one object: a mask of the whole image."""

    mask: Mask

    @cached_property
    def count(self) -> int:
        """Return the number of pixels of the segment."""
        return int(np.count_nonzero(self.mask))


class Extents(Value):
    """Extents of an object, along the vertical and in the horizontal plane [m].

    Args:
        height: vertical.
        width, depth: of the smallest rectangle around it from above; width is the larger.
        centre: of the box that these make, world frame.
        yaw: of the width's direction about the vertical [rad].
    """

    height: float
    width: float
    depth: float
    centre: tuple[float, float, float]
    yaw: float

    @property
    def longest(self) -> float:
        """Return the largest of an object's height, width and depth [m]."""
        return max(self.height, self.width, self.depth)

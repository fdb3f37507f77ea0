"""What the shipped experts hand to each other."""

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
    """An axis-aligned box of the world frame: lower and upper corner [m]."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]

    def holds(self, points: NDArray[np.floating]) -> Mask:
        """Which of (..., 3) points are inside; NaN is outside."""
        inside = (points >= np.array(self.low)) & (points <= np.array(self.high))
        return np.asarray(inside.all(axis=-1))


class Cloud(Value, eq=False):
    """A cut-out of a view: (height, width, 3) points of the world frame, and which of them are meant."""

    points: Points32
    mask: Mask


class Plane(Value, eq=False):
    """n . p = offset, the normal pointing to the camera; ``share`` of the points lies on it, over ``extent`` [m]."""

    normal: Points32
    offset: float
    share: float
    extent: float

    def distance(self, points: NDArray[np.floating]) -> NDArray[np.floating]:
        """Signed distances of (..., 3) points [m], positive on the camera's side."""
        return np.asarray(points @ self.normal.astype(points.dtype) - points.dtype.type(self.offset))


class Segment(Value, eq=False, dict=True):
    """A part of the image that may be one object: a mask of the whole image."""

    mask: Mask

    @cached_property
    def count(self) -> int:
        return int(np.count_nonzero(self.mask))


class Extents(Value):
    """How large something looks, along the vertical and in the horizontal plane [m].

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
        return max(self.height, self.width, self.depth)

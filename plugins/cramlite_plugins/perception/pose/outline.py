"""Silhouette of an object in a depth image: where it ends, and where an occluder hides it."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy import ndimage

from cramlite.model import Intrinsics, Mask, Value, View

from .model import Floats32

BORDER = 24
"""Pixels around the mask that are looked at: 37 mm at 0.6 m."""


GAP = 1
"""Half the width of gaps without depth in what shows an object [pixel]."""
SHADOW = 24
"""Widest shadow of an occluder [pixel]: eyes 50 mm apart, a focal length of 620 pixels, 0.6 m before 1.1 m."""


class Outline(Value, eq=False, dict=True):
    """Silhouette of an object: the crop of mask and depth image around it.

    Args:
        intrinsics: of the whole image; row, column: of the crop's first pixel.
        depth: (h, w) of the crop [m]; NaN where unknown.
        mask: (h, w): the object.
        unsure: (h, w): pixels beside the object that may show it or what is beside it; None if there are none.
    """

    intrinsics: Intrinsics
    row: int
    column: int
    depth: Floats32
    mask: Mask
    unsure: Mask | None = None

    @classmethod
    def of(cls, view: View, mask: Mask, edges: Mask | None = None) -> Outline:
        """Crop a view around a non-empty mask; of pixels at ``edges`` those next to the mask are unsure."""
        rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
        r, c = max(0, int(rows[0]) - BORDER), max(0, int(columns[0]) - BORDER)
        area = slice(r, int(rows[-1]) + BORDER + 1), slice(c, int(columns[-1]) + BORDER + 1)
        own = mask[area]
        unsure = None if edges is None else _unsure(view.depth[area], own, edges[area])
        return cls(view.intrinsics, r, c, view.depth[area], own, unsure)

    @property
    def strict(self) -> Outline:
        """Return the outline without unsure pixels: all beside the mask show something else."""
        return replace(self, unsure=None)

    @cached_property
    def _nearest(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Row and column of the object's nearest pixel, for each pixel."""
        rows, columns = ndimage.distance_transform_edt(~self.mask, return_distances=False, return_indices=True)
        return rows.astype(np.int32), columns.astype(np.int32)

    @cached_property
    def _hiding(self) -> Floats32:
        """Least depth [m] of anything but the object, at each pixel and those next to it; of a gap in the depth, at both its ends.

        A depth image has gaps at the edges of an occluder, so the occluder may be seen in the next pixel
        only; beside it is a shadow without depth, which one of a stereo camera's two eyes does not see.
        """
        others = np.where(self.mask | np.isnan(self.depth), np.inf, self.depth)
        return _across(np.asarray(ndimage.minimum_filter(others, 3), dtype=np.float32), np.isnan(self.depth))

    def hidden(self, flat: NDArray[np.int64], depth: Floats32) -> Mask:
        """Check which points of the object are hidden: their pixels show another thing that is at least as near, or are unsure.

        Args:
            flat: (...) flat indices of pixels of the crop.
            depth: (...) of the points that are seen there [m].
        """
        behind = self._hiding.reshape(-1)[flat] < depth + tolerance(depth)
        return np.asarray(behind if self.unsure is None else behind | self.unsure.reshape(-1)[flat])

    def pixels(self, points: Floats32) -> tuple[Floats32, Floats32, NDArray[np.int64], Mask]:
        """Project points (..., 3) of the camera's optical frame [m] to pixels of the picture's crop around an
        object.

        Returns:
            Column and row in the crop, the flat index of the nearest pixel of the crop, and whether it is inside of it.
        """
        i = self.intrinsics
        z = np.maximum(points[..., 2], np.float32(1e-3))
        u = points[..., 0] / z * np.float32(i.fx) + np.float32(i.cx - self.column)
        v = points[..., 1] / z * np.float32(i.fy) + np.float32(i.cy - self.row)
        height, width = self.mask.shape
        x, y = np.rint(u), np.rint(v)
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = (np.fmin(np.fmax(k, 0), size - 1).astype(np.int64) for k, size in ((x, width), (y, height)))  # NaN: 0
        return u, v, y * width + x, inside

    def in_view(self, points: Floats32) -> Mask:
        """Check whether the whole image, not only the crop, shows points (..., 3) of the optical frame [m]."""
        i = self.intrinsics
        z = np.maximum(points[..., 2], np.float32(1e-3))
        u, v = points[..., 0] / z * np.float32(i.fx) + np.float32(i.cx), points[..., 1] / z * np.float32(i.fy) + np.float32(i.cy)
        return np.asarray((u > -0.5) & (u < i.width - 0.5) & (v > -0.5) & (v < i.height - 0.5))

    def silhouette_error(self, points: Floats32, facing: Mask) -> tuple[tuple[NDArray[np.int64], ...], Floats32]:
        """Return the object's points that are seen outside of its mask, though nothing nearer hides them there.

        The object reaches half a pixel beyond its pixels' centres.

        Args:
            points: (..., 3) in the optical frame [m].
            facing: (...) whether they face the camera.

        Returns:
            The indices of those points, (K,) for each axis, and how far each must move sideways to be seen within the mask,
            (K, 3) [m].
        """
        u, v, flat, _ = self.pixels(points)
        which = np.nonzero(facing & ~self.mask.reshape(-1)[flat] & self.in_view(points))
        z, at = points[..., 2][which], flat[which]
        rows, columns = self._nearest
        du, dv = columns.reshape(-1)[at] - u[which], rows.reshape(-1)[at] - v[which]
        length = np.sqrt(du * du + dv * dv)
        share = np.maximum(0, 1 - 0.5 / np.maximum(length, 1e-6)) * ~self.hidden(at, z)
        sideways = [du * share * z / self.intrinsics.fx, dv * share * z / self.intrinsics.fy, np.zeros_like(z)]
        drawn = share > 0
        return tuple(k[drawn] for k in which), np.stack(sideways, axis=-1)[drawn].astype(np.float32)


def _unsure(depth: Floats32, own: Mask, edges: Mask) -> Mask:
    """Pixels at edges of depth, or without depth, beside a mask, and gaps without depth among these and the mask's pixels."""
    beside = (edges | np.isnan(depth)) & ndimage.binary_dilation(own, np.ones((3, 3)))
    closed = ndimage.binary_closing(own | beside, np.ones((3, 3)), GAP)
    return np.asarray(~own & (beside | (closed & np.isnan(depth))))


def _across(least: Floats32, gap: Mask) -> Floats32:
    """Give each pixel of a gap the least value at both ends of its gap in its row, along which stereo cameras compare their pictures; wider
    gaps than ``SHADOW`` are none of an occluder."""
    columns = np.broadcast_to(np.arange(gap.shape[1]), gap.shape)
    before = np.maximum.accumulate(np.where(gap, 0, columns), axis=1)
    after = np.minimum.accumulate(np.where(gap, gap.shape[1] - 1, columns)[:, ::-1], axis=1)[:, ::-1]
    ends = [np.take_along_axis(least, at, axis=1) for at in (before, after)]
    return np.where(gap & (after - before > SHADOW + 1), least, np.minimum(least, np.minimum(*ends)))


def tolerance(depth: Floats32) -> Floats32:
    """Return the tolerance [m] of measured depths [m]: 3 mm, and twice a D435's noise, z * z / 214 m.

    The noise is 0.09 px of disparity at 385 px and 50 mm.
    """
    return np.asarray(0.003 + 2 * depth * depth / 214, dtype=np.float32)

"""Surface of the robot itself, as its camera would see it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.model import Depth, Floats, Intrinsics, Value, View

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

BESIDE = 0.005
"""Distance along a surface from its nearest seen point up to which a measured point is before or behind it, and not beside it [m]: two
pixels of a camera at a metre."""
SLIM = 0.02
"""Distance by which a robot is wider than its model [m]: in ten pictures its points were seen up to 19 mm beside it."""
JUMP = 0.02
"""Share of the depth by which neighbouring pixels of one surface differ at most; more is the edge of a link before another."""


class OwnSurface(Value, eq=False):
    """Points of the robot's surface (N, 3) that a camera would see, in a search tree, with normals (N, 3), in the world."""

    at: Floats
    normals: Floats
    tree: cKDTree

    @classmethod
    def of(cls, view: View, own: Depth | None) -> OwnSurface | None:
        """Return the surface that a view's camera would see at a depth ``own`` of the robot [m]; None where it would see none."""
        from scipy.spatial import cKDTree

        if own is None:
            return None
        seen = view.intrinsics.rays * np.where(np.isfinite(own), own, np.nan)[..., None]
        down, right = np.gradient(seen, axis=0), np.gradient(seen, axis=1)
        normals = np.cross(right, down)
        steps = np.maximum(np.abs(down[..., 2]), np.abs(right[..., 2]))
        kept = np.isfinite(normals).all(axis=2) & (steps < JUMP * np.where(np.isfinite(own), own, 0.0))
        if not kept.any():
            return None
        facing = -normals[kept] / np.linalg.norm(normals[kept], axis=1)[:, None]
        at = view.camera.apply(seen[kept])
        return cls(at, view.camera.rotate(facing), cKDTree(at))

    def distances(self, points: Floats, rays: Floats) -> tuple[Floats, Any]:
        """Return signed distances (N,) [m] of points from the tangent planes at the surface's nearest points, and the normals
        there; of a point beside the surface its distance from the nearest point."""
        near, index = self.tree.query(points)
        normals = self.normals[index]
        away = np.einsum("ij,ij->i", points - self.at[index], normals)
        beside = near**2 - away**2 > BESIDE**2
        return np.where(beside, near, away), normals


def widened(own: Depth, intrinsics: Intrinsics) -> Depth:
    """Return the depth at which the robot would be seen [m], also beside it, where its model is too slim."""
    from scipy import ndimage

    seen = np.isfinite(own)
    if not seen.any():
        return own
    away, nearest = ndimage.distance_transform_edt(~seen, return_indices=True)
    beside: Depth = own[tuple(nearest)]
    return np.where(away * beside < SLIM * intrinsics.fx, beside, own)

"""Convex hulls of points: planes and volume."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cramlite.model import Floats, Vector3


@lru_cache(maxsize=4096)
def hull_planes(corners: tuple[Vector3, ...]) -> Floats:
    """Compute the planes (n, 4) of the convex hull of points: outward unit normal and offset, n x + d <= 0 inside."""
    from scipy.spatial import ConvexHull

    planes: Floats = np.unique(np.round(ConvexHull(corners).equations, 9), axis=0)
    return planes


@lru_cache(maxsize=4096)
def hull_volume(corners: tuple[Vector3, ...]) -> float:
    """Compute the volume of the convex hull of points [m3]."""
    from scipy.spatial import ConvexHull

    return float(ConvexHull(corners).volume)

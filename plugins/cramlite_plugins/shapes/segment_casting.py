"""Segment casting: whether straight segments pass through convex shapes, exactly along each segment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Geom

from .convex import hull_planes

SKIN = 1e-4  # overlap below which two bodies count as apart [m]


def crosses(geom: Geom, starts: Floats, ends: Floats) -> bool:
    """Check whether any segment between points (n, 3) is inside a geom by more than ``SKIN`` somewhere."""
    back = geom.pose.inverse()
    p, d = back.apply(starts), back.rotate(ends - starts)
    if geom.shape in ("box", "convex"):
        return bool(_in_planes(p, d, planes(geom)).any())
    radius = geom.size[0] - SKIN
    if geom.shape == "sphere":
        return bool((_from(p, d, np.zeros(3)) < radius).any())
    half = geom.size[1]
    flat, way = p[:, :2], d[:, :2]
    low, high = _in_slab(p[:, 2], d[:, 2], half - (SKIN if geom.shape == "cylinder" else 0.0))
    nearest = -np.einsum("ij,ij->i", flat, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-18)
    at = np.clip(nearest, low, np.maximum(low, high))
    met = (np.linalg.norm(flat + at[:, None] * way, axis=1) < radius) & (low < high)
    if geom.shape == "capsule":
        met |= np.minimum(*(_from(p, d, np.array([0.0, 0.0, z])) for z in (half, -half))) < radius
    return bool(met.any())


def planes(geom: Geom) -> Floats:
    """Compute the faces (n, 4) of a box or hull in its own frame: n x + o <= 0 inside."""
    if geom.shape == "convex":
        return hull_planes(geom.corners)
    return np.column_stack([np.concatenate([np.eye(3), -np.eye(3)]), -np.tile(geom.size, 2)])


def _in_planes(p: Floats, d: Floats, faces: Floats) -> NDArray[np.bool_]:
    """Whether each segment p .. p + d has a part inside a convex shape, deeper than ``SKIN`` below each of
    its faces."""
    slope, height = d @ faces[:, :3].T, p @ faces[:, :3].T + faces[:, 3] + SKIN
    level = np.abs(slope) < 1e-12
    at = -height / np.where(level, 1.0, slope)
    low = np.where(slope < 0, at, 0.0)
    high = np.where(slope > 0, at, 1.0)
    low[level], high[level] = 0.0, np.where(height[level] > 0, -1.0, 1.0)
    inside: NDArray[np.bool_] = low.max(axis=1).clip(min=0.0) < high.min(axis=1).clip(max=1.0)
    return inside


def _in_slab(p: Floats, d: Floats, half: float) -> tuple[Floats, Floats]:
    """Start and end of the part of each segment that is between -half and half along one coordinate, as
    shares of the segment; start > end for none."""
    level = np.abs(d) < 1e-12
    safe = np.where(level, 1.0, d)
    one, two = (-half - p) / safe, (half - p) / safe
    low, high = np.clip(np.minimum(one, two), 0.0, 1.0), np.clip(np.maximum(one, two), 0.0, 1.0)
    outside = level & (np.abs(p) > half)
    return np.where(level, np.where(outside, 1.0, 0.0), low), np.where(
        level, np.where(outside, 0.0, 1.0), high
    )


def _from(p: Floats, d: Floats, centre: Floats) -> Floats:
    """Distance of each segment from a point."""
    off = centre - p
    along = np.clip(np.einsum("ij,ij->i", off, d) / np.maximum(np.einsum("ij,ij->i", d, d), 1e-18), 0.0, 1.0)
    found: Floats = np.linalg.norm(off - along[:, None] * d, axis=1)
    return found

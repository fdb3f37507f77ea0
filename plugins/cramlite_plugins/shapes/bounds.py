"""Bounds of shapes: corners, half extents, and the lowest point of things."""

from __future__ import annotations

from typing import Any

import numpy as np

from cramlite.model import Floats, Geom, Pose, Thing, Vector3


def extents(geoms: tuple[Geom, ...]) -> Vector3 | None:
    """Compute the side lengths (3,) of the axis-aligned box around a shape [m], own frame; None without a shape."""
    if not geoms:
        return None
    low, high = zip(*(bounds(g) for g in geoms), strict=True)
    size = np.max(high, axis=0) - np.min(low, axis=0)
    return (float(size[0]), float(size[1]), float(size[2]))


def bounds(geom: Geom) -> tuple[Floats, Floats]:
    """Compute the lowest and highest corner (3,) of a primitive [m], in its thing's frame."""
    if geom.shape == "convex":
        points = geom.pose.apply(geom.corners)
        return points.min(axis=0), points.max(axis=0)
    r = np.abs(geom.pose.rotation)
    if geom.shape == "box":
        half = r @ np.asarray(geom.size)
    elif geom.shape == "sphere":
        half = np.full(3, geom.size[0])
    elif geom.shape == "capsule":
        half = r[:, 2] * geom.size[1] + geom.size[0]
    else:  # a disc of radius s across axis a reaches s*sqrt(1 - a_i^2) along axis i
        half = r[:, 2] * geom.size[1] + geom.size[0] * np.sqrt(np.maximum(0.0, 1.0 - r[:, 2] ** 2))
    position = np.asarray(geom.pose.position)
    return position - half, position + half


def lowest(thing: Thing, pose: Pose) -> float:
    """Compute the height of a thing's lowest point above its origin at an orientation [m]; negative below it.

    The support function of a box along the vertical, sum |r_z,i| h_i; round shapes by the box around them.
    """
    reach = []
    for geom in thing.geoms:
        if geom.shape == "convex":
            reach.append(float(pose.turn(geom.pose.apply(geom.corners))[:, 2].min()))
            continue
        down = (Pose((0, 0, 0), pose.quaternion) * geom.pose).rotation[2]
        centre = float(pose.turn(geom.pose.position)[2])
        end = geom.size[0] if geom.shape == "sphere" else geom.size[1] + geom.size[0] * (geom.shape == "capsule")
        half = geom.size if geom.shape == "box" else (geom.size[0], geom.size[0], end)
        reach.append(centre - float(np.abs(down) @ np.array(half)))
    return min(reach)


def corners_of(thing: Thing) -> Any:
    """Return the corners (N, 3) of the boxes around a thing's geoms, world frame [m]."""
    import numpy as np

    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    return np.concatenate([(thing.pose * g.pose).apply(signs * half_extents(g.shape, g.size)) for g in thing.geoms])


def half_extents(shape: str, size: tuple[float, ...]) -> tuple[float, float, float]:
    """Compute the half extents (3,) of the box around a primitive [m]."""
    if shape in ("box", "convex"):
        return (size[0], size[1], size[2])
    if shape == "sphere":
        return (size[0],) * 3
    return (size[0], size[0], size[1] + (size[0] if shape == "capsule" else 0.0))

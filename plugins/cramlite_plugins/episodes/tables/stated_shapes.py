"""Shapes that a mapping file states: boxes, hollow boxes, cylinders and mesh files, converted to cramlite's
axes (z up)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cramlite.model import Floats, Geom, Pose, vector3

from ...shapes.files import read
from .convention import Convention
from .mapping import ShapeSpec

WALL = 0.002
"""Thickness of the walls and the floor of a hollow shape [m]; it is at most a tenth of the shape's smallest side."""
CONVEX = 0.9
"""Share of the convex hull's volume below which a mesh counts as hollow."""


def geoms_of(spec: ShapeSpec, convention: Convention, folder: Path) -> tuple[Geom, ...]:
    """Return the primitives of a shape, in the frame of its thing.

    A mesh is its convex hull; one that is far from convex is taken as hollow, a box without a lid.

    Raises:
        UserError: a mesh file cannot be used.
    """
    at = convention.positions(np.array([spec.at]))[0]
    if spec.box is not None:
        return (Geom("box", vector3(convention.extents(spec.box) / 2), Pose(vector3(at))),)
    if spec.hollow is not None:
        return _without_lid(convention.extents(spec.hollow), at)
    if spec.cylinder is not None:
        radius, height = (convention.unit * v for v in spec.cylinder)
        return (Geom("cylinder", (radius, height / 2), Pose(vector3(at))),)
    mesh = read(folder / str(spec.mesh), convention.unit)
    points = convention.axes @ np.asarray(mesh.vertices).T
    return _of_mesh(mesh, points.T + at)


def _of_mesh(mesh: Any, points: Floats) -> tuple[Geom, ...]:
    from scipy.spatial import ConvexHull

    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    if mesh.is_watertight and abs(mesh.volume) < CONVEX * mesh.convex_hull.volume:
        return _without_lid(high - low, middle)
    corners = tuple(vector3(c - middle) for c in points[ConvexHull(points).vertices])
    return (Geom("convex", vector3((high - low) / 2), Pose(vector3(middle)), corners=corners),)


def _without_lid(size: Floats, at: Floats) -> tuple[Geom, ...]:
    """Return the geoms of a box that is open above: a floor and four walls."""
    wall = min(WALL, float(size.min()) / 10)
    floor = Geom("box", (size[0] / 2, size[1] / 2, wall / 2), Pose(vector3(at - [0, 0, (size[2] - wall) / 2])))
    across = (size[0] / 2, wall / 2, size[2] / 2), (wall / 2, size[1] / 2, size[2] / 2)
    ways = np.array([0, (size[1] - wall) / 2, 0]), np.array([(size[0] - wall) / 2, 0, 0])
    walls = [Geom("box", half, Pose(vector3(at + sign * way))) for half, way in zip(across, ways, strict=True) for sign in (-1, 1)]
    return (floor, *walls)

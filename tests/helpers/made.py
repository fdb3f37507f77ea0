"""Shapes made by script: what products, tools and vessels look like in files."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import trimesh


def turned(mesh: Any, axis: tuple[float, float, float], angle: float) -> Any:
    """Rotate a mesh about an axis through the origin [rad], and return it."""
    mesh.apply_transform(trimesh.transformations.rotation_matrix(angle, axis))
    return mesh


def moved(mesh: Any, by: tuple[float, float, float]) -> Any:
    """Translate a mesh [m], and return it."""
    mesh.apply_translation(by)
    return mesh


def tagged(diameter: float = 0.009, size: tuple[float, float, float] = (0.06, 0.05, 0.10)) -> Any:
    """A box with a tab on top that has a round hole; origin in the middle of the box."""
    box = trimesh.creation.box(size)
    tab = moved(trimesh.creation.box((0.03, 0.003, 0.04)), (0, 0, size[2] / 2 + 0.010))
    drill = turned(trimesh.creation.cylinder(diameter / 2, 0.2, sections=48), (1, 0, 0), math.pi / 2)
    return trimesh.boolean.difference(
        [trimesh.boolean.union([box, tab], engine="manifold"), moved(drill, (0, 0, size[2] / 2 + 0.018))],
        engine="manifold",
    )


def bowl(radius: float = 0.07, height: float = 0.05, wall: float = 0.005) -> Any:
    """Make a bowl as a body of revolution with a rim; the origin is at the bottom."""
    foot = 0.6 * radius
    profile = [(0, 0), (foot, 0), (radius, height), (radius - wall, height), (foot - wall, wall), (0, wall)]
    return trimesh.creation.revolve(np.array(profile), sections=32)


def mug(radius: float = 0.042, height: float = 0.09, wall: float = 0.005) -> Any:
    """A cup with a handle on +x; origin half way up."""
    shell = trimesh.creation.annulus(radius - wall, radius, height, sections=32)
    floor = moved(trimesh.creation.cylinder(radius - 1e-4, wall, sections=32), (0, 0, (wall - height) / 2))
    ring = turned(trimesh.creation.torus(0.28 * height, 0.006, major_sections=24, minor_sections=12), (1, 0, 0), math.pi / 2)
    room = trimesh.creation.cylinder(radius - wall, 2 * height, sections=32)
    handle = trimesh.boolean.difference([moved(ring, (radius + 0.016, 0, 0)), room], engine="manifold")
    return trimesh.boolean.union([shell, floor, handle], engine="manifold")


def opened(mesh: Any, faces: int) -> Any:
    """Return a mesh without its last faces, so that it is not closed."""
    return trimesh.Trimesh(mesh.vertices, mesh.faces[:-faces], process=False)

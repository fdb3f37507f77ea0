"""Points on the outside of a textured surface, with normals and colours, as a ring of cameras around it sees them."""

from __future__ import annotations

import itertools
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Value

from ...shapes.skins import Skin
from ...simulation.camera.ray_tracer import cast
from ...simulation.camera.skins import visual_model

SPACING = 0.003
"""Edge of the voxels of which each has one point [m]; two where both sides of a wall are in it."""
MOST = 9000
RAYS = 110
"""Rays along each side of a view, at most."""
AWAY = 3.0
"""Distance of the views in radii of the surface's ball."""
SMEARED = 0.004
"""Distance over which colours are averaged [m]: three pixels of a depth camera at 0.9 m."""


class Samples(Value, eq=False):
    """Points on the outside of a surface, in no order; (N, 3) each, positions [m], colours 0 to 255."""

    points: Floats
    normals: Floats
    colours: Floats


def sampled(skin: Skin) -> Samples:
    """Sample the outside of a textured surface, as it is seen from 26 directions."""
    model = visual_model((skin,))
    data: Any = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    low, high = skin.corners.min((0, 1)), skin.corners.max((0, 1))
    centre, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    steps = int(np.clip(2 * radius / (0.6 * SPACING), 12, RAYS))
    points, normals = [], []
    for way in itertools.product((-1, 0, 1), repeat=3):
        if any(way):
            p, n = _seen(model, data, centre, radius, np.array(way, float), steps)
            points.append(p)
            normals.append(n)
    every, facing = np.concatenate(points), np.concatenate(normals)
    kept = _thinned(every, facing)
    every, facing = every[kept], facing[kept]
    return Samples(every, facing, _smeared(every, facing, skin.colours_at(every, facing)))


def _seen(model: Any, data: Any, centre: Floats, radius: float, way: Floats, steps: int) -> tuple[Floats, Floats]:
    """Points of a mesh's surface that are seen from one direction, and the normals there, which point to the viewer."""
    way = way / np.linalg.norm(way)
    eye = centre + AWAY * radius * way
    side = np.cross(way, (0.0, 0.0, 1.0)) if abs(way[2]) < 0.9 else np.array((1.0, 0.0, 0.0))
    side = side / np.linalg.norm(side)
    up = np.cross(side, way)
    u, v = np.meshgrid(*2 * [np.linspace(-radius, radius, steps)])
    aims = centre + u.reshape(-1, 1) * side + v.reshape(-1, 1) * up - eye
    directions = aims / np.linalg.norm(aims, axis=1, keepdims=True)
    geom, distance, normal = cast(model, data, eye, directions)
    hit = geom >= 0
    normal = normal[hit]
    normal = np.where(np.einsum("ij,ij->i", normal, directions[hit])[:, None] > 0, -normal, normal)
    steep = np.einsum("ij,ij->i", normal, directions[hit]) < -0.25
    return (eye + directions[hit] * distance[hit, None])[steep], normal[steep]


def _thinned(points: Floats, normals: Floats) -> Any:
    """Indices of one point for each voxel and direction of the normal, in random order; of larger voxels
    if there would be too many."""
    order = np.random.default_rng(0).permutation(len(points))
    edge = SPACING
    while True:
        keys = np.concatenate([np.floor(points[order] / edge), np.rint(normals[order])], axis=1).astype(np.int64)
        _, first = np.unique(keys, axis=0, return_index=True)
        if len(first) <= MOST:
            return np.random.default_rng(1).permutation(order[first])
        edge *= 1.15


def _smeared(points: Floats, normals: Floats, colours: Floats) -> Floats:
    """Colours (N, 3) of surface points, each averaged with its neighbours over the area of one pixel."""
    from scipy.spatial import cKDTree

    sides = np.concatenate([points, SMEARED * normals], axis=1)
    near = cKDTree(sides).query(sides, k=min(5, len(sides)), distance_upper_bound=1.5 * SMEARED)[1]
    known = near < len(points)
    found = np.where(known[..., None], colours[np.minimum(near, len(points) - 1)], 0.0)
    return np.asarray(found.sum(1) / known.sum(1, keepdims=True))

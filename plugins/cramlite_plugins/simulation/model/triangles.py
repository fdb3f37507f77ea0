"""Triangle meshes of a compiled model's geoms.

Round geoms are turned on a lathe of our own, because importing trimesh costs 0.95 s of CPU time.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Pose, Solid

from .index import Model

EDGE, FEWEST, MOST = 0.013, 8, 28
"""Length of an edge of a round geom [m], and its least and largest number of edges: the widest link of a UR5e gets 28."""
_CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
_SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
"""Sides of a box, each counter-clockwise seen from outside."""
_BOX = np.array([t for a, b, c, d in _SIDES for t in ((a, b, c), (a, c, d))])


def solids(model: Model) -> tuple[Solid, ...]:
    """Triangulate every visible geom, in the frame of its body; planes and fully transparent ones are left out."""
    found = []
    for geom in range(model.ngeom):
        surface = _surface(model, geom) if model.geom_rgba[geom][3] > 0 else None
        if surface is not None:
            vertices, faces = surface
            place = Pose(tuple(model.geom_pos[geom]), tuple(model.geom_quat[geom]))
            colour = tuple(float(c) for c in model.geom_rgba[geom])
            found.append(Solid(body_name(model, int(model.geom_bodyid[geom])), place.apply(vertices), faces, colour))  # type: ignore[arg-type]
    return tuple(found)


def body_name(model: Model, body: int) -> str:
    """Return a name for a body, also where its model has none."""
    return str(model.body(body).name) or f"body {body}"


def _surface(model: Model, geom: int) -> tuple[Floats, Any] | None:
    """Vertices (V, 3) and faces (F, 3) of a triangle mesh of a geom, in the geom's own frame; None for shapes
    that are not drawn."""
    kind, size, kinds = int(model.geom_type[geom]), model.geom_size[geom], mujoco.mjtGeom
    if kind == kinds.mjGEOM_BOX:
        return _CORNERS * size, _BOX
    if kind == kinds.mjGEOM_CYLINDER:
        return lathe(np.array([(0, -size[1]), (size[0], -size[1]), (size[0], size[1]), (0, size[1])]))
    if kind in (kinds.mjGEOM_SPHERE, kinds.mjGEOM_CAPSULE):
        return lathe(_dome(size[0], size[1] if kind == kinds.mjGEOM_CAPSULE else 0.0))
    if kind == kinds.mjGEOM_ELLIPSOID:
        vertices, faces = lathe(_dome(1.0, 0.0))
        return vertices * size, faces
    if kind == kinds.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom]))
    return None


def _dome(radius: float, half: float) -> Floats:
    """The outline of a capsule (a sphere if ``half`` is 0) from its lower to its upper end, rows (distance from the axis, z)."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, _segments(radius) // 2 + 1)
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles) + np.sign(angles) * half])


def _segments(radius: float) -> int:
    """Number of segments by which a circle is approximated in a triangle mesh: even, so that a dome has an equator."""
    return 2 * round(min(max(2 * np.pi * radius / EDGE, FEWEST), MOST) / 2)


def lathe(outline: Floats) -> tuple[Floats, Any]:
    """Triangulate the solid of revolution of an outline about z, closed at both ends.

    Args:
        outline: (P, 2) rows (distance from the axis, z), upwards.
    """
    count = _segments(float(outline[:, 0].max()))
    turns = 2 * np.pi * np.arange(count) / count
    ring = np.column_stack([np.cos(turns), np.sin(turns)])
    vertices = np.concatenate([np.column_stack([r * ring, np.full(count, z)]) for r, z in outline])
    here = np.arange(count)
    there, faces = (here + 1) % count, []
    for row in range(len(outline) - 1):
        low, high = row * count, (row + 1) * count
        faces.append(np.column_stack([low + here, low + there, high + there]))
        faces.append(np.column_stack([low + here, high + there, high + here]))
    return vertices, _proper(vertices, np.concatenate(faces))


def _proper(vertices: Floats, faces: Any) -> Any:
    """Faces of a triangle mesh that have an area; at the ends of a solid of revolution some have none."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12]


def _mesh(model: Model, mesh: int) -> tuple[Floats, Any]:
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    return np.array(model.mesh_vert[first : first + count], dtype=float), np.array(
        model.mesh_face[start : start + faces]
    )

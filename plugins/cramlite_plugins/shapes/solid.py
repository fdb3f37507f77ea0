"""Triangle meshes of things, for display and geometry; holes are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cramlite.model import Geom, Thing

SECTIONS = 32  # of round geoms


def mesh_of(thing: Thing) -> Any:
    """Convert a thing to one trimesh.Trimesh in its own frame [m]: its mesh file's, else one of its geoms.

    Geoms that touch are put side by side, not united; a file that is gone is replaced by the geoms.

    Raises:
        UserError: the file is there and cannot be read.
    """
    import trimesh

    from .files import read

    if thing.mesh is not None and Path(thing.mesh.path).is_file():
        return read(Path(thing.mesh.path), thing.mesh.scale)
    return trimesh.util.concatenate([geom_mesh(g) for g in thing.geoms])


def geom_mesh(geom: Geom) -> Any:
    """Convert a geom to a trimesh.Trimesh in its thing's frame [m]."""
    import trimesh

    if geom.shape == "box":
        mesh = trimesh.creation.box(extents=2 * np.asarray(geom.size))
    elif geom.shape == "sphere":
        mesh = trimesh.creation.icosphere(subdivisions=3, radius=geom.size[0])
    elif geom.shape == "convex":
        mesh = trimesh.Trimesh(np.asarray(geom.corners), process=False).convex_hull
    elif geom.shape == "cylinder":
        mesh = trimesh.creation.cylinder(geom.size[0], 2 * geom.size[1], sections=SECTIONS)
    else:
        mesh = trimesh.creation.capsule(2 * geom.size[1], geom.size[0], count=[SECTIONS, SECTIONS])
        mesh.apply_translation(-mesh.bounds.mean(axis=0))
    mesh.apply_transform(geom.pose.matrix)
    return mesh

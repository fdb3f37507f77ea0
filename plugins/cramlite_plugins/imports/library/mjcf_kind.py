"""Object models from MJCF files: all bodies of a file become one model, with what its joints move."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Geom, MeshFile, Pose, Thing, Value
from cramlite.plugin import UserError

from ...shapes.solid import geom_mesh
from ..scenes.geoms import MESH, Shaped, collides, pose_of, shaped
from ..scenes.source import Source, read_source
from ..scenes.things import inertia_of
from . import look
from .moving_parts import kind_joints
from .parts import parts_of

RGB = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)
FLAT = int(mujoco.mjtTexture.mjTEXTURE_2D)
FURNITURE, LOOSE = "soma:DesignedFurniture", "cram:Product"
"""Class of a kind whose joints move no part of it, and of one without joints."""
OPAQUE = 0.5
"""Least opacity (alpha) of what a camera sees; through less it sees what is behind."""


class Draft(Value, eq=False):
    """Object model that was read from a file and is not yet written to a library.

    Args:
        thing: its shape, mass and class, at the origin, without its look.
        mesh: trimesh.Trimesh with its texture [m].
        printed: (width, height) of the texture [pixel]; None if it has none.
        mass: where its mass comes from, in a clause.
        joints: names of its joints with their ranges, in words; those that move a part of it are also in the thing's mesh.
        notes: what was changed, for people.
    """

    thing: Thing
    mesh: Any
    printed: tuple[int, int] | None
    mass: str
    joints: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def from_mjcf(path: Path, name: str) -> Draft:
    """Read an object model from an MJCF file; its frame is that of the first body that has a shape.

    Raises:
        UserError: the file cannot be used, or has no shape.
    """
    source = read_source(path, {}, textures=True)
    model, data = source.model, source.data
    bodies = [b for b in range(1, model.nbody) if int(model.body_geomnum[b])]
    if not bodies:
        raise UserError(f"{path}: the model has no body with a shape.")
    frame = pose_of(data.xpos[bodies[0]], data.xmat[bodies[0]])
    seen = _visible(model)
    parts = [_part(source, g, frame) for g in seen]
    if not parts:
        raise UserError(f"{path}: the model has no visible shape.")
    mesh = look.whole(parts)
    solid = [g for g in range(model.ngeom) if collides(model, g) and model.geom_bodyid[g]]
    shapes = [shaped(model, data, g, frame) for g in solid]
    geoms, notes = _geoms(shapes, mesh, name)
    mass, inertia = inertia_of(model, data, bodies, frame)
    joints = tuple(_joint(model, j) for j in range(model.njnt) if int(model.jnt_type[j]) >= 2)
    triangles = [(g, len(p.corners)) for g, p in zip(seen, parts, strict=True)]
    counted = [(g, len(s.geoms)) for g, s in zip(solid, shapes, strict=True)]
    moving = kind_joints(source, bodies[0], frame, np.asarray(mesh.triangles), triangles, counted)
    things, moving = parts_of(path, source, frame, moving)
    type_ = things[0].type if things else FURNITURE if joints else LOOSE
    thing = Thing(name, type_, Pose(), geoms, (), None if joints else mass, _friction(geoms), None if joints else inertia,
                  MeshFile("", joints=moving) if moving else None, parts=things)  # fmt: skip
    sizes = [p.image.shape[1::-1] for p in parts if p.printed]
    largest = max(sizes, key=lambda s: s[0] * s[1], default=None)
    return Draft(thing, mesh, largest, f"{1000 * mass:.0f} g, masses and densities of the file", joints, notes)


def _friction(geoms: tuple[Geom, ...]) -> float:
    stated = [g.friction for g in geoms if g.friction is not None]
    return min(stated, default=0.6)


def _geoms(shapes: list[Shaped], mesh: Any, name: str) -> tuple[tuple[Geom, ...], tuple[str, ...]]:
    """Return collision geoms and notes; where nothing of a file collides, the geoms are convex parts of its
    visible mesh."""
    geoms = tuple(g for s in shapes for g in s.geoms)
    notes = tuple(dict.fromkeys(n for s in shapes for n in s.notes))
    if geoms:
        return geoms, notes
    from ...shapes import files, shape

    closed = files.closed(mesh, f"mesh of '{name}'")
    found = shape.from_mesh(closed.mesh, closed.notes)
    return found.geoms, (*notes, f"no shape of the file collides, so its visible mesh does: {found.notes[-1]}")


def _joint(model: Any, joint: int) -> str:
    low, high = model.jnt_range[joint]
    slide = int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    scale, unit = (1000.0, "mm") if slide else (180 / np.pi, "deg")
    ends = f" {scale * low:.0f} to {scale * high:.0f} {unit}" if model.jnt_limited[joint] else " without ends"
    return f"{model.joint(joint).name or f'joint {joint}'}{ends}"


def _visible(model: Any) -> list[int]:
    """Return the geoms that show a model: the purely visual ones, or all opaque ones if none is purely visual.

    A window of a model is none of them, since a camera sees what is behind it. Colliding geoms in the groups of visual ones are shown, too,
    unless all colliding geoms are in these groups.
    """
    seen = [g for g in range(model.ngeom) if model.geom_bodyid[g] and _opacity(model, g) > 0]
    seen = [g for g in seen if _opacity(model, g) >= OPAQUE] or seen
    shown = [g for g in seen if not collides(model, g)]
    looks = {int(model.geom_group[g]) for g in shown}
    if any(collides(model, g) and int(model.geom_group[g]) not in looks for g in range(model.ngeom)):
        shown = [g for g in seen if int(model.geom_group[g]) in looks]
    return shown or seen


def _opacity(model: Any, geom: int) -> float:
    material = int(model.geom_matid[geom])
    return float(model.mat_rgba[material][3] if material >= 0 else model.geom_rgba[geom][3])


def _part(source: Source, geom: int, frame: Pose) -> look.Part:
    model, data = source.model, source.data
    at = frame.inverse() * pose_of(data.geom_xpos[geom], data.geom_xmat[geom])
    if int(model.geom_type[geom]) != MESH:
        made = shaped(model, data, geom, frame)
        solids = [np.asarray(geom_mesh(g).triangles) for g in made.geoms]
        corners = np.concatenate(solids) if solids else np.zeros((0, 3, 3))
        return look.plain(corners, _colour(model, geom))
    mesh = int(model.geom_dataid[geom])
    first, start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    vertices = at.apply(np.asarray(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], float))
    corners = vertices[model.mesh_face[start : start + count]]
    image, material = None, int(model.geom_matid[geom])
    if material >= 0 and int(model.mesh_texcoordnum[mesh]):
        image = _image(model, int(model.mat_texid[material][RGB]))
    if image is None:
        return look.plain(corners, _colour(model, geom))
    return look.Part(corners, _places(model, mesh, material), image)


def _places(model: Any, mesh: int, material: int) -> Floats:
    """Return the texture coordinates (F, 3, 2) of a mesh's corners.

    MuJoCo counts the rows of an image downwards.
    """
    start, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    first = int(model.mesh_texcoordadr[mesh])
    coordinates = np.asarray(model.mesh_texcoord[first : first + int(model.mesh_texcoordnum[mesh])], float)
    found = coordinates[model.mesh_facetexcoord[start : start + count]] * model.mat_texrepeat[material]
    return np.stack([found[..., 0], 1.0 - found[..., 1]], axis=-1)


def _image(model: Any, texture: int) -> Any:
    """Image (height, width, 3) of a flat texture; None for a cube texture, which has no coordinates for
    corners."""
    if texture < 0 or int(model.tex_type[texture]) != FLAT:
        return None
    height, width, channels = (int(v[texture]) for v in (model.tex_height, model.tex_width, model.tex_nchannel))
    start = int(model.tex_adr[texture])
    pixels = np.asarray(model.tex_data[start : start + height * width * channels]).reshape(height, width, channels)
    return pixels[..., :3] if channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)


def _colour(model: Any, geom: int) -> tuple[float, ...]:
    """Colour of a geom without texture coordinates: its material's colour, times the mean colour of the
    material's texture."""
    material = int(model.geom_matid[geom])
    if material < 0:
        return tuple(float(v) for v in model.geom_rgba[geom][:3])
    rgb, texture = model.mat_rgba[material][:3], int(model.mat_texid[material][RGB])
    if texture >= 0 and int(model.tex_nchannel[texture]) >= 3:
        size = int(model.tex_height[texture]) * int(model.tex_width[texture]) * int(model.tex_nchannel[texture])
        start = int(model.tex_adr[texture])
        pixels = model.tex_data[start : start + size].reshape(-1, int(model.tex_nchannel[texture]))
        rgb = rgb * pixels[:, :3].mean(axis=0) / 255.0
    return tuple(float(v) for v in rgb)



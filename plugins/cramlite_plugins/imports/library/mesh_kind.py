"""Object models from mesh files: triangles, a texture where the file has one, and convex parts that collide."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import Pose
from cramlite.plugin import UserError

from ...objects.mesh_thing import mesh_thing
from ...shapes.files import read
from ...shapes.skins import skin_of_mesh
from . import look
from .mjcf_kind import Draft

GREY = (0.62, 0.58, 0.70)
"""Colour of a mesh that states none, the same as that of the object model ``mesh``."""


def from_mesh(path: Path, name: str, scale: float, density: float) -> Draft:
    """Read an object model from a mesh file, in the file's frame.

    Args:
        scale: from the file's unit to metres.
        density: of the whole thing [kg/m3].

    Raises:
        UserError: the file cannot be used.
    """
    try:
        mesh = read(path, scale, materials=True)
    except UserError as error:
        raise UserError(f"{error}.") from error
    skin = skin_of_mesh(mesh)
    if skin is None:
        part = look.plain(np.asarray(mesh.triangles, float), _colour(mesh))
    else:
        part = look.Part(skin.corners, skin.places, skin.image)
    thing = mesh_thing(name, Pose(), str(path), scale, density=density)
    printed = None if skin is None else (int(skin.image.shape[1]), int(skin.image.shape[0]))
    mass = f"{1000 * (thing.mass or 0):.0f} g, its volume at {density:g} kg/m3, which --density sets"
    return Draft(replace(thing, mesh=None), look.whole([part]), printed, mass, notes=thing.notes)


def _colour(mesh: Any) -> tuple[float, ...]:
    """Mean colour of a mesh without texture."""
    main = getattr(mesh.visual, "main_color", None)
    if getattr(mesh.visual, "defined", False) and main is not None:
        return tuple(float(v) / 255.0 for v in main[:3])
    material = getattr(mesh.visual, "material", None)
    found = getattr(material, "main_color", None)
    return GREY if found is None else tuple(float(v) / 255.0 for v in found[:3])

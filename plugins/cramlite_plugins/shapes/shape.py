"""Shapes of mesh files: convex parts, features, mass distribution; cached by content."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import DecodeError, json
from msgspec.structs import replace

from cramlite.model import Feature, Floats, Geom, Pose, Value, vector3
from cramlite.plugin import UserError, cache_folder, keep_file

VERSION = 5  # of what is kept: raise it when parts or features of the same file change
FINE = 20_000  # meshes with more faces are simplified by SIMPLER before they are cut
SIMPLER = 1e-4  # [m]


class Shape(Value):
    """Shape of a mesh file: everything that follows from the file alone.

    Args:
        geoms: convex parts; those about a hole to hang by are parts of that feature.
        features: holes and handles that were found.
        volume: [m3].
        centre: of an even mass [m].
        moments: (xx, yy, zz, xy, xz, yz) about the centre for a density of 1 [m5].
        notes: for people.
    """

    geoms: tuple[Geom, ...]
    features: tuple[Feature, ...]
    volume: float
    centre: tuple[float, float, float]
    moments: tuple[float, float, float, float, float, float]
    notes: tuple[str, ...] = ()


def shape_of(path: Path, scale: float = 1.0) -> Shape:
    """Return the shape of a mesh file; the same for the same content, wherever the file is.

    It is kept in the user's cache, or computed anew where that cannot be written.

    Raises:
        UserError: the file cannot be used (``files.read``, ``files.closed``).
    """
    from .files import _check_file

    _check_file(path)
    return kept_shape(path.read_bytes() + f"|{path.suffix}|{scale!r}".encode(), lambda: compute(path, scale))


def kept_shape(content: bytes, make: Callable[[], Shape]) -> Shape:
    """Return the cached shape of some file content; on the first call make it and keep it."""
    return _shape(_Content(hashlib.sha256(content + f"|{VERSION}".encode()).hexdigest(), make))


@dataclass(frozen=True)
class _Content:
    """Cache key of the shape in a mesh file; two keys are equal if the contents of the files are equal."""

    key: str
    make: Callable[[], Shape] = field(compare=False)


@lru_cache(maxsize=64)
def _shape(content: _Content) -> Shape:
    kept = cache_folder() / "shapes" / f"{content.key}.json"
    try:
        return json.decode(kept.read_bytes(), type=Shape)
    except (OSError, DecodeError):
        shape = content.make()
        keep_file(kept, json.encode(shape))
        return shape


def compute(path: Path, scale: float = 1.0) -> Shape:
    """Compute the shape of a mesh file, without the cache of ``shape_of``."""
    from . import files

    found = files.closed(files.read(path, scale), f"mesh '{path.name}'")
    return from_mesh(found.mesh, found.notes)


def from_mesh(mesh: Any, notes: Sequence[str] = ()) -> Shape:
    """Compute the shape of a closed trimesh.Trimesh [m].

    Raises:
        UserError: it encloses no volume.
    """
    from . import convex, openings
    from .convex import hull_volume

    if mesh.volume < 1e-10:
        raise UserError(
            f"the mesh encloses {1e9 * mesh.volume:.3f} mm3, which is nothing; give the shape a thickness"
        )
    simple, said = _simplified(mesh)
    found = openings.openings(simple)
    bores = [o.bore for o in found if o.round]
    hulls = convex.parts(simple.vertices, simple.faces, bores)
    geoms = _unless_all_hole(tuple(_geom(h, _part(h, found)) for h in hulls))
    added = sum(hull_volume(g.corners) for g in geoms) / mesh.volume - 1
    built = f"{len(geoms)} convex parts, {100 * added:+.1f} % of the mesh's volume added; " + (
        ", ".join(f"{o.feature.name} of {2000 * o.bore.radius:.1f} mm" for o in found) or "no holes"
    )
    mass = mesh.moment_inertia
    moments = (mass[0, 0], mass[1, 1], mass[2, 2], mass[0, 1], mass[0, 2], mass[1, 2])
    return Shape(
        geoms, tuple(o.feature for o in found), float(mesh.volume), vector3(mesh.center_mass),
        tuple(float(v) for v in moments), (*notes, *said, built),  # type: ignore[arg-type]
    )  # fmt: skip


def _simplified(mesh: Any) -> tuple[Any, tuple[str, ...]]:
    if len(mesh.faces) <= FINE:
        return mesh, ()
    import trimesh

    from .convex import solid

    less = solid(mesh.vertices, mesh.faces).simplify(SIMPLER).to_mesh64()
    simple = trimesh.Trimesh(
        np.asarray(less.vert_properties)[:, :3], np.asarray(less.tri_verts), process=False
    )
    return simple, (
        f"{len(mesh.faces):,} faces simplified to {len(simple.faces):,} within {1000 * SIMPLER:g} mm",
    )


def _unless_all_hole(geoms: tuple[Geom, ...]) -> tuple[Geom, ...]:
    """Return the parts of a shape; if most of their volume is labelled as the rim of a hole, as in a ring,
    without the labels.

    The rim of a hole is not gripped, and some part must be.
    """
    from .convex import hull_volume

    volumes = [hull_volume(g.corners) for g in geoms]
    rims = sum(v for g, v in zip(geoms, volumes, strict=True) if g.part)
    return tuple(replace(g, part="") for g in geoms) if rims > 0.5 * sum(volumes) else geoms


def _part(corners: Floats, found: Sequence[Any]) -> str:
    """Name of the hole whose rim a part of a mesh belongs to; "" for other parts.

    Hands keep off rims, and contacts with a rim go by the name of the hole.
    """
    from .convex import RIM, SECTORS

    for opening in found:
        bore = opening.bore
        if opening.round and opening.feature.type == "vrps:Hole":
            off = corners - bore.centre
            along = off @ bore.axis
            out = np.linalg.norm(off - along[:, None] * bore.axis, axis=1)
            widest = RIM * bore.radius / np.cos(np.pi / SECTORS) + 1e-5
            if out.max() <= widest and np.abs(along).max() <= bore.half + 1e-5:
                return str(opening.feature.name)
    return ""


def _geom(corners: Floats, part: str) -> Geom:
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre = np.round((low + high) / 2, 6)
    local = np.round(corners - centre, 6)
    return Geom(
        "convex",
        vector3(np.abs(local).max(axis=0)),
        Pose(vector3(centre)),
        part,
        corners=tuple(map(vector3, local)),
    )

"""Mesh files: read, checked and closed, or refused with numbers."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from cramlite.model import Value
from cramlite.plugin import UserError, nearest

KINDS = ("stl", "obj", "ply", "off", "glb")
MOST_FACES = 500_000  # a scan of a product has 10,000 to 200,000; cutting more takes minutes
MOST_BYTES = 100_000_000
LARGEST, SMALLEST, FLAT = 5.0, 0.002, 1e-4  # sides of the box around a shape [m]


class Closed(Value):
    """A mesh that encloses a volume.

    Args:
        mesh: trimesh.Trimesh [m].
        notes: what was repaired, with numbers.
    """

    mesh: Any
    notes: tuple[str, ...] = ()


def read(path: Path, scale: float = 1.0, *, materials: bool = False) -> Any:
    """Read the triangles of a mesh file as trimesh.Trimesh, in metres.

    Args:
        materials: read its textures, too.

    Raises:
        UserError: no such file, an unknown kind, too large, not readable, empty, or no size that a thing has.
    """
    _check_file(path)
    import trimesh

    try:
        with (
            warnings.catch_warnings()
        ):  # of numbers that it rounds before anybody has looked at them, as _check_size does
            warnings.simplefilter("ignore", RuntimeWarning)
            options = {"process": False} if materials else {"skip_materials": True}
            mesh = trimesh.load_mesh(str(path), file_type=path.suffix[1:].lower(), **options)
    except Exception as error:  # trimesh's readers raise whatever their parsers do
        reason = f"{type(error).__name__}: {' '.join(str(error).split())[:120]}"
        raise UserError(f"mesh '{path}' cannot be read ({reason}); export it anew as binary STL") from error
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
        raise UserError(
            f"mesh '{path}' is empty: it has no triangles; export the surface, not only points or curves"
        )
    if len(mesh.faces) > MOST_FACES:
        raise UserError(_too_many(path, len(mesh.faces)))
    if not np.isfinite(mesh.vertices).all():
        bad = int((~np.isfinite(mesh.vertices)).any(axis=1).sum())
        raise UserError(
            f"mesh '{path}': {bad} of {len(mesh.vertices)} vertices are not finite; export it anew"
        )
    if scale != 1.0:
        mesh.apply_scale(scale)
    _check_size(path, mesh.extents, scale)
    return mesh


def closed(mesh: Any, where: str) -> Closed:
    """Close a mesh, its normals outwards: an open one is filled, or replaced by its convex hull.

    Raises:
        UserError: it encloses nothing.
    """
    import trimesh

    mesh = mesh.copy()
    mesh.merge_vertices()
    whole = _joined(mesh)
    if whole is not None:
        return Closed(whole)
    _weld(mesh)
    turned = _outward(mesh)
    if _usable(mesh):
        return Closed(
            mesh, (f"{where}: faces pointed inwards or both ways; turned outwards",) if turned else ()
        )
    edges = _open_edges(mesh)
    for fans in (False, True):
        filled = mesh.copy()
        trimesh.repair.fill_holes(filled, use_fan=fans)
        _outward(filled)
        if _usable(filled):
            added = len(filled.faces) - len(mesh.faces)
            return Closed(
                filled, (f"{where}: not watertight, {edges} open edges; closed by adding {added} faces",)
            )
    hull = mesh.convex_hull
    if hull.volume <= 0:
        raise UserError(f"{where}: its {len(mesh.faces)} faces enclose no volume; give the shape a thickness")
    note = (
        f"{where}: not watertight, {edges} open edges that could not be closed; its convex hull is used"
        f" ({1e6 * hull.volume:.1f} cm3), so that holes and hollows are lost: repair the file to keep them"
    )
    return Closed(hull, (note,))


def _check_file(path: Path) -> None:
    if path.suffix[1:].lower() not in KINDS:
        raise UserError(
            f"mesh '{path}': there is no reader for '{path.suffix}'; "
            f"{nearest(path.suffix[1:].lower(), KINDS)}"
        )
    if not path.is_file():
        beside = (
            [p.name for p in path.parent.glob("*") if p.suffix[1:].lower() in KINDS]
            if path.parent.is_dir()
            else []
        )
        raise UserError(f"mesh '{path}': there is no such file; beside it, {nearest(path.name, beside)}")
    size = path.stat().st_size
    if size == 0:
        raise UserError(f"mesh '{path}' is empty: 0 bytes; export it anew")
    faces = (
        (size - 84) // 50 if path.suffix.lower() == ".stl" else size // 60
    )  # 50 bytes a face; text takes more
    if faces > 4 * MOST_FACES or size > MOST_BYTES:
        raise UserError(_too_many(path, faces, "about "))


def _too_many(path: Path, faces: int, about: str = "") -> str:
    return (
        f"mesh '{path}' has {about}{faces:,} faces; up to {MOST_FACES:,} are read. Simplify it to some "
        "20,000, which moves a product's surface by less than 1 mm: trimesh's "
        "simplify_quadric_decimation(face_count=20000), MeshLab or Blender"
    )


def _check_size(path: Path, extents: Any, scale: float) -> None:
    sides = " x ".join(f"{v:.4g}" for v in extents)
    largest, flat = float(max(extents)), float(min(extents))
    if largest > LARGEST:
        guess = next(
            (f for n, f in (("mm", 1e-3), ("cm", 1e-2)) if largest * f <= 2.0), LARGEST / largest / 10
        )
        unit = {1e-3: "millimetres", 1e-2: "centimetres"}.get(guess, "another unit")
        raise UserError(
            f"mesh '{path}' is {sides} m large; things are up to {LARGEST:g} m. If the file is in {unit}, "
            f"write 'scale: {guess * scale:.3g}'"
        )
    if largest < SMALLEST:
        raise UserError(
            f"mesh '{path}' is {sides} m small; things are at least {SMALLEST:g} m. Remove or raise 'scale'"
            f" ({scale:g} now)"
        )
    if flat < FLAT:
        raise UserError(f"mesh '{path}' is flat: {sides} m encloses no volume; give the shape a thickness")


def _outward(mesh: Any) -> bool:
    """Turn faces that point inwards; return whether any had to be turned."""
    before = mesh.faces.copy()
    mesh.fix_normals(multibody=True)
    return bool((mesh.faces != before).any())


def _weld(mesh: Any) -> None:
    """Join corners nearer than 1 um, which rounding has torn apart, and drop the triangles that vanish."""
    mesh.merge_vertices(digits_vertex=6)
    a, b, c = mesh.faces.T
    mesh.update_faces((a != b) & (b != c) & (a != c))


def _joined(mesh: Any) -> Any | None:
    """The closed mesh, with corners that rounding in a file has torn apart joined; None if it is not
    closed."""
    import trimesh

    from .convex import solid

    try:
        found = solid(mesh.vertices, mesh.faces).to_mesh64()
    except ValueError:
        return None
    whole = trimesh.Trimesh(
        np.asarray(found.vert_properties)[:, :3], np.asarray(found.tri_verts), process=False
    )
    return whole


def _usable(mesh: Any) -> bool:
    from .convex import solid

    if not mesh.is_watertight or mesh.volume <= 0:
        return False
    try:
        solid(mesh.vertices, mesh.faces)
    except ValueError:
        return False
    return True


def _open_edges(mesh: Any) -> int:
    """Edges that do not have exactly two faces."""
    counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)[1]
    return int((counts != 2).sum())

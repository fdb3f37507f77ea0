"""Geoms of a scene file as geoms of things, without purely visual ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite.model import Contact, Feature, Floats, Geom, Pose, Value, vector3
from cramlite.plugin import UserError

if TYPE_CHECKING:
    from ...shapes.shape import Shape

HOLLOW = 0.1
"""A mesh whose hull adds more than this share of its volume is taken apart."""
GROUND, BEYOND, THICK = 2.5, 1.0, 0.05
"""Least half length of the slab that stands for a plane, how far it reaches beyond all bodies, and its half thickness [m]. MuJoCo's
planes have no end, whatever size they are drawn in."""
PLANE, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = (
    int(getattr(mujoco.mjtGeom, f"mjGEOM_{kind}"))
    for kind in ("PLANE", "SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER", "BOX", "MESH")
)


class Shaped(Value):
    """Geoms of a thing that one geom of a scene file was converted to, with the features of its mesh.

    Args:
        geoms: in the frame of its group.
        features: holes and handles that were found in its mesh, in that frame.
        notes: what was changed, for people.
        name: of the geom, its mesh and its body, for what they are called.
    """

    geoms: tuple[Geom, ...]
    features: tuple[Feature, ...] = ()
    notes: tuple[str, ...] = ()
    name: str = ""


def pose_of(position: Any, matrix: Any) -> Pose:
    """Convert a position and a rotation matrix of nine numbers to a pose."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.asarray(matrix, dtype=float).reshape(9))
    w, x, y, z = quaternion.tolist()
    return Pose(vector3(position), (w, x, y, z))


def collides(model: Any, geom: int) -> bool:
    """Check whether a geom can touch anything."""
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def shaped(model: Any, data: Any, geom: int, frame: Pose) -> Shaped:
    """Convert a geom of a MuJoCo model to a geom of a thing.

    Args:
        frame: of its group, in the world.
    """
    kind, name = int(model.geom_type[geom]), _name(model, geom)
    at = frame.inverse() * pose_of(data.geom_xpos[geom], data.geom_xmat[geom])
    size = tuple(float(v) for v in model.geom_size[geom])
    look = {"rgba": _colour(model, geom), "friction": float(model.geom_friction[geom, 0]), "contact": _contact(model, geom)}
    primitives = {SPHERE: ("sphere", 1), CAPSULE: ("capsule", 2), CYLINDER: ("cylinder", 2), BOX: ("box", 3)}
    if kind in primitives:
        shape, count = primitives[kind]
        return Shaped((Geom(shape, size[:count], at, **look),), name=name)  # type: ignore[arg-type]
    if kind == PLANE:
        half = _wide(data.xpos, data.geom_xpos[geom], data.geom_xmat[geom], size)
        slab = Geom("box", (*half, THICK), at * Pose((0, 0, -THICK)), **look)  # type: ignore[arg-type]
        said = f"the plane '{name}' is a slab of {2 * half[0]:g} x {2 * half[1]:g} m, {2000 * THICK:g} mm thick"
        return Shaped((slab,), (), (said,), name)
    if kind == ELLIPSOID:
        return Shaped((_hull(_ball() * size, at, look),), (), (f"the ellipsoid '{name}' is a hull of {len(_ball())} corners",), name)
    if kind == MESH:
        return _meshed(model, geom, at, look, name)
    said = f"'{name}' is a {mujoco.mjtGeom(kind).name.removeprefix('mjGEOM_').lower()}, which things cannot have; left out"
    return Shaped((), (), (said,), name)


def _wide(bodies: Floats, at: Floats, matrix: Floats, drawn: tuple[float, ...]) -> tuple[float, float]:
    """Half lengths of the flat box that replaces a plane, wide enough to extend under all bodies of the scene [m]."""
    out = np.abs((bodies - at) @ matrix.reshape(3, 3)[:, :2]).max(axis=0) + BEYOND
    return (max(drawn[0] or GROUND, round(float(out[0]), 1)), max(drawn[1] or GROUND, round(float(out[1]), 1)))


def _name(model: Any, geom: int) -> str:
    mesh = int(model.geom_dataid[geom]) if int(model.geom_type[geom]) == MESH else -1
    names = (model.geom(geom).name, model.mesh(mesh).name if mesh >= 0 else "", model.body(int(model.geom_bodyid[geom])).name)
    return next((n for n in names if n), f"geom {geom}")


def _contact(model: Any, geom: int) -> Contact:
    _, torsional, rolling = (float(v) for v in model.geom_friction[geom])
    time, damping = (float(v) for v in model.geom_solref[geom])
    solimp: Any = tuple(float(v) for v in model.geom_solimp[geom])
    return Contact(
        int(model.geom_condim[geom]), torsional, rolling, int(model.geom_priority[geom]), (time, damping), solimp,
        float(model.geom_solmix[geom]), float(model.geom_margin[geom]), float(model.geom_gap[geom]),
    )  # fmt: skip


def _colour(model: Any, geom: int) -> tuple[float, float, float, float]:
    material = int(model.geom_matid[geom])
    r, g, b, a = (float(v) for v in (model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]))
    return (r, g, b, a or 1.0)  # collision shapes are often made invisible


def _meshed(model: Any, geom: int, at: Pose, look: dict[str, Any], name: str) -> Shaped:
    """Convert a mesh to geoms: a convex mesh to its hull; a hollow one, which MuJoCo would fill, to convex parts."""
    from ...shapes import files, shape

    mesh = int(model.geom_dataid[geom])
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    if faces > files.MOST_FACES:
        raise UserError(f"mesh '{name}' has {faces:,} faces; up to {files.MOST_FACES:,} are read: simplify it to some 20,000")
    points = np.asarray(model.mesh_vert[first : first + count], dtype=float)
    triangles = np.asarray(model.mesh_face[start : start + faces])
    found = shape.kept_shape(points.tobytes() + triangles.tobytes() + name.encode(), lambda: _parts(points, triangles, name))
    geoms = tuple(replace(g, pose=at * g.pose, **look) for g in found.geoms)
    return Shaped(geoms, tuple(replace(f, pose=at * f.pose) for f in found.features), found.notes, name)


def _parts(points: Floats, triangles: Any, name: str) -> Shape:
    import trimesh

    from ...shapes import files, shape

    try:
        closed = files.closed(trimesh.Trimesh(points, triangles, process=False), f"mesh '{name}'")
    except UserError as error:
        return _convex(points, (f"{error}; its convex hull is used",))
    if closed.mesh.convex_hull.volume <= (1 + HOLLOW) * closed.mesh.volume:
        return _convex(points, closed.notes)
    found = shape.from_mesh(closed.mesh, closed.notes)
    said = f"mesh '{name}' is hollow: {found.notes[-1]}, where MuJoCo would collide its hull"
    return replace(found, notes=(*found.notes[:-1], said))


def _convex(points: Floats, notes: tuple[str, ...]) -> Shape:
    from ...shapes.convex import hull_volume
    from ...shapes.shape import Shape

    hull = _hull(points, Pose(), {})
    return Shape((hull,), (), hull_volume(hull.corners), hull.pose.position, (0.0,) * 6, notes)


def _hull(points: Floats, at: Pose, look: dict[str, Any]) -> Geom:
    """The convex hull of points in the frame of a geom."""
    from scipy.spatial import ConvexHull

    corners = points[ConvexHull(points).vertices]
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = np.round((low + high) / 2, 6)
    local = np.round(corners - middle, 6)
    return Geom(
        "convex", vector3(np.abs(local).max(axis=0)), at * Pose(vector3(middle)), corners=tuple(vector3(c) for c in local), **look
    )


def _ball() -> Floats:
    """Points of the unit sphere, 24 around and 11 up."""
    turns, ups = np.meshgrid(np.linspace(0, 2 * np.pi, 24, endpoint=False), np.linspace(0, np.pi, 13)[1:-1])
    ring = np.column_stack([(np.sin(ups) * np.cos(turns)).ravel(), (np.sin(ups) * np.sin(turns)).ravel(), np.cos(ups).ravel()])
    return np.vstack([ring, [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]])

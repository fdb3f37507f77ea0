"""Surface models for pose estimation: sampled points and normals, symmetries, nearest-neighbour grid.

Derived from the object models that scenarios use, so that a product needs one description only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from cramlite.model import Feature, Floats, Pose, Thing, Value
from cramlite.plugin import UserError

from ...shapes.files import closed
from ...shapes.solid import geom_mesh, mesh_of

Floats32 = NDArray[np.floating[Any]]  # float32 wherever speed counts
Indices = NDArray[np.int32]
SPACING = 0.0018
"""Mean distance of surface points [m]: a pixel at 0.7 m. Twice as dense changes no figure (tests/benchmarks)."""
FEWEST, MOST = 1500, 9000
MARGIN = 0.025
"""Distance around a model within which its nearest points are known [m]: coarse registration starts within it."""
CELLS = 100
"""Grid cells along the longest side, at most; a cell has at least 2 mm."""
EXACT = 2.5
"""Cells from the surface within which the nearest point is searched for exactly; farther away the one in the nearest
cell that has any will do, at a third of the time."""
SAME = 0.0012
"""Largest distance between two surfaces that a camera cannot tell apart [m]: half its noise at 0.6 m."""
WITHIN = 0.998
"""Share of a surface's points that a symmetry maps onto the surface: all but flaws of a mesh."""
FIRST = 8
"""Only every so many points are compared at first; most transforms are refused by these."""


class NearestGrid(Value, eq=False):
    """Nearest-neighbour lookup table: the surface point nearest to each cell of a voxel grid.

    Args:
        low: corner of the box; step: of a cell [m].
        index: (nx, ny, nz) of the nearest point to each cell's centre.
    """

    low: Floats32
    step: float
    index: Indices

    def look_up(self, points: Floats32) -> Indices:
        """Return the indices (...) of the surface points nearest to points (..., 3) [m].

        Outside of the grid those of its nearest cell.
        """
        x, y, z = (self._cell(points[..., k], k) for k in range(3))
        _, sy, sz = self.index.shape
        return np.asarray(np.take(self.index.reshape(-1), (x * sy + y) * sz + z))

    def _cell(self, coordinates: Floats32, axis: int) -> Indices:
        """Return the index of the grid cell that each coordinate along one axis falls in; outside of the
        grid, of the nearest cell."""
        cell = ((coordinates - self.low[axis]) * np.float32(1.0 / self.step)).astype(np.int32)
        return np.asarray(np.minimum(np.maximum(cell, 0), self.index.shape[axis] - 1))


class Lookups(Value, eq=False):
    """Tables of a surface model that take some 0.15 s to make: see ``PoseModel.grid`` and ``PoseModel.opposite_points``."""

    grid: NearestGrid
    opposite: Indices


class PoseModel(Value, eq=False, dict=True):
    """Surface model of a thing for pose estimation, in the thing's frame.

    Args:
        name, type: of the product.
        points, normals: (N, 3) of the outer surface, normals outwards [m].
        symmetries: transforms that leave the surface as it is, the identity first; a round thing has one a 5 degrees.
        axis: of a continuous symmetry, None if there is none.
        features: the thing's: holes, pegs, faces.
        lookups: made before; None to make them when they are needed.
    """

    name: str
    type: str
    points: Floats32
    normals: Floats32
    symmetries: tuple[Pose, ...] = (Pose(),)
    axis: tuple[float, float, float] | None = None
    features: tuple[Feature, ...] = ()
    lookups: Lookups | None = None

    @cached_property
    def surface(self) -> Floats32:
        """Return surface points and their normals side by side, (N, 6), so that one lookup gives both."""
        return np.concatenate([self.points, self.normals], axis=1)

    @cached_property
    def centre(self) -> Floats:
        """Return the centre (3,) of the model's bounding box [m]."""
        return np.asarray((self.points.min(0) + self.points.max(0)) / 2, dtype=float)

    @cached_property
    def extents(self) -> Floats:
        """Return the side lengths (3,) of the model's bounding box [m]."""
        return np.asarray(np.ptp(self.points, axis=0), dtype=float)

    @property
    def diameter(self) -> float:
        """Return the diagonal of the model's bounding box [m]."""
        return float(np.linalg.norm(self.extents))

    @cached_property
    def tree(self) -> Any:
        """Return a k-d tree (scipy's cKDTree) of the model's surface points."""
        return cKDTree(self.points)

    @cached_property
    def grid(self) -> NearestGrid:
        """Return the nearest-neighbour grid around the surface; made once, in some 0.1 s."""
        return self.lookups.grid if self.lookups else _grid(self.points, self.tree)

    @cached_property
    def opposite_points(self) -> Indices:
        """Return for each point on a plate up to 6 mm thick the index of the nearest point on its other
        side; else the point's own index."""
        return self.lookups.opposite if self.lookups else _opposite(self.points, self.normals, self.tree)

    def difference(self, pose: Pose, truth: Pose) -> tuple[float, float]:
        """Return the pose error (m, rad) up to the model's symmetries; metres at the model's centre."""
        same = self.symmetries if self.axis is None else self.symmetries[:2]  # turns about the axis change neither
        return min((self._apart(pose * s, truth) for s in same), key=lambda d: d[1] + d[0])

    def _apart(self, pose: Pose, truth: Pose) -> tuple[float, float]:
        metres = float(np.linalg.norm(pose.apply(self.centre) - truth.apply(self.centre)))
        if self.axis is not None:
            cosine = float(pose.rotate(self.axis) @ truth.rotate(self.axis))
            return metres, float(np.arccos(np.clip(cosine, -1, 1)))
        return metres, pose.distance(truth)[1]


def _grid(points: Floats32, tree: Any) -> NearestGrid:
    low, size = points.min(0) - MARGIN, np.ptp(points, axis=0) + 2 * MARGIN
    step = max(0.002, float(size.max()) / CELLS)
    shape = np.ceil(size / step).astype(int)
    cell_of = np.minimum(((points - low) / step).astype(int), shape - 1)
    index = np.full(shape, -1, np.int32)
    index[tuple(cell_of.T)] = np.arange(len(points))
    away, nearest = ndimage.distance_transform_edt(index < 0, return_indices=True)
    index = index[tuple(nearest)]
    close = np.argwhere(away <= EXACT)
    index[tuple(close.T)] = tree.query(low + step * (close + 0.5))[1]
    return NearestGrid(low.astype(np.float32), step, index)


def _opposite(points: Floats32, normals: Floats32, tree: Any) -> Indices:
    near, which = tree.query(points, k=48, distance_upper_bound=0.006)
    which = np.where(np.isfinite(near), which, np.arange(len(points))[:, None])
    away = np.einsum("ij,ikj->ik", normals, normals[which]) < -0.7
    first = np.argmax(away, axis=1)
    rows = np.arange(len(points))
    return np.asarray(np.where(away.any(1), which[rows, first], rows), dtype=np.int32)


class ModelKey(Value, eq=False):
    """Cache key of a model, compared by its text only."""

    text: str
    thing: Thing

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ModelKey) and other.text == self.text

    def __hash__(self) -> int:
        return hash(self.text)


def surface_of(thing: Thing) -> PoseModel:
    """Return the surface model of a thing; sampled once for each shape.

    Raises:
        UserError: it has no shape, or one without a surface.
    """
    return _kept(ModelKey(repr(thing), thing))


@lru_cache(maxsize=64)
def _kept(key: ModelKey) -> PoseModel:
    return pose_model(key.thing)


def pose_model(thing: Thing, seed: int = 0) -> PoseModel:
    """Sample the surface model of a thing: of its mesh file where it was made from one, else of its geoms.

    Raises:
        UserError: it has no shape, or one without a surface.
    """
    if not thing.geoms:
        raise UserError(f"'{thing.name}' has no shape, so its pose cannot be found; give its model geoms or a mesh.")
    if thing.mesh is not None and Path(thing.mesh.path).is_file():
        return mesh_model(mesh_of(thing), thing.name, thing.type, thing.features, seed)
    solids = [geom_mesh(g) for g in thing.geoms]
    area = sum(float(s.area) for s in solids)
    if not np.isfinite(area) or area <= 0:
        raise UserError(f"'{thing.name}' has a surface of {area} m2, so its pose cannot be found; check its shape.")
    points, normals = _surface(solids, _count(area), seed)
    model = PoseModel(thing.name, thing.type, points, normals, features=thing.features)
    return with_symmetries(model)


def mesh_model(mesh: Any, name: str, type_: str, features: Sequence[Feature] = (), seed: int = 0) -> PoseModel:
    """Sample the surface model of a triangle mesh (trimesh) [m].

    A mesh that is not closed is closed first, as for collision: which side of a triangle is outside, only a closed
    mesh says.

    Raises:
        UserError: it has no triangles, no area, or cannot be closed.
    """
    if len(getattr(mesh, "faces", ())) == 0 or not np.isfinite(mesh.area) or mesh.area <= 0:
        raise UserError(f"'{name}' is a mesh without triangles or without area, so its pose cannot be found.")
    if float(np.min(mesh.extents)) < 1e-5:
        raise UserError(f"'{name}' is a flat mesh, {mesh.extents} m, and encloses no volume; give it a thickness.")
    whole = mesh if mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0 else closed(mesh, name).mesh
    points, normals = _sample(whole, _count(float(whole.area)), seed)
    return with_symmetries(PoseModel(name, type_, points, normals, features=tuple(features)))


def with_symmetries(model: PoseModel) -> PoseModel:
    """Return the model with its rotational symmetries: any of the 24 rotations of a cube, or all turns about
    an axis."""
    turns, limit = cube_rotations(), SAME + _gap(model)
    found = [Pose()] + [p for p in (_about(model, q) for q in turns[1:]) if _invariant(model, p, limit)]
    for k in range(3):
        axis = tuple(float(i == k) for i in range(3))
        odd = [_about(model, Pose.from_rotvec((0, 0, 0), [v * a for v in axis])) for a in (0.3, 1.1, 2.0)]
        if all(_invariant(model, p, limit) for p in odd):
            turned = [Pose.from_rotvec((0, 0, 0), [v * math.radians(a) for v in axis]) for a in range(5, 360, 5)]
            around = [_about(model, p) for p in turned]
            flips = [p for p in found[1:] if abs(p.rotate(axis)[k] + 1) < 1e-6][:1]
            return replace(model, symmetries=(Pose(), *flips, *around), axis=axis)
    return replace(model, symmetries=tuple(found))


@lru_cache(maxsize=1)
def cube_rotations() -> tuple[Pose, ...]:
    """Return the 24 proper rotations that map the axes onto the axes, the identity first."""
    found = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            matrix = np.zeros((3, 3))
            matrix[range(3), order] = signs
            if np.linalg.det(matrix) > 0:
                found.append(Pose.from_matrix(matrix))
    return tuple(sorted(found, key=lambda p: -abs(p.quaternion[0])))


def _about(model: PoseModel, turn: Pose) -> Pose:
    """A rotation about the model's centre."""
    centre = model.centre
    return Pose(tuple(centre - turn.rotate(centre)), turn.quaternion)


def _some(model: PoseModel) -> Floats32:
    return model.points[:: max(1, len(model.points) // 800)]


def _gap(model: PoseModel) -> float:
    """Sampling error of a model's surface: the distance between neighbouring points, which 1 of 100 exceeds [m]."""
    return float(np.quantile(model.tree.query(_some(model), k=2)[0][:, 1], 0.99))


def _invariant(model: PoseModel, pose: Pose, limit: float) -> bool:
    """Whether a transform maps the model's surface onto itself to within ``limit`` [m], except for 2 points of 1000.

    A few points refuse most transforms, so they are looked at first.
    """
    turned = pose.apply(_some(model))
    allowed = len(turned) - math.floor(WITHIN * (len(turned) - 1)) - 1
    if (model.tree.query(turned[::FIRST])[0] >= limit).sum() > allowed:
        return False
    return bool(np.quantile(model.tree.query(turned)[0], WITHIN) < limit)


def _count(area: float) -> int:
    return int(np.clip(area / SPACING**2, FEWEST, MOST))


def _surface(solids: Sequence[Any], count: int, seed: int) -> tuple[Floats32, Floats32]:
    """Points on the outside of a union of convex solids."""
    area = sum(float(s.area) for s in solids)
    points, normals = [], []
    for i, solid in enumerate(solids):
        p, n = _sample(solid, max(12, round(1.2 * count * float(solid.area) / area)), seed + i)
        hidden = np.zeros(len(p), bool)
        for other in solids[:i] + solids[i + 1 :]:  # type: ignore[operator]
            hidden |= _inside(other, p)
        points.append(p[~hidden])
        normals.append(n[~hidden])
    return np.concatenate(points), np.concatenate(normals)


def _sample(mesh: Any, count: int, seed: int) -> tuple[Floats32, Floats32]:
    """About ``count`` evenly spread points of a mesh's surface and the normals there: thrice as many random points,
    without those that are near another one."""
    import trimesh

    points, faces = trimesh.sample.sample_surface(mesh, 3 * count, seed=seed)
    points, kept = trimesh.points.remove_close(points, float(np.sqrt(mesh.area / (3 * count))))
    faces = faces[kept]
    return points.astype(np.float32), mesh.face_normals[faces].astype(np.float32)


def _inside(solid: Any, points: Floats32) -> NDArray[np.bool_]:
    """Mask of points inside a convex solid by more than 10 um."""
    normals = solid.face_normals
    offsets = np.einsum("ij,ij->i", normals, solid.triangles[:, 0])
    low, high = solid.bounds
    near = ((points > low) & (points < high)).all(1)
    inside = np.zeros(len(points), bool)
    inside[near] = (points[near] @ normals.T - offsets).max(1, initial=-np.inf) < -1e-5
    return inside

"""Textured surfaces of mesh files: triangles, their place in an image, and the colour of any point on
them."""

from __future__ import annotations

from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from cramlite.model import Floats, KindJoint, MeshFile, Value

FINDER = 0.002
"""Mean distance between the sample points of a surface by which the triangle at a place is found [m], if
``MOST`` of them suffice."""
MOST = 60_000
NEAR = 4
"""Number of nearest sample points whose triangles are compared: where triangles are smaller than ``FINDER``,
the nearest point may be the neighbour's."""
TURNED = 0.005
"""Distance that counts as much as a difference of 1 rad between the normals of triangles [m]: it tells apart
the two sides of an edge, and of a thin wall."""


class Skin(Value, eq=False, dict=True):
    """Textured surface of a thing, in its frame.

    Args:
        corners: (F, 3, 3) of the triangles [m].
        places: (F, 3, 2) of the corners in the image, 0 to 1; the first number to the right, the second
            upwards.
        image: (height, width, 3) uint8.
    """

    corners: Floats
    places: Floats
    image: Any

    @cached_property
    def _finder(self) -> tuple[Any, Any]:
        """K-d tree of points on the surface and their normals, and the triangle of each."""
        from scipy.spatial import cKDTree

        sides = self.corners[:, 1:] - self.corners[:, :1]
        areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
        count = int(np.clip(areas.sum() / FINDER**2, 2000, MOST))
        own = np.arange(len(areas))
        face = np.concatenate([own, np.random.default_rng(0).choice(own, count, p=areas / areas.sum())])
        weight = np.random.default_rng(1).dirichlet((1.0, 1.0, 1.0), len(face))
        points = np.einsum("nk,nkj->nj", weight, self.corners[face])
        return cKDTree(np.concatenate([points, TURNED * self.normals[face]], axis=1)), face

    @cached_property
    def normals(self) -> Floats:
        """Return the unit normals (F, 3) of the triangles; zero of those without area."""
        sides = self.corners[:, 1:] - self.corners[:, :1]
        cross = np.cross(sides[:, 0], sides[:, 1])
        return np.asarray(cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-15))

    def colours_at(self, points: Floats, normals: Floats) -> Floats:
        """Return the colours (N, 3), 0 to 255, of a surface at points (N, 3) [m] with normals (N, 3)."""
        import trimesh

        if not len(points):
            return np.zeros((0, 3))
        chosen, on = self.triangles_at(points, normals)
        share = trimesh.triangles.points_to_barycentric(self.corners[chosen], on, method="cross")
        share = np.clip(np.nan_to_num(share, nan=1 / 3), 0.0, 1.0)
        return self.looked_up(
            np.einsum("nk,nkj->nj", share / share.sum(1, keepdims=True), self.places[chosen])
        )

    def triangles_at(self, points: Floats, normals: Floats) -> tuple[Any, Floats]:
        """Return the triangles (N,) of a surface at points (N, 3) [m] with normals (N, 3), and the nearest
        points (N, 3) on them.

        At an edge, and through a thin wall, points of several triangles are as near.
        """
        import trimesh

        tree, face = self._finder
        near = face[tree.query(np.concatenate([points, TURNED * normals], axis=1), k=NEAR)[1]]
        corners = self.corners[near.reshape(-1)]
        closest = trimesh.triangles.closest_point(corners, np.repeat(points, NEAR, axis=0))
        away = np.linalg.norm(closest.reshape(-1, NEAR, 3) - points[:, None], axis=2)
        away += TURNED * np.linalg.norm(self.normals[near] - normals[:, None], axis=2)
        rows, best = np.arange(len(points)), away.argmin(axis=1)
        on = closest.reshape(-1, NEAR, 3)[rows, best]
        return near[rows, best], on

    def looked_up(self, places: Floats) -> Floats:
        """Return the colours (N, 3), 0 to 255, at places (N, 2) of the image, which repeats beyond its
        borders."""
        height, width = self.image.shape[:2]
        inside = places - np.floor(places)
        inside = np.where((inside == 0.0) & (places != 0.0), 1.0, inside)
        column = np.minimum((inside[:, 0] * width).astype(np.int64), width - 1)
        row = np.minimum(((1.0 - inside[:, 1]) * height).astype(np.int64), height - 1)
        return np.asarray(self.image[row, column], dtype=float)


def skin_of(mesh: MeshFile | None) -> Skin | None:
    """Return the textured surface of a mesh file; None if there is no file, or it has no texture.

    Raises:
        UserError: the file is there and cannot be read.
    """
    path = Path(mesh.path) if mesh is not None else None
    if mesh is None or path is None or not path.is_file():
        return None
    skin = _read(path, mesh.scale, path.stat().st_mtime_ns)
    return _moved(skin, mesh.joints, mesh.values) if skin is not None and mesh.values else skin


@lru_cache(maxsize=128)
def _moved(skin: Skin, joints: tuple[KindJoint, ...], values: tuple[float, ...]) -> Skin:
    """Return a surface with its joints at other values than in its file."""
    corners = skin.corners.copy()
    for moving, value in reversed([*zip(joints, values, strict=True)]):
        step = moving.step(value)
        for first, last in moving.faces:
            corners[first:last] = step.apply(corners[first:last].reshape(-1, 3)).reshape(-1, 3, 3)
    return Skin(corners, skin.places, skin.image)


@lru_cache(maxsize=128)
def _read(path: Path, scale: float, _changed: int) -> Skin | None:
    from .files import read

    return skin_of_mesh(read(path, scale, materials=True))


def skin_of_mesh(mesh: Any) -> Skin | None:
    """Return the textured surface of a trimesh.Trimesh [m]; None without a texture."""
    image = _image(mesh.visual)
    uv = getattr(mesh.visual, "uv", None)
    if image is None or uv is None or len(uv) != len(mesh.vertices):
        return None
    pixels = np.asarray(image.convert("RGB"), dtype=np.uint8)
    return Skin(np.asarray(mesh.triangles, float), np.asarray(uv, float)[mesh.faces], pixels)


def _image(visual: Any) -> Any:
    """Texture image of a mesh's material; None without one."""
    material = getattr(visual, "material", None)
    for name in ("baseColorTexture", "image"):
        found = getattr(material, name, None)
        if found is not None:
            return found
    return None

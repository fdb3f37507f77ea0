"""Words for the shape and the colours of an object model, from its triangles and texture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from cramlite.model import Floats, Looks, colour_words

SAMPLES = 6000
"""Number of points of the surface whose colours are looked at."""
LARGE, SMALL = 0.2, 0.03
"""Least shares of the surface that one colour covers: of a colour by which people call a thing, and of one that they see on it."""
SOLID, RECESS = 0.85, 0.1
"""Least share of each side of the convex hull that has surface beside it: less has a vessel. And how far inside that surface may be,
relative to the longest side: the lids of cans are recessed by 8 %."""
FULL = 0.8
"""Share of its bounding box that a box fills at least; cartons fill 0.84 to 1, bottles and cans at most 0.73."""
ROUND, SQUAT = 0.85, 0.6
"""Least ratio of the horizontal sides of a can, and of its height to its width; a slim one is none."""
SLICES = 8
"""Slices across the height, in each of which the radius is taken."""
NECK, SLIM = 0.75, 1.8
"""Largest radius of a bottle's neck, relative to its largest one, and least ratio of its height to its width."""


def looks_of(mesh: Any, up: str, *, loose: bool) -> Looks:
    """Return the words for the looks of a mesh with a texture.

    Args:
        mesh: trimesh.Trimesh, in metres.
        up: axis that usually points up, "y" or "-z"; "" where that is not known.
        loose: whether it can be moved: furniture is not called by its shape.
    """
    import trimesh

    points, faces = trimesh.sample.sample_surface(mesh, SAMPLES, seed=1)
    count = Counter(word for rgb in _colours(mesh, points, faces) for word in colour_words(tuple(rgb.tolist())))
    shares = [(word, n / SAMPLES) for word, n in count.most_common()]
    large = tuple(word for word, share in shares if share >= LARGE)
    return Looks(tuple(_nouns(mesh, points, up)) if loose else (), large, tuple(w for w, share in shares if SMALL <= share < LARGE))


def _colours(mesh: Any, points: Floats, faces: Any) -> Floats:
    """Colours (N, 3) of points on a mesh's faces, each channel 0 to 1."""
    from trimesh.triangles import points_to_barycentric
    from trimesh.visual.color import uv_to_color

    with np.errstate(divide="ignore", invalid="ignore"):
        weights = np.nan_to_num(points_to_barycentric(mesh.triangles[faces], points), nan=1 / 3)
    places = (mesh.visual.uv[mesh.faces[faces]] * weights[:, :, None]).sum(axis=1)
    return np.asarray(uv_to_color(places, mesh.visual.material.baseColorTexture)[:, :3] / 255.0)


def _nouns(mesh: Any, points: Floats, up: str) -> Iterator[str]:
    """Yield the noun for a shape; none for vessels, furniture, and what has several parts."""
    import trimesh

    hull, size = trimesh.convex.convex_hull(mesh.vertices), np.ptp(mesh.vertices, axis=0)
    if not _solid(hull, points, float(size.max())):
        return
    if hull.volume >= FULL * float(np.prod(size)):
        yield "box"
        return
    axis = "xyz".index(up[-1]) if up else int(np.argmax(size))
    sides, radii = np.delete(size, axis), _radii(points, axis, up.startswith("-"))
    slim = size[axis] / sides.max()
    ways = [radii] if up else [radii, radii[::-1]]
    if slim >= SLIM and any(way[: SLICES // 2].min() > 1 - NECK and way[-2:].max() < NECK for way in ways):
        yield "bottle"
    elif sides.min() >= ROUND * sides.max() and radii.min() >= ROUND and SQUAT <= slim <= SLIM:
        yield "can"


def _solid(hull: Any, points: Floats, size: float) -> bool:
    """Whether a surface has a part beside each side of its convex hull."""
    import trimesh
    from scipy.spatial import cKDTree

    outside, faces = trimesh.sample.sample_surface(hull, SAMPLES // 3, seed=1)
    beside = cKDTree(points).query(outside)[0] < RECESS * size
    normals = hull.face_normals[faces]
    axis = np.abs(normals).argmax(axis=1)
    side = 2 * axis + (normals[np.arange(len(axis)), axis] > 0)
    return all(np.mean(beside[side == k]) > SOLID for k in range(6) if np.mean(side == k) > SMALL)


def _radii(points: Floats, axis: int, down: bool) -> Floats:
    """Radii (SLICES,) of a surface from its lower to its upper end, relative to the largest one."""
    low, high = points.min(axis=0), points.max(axis=0)
    apart = np.linalg.norm(np.delete(points - (low + high) / 2, axis, axis=1), axis=1)
    at = np.clip((points[:, axis] - low[axis]) / (high - low)[axis] * SLICES, 0, SLICES - 1e-9).astype(int)
    found = np.array([np.percentile(apart[at == k], 95) if (at == k).any() else 0.0 for k in range(SLICES)])
    return np.asarray((found[::-1] if down else found) / found.max())

"""Convex hulls, and convex decomposition of a mesh that keeps its holes: simulators collide a mesh by its
convex hull.

Approximate convex decomposition by planes: the piece whose hull adds most volume is cut by the candidate
plane that leaves the least, until every hull follows its piece (the greedy form of Wei et al., CoACD, ACM TOG
41(4), 2022). Round holes are cut into wedges about their axis first, because a plane never follows a circle:
the hull of a wedge of angle a reaches r (1 - cos(a / 2)) into a hole of radius r, 0.08 mm into one of 9 mm.

Of libraries: coacd 1.0.14 aborts the process by a failed assertion on a mug made by a boolean (measured), and
vhacdx works on voxels of a wall's thickness. Cuts are manifold3d's, which are exact and always closed.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import manifold3d
import numpy as np

from cramlite.model import Floats, Value, Vector3
from cramlite.plugin import checkpoint

MOST = 72  # parts of one mesh
DEPTH = 0.0015  # how far a hull may fill in a hollow [m], and
BULGE = 0.12  # how much volume it may add to its piece
SPARED = 0.02  # a hull that adds no more than this is taken whatever its depth
SECTORS = 16  # wedges about a hole
RIM = 1.6  # radius of what is cut into wedges, in radii of the hole
# Radius that no hull may reach into, in radii of the hole: hulls of wedges reach to cos(pi / SECTORS) = 0.98
OPEN = 0.95
SHARP = math.radians(15)  # concave edges above this are edges of a shape, not facets of a round one
EVEN = 0.2  # how much the worst half counts beside the sum of both
FINEST = 1e-6  # coordinates are rounded to this [m]
NOTHING = 1e-12  # volumes up to this are left out [m3]


class Bore(Value):
    """A round through hole: its centre, unit axis, radius and depth to either side [m]."""

    centre: Floats
    axis: Floats
    radius: float
    half: float


Plane = tuple[Floats, float]  # unit normal n and offset d: n x = d


@lru_cache(maxsize=4096)
def hull_planes(corners: tuple[Vector3, ...]) -> Floats:
    """Compute the planes (n, 4) of the convex hull of points: outward unit normal and offset, n x + d <= 0
    inside."""
    from scipy.spatial import ConvexHull

    checkpoint()
    planes: Floats = np.unique(np.round(ConvexHull(corners).equations, 9), axis=0)
    return planes


@lru_cache(maxsize=4096)
def hull_volume(corners: tuple[Vector3, ...]) -> float:
    """Compute the volume of the convex hull of points [m3]."""
    from scipy.spatial import ConvexHull

    return float(ConvexHull(corners).volume)


def parts(vertices: Floats, faces: Any, bores: Sequence[Bore] = ()) -> list[Floats]:
    """Decompose a closed mesh into convex parts: the corners (n, 3) of each, the largest part first.

    Raises:
        ValueError: the mesh does not enclose a volume that manifold3d accepts.
    """
    body = solid(vertices, faces)
    pieces: list[Any] = []
    light = manifold3d.Manifold.batch_boolean([_cylinder(b, OPEN) for b in bores], manifold3d.OpType.Add)
    for bore in bores:
        column = _cylinder(bore, RIM / math.cos(math.pi / SECTORS))
        pieces += [p for wedge in _wedges(bore) for p in _connected(body ^ column ^ wedge)]
        body = body - column
    box = np.asarray(np.stack([vertices.min(axis=0), vertices.max(axis=0)]))
    pieces += _connected(body)
    hulls = [_corners(p) for p in _refined(pieces, light, box.mean(axis=0))]
    return sorted(
        (h for h in hulls if h is not None),
        key=lambda h: (-hull_volume(tuple(map(tuple, h.tolist()))), h.tolist()),
    )


def solid(vertices: Floats, faces: Any) -> Any:
    """Convert a closed mesh to a Manifold of the library manifold3d.

    Raises:
        ValueError: it is not closed, with manifold3d's reason.
    """
    mesh = manifold3d.Mesh64(np.array(vertices, np.float64), np.array(faces, np.uint64))
    mesh.merge()
    body = manifold3d.Manifold(mesh)
    if body.status() != manifold3d.Error.NoError or body.volume() <= 0:
        raise ValueError(f"not a closed volume ({body.status().name})")
    return body


def _refined(pieces: list[Any], light: Any, centre: Floats) -> Iterator[Any]:
    """Yield the pieces of a solid, cut until the hull of each fits it and closes no hole; the piece whose
    hull adds most volume is cut first."""
    count = itertools.count()
    heap = [(-_excess(p), next(count), p) for p in pieces]
    heapq.heapify(heap)
    done = 0
    while heap:
        _, _, piece = heapq.heappop(heap)
        halves = [] if _fits(piece, light) or done + len(heap) + 1 >= MOST else _cut(piece, centre)
        if not halves:
            done += 1
            yield piece
        for half in halves:
            heapq.heappush(heap, (-_excess(half), next(count), half))


def _excess(piece: Any) -> float:
    return float(piece.hull().volume() - piece.volume())


def _fits(piece: Any, light: Any) -> bool:
    """Whether the hull of a piece adds little volume, fills no deep hollow, and stays out of the free space
    of a hole.

    A hole is checked by itself, since the depth of hollows does not show it: all corners of a plate with a
    hole are on the surface of the plate's hull.
    """
    if (piece.hull() ^ light).volume() > NOTHING:
        return False
    added = _excess(piece) / max(piece.volume(), 1e-15)
    return added < SPARED or (added < BULGE and float(_depths(piece).max(initial=0.0)) < DEPTH)


def _depths(piece: Any) -> Floats:
    """Return how deep each vertex of a solid piece lies inside the piece's convex hull [m]."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.asarray(piece.to_mesh64().vert_properties)[:, :3]
    try:
        planes = np.unique(np.round(ConvexHull(points).equations, 9), axis=0)
    except QhullError:
        return np.zeros(len(points))
    result: Floats = -(points @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    return result


def _cut(piece: Any, centre: Floats) -> list[Any]:
    """Cut a piece by the plane that leaves the least hull volume; return the connected parts, none if no
    plane divides it.

    The largest excess of one part's hull counts, too: the first cut through a bowl gains nothing, but lets
    the next ones gain.
    """
    best, least = [], math.inf
    for normal, offset in _planes(piece, centre):
        sides = piece.split_by_plane(normal.tolist(), offset)
        halves = [p for s in sides for p in _connected(s)]
        hulls = [(p.hull().volume(), p.volume()) for p in halves]
        cost = sum(h for h, _ in hulls) + EVEN * max((h - v for h, v in hulls), default=0.0)
        if len(halves) > 1 and cost < least:
            best, least = halves, cost
    return best


def _planes(piece: Any, centre: Floats) -> Iterator[Plane]:
    """Planes that may cut a piece: across the axes, where hollows are deepest and in between; tilted ones
    through a given centre; and along concave edges."""
    mesh = piece.to_mesh64()
    points, depths = np.asarray(mesh.vert_properties)[:, :3], _depths(piece)
    low, high = points.min(axis=0), points.max(axis=0)
    deep = points[depths > 0.5 * depths.max(initial=0.0)]
    for axis, normal in enumerate(np.eye(3)):
        offsets = [low[axis] + share * (high[axis] - low[axis]) for share in (0.25, 0.5, 0.75)]
        offsets += np.quantile(deep[:, axis], (0.0, 0.5, 1.0), method="nearest").tolist() if len(deep) else []
        for offset in dict.fromkeys(np.round(offsets, 7).tolist()):
            if low[axis] + DEPTH < offset < high[axis] - DEPTH:
                yield normal, offset
    for one, other in ((0, 1), (1, 2), (0, 2)):
        for k in (1, 2, 3, 5, 6, 7):
            normal = np.zeros(3)
            normal[one], normal[other] = math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)
            yield normal, float(normal @ centre)
    yield from _along_edges(points, np.asarray(mesh.tri_verts))


def _along_edges(points: Floats, faces: Any) -> Iterator[Plane]:
    """The planes of faces beside sharp concave edges, the largest first."""
    import trimesh

    mesh = trimesh.Trimesh(points, faces, process=False)
    concave = ~mesh.face_adjacency_convex & (mesh.face_adjacency_angles > SHARP)
    beside = np.unique(mesh.face_adjacency[concave])
    area: dict[tuple[float, ...], float] = {}
    for f in beside.tolist():
        normal = mesh.face_normals[f]
        key = (*np.round(normal, 4).tolist(), round(float(normal @ points[faces[f, 0]]), 6))
        area[key] = area.get(key, 0.0) + float(mesh.area_faces[f])
    for key in sorted(area, key=lambda k: (-area[k], k))[:8]:
        yield np.asarray(key[:3]), key[3]


def _cylinder(bore: Bore, width: float) -> Any:
    """Prism of SECTORS sides along a hole and a little beyond, its corners at a multiple of the hole's
    radius."""
    height = 2 * bore.half + 0.002
    return _placed(manifold3d.Manifold.cylinder(height, width * bore.radius, -1.0, SECTORS, True), bore)


def _wedges(bore: Bore) -> Iterator[Any]:
    """Sectors of the column of material around a hole; their sides meet in the hole's axis."""
    outer, height = 2.5 * RIM * bore.radius, 2 * bore.half + 0.004
    for k in range(SECTORS):
        turns = [math.tau * (k + s) / SECTORS for s in (0, 1)]
        corners = [(0.0, 0.0), *((outer * math.cos(a), outer * math.sin(a)) for a in turns)]
        prism = manifold3d.Manifold.extrude(manifold3d.CrossSection([corners]), height).translate(
            (0, 0, -height / 2)
        )
        yield _placed(prism, bore)


def _placed(shape: Any, bore: Bore) -> Any:
    other = np.eye(3)[int(np.argmin(np.abs(bore.axis)))]
    x = np.cross(bore.axis, other)
    x /= np.linalg.norm(x)
    frame = np.column_stack([x, np.cross(bore.axis, x), bore.axis, bore.centre])
    return shape.transform(frame)


def _connected(shape: Any) -> list[Any]:
    return [p for p in shape.decompose() if p.volume() > NOTHING]


def _corners(piece: Any) -> Floats | None:
    """Corners of the convex hull of one piece of a mesh; None for a piece of almost no volume."""
    from scipy.spatial import ConvexHull, QhullError

    points = (
        np.round(np.asarray(piece.hull().simplify(2e-5).to_mesh64().vert_properties)[:, :3] / FINEST) * FINEST
    )
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    found = np.unique(points[hull.vertices], axis=0)
    return found if hull.volume > NOTHING and len(found) >= 4 else None

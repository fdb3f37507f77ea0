"""Openings through a closed shape: round holes to hang it by, and handles, found in its silhouettes.

Looked along an axis, an opening is a hole in the silhouette. A silhouette's hole is what is open all the way,
so no cavity is mistaken for a hole.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import manifold3d
import numpy as np
from msgspec.structs import replace

from cramlite.model import Feature, Floats, Pose, Value

from .convex import Bore, solid

SQUARE = 0.03  # relative deviation of a ring from a square
ROUND = 1.12  # farthest to nearest edge of a round hole from its centre; a hexagon has 1.15
NARROW = 0.001  # openings with a smaller radius are ignored [m]
PEG_HOLE = 0.015  # holes up to this radius are there to hang a thing by; wider ones are not [m]
BAR = 0.030  # material beside an opening up to this thickness is a handle [m]
FACET = 0.05  # a face of this share of the surface gives an axis to look along


class Opening(Value):
    """Hole that was found in a thing's silhouette: its position and size, and the handle that borders it, if
    there is one."""

    bore: Bore
    round: bool
    feature: Feature


def openings(mesh: Any) -> list[Opening]:
    """Find the openings of a closed trimesh.Trimesh: round holes and handles.

    An opening that several directions of view show is found once; along each axis the roundest come first.
    """
    body, found = solid(mesh.vertices, mesh.faces), list[Opening]()
    centre = np.asarray(mesh.center_mass)
    for axis in _axes(mesh):
        for opening in _along(body, axis, centre):
            apart = [np.linalg.norm(o.bore.centre - opening.bore.centre) for o in found]
            if all(d > max(o.bore.radius, opening.bore.radius) for d, o in zip(apart, found, strict=True)):
                found.append(opening)
    return [_numbered(o, found) for o in found]


def holes(mesh: Any) -> list[Feature]:
    """Find the through holes of a closed trimesh.Trimesh, however wide, looking along its three axes.

    A square hole has a ``width``, and the axes of its pose are along its sides.
    """
    body, centre = solid(mesh.vertices, mesh.faces), np.asarray(mesh.center_mass)
    found = [hole for axis in np.eye(3)[[2, 1, 0]] for hole in _through(body, _frame(axis), centre)]
    return [replace(hole, name=f"hole{k + 1 if k else ''}") for k, hole in enumerate(found)]


def _through(body: Any, frame: Floats, centre: Floats) -> Iterator[Feature]:
    rings = [r for r in _rings(body, frame) if _area(r) < 0]
    for ring in sorted(rings, key=_area):
        middle = _middle(ring)
        near, far = _distance(middle, ring), float(np.linalg.norm(ring - middle, axis=1).max())
        if near < NARROW:
            continue
        low, high = _reach(body, frame, middle, 1.3 * far)
        bore = Bore(frame @ np.array([*middle, (low + high) / 2]), frame[:, 2], near, (high - low) / 2)
        hole, side = _hole(bore, centre), _square_side(ring)
        yield hole if side is None else _squared(hole, bore, frame[:, :2] @ side)


def _square_side(ring: Floats) -> Floats | None:
    """Unit vector (2,) along a side of a closed polygon, if the polygon is a square; else None."""
    ways = np.roll(ring, -1, axis=0) - ring
    corner = np.abs([_cross(a, b) for a, b in zip(np.roll(ways, 1, axis=0), ways, strict=True)]) > 1e-9
    ways = np.roll(ring[corner], -1, axis=0) - ring[corner]
    if len(ways) != 4:
        return None
    lengths = np.linalg.norm(ways, axis=1)
    leaning = np.abs([a @ b for a, b in pairwise(ways)]).max() / lengths.mean() ** 2
    way: Floats = ways[0] / lengths[0]
    return way if np.ptp(lengths) < SQUARE * lengths.mean() and leaning < SQUARE else None


def _cross(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _squared(hole: Feature, bore: Bore, side: Floats) -> Feature:
    """Square hole as a feature: its y axis is perpendicular to the side that is farthest from the centre
    of mass."""
    up = hole.pose.rotation[:, 1]
    across = max(
        (side, -side, np.cross(bore.axis, side), -np.cross(bore.axis, side)), key=lambda v: float(v @ up)
    )
    pose = Pose.from_axes(hole.pose.position, bore.axis, np.cross(across, bore.axis))
    return replace(hole, pose=pose, size={**hole.size, "width": 2 * bore.radius})


def _rings(body: Any, frame: Floats) -> list[Floats]:
    """The rings (n, 2) of a silhouette; those of its holes have a negative area."""
    return [
        np.asarray(r) for r in body.transform(np.column_stack([frame.T, np.zeros(3)])).project().to_polygons()
    ]


def _numbered(opening: Opening, found: list[Opening]) -> Opening:
    """Number the name of an opening among those of the same name: hole, hole2, ..."""
    same = [o for o in found if o.feature.name == opening.feature.name]
    k = next(i for i, o in enumerate(same) if o is opening)
    feature = opening.feature
    name = feature.name + (str(k + 1) if k else "")
    return Opening(opening.bore, opening.round, Feature(name, feature.type, feature.pose, feature.size))


def _axes(mesh: Any) -> Iterator[Floats]:
    """Directions to look along for openings: the file's axes, and the normals of large flat faces."""
    seen: list[Floats] = []
    large = sorted(zip(mesh.facets_area, mesh.facets_normal, strict=True), key=lambda f: -float(f[0]))
    normals = [n for area, n in large[:8] if area > FACET * mesh.area]
    for axis in (*np.eye(3)[[1, 0, 2]], *normals):
        if all(abs(float(axis @ other)) < 0.996 for other in seen):
            seen.append(axis)
            yield np.asarray(axis, dtype=float)


def _along(body: Any, axis: Floats, centre: Floats) -> Iterator[Opening]:
    if (axis[1], axis[0], -axis[2]) > (0.0, 0.0, 0.0):
        axis = -axis  # out of the front, which is -y, or upwards
    frame = _frame(axis)
    rings = _rings(body, frame)
    outer = [r for r in rings if _area(r) > 0]
    for ring in sorted((r for r in rings if _area(r) < 0), key=_area):
        opening = _opening(body, frame, ring, outer, centre)
        if opening is not None:
            yield opening


def _opening(body: Any, frame: Floats, ring: Floats, outer: list[Floats], centre: Floats) -> Opening | None:
    middle = _middle(ring)
    near, far = _distance(middle, ring), float(np.linalg.norm(ring - middle, axis=1).max())
    if near < NARROW:
        return None
    low, high = _reach(body, frame, middle, 1.3 * far)
    at = frame @ np.array([*middle, (low + high) / 2])
    bore = Bore(at, frame[:, 2], near, (high - low) / 2)
    if far / near < ROUND:
        return Opening(bore, True, _hole(bore, centre))
    handle = _handle(body, frame, ring, outer, bore)
    return Opening(bore, False, handle) if handle is not None else None


def _hole(bore: Bore, centre: Floats) -> Feature:
    """Hole as a feature, its y axis pointing away from the centre of mass, which hangs below the hole."""
    up = bore.centre - centre
    up = up - (up @ bore.axis) * bore.axis
    if np.linalg.norm(up) < 0.001:
        up = np.array([0.0, 0.0, 1.0]) if abs(bore.axis[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    kind = "vrps:Hole" if bore.radius <= PEG_HOLE else "soma:Feature"
    name = "hole" if bore.radius <= PEG_HOLE else "opening"
    pose = Pose.from_axes(tuple(bore.centre), bore.axis, np.cross(up, bore.axis))
    return Feature(name, kind, pose, {"diameter": 2 * bore.radius, "depth": 2 * bore.half})


def _handle(body: Any, frame: Floats, ring: Floats, outer: list[Floats], bore: Bore) -> Feature | None:
    """Handle where the material between an opening and the outside is thinnest, z outwards and x along the
    opening's axis; None if the material is thicker than a bar."""
    points = _dense(ring)
    gaps = np.array([min(_distance(p, o) for o in outer) for p in points])
    thin = points[gaps < 1.3 * gaps.min()]
    if gaps.min() > BAR:
        return None
    inner = thin[int(np.argmin(np.linalg.norm(thin - thin.mean(axis=0), axis=1)))]
    out = inner - _middle(ring)
    out = out / np.linalg.norm(out)
    middle = inner + out * gaps.min() / 2
    low, high = _reach(body, frame, middle, float(gaps.min()) / 2)
    size = {"thickness": float(gaps.min()), "width": high - low, "length": 2 * bore.radius}
    at, z = frame @ np.array([*middle, (low + high) / 2]), frame @ np.array([*out, 0.0])
    return Feature("handle", "cram:Handle", Pose.from_axes(tuple(at), z, bore.axis), size)


def _reach(body: Any, frame: Floats, middle: Floats, radius: float) -> tuple[float, float]:
    """Lowest and highest coordinate of a body's material along an axis, within a radius of a line parallel
    to the axis."""
    turned = body.transform(np.column_stack([frame.T, np.zeros(3)]))
    column = manifold3d.Manifold.cylinder(20.0, radius, -1.0, 32, True).translate((*middle.tolist(), 0.0))
    box = (turned ^ column).bounding_box()
    return float(box[2]), float(box[5])


def _frame(axis: Floats) -> Floats:
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(axis, other) / np.linalg.norm(np.cross(axis, other))
    return np.column_stack([x, np.cross(axis, x), axis])


def _area(ring: Floats) -> float:
    x, y = ring[:, 0], ring[:, 1]
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _middle(ring: Floats) -> Floats:
    """The centroid of a polygon."""
    following = np.roll(ring, -1, axis=0)
    cross = ring[:, 0] * following[:, 1] - ring[:, 1] * following[:, 0]
    result: Floats = ((ring + following) * cross[:, None]).sum(axis=0) / (3 * cross.sum())
    return result


def _distance(point: Floats, ring: Floats) -> float:
    """Distance of a point from the nearest edge of a polygon [m]."""
    a, way = ring, np.roll(ring, -1, axis=0) - ring
    along = np.clip(((point - a) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-18), 0.0, 1.0)
    return float(np.linalg.norm(a + along[:, None] * way - point, axis=1).min())


def _dense(ring: Floats, step: float = 0.002) -> Floats:
    """Points along a polygon, no more than a step apart [m]."""
    sides = zip(ring, np.roll(ring, -1, axis=0), strict=True)
    return np.concatenate(
        [
            a + (b - a) * np.linspace(0, 1, max(2, math.ceil(np.linalg.norm(b - a) / step)))[:, None]
            for a, b in sides
        ]
    )

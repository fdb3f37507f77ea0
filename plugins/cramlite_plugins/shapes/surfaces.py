"""Surfaces of things: level upper faces, the things on them, and whether a thing that is released on one
stays there.

A face is level where its normal is within ``LEVEL`` of the vertical, and faces that lie in one plane within
``FLAT`` are one surface: the rim of a pot is one, of twelve boxes. Boxes and cylinders have them
analytically, hulls by their planes; balls and capsules have none.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import shapely

from cramlite.model import Feature, Floats, Geom, Pose, Thing, Value, Vector3, vector3

from .bounds import FLAT_FACED, centre_of_mass, corners, lowest
from .convex import hull_planes
from .itself import Itself

FLAT = 0.002
"""Tolerance of heights [m]: faces that lie in one plane within it are one surface, and points of a thing that
are this near to its lowest one touch what is below."""
LEVEL = math.atan(0.2) / 2
"""Largest slope of a level surface [rad]: half of the 11.3 deg at which wood slides on wood (a friction of
0.2). A plate whose floor is made of boxes that lean by 1.5 deg, and that lies on a box at 3.7 deg, has
one."""
EDGE = 0.005
"""Least distance of a centre of mass from its support's border [m]."""
SURFACE = "vrps:SurfaceFeature"
FINE, HEIGHT = 4, 5
"""Decimals to which the vertical direction in a thing's frame is rounded, and the heights between which its
outline is taken [m]: 0.01 mm at the far end of a thing of 0.2 m. Surfaces lean by as much, so that what is
turned on one does not quite lean as before."""
_ROUND = 8
"""Number of points of a polygon for a quarter of a circle."""

Area = Any
"""A shapely polygon or several, of x and y in the frame of a surface [m]."""


class Surface(Value):
    """Level upper face of a thing.

    Args:
        pose: of its frame, whose z axis is the normal, at the middle of the box around its area.
        area: in that frame.
    """

    pose: Pose
    area: Area


class Standing(Value):
    """Support polygon of a thing, and its centre of mass, seen from above in the frame of a surface.

    Args:
        area: hull of the points that touch what is under it.
        centre: of mass.
    """

    area: Area
    centre: Any


def surfaces(thing: Thing, pose: Pose, part: str = "") -> tuple[Surface, ...]:
    """Find the surfaces of a thing, the largest first.

    Args:
        pose: of the thing in a frame whose z is up.
        part: a feature: only its own surface, as large as it says, if that looks upwards.
    """
    up = tuple(float(v) for v in np.round(pose.inverse().rotate((0.0, 0.0, 1.0)), 6))
    features = (f for f in thing.features if f.name == part and f.type == SURFACE)
    own = (
        tuple(_stated(f) for f in features if f.pose.rotation[:, 2] @ np.array(up) > math.cos(LEVEL))
        if part
        else ()
    )
    found = own or _upper_faces(thing.geoms, up, part)
    return tuple(Surface(pose * s.pose, s.area) for s in found)


def stated_surface(thing: Thing, pose: Pose, part: str) -> Surface | None:
    """Return the surface that a thing's feature of a given name describes; None without such a feature.

    It need not be level: the back of a rack leans.

    Args:
        pose: of the thing in a frame whose z is up.
    """
    own = next((_stated(f) for f in thing.features if f.name == part and f.type == SURFACE), None)
    return Surface(pose * own.pose, own.area) if own else None


def outline(thing: Thing, pose: Pose) -> Surface:
    """Return the outline of a thing as seen from above, at the height of its highest point, for a thing
    without a level surface.

    Args:
        pose: of the thing in a frame whose z is up.
    """
    area, top = footprint(thing, pose), float(corners(thing, pose)[:, 2].max())
    x, y = (float(v) for v in np.reshape(area.bounds, (2, 2)).mean(axis=0))
    return Surface(Pose((x, y, top)), shapely.transform(area, lambda points: points - np.asarray((x, y))))


def _stated(feature: Feature) -> Surface:
    size = feature.size
    if "radius" in size:
        return Surface(feature.pose, shapely.Point(0, 0).buffer(size["radius"], _ROUND))
    half = [size.get(name, math.inf) / 2 for name in ("width", "depth")]
    x, y = (min(h, 10.0) for h in half)
    return Surface(feature.pose, shapely.box(-x, -y, x, y))


@lru_cache(maxsize=256)
def _upper_faces(geoms: tuple[Geom, ...], up: Vector3, part: str) -> tuple[Surface, ...]:
    faces = [f for g in geoms if part in ("", g.part) for f in _level_faces(g, np.asarray(up))]
    planes: list[tuple[Pose, list[Floats]]] = []
    for points in sorted(faces, key=lambda p: -_extent(p, up)):
        into = next(
            (group for frame, group in planes if np.abs(frame.inverse().apply(points)[:, 2]).max() <= FLAT),
            None,
        )
        if into is None:
            planes.append((_frame(points, up), [points]))
        else:
            into.append(points)
    found = [_united(frame, group) for frame, group in planes]
    return tuple(sorted(found, key=lambda s: (-round(s.area.area, 8), -round(_height(s, up), 6))))


def _extent(points: Floats, up: Vector3) -> float:
    """Area of a face [m2], rounded so that faces of nearly the same size count as equal."""
    return round(
        float(shapely.MultiPoint(_frame(points, up).inverse().apply(points)[:, :2]).convex_hull.area), 9
    )


def _height(surface: Surface, up: Vector3) -> float:
    return float(np.asarray(surface.pose.position) @ np.asarray(up))


def _frame(points: Floats, up: Vector3) -> Pose:
    """Frame on a face: z along the face's upward normal, x as near as possible to the thing's x axis, or
    to its y axis if x is nearly normal."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle)[2][2]
    normal = normal if normal @ np.asarray(up) > 0 else -normal
    return Pose.from_axes(tuple(middle), normal, (1.0, 0.0, 0.0) if abs(normal[0]) < 0.9 else (0.0, 1.0, 0.0))


def _united(frame: Pose, faces: list[Floats]) -> Surface:
    """Surface that unites faces in one plane, its frame in the middle of their area."""
    area = shapely.union_all([shapely.MultiPoint(frame.inverse().apply(p)[:, :2]).convex_hull for p in faces])
    x, y, x1, y1 = area.bounds
    middle = (x + x1) / 2, (y + y1) / 2
    moved = shapely.transform(area, lambda points: points - np.asarray(middle))
    return Surface(frame * Pose((*middle, 0.0)), moved)


def _level_faces(geom: Geom, up: Floats) -> Iterator[Floats]:
    """Corners (n, 3) of the faces of a geom that look upwards, in its thing's frame."""
    way = geom.pose.inverse().rotate(up)
    if geom.shape == "box":
        axis = int(np.argmax(np.abs(way)))
        if abs(way[axis]) >= math.cos(LEVEL):
            yield geom.pose.apply(_box_face(np.asarray(geom.size), axis, math.copysign(1.0, way[axis])))
    elif geom.shape == "cylinder" and abs(way[2]) >= math.cos(LEVEL):
        angles = np.linspace(0, math.tau, 4 * _ROUND, endpoint=False)
        height = np.full_like(angles, math.copysign(geom.size[1], way[2]))
        yield geom.pose.apply(
            np.column_stack([geom.size[0] * np.cos(angles), geom.size[0] * np.sin(angles), height])
        )
    elif geom.shape == "convex":
        points = np.asarray(geom.corners)
        for plane in hull_planes(geom.corners):
            on = points[np.abs(points @ plane[:3] + plane[3]) < 1e-5]
            if plane[:3] @ way >= math.cos(LEVEL) and len(on) >= 3:
                yield geom.pose.apply(on)


def _box_face(half: Floats, axis: int, sign: float) -> Floats:
    ends = np.array([(a, b) for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
    return np.insert(ends, axis, sign, axis=1) * half


def footprint(thing: Thing, pose: Pose, low: float = -math.inf, high: float = math.inf) -> Area:
    """Outline of a thing seen from above: the union of the parts of its geoms in a range of heights [m].

    Args:
        pose: of the thing in the frame that it is seen in, along z.
    """
    if not _turns_alike(Itself(thing.geoms)):
        return _footprint(thing.geoms, pose, low, high)
    up, z = _up(pose), pose.position[2]
    outline = _leaning_footprint(Itself(thing.geoms), up, round(low - z, HEIGHT), round(high - z, HEIGHT))
    return _turned(outline, pose, up)


def filled(outline: Area) -> Area:
    """Fill the holes of an outline, such as gaps between the boxes of a bowl, into which nothing else
    would fit."""
    return shapely.union_all(
        [shapely.Polygon(part.exterior) for part in getattr(outline, "geoms", (outline,))]
    )


def _footprint(geoms: tuple[Geom, ...], pose: Pose, low: float, high: float) -> Area:
    parts = []
    for geom in geoms:
        there = pose * geom.pose
        points = corners(Thing("", "", Pose(), (geom,)), pose)
        if points[:, 2].max() > low and points[:, 2].min() < high:
            parts.append(_outline(geom, there, _between(points, low, high)))
    return shapely.union_all(parts) if parts else shapely.Polygon()


@lru_cache(maxsize=512)
def _turns_alike(geoms: Itself[tuple[Geom, ...]]) -> bool:
    """Whether a thing's outline can be computed once and turned about the vertical: only if all its geoms
    have flat faces.

    The outline of a round geom is a polygon in place of its curves, for which this is not exact.
    """
    return all(g.shape in FLAT_FACED for g in geoms.it)


def _up(pose: Pose) -> Vector3:
    """Vertical direction in a thing's frame, rounded: says how the thing leans, however it is turned about
    the vertical."""
    return vector3((pose.rotation[2] + 0.0).round(FINE))


@lru_cache(maxsize=512)
def _leaning(up: Vector3) -> Pose:
    """Shortest rotation that turns a direction vertically up; half a turn about x if it points straight
    down."""
    x, y, z = up
    sine = math.hypot(x, y)
    if sine == 0.0:
        return Pose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0) if z > 0 else (0.0, 1.0, 0.0, 0.0))
    angle = math.atan2(sine, z)
    return Pose.from_rotvec((0.0, 0.0, 0.0), (angle * y / sine, -angle * x / sine, 0.0))


@lru_cache(maxsize=512)
def _leaning_footprint(geoms: Itself[tuple[Geom, ...]], up: Vector3, low: float, high: float) -> Area:
    return _footprint(geoms.it, _leaning(up), low, high)


def _turned(area: Area, pose: Pose, up: Vector3) -> Area:
    """Turn and move an area, computed for a leaning thing at the origin, to the thing's pose."""
    turn = pose.rotation @ _leaning(up).rotation.T
    return shapely.transform(area, lambda points: points @ turn[:2, :2].T + np.asarray(pose.position[:2]))


def _between(points: Floats, low: float, high: float) -> Floats:
    """Points (M, 3) of the part of a convex body, given by its corners (N, 3), in a range of heights."""
    for height, sign in ((low, 1.0), (high, -1.0)):
        above = sign * (points[:, 2] - height)
        if not math.isfinite(height) or above.min() >= 0:
            continue
        up, down = points[above > 0], points[above < 0]
        share = (above[above > 0][:, None] / (above[above > 0][:, None] - above[above < 0]))[..., None]
        cut = (up[:, None] + share * (down - up[:, None])).reshape(
            -1, 3
        )  # of all lines between the two sides: edges and inner ones
        points = np.vstack([points[above >= 0], cut])
    return points


def _outline(geom: Geom, there: Pose, points: Floats) -> Area:
    upright = geom.shape == "sphere" or (
        geom.shape in ("cylinder", "capsule") and abs(there.rotation[2, 2]) > 1 - 1e-6
    )
    if upright:
        return shapely.Point(*there.position[:2]).buffer(geom.size[0], _ROUND)
    return shapely.MultiPoint(points[:, :2]).convex_hull


def standing(thing: Thing, pose: Pose) -> Standing:
    """Return the support polygon of a thing and its centre of mass, at a pose in the frame of a surface."""
    centre = shapely.Point(pose.apply(centre_of_mass(thing))[:2])
    if not _turns_alike(Itself(thing.geoms)):
        return Standing(_under(thing.geoms, pose), centre)
    up = _up(pose)
    return Standing(_turned(_leaning_under(Itself(thing.geoms), up), pose, up), centre)


@lru_cache(maxsize=512)
def _leaning_under(geoms: Itself[tuple[Geom, ...]], up: Vector3) -> Area:
    return _under(geoms.it, _leaning(up))


def _under(geoms: tuple[Geom, ...], pose: Pose) -> Area:
    """Hull of the points of a body within ``FLAT`` of its lowest."""
    low = lowest(Thing("", "", Pose(), geoms), pose) + pose.position[2]
    touching = [_level_lowest(g, pose, low) for g in geoms]
    return shapely.union_all([t for t in touching if t is not None] or [shapely.Polygon()]).convex_hull


def _level_lowest(geom: Geom, pose: Pose, low: float) -> Area | None:
    """Outline of the points of a geom that are less than ``FLAT`` above a height; None if there are none."""
    there = pose * geom.pose
    if geom.shape == "cylinder":
        angles = np.linspace(0, math.tau, 4 * _ROUND, endpoint=False)
        ring = np.column_stack([geom.size[0] * np.cos(angles), geom.size[0] * np.sin(angles)])
        points = there.apply(
            np.vstack([np.column_stack([ring, np.full(len(ring), s * geom.size[1])]) for s in (-1, 1)])
        )
    elif geom.shape in ("sphere", "capsule"):
        ends = (0.0,) if geom.shape == "sphere" else (-geom.size[1], geom.size[1])
        points = np.array([there.apply((0.0, 0.0, z)) - (0.0, 0.0, geom.size[0]) for z in ends])
    else:
        points = corners(Thing("", "", Pose(), (geom,)), pose)
    touching = points[points[:, 2] <= low + FLAT]
    return shapely.MultiPoint(touching[:, :2]).convex_hull if len(touching) else None


def inset(standing: Standing, area: Area) -> tuple[float, float]:
    """Return the distance of a centre of mass inside its support's border [m], negative outside, and the
    least distance that is needed.

    What supports it is the hull of what touches the area. It should be by ``EDGE``, or, of what stands on
    less, by half of what its own support leaves it.
    """
    own, under = _depth(standing.centre, standing.area), standing.area.intersection(area).convex_hull
    wanted = min(EDGE, own / 2) if own > 0 else EDGE
    return (_depth(standing.centre, under) if own > 0 else _depth(standing.centre, area)), wanted


def _depth(point: Any, area: Area) -> float:
    """Depth of a point inside an area [m], negative outside; -inf if the area is empty."""
    if area.is_empty:
        return -math.inf
    inside = area.area > 0 and area.covers(point)
    return float(area.boundary.distance(point)) if inside else -float(area.distance(point))


def resting_height(thing: Thing, pose: Pose, others: Iterable[tuple[Thing, Pose]]) -> tuple[float, str]:
    """Return the height of the highest surface that would support a thing, and the name of the thing that it
    belongs to; -inf and "" for none.

    Args:
        pose: of the thing, in the frame of the others' poses, z up: it falls straight down from there.
        others: what there is under it, with poses.
    """
    found, bottom = [(-math.inf, "")], lowest(thing, pose) + pose.position[2]
    for other, at in others:
        for surface in surfaces(other, at):
            local = surface.pose.inverse() * pose
            if (
                surface.pose.position[2] <= bottom + SUNK
                and inset(standing(thing, local), surface.area)[0] > 0
            ):
                found.append((surface.pose.position[2], other.name))
    return max(found)


SUNK = 0.01
"""Depth by which a standing thing may reach into its support [m]: the accuracy of poses."""

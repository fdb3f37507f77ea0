"""Attitude in which a leaning thing comes to stand when it is released: on the face of its hull that is
nearest to facing down."""

from __future__ import annotations

import math

import numpy as np
import shapely

from cramlite.model import Floats, Pose, Thing, Vector3

from .bounds import centre_of_mass, corners
from .convex import hull_planes
from .surfaces import FLAT, LEVEL

MOST = math.radians(40.0)
"""Lean beyond which a thing lies on its side, such as a bowl on its rim."""
_DOWN = np.array([0.0, 0.0, -1.0])


def stood_up(thing: Thing, pose: Pose) -> Pose:
    """Return a pose turned the shortest way so that the thing stands; unchanged if it stands already or has
    no face to stand on.

    Args:
        pose: of the thing, in a frame whose z is up.
    """
    points = corners(thing, Pose())
    normals, centre = hull_planes(_tuples(points))[:, :3], np.asarray(centre_of_mass(thing))
    leaning = np.arccos(np.clip((normals @ pose.rotation.T) @ _DOWN, -1.0, 1.0))
    faces = (int(k) for k in np.argsort(leaning, kind="stable") if leaning[k] <= MOST)
    face = next((k for k in faces if _carries(points, normals[k], centre)), None)
    if face is None or leaning[face] <= LEVEL:
        return pose
    return turned_down(pose, normals[face])


def turned_down(pose: Pose, normal: Floats) -> Pose:
    """Return a pose turned the shortest way so that a direction (3,) of the thing points down, such as the
    normal of a face; its position stays."""
    down = np.asarray(pose.rotate(normal))
    angle, axis = math.acos(max(-1.0, min(1.0, float(down @ _DOWN)))), np.cross(down, _DOWN)
    length = float(np.linalg.norm(axis))
    if length < FLAT:  # down already, or up: then about any level axis
        axis, length = np.array([1.0, 0.0, 0.0]), 1.0
    return Pose.at(pose.position, Pose.from_rotvec((0, 0, 0), axis / length * angle) * pose)


def carrying_faces(thing: Thing) -> list[Floats]:
    """Return the outward normals (3,) of the faces of a thing's hull that it can lie on."""
    points = corners(thing, Pose())
    normals, centre = hull_planes(_tuples(points))[:, :3], np.asarray(centre_of_mass(thing))
    return [normal for normal in normals if _carries(points, normal, centre)]


def _carries(points: Floats, normal: Floats, centre: Floats) -> bool:
    """Whether a thing can stand on a face of its hull: its centre of mass (3,) is over those of its points
    (n, 3) that are in the face's plane."""
    along = points @ normal
    level = (1.0, 0.0, 0.0) if abs(normal[0]) < 0.9 else (0.0, 1.0, 0.0)
    frame = Pose.from_axes((0.0, 0.0, 0.0), normal, level).inverse()
    foot = shapely.MultiPoint(frame.apply(points[along > along.max() - FLAT])[:, :2]).convex_hull
    return bool(foot.area > 0 and foot.contains(shapely.Point(frame.apply(centre)[:2])))


def _tuples(points: Floats) -> tuple[Vector3, ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in points)

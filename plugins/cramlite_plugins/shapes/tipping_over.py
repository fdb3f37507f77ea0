"""Attitude in which a thing comes to lie after it tips over about its lowest edge."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Floats, Pose, Thing, vector3

from .bounds import centre_of_mass, corners
from .standing_up import carrying_faces

EDGE = 0.0005  # points that are no higher than this over the lowest one touch as well [m]
# Of a face's normal along the edge: with more of it the face is no side that it tips onto
ALONG = math.sin(math.radians(10.0))
BALANCED = 1e-6  # of a centre of mass over the edge [m]


def tipped_over(thing: Thing, pose: Pose) -> tuple[Pose, float] | None:
    """Return the pose of a thing after tipping over about its lowest edge, and how far its centre of mass was
    beyond that edge [m].

    Args:
        pose: of the thing, in a frame whose z is up; its lowest edge is on what is level.

    Returns:
        None where it balances on the edge, or has no side to come to lie on.
    """
    edge = _edge(thing, pose)
    beyond = (pose.apply(centre_of_mass(thing)) - edge) * (1.0, 1.0, 0.0)
    far = float(np.linalg.norm(beyond))
    if far < BALANCED:
        return None
    axis = np.cross((0.0, 0.0, 1.0), beyond / far)
    turns = [turn for n in carrying_faces(thing) if (turn := _turn(pose.rotate(n), axis)) is not None]
    return (_about(pose, edge, axis, min(turns)), far) if turns else None


def _edge(thing: Thing, pose: Pose) -> Floats:
    """Mean position (3,) [m] of those corners of a thing that are less than ``EDGE`` above its lowest one."""
    points = corners(thing, pose)
    found: Floats = points[points[:, 2] < points[:, 2].min() + EDGE].mean(axis=0)
    return found


def _turn(normal: Floats, axis: Floats) -> float | None:
    """Angle about an axis that turns a face downwards [rad]; None if it is more than a quarter turn."""
    if abs(float(normal @ axis)) > ALONG:
        return None
    down = np.array([0.0, 0.0, -1.0])
    turn = math.atan2(float(axis @ np.cross(normal, down)), float(normal @ down))
    return turn if 0.0 < turn <= math.pi / 2 else None


def _about(pose: Pose, edge: Floats, axis: Floats, turn: float) -> Pose:
    """A pose turned about an axis through a point."""
    return Pose.from_rotvec(edge, turn * axis) * Pose(vector3(-edge)) * pose

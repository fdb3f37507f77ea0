"""Lines across a shape between which two pads may close, found on the faces of its convex parts.

Each face gives points; the line through a point along the face's normal, where it leaves the whole shape on the other side,
is a contact pair. Lines near the centre of mass come first, and one of many alike is enough.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cramlite import Geom, Pose
from cramlite.geometry import Floats
from cramlite.robots import Gripper

from ..shapes.hull import hull_planes
from . import antipodal

LINES = 48  # contact pairs that are looked at from all sides
ALIKE, TURN = 0.010, math.cos(math.radians(15))  # lines nearer than this [m] and less turned are alike
SIDES = 8  # directions of approach about a line
WIDE = 0.022  # faces wider than this are sampled off their middle too [m]


@dataclass(frozen=True)
class Line:
    """A contact pair: the middle, the unit closing direction, the distance of the faces [m], and a cost [m]."""

    middle: Floats
    way: Floats
    width: float
    cost: float


def lines(shape: antipodal.Body, parts: list[Geom], centre: Floats, gripper: Gripper, slack: float) -> list[Line]:
    """Contact pairs between the pads, the nearest to the centre of mass first, no two alike."""
    found = [line for p, n in _points(parts) if (line := _line(shape, p, n, centre, gripper, slack)) is not None]
    chosen: list[Line] = []
    for line in sorted(found, key=lambda x: (round(x.cost, 5), *np.round(x.middle, 5), *np.round(x.way, 5))):
        if all(not _alike(line, other) for other in chosen):
            chosen.append(line)
        if len(chosen) == LINES:
            break
    return chosen


def frames(line: Line) -> Iterator[tuple[Pose, str]]:
    """TCP frames on a line, one for each direction of approach, downwards first."""
    up = np.array([0.0, 0.0, 1.0]) if abs(line.way[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    first = up - (up @ line.way) * line.way
    first /= np.linalg.norm(first)
    second = np.cross(line.way, first)
    for k in sorted(range(SIDES), key=lambda k: min(k, SIDES - k)):
        angle = math.tau * k / SIDES
        z = -(math.cos(angle) * first + math.sin(angle) * second)
        yield Pose.from_axes(tuple(line.middle), z, np.cross(line.way, z)), f"{_says(-z)}, closing {_axis(line.way)}"


def _line(
    shape: antipodal.Body, point: Floats, normal: Floats, centre: Floats, gripper: Gripper, slack: float
) -> Line | None:
    side = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    pose = Pose.from_axes(tuple(point - 0.0005 * normal), side, np.cross(normal, side))
    found = antipodal.pinch(shape, pose)
    if found is None or found.width + slack > gripper.opening[1]:
        return None
    middle = np.asarray(found.pose.position)
    off = middle - centre
    across = off - (off @ normal) * normal
    cost = float(np.linalg.norm(across)) + 0.3 * max(0.0, abs(float(off @ normal)) - found.width / 2)
    return Line(middle, normal, found.width, cost + 0.02 * found.slant)


def _points(parts: list[Geom]) -> Iterator[tuple[Floats, Floats]]:
    """Points on the faces of convex parts with the outward normals, in the thing's frame."""
    for geom in parts:
        corners = np.asarray(geom.corners)
        for plane in hull_planes(geom.corners):
            face = corners[np.abs(corners @ plane[:3] + plane[3]) < 1e-6]
            normal = geom.pose.turn(plane[:3])
            for point in _on(face, plane[:3]):
                yield geom.pose.apply(point), normal


def _on(face: Floats, normal: Floats) -> Iterator[Floats]:
    """The middle of a face, and points half way to its ends where it is wide."""
    if len(face) < 3:
        return
    middle = face.mean(axis=0)
    yield middle
    side = np.linalg.svd(face - middle)[2][0]
    for way in (side, np.cross(normal, side)):
        reach = (face - middle) @ way
        if np.ptp(reach) > WIDE:
            yield from (middle + 0.6 * end * way for end in (reach.min(), reach.max()))


def _alike(a: Line, b: Line) -> bool:
    return abs(float(a.way @ b.way)) > TURN and float(np.linalg.norm(a.middle - b.middle)) < ALIKE


def _says(way: Floats) -> str:
    """A direction in words: "from above", "from -x and above"."""
    names = ("+x", "-x", "+y", "-y", "above", "below")
    signs = list(itertools.chain.from_iterable((v, -v) for v in way))
    strong = [n for n, v in zip(names, signs, strict=True) if v > 0.35]
    return "from " + " and ".join(strong)


def _axis(way: Floats) -> str:
    return f"({way[0]:+.2f} {way[1]:+.2f} {way[2]:+.2f})"

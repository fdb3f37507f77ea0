"""Antipodal grasps on a shape of primitives: contact pairs by exact ray casting, and room for the hand.

A line along the closing direction meets each convex primitive in one interval; the union of the intervals around
the pinch point ends in the contact pair. Pads can hold it when both normals lie in the friction cone about the line
(Nguyen, Constructing Force-Closure Grasps, IJRR 7(3), 1988). Tool frame: z approach, y closing, as ``cramlite.model.Gripper``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from cramlite.model import Floats, Geom, Gripper, Pose, Value

from ..shapes.convex import hull_planes
from ..shapes.ray_casting import Body, body, crossed, inverse, spans
from ..shapes.segment_casting import SKIN

FINGER = 0.020  # thickness of pad and finger, from the data sheet's drawing [m]
PALM = 0.0375  # radius of the palm [m]
SAMPLES = 0.10  # how far behind the pinch point the swept fingers are looked at [m]
STEP = 0.005  # along the fingers [m]
TIPS = 0.008  # of the pads, in a grasp by the tips [m]
THIN = 0.6  # share of a thin thing's thickness that they overlap: hands stay off what it lies on
BEFORE, INTO = 0.003, 0.004  # a shallow grasp: tips before the far side, pinch point behind the near one [m]
DEEP = 0.004  # what stays between the palm and the near side [m]
ANGLES = 8  # side grasps around a cylinder


class Pinch(Value):
    """Contact pair between two pads.

    Args:
        pose: of the TCP, half way between the contacts, in the thing's frame.
        width: between the contacts [m].
        slant: the larger angle of a contact normal to the closing direction [rad].
    """

    pose: Pose
    width: float
    slant: float


def pinch(shape: Body, pose: Pose) -> Pinch | None:
    """The contact pair on the closing line through a TCP pose; None where the line misses the shape."""
    way = pose.rotate((0.0, 1.0, 0.0))
    low, high, ends = _around(shape, np.asarray(pose.position), way)
    if not ends:
        return None
    contacts = [np.asarray(pose.position) + t * way for t in (low, high)]
    slant = max(_slant(g, c, way) for g, c in zip(ends, contacts, strict=True))
    middle = pose * Pose((0.0, (low + high) / 2, 0.0))
    return Pinch(middle, high - low, slant)


def clear(shape: Body, pose: Pose, opening: float, gripper: Gripper) -> bool:
    """Check whether fingers at this opening [m], and the palm, meet nothing at the pose and on the straight way to it."""
    starts, ends = _hand(round(opening, 6), gripper)
    return not crossed(shape, pose.apply(starts), pose.apply(ends))


@lru_cache(maxsize=256)
def _hand(opening: float, gripper: Gripper) -> tuple[Floats, Floats]:
    """Segments that fill the swept fingers and the palm, in the tool frame: along each axis, so that no wall is missed."""
    half, reach, inner = gripper.pad[0] / 2, gripper.pad[1] / 2, opening / 2
    across, thick = np.linspace(-half, half, 4), np.array([0.0, 0.3, 0.65, 1.0]) * FINGER
    along = [*np.arange(reach, -gripper.depth, -STEP), -gripper.depth, -SAMPLES]
    segments: list[tuple[tuple[float, ...], tuple[float, ...]]] = []
    for side in (1.0, -1.0):
        ys = [side * (inner + t) for t in thick]
        segments += [((x, y, -SAMPLES), (x, y, reach)) for x in across for y in ys]
        segments += [((x, ys[0], z), (x, ys[-1], z)) for x in across for z in along]
        segments += [((-half, y, z), (half, y, z)) for y in ys for z in along]
    turns = [(PALM * math.cos(a), PALM * math.sin(a)) for a in np.linspace(0, math.tau, 12, endpoint=False)]
    for share, (x, y) in itertools.product((0.35, 0.7, 1.0), turns):
        segments.append(((share * x, share * y, -SAMPLES), (share * x, share * y, -gripper.depth)))
    for (x, y), (u, v) in itertools.combinations(turns, 2):
        segments.append(((x, y, -gripper.depth), (u, v, -gripper.depth)))
    return np.array([s for s, _ in segments]), np.array([e for _, e in segments])


def shallow(geom: Geom, pose: Pose, gripper: Gripper) -> Pose | None:
    """Draw a TCP pose back until the pads end before the geom's far side; None where they do already.

    A thin thing that lies on a table is gripped so.
    """
    met = next(spans(body([geom]), np.asarray(pose.position), pose.rotate((0.0, 0.0, 1.0))), None)
    if met is None:
        return None
    back = gripper.pad[1] / 2 + BEFORE - met[1]
    least = -met[0] - INTO  # so that the pinch point stays inside
    return pose * Pose((0.0, 0.0, -min(back, least))) if back > 0 and least > 0 else None


def by_tips(geom: Geom, pose: Pose, gripper: Gripper) -> tuple[Pose, float] | None:
    """The pose drawn back until the pads overlap the geom by twice ``TIPS``, of a thin one by ``THIN`` of its thickness, and how far
    before it the contacts then are; None where it is as far back already. A rim above a floor, or a box that lies flat, is gripped so."""
    met = next(spans(body([geom]), np.asarray(pose.position), pose.rotate((0.0, 0.0, 1.0))), None)
    if met is None:
        return None
    overlap = min(TIPS, THIN / 2 * (met[1] - met[0]))
    ahead = gripper.pad[1] / 2 - overlap
    back = met[0] + overlap - ahead
    return (pose * Pose((0.0, 0.0, back)), ahead) if back < -0.002 else None


def depths(shape: Body, pose: Pose, gripper: Gripper) -> Iterator[tuple[Pose, float, str]]:
    """Yield TCP poses that bring the pads to a contact pair, how far before the TCP it then is [m], and words for it.

    As deep as the hand is; drawn back until the pads end before the far side; and by the tips of the pads.
    """
    point, way = np.asarray(pose.position), pose.rotate((0.0, 0.0, 1.0))
    low, high, _ = _around(shape, point, way)
    deepest = min(0.0, low + gripper.depth - DEEP)
    yield pose * Pose((0.0, 0.0, deepest)), 0.0, ""
    drawn = max(high - BEFORE - gripper.pad[1] / 2, low + INTO)
    if drawn < deepest - 0.002:
        yield pose * Pose((0.0, 0.0, drawn)), 0.0, ", shallow"
    tips = gripper.pad[1] / 2 - TIPS
    yield pose * Pose((0.0, 0.0, -tips)), tips, ", by the tips"


def round_frames(geom: Geom, depth: float) -> Iterator[tuple[Pose, str]]:
    """Yield TCP frames around a cylinder, capsule or sphere in the thing's frame, with a name for people."""
    if geom.shape == "sphere":
        yield from _ball_frames(geom, depth)
        return
    radius, half = geom.size
    end = half + (radius if geom.shape == "capsule" else 0.0)
    turns = [(math.cos(k * math.tau / ANGLES), math.sin(k * math.tau / ANGLES)) for k in range(ANGLES)]
    for share, (x, y) in itertools.product((0.0, 0.5, -0.5), turns):
        name = f"from the side at {math.degrees(math.atan2(y, x)):.0f} deg, {1000 * share * half:+.0f} mm along the axis"
        yield geom.pose * Pose.from_axes((0, 0, share * half), (-x, -y, 0), (0, 0, 1)), name
    for sign, (x, y) in itertools.product((1.0, -1.0), turns[: ANGLES // 2]):
        height = sign * (end - min(half, depth))
        where = "top" if sign > 0 else "bottom"
        name = f"from the {where} across the diameter at {math.degrees(math.atan2(y, x)):.0f} deg"
        yield geom.pose * Pose.from_axes((0, 0, height), (0, 0, -sign), (x, y, 0)), name


def _ball_frames(geom: Geom, depth: float) -> Iterator[tuple[Pose, str]]:
    for z in itertools.product((-1, 0, 1), repeat=3):
        if not any(z):
            continue
        for k, x in enumerate(((0.31, 0.17, 0.94), (0.94, -0.31, 0.17))):
            frame = Pose.from_axes((0, 0, 0), z, x)
            short = max(0.0, geom.size[0] - depth)
            yield geom.pose * frame * Pose((0, 0, -short)), f"along {z} of the ball, turn {k}"


def _around(shape: Body, point: Floats, way: Floats) -> tuple[float, float, tuple[Geom, ...]]:
    """The united interval that holds the point, and the geoms at its two ends."""
    all_ = sorted(spans(shape, point, way), key=lambda s: s[0])
    within = [s for s in all_ if s[0] <= SKIN and s[1] >= -SKIN]
    if not within:
        return 0.0, 0.0, ()
    first, last = min(within, key=lambda s: s[0]), max(within, key=lambda s: s[1])
    for _ in all_:
        for s in all_:
            if s[0] <= last[1] + SKIN and s[1] > last[1]:
                last = s
            if s[1] >= first[0] - SKIN and s[0] < first[0]:
                first = s
    return first[0], last[1], (first[2], last[2])


def coverage(shape: Body, pose: Pose, width: float, gripper: Gripper) -> float:
    """Return the share of the pad, sampled by rays along the closing direction, that meets the shape between the pads."""
    half, reach = 0.45 * gripper.pad[0], 0.45 * gripper.pad[1]
    way, hits = pose.rotate((0.0, 1.0, 0.0)), 0
    grid = list(itertools.product(np.linspace(-half, half, 3), np.linspace(-reach, reach, 3)))
    for x, z in grid:
        met = [s for s in spans(shape, pose.apply((x, 0.0, z)), way) if s[1] > -width / 2 and s[0] < width / 2]
        hits += bool(met) and max(s[1] for s in met) - min(s[0] for s in met) > width - 0.004
    return hits / len(grid)


def _slant(geom: Geom, contact: Floats, way: Floats) -> float:
    """Angle between the surface normal at a contact and the closing line [rad]."""
    p = inverse(geom.pose).apply(contact)
    if geom.shape == "box":
        normal = np.eye(3)[int(np.argmax(np.abs(p) / geom.size))]
    elif geom.shape == "sphere":
        normal = p
    elif geom.shape == "convex":
        planes = hull_planes(geom.corners)
        here = planes[planes[:, :3] @ p + planes[:, 3] > -2 * SKIN][:, :3]
        turns = np.abs(here @ geom.pose.inverse().rotate(way))
        normal = here[int(np.argmax(turns))] if len(here) else np.ones(3)
    elif abs(p[2]) >= geom.size[1] - SKIN and geom.shape == "cylinder":
        normal = np.array([0.0, 0.0, 1.0])
    else:
        normal = p - (0, 0, float(np.clip(p[2], -geom.size[1], geom.size[1])))
    cosine = abs(float(geom.pose.rotate(normal) @ way)) / max(float(np.linalg.norm(normal)), 1e-9)
    return math.acos(min(1.0, cosine))

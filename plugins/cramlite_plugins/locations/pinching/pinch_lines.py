"""Antipodal lines across a shape, between which two pads may close, found on the faces of its convex parts.

Each face gives points; the line through a point along the face's normal, where it leaves the whole shape on
the other side, is a contact pair. Lines near the centre of mass come first, and one of many alike is enough.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Floats, Geom, Gripper, Pose, Value

from ...shapes import ray_casting as rays
from ...shapes.convex import hull_planes
from . import antipodal

LINES = 48  # contact pairs that are looked at from all sides
ALIKE, TURN = 0.010, math.cos(math.radians(15))  # lines nearer than this [m] and less turned are alike
CELL = 0.006  # of points on faces, one is enough in a cube of this size [m]
SIDES = 8  # directions of approach about a line
LEVEL = math.radians(5)  # faces that lean more than this are also gripped level
WIDE = 0.022  # faces wider than this are sampled off their middle too [m]


class PinchLine(Value):
    """Contact pair: the middle, the unit closing direction, the distance of the faces [m], and a cost [m]."""

    middle: Floats
    way: Floats
    width: float
    cost: float


def lines(
    shape: rays.Body, parts: list[Geom], centre: Floats, gripper: Gripper, slack: float, cone: float
) -> list[PinchLine]:
    """Return contact pairs between the pads, the nearest to the centre of mass first; of similar pairs only
    the first.

    Args:
        slack: that must be left between the pads [m].
        cone: largest angle of a contact normal to the closing direction [rad].
    """
    pairs = list({_cell(p, w): (p, w) for p, n in _points(parts) for w in _ways(n, cone)}.values())
    found = _lines(shape, pairs, centre, gripper, slack, cone) if pairs else []
    found.sort(key=lambda x: (round(x.cost, 5), *np.round(x.middle, 5), *np.round(x.way, 5)))
    chosen: list[PinchLine] = []
    for line in found:
        if not chosen or not _alike(line, chosen):
            chosen.append(line)
    return _spread(chosen)


def _cell(point: Floats, way: Floats) -> tuple[float, ...]:
    """Key that is equal for similar antipodal lines: through points of the same cube of side ``CELL``,
    with like or opposite directions."""
    sign = -1.0 if tuple(np.round(way, 1)) < (0.0, 0.0, 0.0) else 1.0
    return (*np.round(point / CELL).tolist(), *(sign * np.round(5 * way)).tolist())


def _spread(found: list[PinchLine]) -> list[PinchLine]:
    """Choose the best ``LINES`` / 2 contact pairs, then up to as many again, each at the greatest distance
    from those chosen so far.

    Obstacles may block the pairs near the centre of mass.
    """
    chosen, rest = found[: LINES // 2], found[LINES // 2 :]
    if not rest:
        return chosen
    middles = np.array([line.middle for line in rest])
    away = np.min([np.linalg.norm(middles - c.middle, axis=1) for c in chosen], axis=0)
    while len(chosen) < LINES and away.max() > 0:
        k = int(np.argmax(away))
        chosen.append(rest[k])
        away = np.minimum(away, np.linalg.norm(middles - rest[k].middle, axis=1))
    return chosen


def frames(line: PinchLine) -> Iterator[tuple[Pose, str]]:
    """Yield TCP frames on an antipodal line, one for each direction in which the hand may approach it,
    downwards first."""
    up = np.array([0.0, 0.0, 1.0]) if abs(line.way[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    first = up - (up @ line.way) * line.way
    first /= np.linalg.norm(first)
    second = np.cross(line.way, first)
    for k in sorted(range(SIDES), key=lambda k: min(k, SIDES - k)):
        angle = math.tau * k / SIDES
        z = -(math.cos(angle) * first + math.sin(angle) * second)
        yield (
            Pose.from_axes(tuple(line.middle), z, np.cross(line.way, z)),
            f"{_says(-z)}, closing {_axis(line.way)}",
        )


def _ways(normal: Floats, cone: float) -> Iterator[Floats]:
    """Yield closing directions for a face: its normal, and the level direction next to it if the friction
    cone includes that.

    So slanted walls are gripped from above.
    """
    yield normal
    tilt = math.asin(min(1.0, abs(float(normal[2]))))
    if LEVEL < tilt < 0.9 * cone:
        level = normal * (1.0, 1.0, 0.0)
        yield level / np.linalg.norm(level)


def _lines(
    shape: rays.Body,
    pairs: list[tuple[Floats, Floats]],
    centre: Floats,
    gripper: Gripper,
    slack: float,
    cone: float,
) -> list[PinchLine]:
    points, ways = (np.array(column) for column in zip(*pairs, strict=True))
    turns = np.repeat(ways[:, :, None], 3, axis=2)  # only the closing direction matters
    hands = antipodal.Hands(points - 0.0005 * ways, turns)
    found = antipodal.pinches(shape, hands)
    fits = (found.width > 0) & (found.width + slack <= gripper.opening[1]) & (found.slant <= cone)
    rows = np.flatnonzero(fits)
    middles = hands.positions[rows] + (found.low[rows] + found.width[rows] / 2)[:, None] * ways[rows]
    return [
        _line(m, ways[k], float(found.width[k]), float(found.slant[k]), centre)
        for m, k in zip(middles, rows, strict=True)
    ]


def _line(middle: Floats, way: Floats, width: float, slant: float, centre: Floats) -> PinchLine:
    off = middle - centre
    across = off - (off @ way) * way
    cost = float(np.linalg.norm(across)) + 0.3 * max(0.0, abs(float(off @ way)) - width / 2)
    return PinchLine(middle, way, width, cost + 0.02 * slant)


def _points(parts: list[Geom]) -> Iterator[tuple[Floats, Floats]]:
    """Points on the faces of convex parts with the outward normals, in the thing's frame."""
    for geom in parts:
        corners = np.asarray(geom.corners)
        for plane in hull_planes(geom.corners):
            face = corners[np.abs(corners @ plane[:3] + plane[3]) < 1e-6]
            normal = geom.pose.rotate(plane[:3])
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


def _alike(line: PinchLine, others: list[PinchLine]) -> bool:
    turned = np.abs(np.array([o.way for o in others]) @ line.way)
    apart = np.array([o.middle for o in others]) - line.middle
    return bool(((turned > TURN) & (np.einsum("ij,ij->i", apart, apart) < ALIKE**2)).any())


def _says(way: Floats) -> str:
    """A direction in words: "from above", "from -x and above"."""
    names = ("+x", "-x", "+y", "-y", "above", "below")
    signs = list(itertools.chain.from_iterable((v, -v) for v in way))
    strong = [n for n, v in zip(names, signs, strict=True) if v > 0.35]
    return "from " + " and ".join(strong)


def _axis(way: Floats) -> str:
    return f"({way[0]:+.2f} {way[1]:+.2f} {way[2]:+.2f})"

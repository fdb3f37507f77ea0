"""Antipodal grasps on a shape of primitives: contact pairs by exact ray casting, and room for the hand.

A line along the closing direction meets each convex primitive in one interval; the union of the intervals
around the pinch point ends in the contact pair. Pads can hold it when both normals lie in the friction cone
about the line (Nguyen, Constructing Force-Closure Grasps, IJRR 7(3), 1988). Tool frame: z approach, y
closing, as ``cramlite.model.Gripper``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Geom, Gripper, Pose, Value

from ...shapes.box_overlaps import overlaps
from ...shapes.convex import hull_planes
from ...shapes.ray_casting import Body, Span, intervals, inverse
from ...shapes.segment_casting import SKIN, crosses

FINGER = 0.020  # thickness of pad and finger, from the data sheet's drawing [m]
PALM = 0.0375  # radius of the palm [m]
SAMPLES = 0.10  # how far behind the pinch point the swept fingers are looked at [m]
STEP = 0.005  # along the fingers [m]
TIPS = 0.008  # of the pads, in a grasp by the tips [m]
ENDS = 0.005  # and in one by no more than their ends: half of pads that are 20 mm long [m]
THIN = 0.6  # overlap of the pads as a share of a thin thing's thickness: hands stay off its support
BEFORE, INTO = 0.003, 0.004  # a shallow grasp: tips before the far side, pinch point behind the near one [m]
DEEP = 0.010
"""Least gap between the palm and the near side of a grasped thing [m]: parts of a hand reach 4 mm beyond its
palm, and poses are in doubt."""
FACE = 0.001  # pads are pressed in by less, and lean by less [m]
ANGLES = 8  # side grasps around a cylinder


class Hands(Value):
    """Many TCP poses in the thing's frame: positions (n, 3) [m], and their axes as columns (n, 3, 3)."""

    positions: Floats
    turns: Floats

    @classmethod
    def at(cls, poses: Sequence[Pose]) -> Hands:
        """Stack TCP poses, each of a possible grasp, into arrays of positions and axes."""
        return cls(
            np.array([p.position for p in poses]).reshape(-1, 3),
            np.array([p.rotation for p in poses]).reshape(-1, 3, 3),
        )

    @property
    def approach(self) -> Floats:
        """Unit vectors (n, 3) along which the hands approach: the TCPs' z axes, out of the palms."""
        return self.turns[:, :, 2]

    @property
    def closing(self) -> Floats:
        """Unit vectors (n, 3) from pad to pad."""
        return self.turns[:, :, 1]

    def moved(self, along: Floats | float, closing: Floats | float = 0.0) -> Hands:
        """Return the hand poses moved along their approach and closing directions [m], (n,) each or one for
        all."""
        by = np.reshape(along, (-1, 1)) * self.approach + np.reshape(closing, (-1, 1)) * self.closing
        return Hands(self.positions + by, self.turns)

    def of(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> Hands:
        """Return some of the hand poses, selected by a mask or by indices."""
        return Hands(self.positions[rows], self.turns[rows])


class Pinches(Value):
    """Contact pairs on a shape, one for each hand pose: on the line along the hand's closing direction
    through the TCP.

    Args:
        low, high: of the contacts from the TCP along the closing direction (n,) [m]; inf and -inf where the
            line misses the shape there.
        slant: the larger angle of a contact normal to the closing direction (n,) [rad].
    """

    low: Floats
    high: Floats
    slant: Floats

    @property
    def width(self) -> Floats:
        """Distance between the two contacts on each closing line (n,) [m]; -inf where the line meets
        nothing."""
        return self.high - self.low


def pinches(shape: Body, hands: Hands) -> Pinches:
    """Compute the contact pairs on the closing lines through TCPs."""
    (low, high), (first, last) = _around(*intervals(shape, hands.positions, hands.closing))
    slant = np.where(low < high, 0.0, np.inf)
    for ends, distances in ((first, low), (last, high)):
        for k in np.unique(ends[low < high]).tolist():
            rows = np.flatnonzero((ends == k) & (low < high))
            contacts = hands.positions[rows] + distances[rows, None] * hands.closing[rows]
            slant[rows] = np.maximum(slant[rows], _slants(shape.geoms[k], contacts, hands.closing[rows]))
    return Pinches(low, high, slant)


def _around(low: Floats, high: Floats) -> tuple[Span, tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Return for each line the interval around its point t = 0 that is inside material, and the geoms at both
    ends.

    Geoms that touch each other on the line are joined.
    """
    if not low.shape[1]:
        nothing = np.zeros(len(low), np.intp)
        return (np.full(len(low), np.inf), np.full(len(low), -np.inf)), (nothing, nothing)
    joined = (low <= SKIN) & (high >= -SKIN)
    while True:
        starts, ends = np.where(joined, low, np.inf), np.where(joined, high, -np.inf)
        start, end = starts.min(axis=1), ends.max(axis=1)
        wider = (low <= end[:, None] + SKIN) & (high >= start[:, None] - SKIN) & (low < high)
        if (wider == joined).all():
            return (start, end), (starts.argmin(axis=1), ends.argmax(axis=1))
        joined = wider


def clear(shape: Body, hands: Hands, openings: Floats, gripper: Gripper) -> NDArray[np.bool_]:
    """Check at which hand poses (n,) the open fingers and the palm meet nothing of a shape, at the pose and
    on the straight approach to it."""
    half, reach = gripper.pad[0] / 2, gripper.pad[1] / 2
    free = np.ones(len(openings), bool)
    for side in (1.0, -1.0):
        fingers = hands.moved((reach - SAMPLES) / 2, side * (openings + FINGER) / 2)
        box = np.array([half, FINGER / 2, (reach + SAMPLES) / 2])
        met = overlaps(shape, fingers.positions, fingers.turns, box)
        for row, k in zip(*np.nonzero(met), strict=True):
            geom = shape.geoms[k]
            if free[row]:
                free[row] = geom.shape != "box" and not _meets(geom, fingers, row, _finger(gripper))
    palms = hands.moved(-(SAMPLES + gripper.depth) / 2)
    met = overlaps(shape, palms.positions, palms.turns, np.array([PALM, PALM, (SAMPLES - gripper.depth) / 2]))
    for row, geom in zip(*np.nonzero(met), strict=True):
        free[row] = free[row] and not _meets(shape.geoms[geom], palms, row, _palm(gripper))
    return free


def caught(shape: Body, hands: Hands, widths: Floats, gripper: Gripper) -> NDArray[np.bool_]:
    """Check for each of n hand poses whether the thing would stay caught on the opened hand, since a part of
    it is behind a pad; the pads are ``widths`` (n,) apart [m].

    That part is within a pad's length behind the rear edge of the pad's face, but apart from that edge.

    A thing that is released there in the air falls onto the pad, and comes along with the hand as it
    withdraws.
    """
    inside, found = np.minimum(FACE, widths / 4), np.zeros(len(widths), bool)
    for side, across in itertools.product((0.5, -0.5), (-0.4, 0.0, 0.4)):
        edges = (
            hands.moved(-gripper.pad[1] / 2, side * (widths - 2 * inside)).positions
            + across * gripper.pad[0] * hands.turns[:, :, 0]
        )
        low, high = intervals(shape, edges, -hands.approach)
        behind, within = (low > SKIN) & (low < gripper.pad[1]), (low <= SKIN) & (high > SKIN)
        found |= behind.any(axis=1) & ~within.any(axis=1)
    return found


def _meets(geom: Geom, hands: Hands, row: int, segments: tuple[Floats, Floats]) -> bool:
    """Whether line segments, given in the frame of hand pose number ``row``, pass through a geom."""
    turn, at = hands.turns[row].T, hands.positions[row]
    return crosses(geom, segments[0] @ turn + at, segments[1] @ turn + at)


@lru_cache(maxsize=16)
def _finger(gripper: Gripper) -> tuple[Floats, Floats]:
    """Line segments (starts, ends) that fill the volume swept by a finger, so densely that no wall fits
    between them, in the frame of the volume's middle."""
    half, long = gripper.pad[0] / 2, (gripper.pad[1] / 2 + SAMPLES) / 2
    across, thick = np.linspace(-half, half, 4), (np.array([0.0, 0.3, 0.65, 1.0]) - 0.5) * FINGER
    along = np.arange(long, -long, -STEP)
    segments = [((x, y, -long), (x, y, long)) for x in across for y in thick]
    segments += [((x, thick[0], z), (x, thick[-1], z)) for x in across for z in along]
    segments += [((-half, y, z), (half, y, z)) for y in thick for z in along]
    return np.array([s for s, _ in segments]), np.array([e for _, e in segments])


@lru_cache(maxsize=16)
def _palm(gripper: Gripper) -> tuple[Floats, Floats]:
    """Line segments (starts, ends) that fill the volume swept by the palm, in the frame of the volume's
    middle."""
    long, segments = (SAMPLES - gripper.depth) / 2, []
    turns = [(PALM * math.cos(a), PALM * math.sin(a)) for a in np.linspace(0, math.tau, 12, endpoint=False)]
    for share, (x, y) in itertools.product((0.35, 0.7, 1.0), turns):
        segments.append(((share * x, share * y, -long), (share * x, share * y, long)))
    for (x, y), (u, v) in itertools.combinations(turns, 2):
        segments.append(((x, y, long), (u, v, long)))
    return np.array([s for s, _ in segments]), np.array([e for _, e in segments])


def shallow(pose: Pose, near: float, far: float, gripper: Gripper) -> Pose | None:
    """Move a TCP pose back until the pads end before the far side of a geom; None if they end there already,
    or if the pinch point would leave the geom.

    So a thin thing is gripped that lies on a table.

    Args:
        near, far: of the geom along the approach, from the TCP [m].
    """
    back = gripper.pad[1] / 2 + BEFORE - far
    least = -near - INTO  # so that the pinch point stays inside
    return pose * Pose((0.0, 0.0, -min(back, least))) if back > 0 and least > 0 else None


def by_tips(
    pose: Pose, near: float, far: float, gripper: Gripper, corner: float = 0.0, most: float = TIPS
) -> tuple[Pose, float] | None:
    """Move a TCP pose back until only the tips of the pads are on a geom; None if the pose is as far back
    already.

    The pads then overlap the geom by 2 * ``most`` [m], or by the share ``THIN`` of a thin geom.

    Returned with the contacts' distance ahead of the TCP [m]. So a rim above a floor, or a flat box, is
    gripped.

    Args:
        near, far: of the geom along the approach, from the TCP [m].
        corner: of a pad that leans, how much further ahead it is than the pad's middle [m].
    """
    overlap = min(most, (THIN * (far - near) - corner) / 2)
    ahead = gripper.pad[1] / 2 - overlap
    back = near + overlap - ahead
    return (pose * Pose((0.0, 0.0, back)), ahead) if back < -0.002 else None


def depths(shape: Body, poses: Sequence[Pose], gripper: Gripper) -> Iterator[list[tuple[Pose, float, str]]]:
    """Yield for each pair of contacts the TCP poses that bring the pads there: deep in the hand, less deep,
    at the finger tips.

    Each comes with how far the contacts are beyond the TCP towards the finger tips [m], and a description.

    As deep as the hand is; drawn back until the pads end before the far side; and by the tips of the pads.
    """
    hands = Hands.at(poses)
    lows, highs = _around(*intervals(shape, hands.positions, hands.approach))[0]
    tips = gripper.pad[1] / 2 - TIPS
    for pose, low, high in zip(poses, lows.tolist(), highs.tolist(), strict=True):
        deepest = min(0.0, low + gripper.depth - DEEP)
        found = [(pose * Pose((0.0, 0.0, deepest)), 0.0, "")]
        drawn = max(high - BEFORE - gripper.pad[1] / 2, low + INTO)
        if drawn < deepest - 0.002:
            found.append((pose * Pose((0.0, 0.0, drawn)), 0.0, ", shallow"))
        yield [*found, (pose * Pose((0.0, 0.0, -tips)), tips, ", by the tips")]


def round_frames(geom: Geom, depth: float) -> Iterator[tuple[Pose, str]]:
    """Yield TCP frames around a cylinder, capsule or sphere in the thing's frame, with a name for people."""
    if geom.shape == "sphere":
        yield from _ball_frames(geom, depth)
        return
    radius, half = geom.size
    end = half + (radius if geom.shape == "capsule" else 0.0)
    turns = [(math.cos(k * math.tau / ANGLES), math.sin(k * math.tau / ANGLES)) for k in range(ANGLES)]
    for share, (x, y) in itertools.product((0.0, 0.5, -0.5), turns):
        name = (
            f"from the side at {math.degrees(math.atan2(y, x)):.0f} deg, {1000 * share * half:+.0f} mm "
            "along the axis"
        )
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


def coverage(shape: Body, hands: Hands, widths: Floats, gripper: Gripper) -> Floats:
    """Return the share of the pad (n,), sampled by rays along the closing direction, that meets the shape
    between the pads."""
    half, reach = 0.45 * gripper.pad[0], 0.45 * gripper.pad[1]
    grid = np.array([(x, 0.0, z) for x in np.linspace(-half, half, 3) for z in np.linspace(-reach, reach, 3)])
    points = hands.positions[:, None] + np.einsum("nij,gj->ngi", hands.turns, grid)
    low, high = intervals(shape, points.reshape(-1, 3), np.repeat(hands.closing, len(grid), axis=0))
    inner = np.repeat(widths, len(grid))
    between = (high > -inner[:, None] / 2) & (low < inner[:, None] / 2)
    far = np.where(between, high, -np.inf).max(axis=1, initial=-np.inf)
    near = np.where(between, low, np.inf).min(axis=1, initial=np.inf)
    return np.asarray((far - near > inner - 0.004).reshape(-1, len(grid)).mean(axis=1))


def _slants(geom: Geom, contacts: Floats, ways: Floats) -> Floats:
    """Angles between the surface normals at contacts and the closing lines (n,) [rad]."""
    back = inverse(geom.pose)
    p, d = back.apply(contacts), back.rotate(ways)
    if geom.shape == "box":
        faces = np.argmax(np.abs(p) / geom.size, axis=1)
        return _angles(d[np.arange(len(d)), faces])
    if geom.shape == "convex":
        planes = hull_planes(geom.corners)
        here = p @ planes[:, :3].T + planes[:, 3] > -2 * SKIN
        return _angles(np.where(here, np.abs(d @ planes[:, :3].T), 0.0).max(axis=1))
    normals = p.copy()
    if geom.shape != "sphere":
        normals[:, 2] -= np.clip(p[:, 2], -geom.size[1], geom.size[1])
    if geom.shape == "cylinder":
        normals[np.abs(p[:, 2]) >= geom.size[1] - SKIN] = (0.0, 0.0, 1.0)
    return _angles(np.einsum("ij,ij->i", normals, d) / np.maximum(np.linalg.norm(normals, axis=1), 1e-9))


def _angles(cosines: Floats) -> Floats:
    """Angles between lines [rad]."""
    return np.asarray(np.arccos(np.minimum(1.0, np.abs(cosines))))

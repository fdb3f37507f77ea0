"""Paths that demonstrations showed: of the middle of a moved thing's lower face, in the frame of another
thing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ..base.value import Value
from .geometry import Floats, Pose, Vector3
from .world.thing import Geom
from .world.thing_boxes import around, box

UPRIGHT = 0.9
"""Smallest vertical component of the z axis of a part (a unit vector) relative to which a path may be given: a tilt of 26 deg."""
STEP = 0.004
"""Distance between the points along a path at which it is compared with a track [m]."""
AHEAD = 0.12
"""Largest share of a path that may lie between two successive samples that count as on the path."""
Part = tuple[str, Pose, Mapping[str, float]]
"""Class, pose and sizes of a part of a thing, the pose in the frame of the thing."""


class Anchor(Value):
    """Frame in which a path's points are given: that of a thing, or of a part of it.

    Args:
        part: class of the part; "" for the thing's own frame.
        deep: whether its origin is at the part's bottom, by the part's height, rather than at the part's own.
        scaled: whether x and y are shares of half the part's width rather than metres.
        own: whether the frame is at the first place of the moved thing itself, upright, in any heading.
    """

    part: str = ""
    deep: bool = False
    scaled: bool = False
    own: bool = False

    def frame(self, parts: Iterable[Part]) -> tuple[Pose, float] | None:
        """Return the pose of the path's reference frame in the thing's frame, and the length [m] that one unit of
        the path's x and y stands for.

        None if the thing lacks the part that the frame is on.

        The unit is 1 m, or half the part's width where ``scaled``.
        """
        if not self.part:
            return Pose(), 1.0
        for class_, pose, size in parts:
            if class_ == self.part and pose.rotation[2, 2] > UPRIGHT and (not self.deep or "height" in size):
                down = Pose((0.0, 0.0, -size.get("height", 0.0))) if self.deep else Pose()
                return pose * down, size.get("width", 2.0) / 2 if self.scaled else 1.0
        return None


class ShownPath(Value):
    """Path of the middle of a thing's lower face relative to another thing, as demonstrations showed it.

    Args:
        points: corners in the anchor's frame; z [m], x and y [m] or, of a scaled anchor, shares.
        anchor: frame of the other thing.
        times: how often it is gone through; an open path each time from its beginning.
        least: how often it must be gone through, to be this motion.
        tolerance: distance that still counts as on the path [m].
        closed: whether its end is its beginning.
        either: whether a closed path may be gone through the other way round.
        touching: whether both touch all along.
        stand_off: height above the first and the last point at which it begins and ends [m].
        speed: along the path [m/s].
        heading: of the moved thing's x axis about the anchor's vertical, from the anchor's x axis [rad]; None where any will do.
    """

    points: tuple[Vector3, ...]
    anchor: Anchor
    times: int
    least: float
    tolerance: float
    closed: bool = False
    either: bool = False
    touching: bool = False
    stand_off: float = 0.1
    speed: float = 0.1
    heading: float | None = None

    @property
    def corners(self) -> Floats:
        """Corner points (N, 3) of the path in its reference frame; those of a closed path end with the first one
        again."""
        points = np.array(self.points, dtype=float)
        return np.concatenate([points, points[:1]]) if self.closed else points


def foot(geoms: Sequence[Geom], size: Vector3 | None = None) -> Vector3:
    """Return the middle of the lower face of a thing's box, in the thing's frame.

    Args:
        size: of the box around the thing's origin, where nobody knows its shape.
    """
    if not geoms:
        return (0.0, 0.0, -size[2] / 2 if size else 0.0)
    low, high = around([box(geom.pose, geom) for geom in geoms])
    return ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2])


def resampled(points: Floats, count: int) -> Floats:
    """Return points (count, 3) at even distances along a line through points (N, 3)."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, lengths[-1], count)
    return np.stack([np.interp(at, lengths, points[:, k]) for k in range(3)], axis=1)


def length(points: Floats) -> float:
    """Return the length of a line through points (N, 3) [m]."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def passes(path: ShownPath, points: Floats, counts: np.ndarray, metres: float = 1.0) -> float:
    """Return how often a series of points runs along the whole of a path; a fraction counts a run that
    ends on the way.

    Args:
        points: (N, 3) in the anchor's frame; x and y as the path has them.
        counts: (N,) which of them may count, such as those in contact.
        metres: how many of them one of x and y is.
    """
    scale = np.array([metres, metres, 1.0])
    line = path.corners * scale
    grid = resampled(line, max(int(length(line) / STEP), 8) + 1)
    off = np.linalg.norm((points * scale)[:, None] - grid[None], axis=2)
    near = (off <= path.tolerance) & counts[:, None]
    rows = np.flatnonzero(near.any(axis=1))
    if not len(rows):
        return 0.0
    if not path.closed:
        return _open(off, near, rows)
    ways = (1, -1) if path.either else (1,)
    return max(_around(off[:, -2::-1] if way < 0 else off[:, :-1], path.tolerance, rows) for way in ways)


def _open(off: Floats, near: np.ndarray, rows: np.ndarray) -> float:
    """Return the share of an open path, from its beginning, along which a series of points runs."""
    last, at = off.shape[1] - 1, 0
    ahead = max(round(AHEAD * last), 2)
    for row in rows.tolist():
        window = slice(at, at + ahead + 1)
        if near[row, window].any():
            at += int(np.argmin(off[row, window]))
    return float(at / last)


def _around(off: Floats, tolerance: float, rows: np.ndarray) -> float:
    """Return how many times a series of points runs along a closed path, from wherever it enters the path."""
    size = off.shape[1]
    ahead = np.arange(max(round(AHEAD * size), 2) + 1)
    at, done = int(np.argmin(off[rows[0]])), 0
    for row in rows.tolist():
        places = (at + ahead) % size
        step = int(np.argmin(off[row, places]))
        if off[row, places[step]] <= tolerance:
            done, at = done + step, (at + step) % size
    return float(done / size)

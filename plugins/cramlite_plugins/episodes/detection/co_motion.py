"""Common motion of recorded coordinate frames: tracks on one time grid, and the times at which one frame rides along with another.

Recordings are sparse, often written on change only, noisy and with gaps. Poses are interpolated over short gaps and held over
longer ones, and positions are averaged over ``SMOOTH``, which leaves 2 mm of 5 mm of tracker noise at 45 Hz.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Track, Value

from ..tracks import compose
from .signals import runs

#: Everything is looked at on a common time grid of this step [s]; recordings have 5 to 60 samples a second.
STEP = 0.02
#: Gaps up to this are interpolated [s]: a recorder of 5 Hz that lost a sample. Over longer ones nothing was seen to move.
BRIDGED = 0.5
#: Who is this far away after a gap [m] was lost and moved meanwhile, in gaps up to the second [s]; who records on change only writes
#: nothing while a thing rests, but would have written how it got there.
JUMPED, LOST = 0.05, 5.0
#: Positions are averaged over this [s]; the shortest swing of a shaken thing takes twice as long.
SMOOTH = 0.2
#: Speeds are taken over this window [s]; a thing moves above this speed [m/s]: 5 mm of noise at 10 Hz give 15 mm/s.
WINDOW, MOVING = 0.4, 0.04
#: A held thing stays within this of its place in the hand [m]: VR hands are compliant (1 cm on a real recording), and
#: 5 mm and 2 degrees of noise at 0.15 m add 1.5 cm.
STEADY = 0.035
#: A held thing travels this far at least [m]. Pauses in which it also keeps its place in the hand are bridged.
TRAVEL = 0.05
#: Stays at its place for this long at least [s]; what a hand hits and takes along is not held.
HELD = 0.3

Flags = NDArray[np.bool_]
Span = tuple[int, int]
"""Index range of the grid, end exclusive."""


class Grid(Value):
    """Poses of frames on one time grid.

    Args:
        times: (N,) [s], STEP apart.
        poses: frame -> (N, 7) position, averaged, and quaternion (w, x, y, z).
    """

    times: Floats
    poses: dict[str, Floats]

    def time(self, index: int) -> float:
        """Return the time of a sample of the grid by its index [s]; the index may be one past the last."""
        return float(self.times[0] + index * STEP)

    def moving(self, name: str) -> Flags:
        """Return the spans in which a frame moves faster than ``MOVING``."""
        return np.asarray(_speed(self.poses[name]) > MOVING)

    def place(self, thing: str, hand: str) -> Floats:
        """Return the position of a frame in another one's axes (N, 3) [m]."""
        its, mine = self.poses[thing], self.poses[hand]
        inverse = mine * [0, 0, 0, 1, -1, -1, -1]
        shifted = np.hstack([its[:, :3] - mine[:, :3], its[:, 3:]])
        return compose(inverse, shifted)[:, :3]

    def distance(self, one: str, other: str) -> Floats:
        """Return the distance of two frames' origins (N,) [m]."""
        return np.asarray(np.linalg.norm(self.poses[one][:, :3] - self.poses[other][:, :3], axis=1))


def grid_of(tracks: dict[str, Track]) -> Grid:
    """Resample tracks on one grid, from the first pose of any to the last."""
    known = {n: t for n, t in tracks.items() if len(t.times)}
    first, last = min(t.times[0] for t in known.values()), max(t.times[-1] for t in known.values())
    times = first + STEP * np.arange(int(np.ceil((last - first) / STEP - 1e-6)) + 1)
    return Grid(times, {n: _sampled(t, times) for n, t in known.items()})


def _sampled(track: Track, times: Floats) -> Floats:
    """Poses of a track at sample times: interpolated in short gaps, the last recorded pose in longer ones, and the
    first recorded pose before the track starts.

    A gap is short if it lasts up to BRIDGED, or up to LOST with positions before and after it that differ by
    more than JUMPED.
    """
    before = np.clip(np.searchsorted(track.times, times, side="right") - 1, 0, None)
    after = np.minimum(before + 1, len(track.times) - 1)
    gap = track.times[after] - track.times[before]
    away = np.linalg.norm(track.poses[after, :3] - track.poses[before, :3], axis=1)
    bridged = (gap > 0) & ((gap <= BRIDGED) | ((gap <= LOST) & (away > JUMPED)))
    share = np.where(bridged, (times - track.times[before]) / np.where(gap > 0, gap, 1.0), 0.0)
    a, b = track.poses[before], track.poses[after]
    sign = np.where(np.sum(a[:, 3:] * b[:, 3:], axis=1, keepdims=True) < 0, -1.0, 1.0)
    poses = a + np.clip(share, 0.0, 1.0)[:, None] * (np.hstack([b[:, :3], sign * b[:, 3:]]) - a)
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    poses[:, :3] = _averaged(poses[:, :3])
    return poses


def _averaged(points: Floats) -> Floats:
    half = round(SMOOTH / STEP / 2)
    sums = np.cumsum(np.vstack([np.zeros(3), np.pad(points, ((half, half), (0, 0)), mode="edge")]), axis=0)
    return np.asarray((sums[2 * half + 1 :] - sums[: -2 * half - 1]) / (2 * half + 1))


def _speed(poses: Floats) -> Floats:
    """Speed of positions over a centred window of WINDOW [m/s]."""
    half = round(WINDOW / STEP / 2)
    padded = np.pad(poses[:, :3], ((half, half), (0, 0)), mode="edge")
    return np.asarray(np.linalg.norm(padded[2 * half :] - padded[: -2 * half], axis=1) / (2 * half * STEP))


def travel(poses: Floats) -> float:
    """Return the largest distance of positions from the first one [m]."""
    return float(np.max(np.linalg.norm(poses[:, :3] - poses[0, :3], axis=1), initial=0.0))


def carried_spans(grid: Grid, thing: str, carrier: str) -> list[Span]:
    """Return in order of time the spans in which a thing moves along with a carrier, its place relative to
    the carrier unchanged.

    A pause in which it keeps its place, too, belongs to the span around it.
    """
    place = grid.place(thing, carrier)
    found: list[Span] = []
    for start, end in runs(grid.moving(thing)):
        for s, e in _steady(place, start, end):
            if found and _keeps(place, found[-1][0], e):
                found[-1] = (found[-1][0], e)
            else:
                found.append((s, e))
    return [(s, e) for s, e in found if (e - s) * STEP >= HELD and min(_travels(grid, thing, carrier, s, e)) > TRAVEL]


def _travels(grid: Grid, thing: str, carrier: str, start: int, end: int) -> tuple[float, float]:
    return travel(grid.poses[thing][start:end]), travel(grid.poses[carrier][start:end])


def _steady(place: Floats, start: int, end: int) -> list[Span]:
    """Return the parts of the span from ``start`` to ``end`` in which a relative position is near its median
    over that span."""
    near = _away(place[start:end], place[start:end]) < STEADY
    return [(start + s, start + e) for s, e in runs(near)]


def _keeps(place: Floats, start: int, end: int) -> bool:
    return bool(np.mean(_away(place[start:end], place[start:end]) < STEADY) > 0.98)


def _away(place: Floats, of: Floats) -> Floats:
    return np.asarray(np.linalg.norm(place - np.median(of, axis=0), axis=1))


def at_its_place(grid: Grid, thing: str, hand: str, span: Span, within: float) -> Span:
    """Return a span, extended by neighbouring samples in which the thing's position in the hand is within a distance
    [m] of its median over the span."""
    place = grid.place(thing, hand)
    near = np.linalg.norm(place - np.median(place[slice(*span)], axis=0), axis=1) < within
    start, end = span
    before, after = np.flatnonzero(~near[:start]), np.flatnonzero(~near[end:])
    return int(before[-1]) + 1 if len(before) else 0, end + int(after[0]) if len(after) else len(near)

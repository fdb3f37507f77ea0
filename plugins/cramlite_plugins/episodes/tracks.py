"""Conversion of recorded transforms between frames to tracks in the world frame, with repairs reported."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Repair, Track, Value

#: Quaternions of a length this near to 1 are left as they are; float32 writers are within it.
UNIT = 1e-5
#: Numbers beyond this [m] are no positions: the earth's radius. Their squares would overflow.
FARTHEST = 6.4e6
#: A link that stays within this of its place in its parent [m, or 1 - cosine of half the angle] is a rigid part of it.
STILL = 1e-4
#: Nearly identity [m, or 1 - cosine of half the angle], and this long before and after any other pose [s].
NEARLY, ALONE = 0.03, 10.0
#: How frames are called in which free things are recorded.
_ROOT = re.compile(r"(^|_)(root|map|world|odom|odom_combined|room_link)$", re.IGNORECASE)

_WORLD = re.compile(r"^(map|world)$", re.IGNORECASE)


class Rows(Value):
    """Recorded transforms of one child frame.

    Args:
        times: (N,) [s].
        poses: (N, 7) position and quaternion (w, x, y, z), in the parent frame.
        parents: (N,) index of each row's parent in ``names``.
        names: parent frames.
        trusted: identity poses are real ones, because the writer is known.
    """

    times: Floats
    poses: Floats
    parents: NDArray[np.int32]
    names: tuple[str, ...]
    trusted: bool = True

    def where(self, keep: NDArray[np.bool_]) -> Rows:
        """Return the recorded transforms that a mask (N,) selects."""
        return Rows(self.times[keep], self.poses[keep], self.parents[keep], self.names, self.trusted)


def world_tracks(rows: dict[str, Rows]) -> tuple[dict[str, Track], tuple[Repair, ...]]:
    """Return the tracks of all frames in the root frame of the transform tree, and the repairs."""
    inner = {n for r in rows.values() for n in r.names}
    clean: dict[str, Rows] = {}
    repairs: list[Repair] = []
    for name, recorded in rows.items():
        clean[name], found = _repaired(name, recorded, name in inner)
        repairs += found
    tracks: dict[str, Track] = {}
    for name in clean:
        _resolve(name, clean, tracks, repairs)
    return {name: tracks[name] for name in clean if len(tracks[name].times)}, tuple(repairs)


def rigid_links(rows: dict[str, Rows]) -> dict[str, str]:
    """Return the parent of each coordinate frame that never moves in its only parent; frames with a parent such as "map" are left out."""
    links = {}
    for name, recorded in rows.items():
        if len(set(recorded.names)) == 1 and recorded.names[0] in rows and not _ROOT.search(recorded.names[0]):
            still = np.ptp(recorded.poses[:, :3], axis=0).max(initial=0.0) < STILL
            if still and np.abs(recorded.poses[:, 3:] @ recorded.poses[0, 3:]).min() > 1 - STILL:
                links[name] = recorded.names[0]
    return links


def _repaired(name: str, rows: Rows, inner: bool) -> tuple[Rows, list[Repair]]:
    """Drop the rows of a track that hold no valid pose, sort the others by time, and scale quaternions to
    length 1."""
    near: NDArray[np.bool_] = np.asarray(np.all(np.abs(rows.poses) < FARTHEST, axis=1))
    length = np.linalg.norm(np.where(near[:, None], rows.poses[:, 3:], 0.0), axis=1)
    good = np.isfinite(rows.times) & near & (length > 1e-9)
    repairs: list[Repair | None] = [
        _repair(name, "dropped", "not finite, beyond all measure, or a quaternion without length", rows, ~good)
    ]
    rows, length = rows.where(good), length[good]
    if _WORLD.match(name):
        inside = np.array([not _ROOT.search(n) for n in rows.names], dtype=bool)[rows.parents]
        repairs.append(_repair(name, "dropped", "the world is in no thing's frame", rows, inside))
        rows, length = rows.where(~inside), length[~inside]
    identity = np.all(rows.poses == [0, 0, 0, 1, 0, 0, 0], axis=1) | _alone_near_identity(rows)
    if not (rows.trusted or inner) and identity.any():
        repairs.append(_repair(name, "dropped", "an identity pose means that the tracker saw nothing", rows, identity))
        rows, length = rows.where(~identity), length[~identity]
    wrong = np.abs(length - 1.0) > UNIT
    if wrong.any():
        repairs.append(_repair(name, "normalised", "quaternions were not of length 1", rows, wrong))
        rows.poses[wrong, 3:] /= length[wrong, None]
    late = np.diff(rows.times, prepend=-np.inf) < 0
    if late.any():
        repairs.append(_repair(name, "sorted", "stamps went back", rows, late))
        order = np.argsort(rows.times, kind="stable")
        rows = Rows(rows.times[order], rows.poses[order], rows.parents[order], rows.names, rows.trusted)
    return rows, [r for r in repairs if r is not None]


def _alone_near_identity(rows: Rows) -> NDArray[np.bool_]:
    """Whether each pose of a track is spurious, as from a recorder that has just started: nearly the identity,
    and far in time from all others."""
    near = (np.linalg.norm(rows.poses[:, :3], axis=1) < NEARLY) & (np.abs(rows.poses[:, 3]) > 1 - NEARLY)
    gaps = np.abs(np.diff(np.concatenate([[-np.inf], rows.times, [np.inf]])))
    return np.asarray(near & (np.minimum(gaps[:-1], gaps[1:]) > ALONE))


def _repair(name: str, done: str, why: str, rows: Rows, which: NDArray[np.bool_]) -> Repair | None:
    if not which.any():
        return None
    times = rows.times[which]
    times = times[np.isfinite(times)]
    when = (float(times.min()), float(times.max())) if len(times) else (0.0, 0.0)
    return Repair(f"{done} {int(which.sum())} of {len(which)} poses of '{name}'", when, why)


def _resolve(name: str, rows: dict[str, Rows], tracks: dict[str, Track], repairs: list[Repair]) -> None:
    """Compute the tracks in the world of a frame and of the frames above it in the transform tree.

    Iterative, so that no chain of frames is too long.
    """
    stack = [name]
    while stack:
        top = stack[-1]
        open_ = [p for p in rows[top].names if p in rows and p not in tracks]
        cyclic = [p for p in open_ if p in stack]
        for parent in cyclic:
            repairs.append(
                Repair(f"took '{parent}' as a root", (0.0, 0.0), f"frames '{top}' and '{parent}' contain each other")
            )
        waiting = [p for p in open_ if p not in stack]
        if waiting and top not in tracks:
            stack.append(waiting[0])
            continue
        if top not in tracks:
            tracks[top] = _in_world(rows[top], tracks)
        stack.pop()


def _in_world(rows: Rows, tracks: dict[str, Track]) -> Track:
    """Convert a frame's recorded transforms to its track in the world; the tracks of its parent frames are
    known."""
    if not any(p in tracks for p in rows.names):
        return Track(rows.times, rows.poses)
    bounds = [0, *(np.flatnonzero(np.diff(rows.parents)) + 1).tolist(), len(rows.times)]
    pieces = [_piece(rows, s, e, len(rows.times), tracks) for s, e in pairwise(bounds) if e > s]
    if not pieces:
        return Track(np.zeros(0), np.zeros((0, 7)))
    return Track(np.concatenate([p.times for p in pieces]), np.concatenate([p.poses for p in pieces]))


def _piece(rows: Rows, start: int, end: int, total: int, tracks: dict[str, Track]) -> Track:
    """Convert a frame's recorded transforms from row ``start`` to row ``end``, all given in one parent frame, to
    a track in the world."""
    times, poses = rows.times[start:end], rows.poses[start:end]
    parent = tracks.get(rows.names[rows.parents[start]])
    if parent is None or not len(parent.times):
        return Track(times, poses)
    until = rows.times[end] if end < total else np.inf
    moves = parent.times[1:]
    moves = moves[(moves > times[0]) & (moves < until)]
    instants = np.union1d(times, moves) if len(moves) else times
    mine = np.clip(np.searchsorted(times, instants, side="right") - 1, 0, None)
    base = np.clip(np.searchsorted(parent.times, instants, side="right") - 1, 0, None)
    return Track(instants, compose(parent.poses[base], poses[mine]))


def compose(a: Floats, b: Floats) -> Floats:
    """Convert poses ``b`` (N, 7), each given relative to a pose of ``a`` (N, 7), to the frame in which ``a`` are
    given."""
    wa, ua, wb, ub = a[:, 3:4], a[:, 4:], b[:, 3:4], b[:, 4:]
    turned = np.cross(ua, b[:, :3])
    position = a[:, :3] + b[:, :3] + 2 * wa * turned + 2 * np.cross(ua, turned)
    w = wa * wb - np.sum(ua * ub, axis=1, keepdims=True)
    return np.concatenate([position, w, wa * ub + wb * ua + np.cross(ua, ub)], axis=1)

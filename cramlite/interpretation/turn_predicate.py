"""Predicate that demonstrations define: a thing is turned about an axis of its own by an angle, in as many grasps as it takes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..model.episode import Episode
from ..model.geometry import Floats, Vector3
from .path_predicate import related
from .timeline import Phase, Predicate, Row


def turn_predicate(name: str, axis: Vector3, least: float, most: float) -> Predicate:
    """Return a predicate that holds where the hand turns a thing about an axis by an angle, summed over all its grasps.

    Args:
        name: of it, as rules write it.
        axis: in the thing's frame, of length 1; the turn about it is positive.
        least, most: of the angle [rad].
    """

    def holds(phase: Phase, thing: str | None) -> Iterator[Row]:
        names = [n for n, e in phase.timeline.entities.items() if e.part_of is None and n != phase.episode.effector]
        for one in [thing] if thing is not None else names:
            if least <= float(turn_in_hand(phase.episode, one, (phase.start, phase.end)) @ np.array(axis)) <= most:
                yield (one,)

    def unknown(phase: Phase, *things: str | None) -> str | None:
        missing = [t for t in things if t is not None and t not in phase.episode.tracks]
        return f"no poses of '{missing[0]}'" if missing else None

    low, high = np.degrees([least, most])
    doc = f"The hand turns a thing by {low:.0f} to {high:.0f} deg about an axis of its own, summed over all grasps."
    return Predicate(name, 1, holds, frozenset({"run"}), complete=True, doc=doc, unknown=unknown)


def turn_in_hand(episode: Episode, thing: str, span: tuple[float, float]) -> Floats:
    """Return the rotation vector (3,) [rad], in a thing's own frame, by which a thing turned in a span while the
    hand touched it.

    A turn there and back adds up to 0.

    It is the sum of the rotation vectors from one pose to the next, so that turns of more than 180 deg count, as long as samples are
    less than half a turn apart.
    """
    track = episode.tracks.get(thing)
    rows = np.flatnonzero((track.times >= span[0]) & (track.times <= span[1])) if track is not None else np.zeros(0, dtype=int)
    if track is None or len(rows) < 2 or not episode.effector:
        return np.zeros(3)
    had = related(episode, episode.effector, thing, track.times[rows])
    steps = _steps(track.poses[rows, 3:])
    return np.asarray((steps * (had[:-1] & had[1:])[:, None]).sum(axis=0))


def _steps(quaternions: Floats) -> Floats:
    """Return the rotation vectors (N-1, 3) [rad] between successive quaternions (N, 4), w first, each in the frame
    of the earlier orientation."""
    (w, x), (v, u) = (quaternions[:-1, 0], quaternions[1:, 0]), (quaternions[:-1, 1:], quaternions[1:, 1:])
    real = w * x + (v * u).sum(axis=1)
    imaginary = w[:, None] * u - x[:, None] * v - np.cross(v, u)
    imaginary, size = np.where(real < 0, -1.0, 1.0)[:, None] * imaginary, np.linalg.norm(imaginary, axis=1)
    angle = 2 * np.arctan2(size, abs(real))
    return np.asarray(imaginary * (angle / np.maximum(size, 1e-12))[:, None])

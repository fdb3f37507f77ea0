"""Predicates that demonstrations define: a thing goes along a shown path relative to another thing, or the
hand keeps still for a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..model.episode import Episode
from ..model.geometry import Floats
from ..model.shown_path import Part, ShownPath, foot, passes
from .in_place import done_in_place
from .timeline import Phase, Predicate, Row

STILL = 0.01
"""Distance within which a hand keeps still [m]: several times a person's drift."""


def path_predicate(name: str, path: ShownPath) -> Predicate:
    """Return a predicate that holds while the bottom centre of a thing moves along a path, given relative to
    another thing or to the moving thing's own place.

    Args:
        name: of it, as rules write it.
    """

    def in_place(phase: Phase, mover: str | None) -> Iterator[Row]:
        for one in [mover] if mover is not None else _things(phase):
            if done_in_place(path, phase.episode, one, (phase.start, phase.end)) >= path.least:
                yield (one,)

    def holds(phase: Phase, mover: str | None, about: str | None) -> Iterator[Row]:
        names = _things(phase)
        for one in [mover] if mover is not None else names:
            for other in [about] if about is not None else names:
                if one != other and gone_through(path, phase.episode, one, other, (phase.start, phase.end)) >= path.least:
                    yield (one, other)

    def unknown(phase: Phase, *things: str | None) -> str | None:
        missing = [t for t in things if t is not None and phase.episode.pose_at(t, phase.start) is None]
        return f"no pose of '{missing[0]}'" if missing else None

    arity, asked = (1, in_place) if path.anchor.own else (2, holds)
    return Predicate(name, arity, asked, frozenset({"run"}), complete=True, doc=_said(path), unknown=unknown)


def _things(phase: Phase) -> list[str]:
    return [n for n, e in phase.timeline.entities.items() if e.part_of is None and n != phase.episode.effector]


def rest_predicate(name: str, least_s: float) -> Predicate:
    """Return a predicate without arguments that holds where the hand keeps still for at least a time.

    Args:
        name: of it, as rules write it.
        least_s: of the time [s].
    """

    def holds(phase: Phase) -> Iterator[Row]:
        episode = phase.episode
        if episode.effector and max((b - a for a, b in rests(episode, episode.effector, (phase.start, phase.end))), default=0.0) >= least_s:
            yield ()

    doc = f"The hand keeps within {1000 * STILL:.0f} mm of a place for {least_s:g} s at least."
    return Predicate(name, 0, holds, frozenset({"run"}), complete=True, doc=doc)


def rests(episode: Episode, name: str, span: tuple[float, float]) -> Iterator[tuple[float, float]]:
    """Yield start and end of each rest within a span of an episode [s]: while it lasts, a frame stays within
    ``STILL`` of its first position."""
    track = episode.tracks.get(name)
    if track is None or not len(rows := np.flatnonzero((track.times >= span[0]) & (track.times <= span[1]))):
        return
    first = rows[0]
    for row in rows:
        if np.linalg.norm(track.poses[row, :3] - track.poses[first, :3]) > STILL:
            yield float(track.times[first]), float(track.times[row])
            first = row
    yield float(track.times[first]), float(span[1])


def _said(path: ShownPath) -> str:
    if path.anchor.own:
        return f"A thing goes to and fro about its own place at least {path.least:g} times, as it was shown."
    shape = "goes round its path about" if path.closed else "goes along its path on" if path.touching else "goes along its path at"
    touching = ", touching it" if path.touching else ""
    return f"A thing {shape} another thing at least {path.least:g} times, within {1000 * path.tolerance:.0f} mm{touching}."


def gone_through(path: ShownPath, episode: Episode, mover: str, about: str, span: tuple[float, float]) -> float:
    """Return how many times a thing went along a path relative to another thing in a span of an episode; a
    part of the path counts as a fraction."""
    if path.anchor.own:
        return done_in_place(path, episode, mover, span) if mover == about else 0.0
    frame = path.anchor.frame(parts_of(episode, about))
    found = followed(episode, mover, about, span) if frame is not None else None
    if frame is None or found is None:
        return 0.0
    times, points = found
    points = (points - np.array(frame[0].position)) @ frame[0].rotation
    points[:, :2] /= frame[1]
    low, high = path.corners.min(axis=0), path.corners.max(axis=0)
    if np.any(np.ptp(points, axis=0) < 0.5 * (high - low)):
        return 0.0  # most pairs of things
    counts = related(episode, mover, about, times) if path.touching else np.ones(len(times), dtype=bool)
    return passes(path, points, counts, frame[1])


def parts_of(episode: Episode, thing: str) -> list[Part]:
    """Return the parts of a thing whose poses relative to the thing are known."""
    return [(e.types[0], e.pose, e.properties) for e in episode.entities if e.part_of == thing and e.pose is not None and e.types]


def followed(episode: Episode, mover: str, about: str, span: tuple[float, float]) -> tuple[Floats, Floats] | None:
    """Return times (N,) [s] in a span, and the positions (N, 3) [m] of a thing's bottom centre in the frame of
    another thing.

    None if the poses of one of them are not known.
    """
    track, entity = episode.tracks.get(mover), episode.known(mover)
    if track is None or entity is None or episode.pose_at(about, span[0]) is None:
        return None
    rows = (track.times >= span[0]) & (track.times <= span[1])
    if rows.sum() < 2:
        return None
    times, poses = track.times[rows], track.poses[rows]
    places = poses[:, :3] + _turned(poses[:, 3:], np.array(foot(entity.geoms, entity.size)))
    its = episode.tracks.get(about)
    if its is None or not len(its.times):
        pose = episode.pose_at(about, span[0])
        assert pose is not None
        return times, (places - np.array(pose.position)) @ pose.rotation
    there = its.poses[np.maximum(its.times.searchsorted(times, side="right") - 1, 0)]
    back = there[:, 3:] * np.array([1.0, -1.0, -1.0, -1.0])
    return times, _turned(back, places - there[:, :3])


def headed(episode: Episode, mover: str, about: str, times: Floats) -> Floats:
    """Return the heading (N,) of a thing's x axis in the x-y plane of another thing's frame, counted from
    that frame's x axis [rad]."""
    pairs = ((episode.pose_at(about, float(t)), episode.pose_at(mover, float(t))) for t in times)
    axes = [one.inverse().rotate(other.rotate((1.0, 0.0, 0.0))) for one, other in pairs if one is not None and other is not None]
    return np.array([np.arctan2(a[1], a[0]) for a in axes])


def _turned(quaternions: Floats, vectors: Floats) -> Floats:
    """Rotate vectors (3,) or (N, 3) by quaternions (N, 4)."""
    w, v = quaternions[:, :1], quaternions[:, 1:]
    across = 2.0 * np.cross(v, vectors)
    return np.asarray(vectors + w * across + np.cross(v, across))


def related(episode: Episode, one: str, other: str, times: Floats) -> np.ndarray:
    """Return a mask (N,) of the times [s] at which a recorded state relates two things, such as that they
    touch."""
    found = np.zeros(len(times), dtype=bool)
    pair = {one, other}
    for event in episode.of("state"):
        if pair <= {episode.whole(n) for n in event.roles.values()}:
            found |= (times >= event.start) & (times < event.end)
    return found

"""Poses, sizes and distances of entities in a phase of an episode; each is computed once."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Floats, Pose, Vector3, seen_from, vector3
from cramlite.plugin import Phase, Timeline

from ..shapes.bounds import box_around

Box = tuple[Vector3, Vector3]
"""Lowest and highest corner of a bounding box, in an entity's frame [m]."""


def things(phase: Phase) -> tuple[str, ...]:
    """Return the names of the things of an episode."""
    memo = phase.timeline.memo
    if "things" not in memo:
        effectors = set(phase.timeline.entities_of("soma:PhysicalEffector")) | {phase.episode.effector}
        memo["things"] = tuple(
            n for n, e in phase.timeline.entities.items() if e.part_of is None and n not in effectors
        )
    return memo["things"]  # type: ignore[no-any-return]


def each(phase: Phase, name: str | None) -> tuple[str, ...]:
    """Return a name that is given, or the names of all things where none is."""
    return things(phase) if name is None else (name,)


def pairs(phase: Phase, one: str | None, other: str | None) -> Iterator[tuple[str, str]]:
    """Generate the pairs of two different things, ordered by the first; a name that is given stands for itself."""
    yield from ((a, b) for a in each(phase, one) for b in each(phase, other) if a != b)


def tips(timeline: Timeline) -> tuple[str, ...]:
    """Return the finger tips of the effector that are tracked."""
    episode = timeline.episode
    if "tips" not in timeline.memo:
        own = (e.name for e in episode.entities if e.part_of is not None and e.part_of == episode.effector)
        timeline.memo["tips"] = tuple(
            n for n in own if n in episode.tracks and "cram:Camera" not in timeline.entities[n].types
        )
    return timeline.memo["tips"]  # type: ignore[no-any-return]


def pose_of(phase: Phase, name: str, time: float) -> Pose | None:
    """Return the pose of an entity in the world frame; that of an untracked one is looked up only once."""
    timeline = phase.timeline
    if name not in timeline.entities and name not in phase.episode.tracks:
        return None
    moving = any(w in phase.episode.tracks for w in timeline.wholes.get(name, (name,)))
    key = ("pose", name, time if moving else None)
    if key not in timeline.memo:
        timeline.memo[key] = phase.episode.pose_at(name, time)
    return timeline.memo[key]  # type: ignore[no-any-return]


def box_of(phase: Phase, name: str) -> Box | None:
    """Return the lower and upper corner of an entity's box in its frame [m], from its shape, or else from its size about its origin."""
    memo = phase.timeline.memo
    if ("box", name) not in memo:
        memo["box", name] = _find_box(phase, name)
    return memo["box", name]  # type: ignore[no-any-return]


def _find_box(phase: Phase, name: str) -> Box | None:
    entity = phase.timeline.entities.get(name)
    if entity is None:
        return None
    if entity.geoms:
        low, high = box_around(entity.geoms)
        return vector3(low), vector3(high)
    if entity.size is None:
        return None
    half = np.asarray(entity.size) / 2
    return vector3(-half), vector3(half)


def relative_position(phase: Phase, name: str, other: str, time: float) -> Vector3 | None:
    """Return the position of another entity's origin in an entity's frame [m]."""
    pose, origin = pose_of(phase, name, time), pose_of(phase, other, time)
    if pose is None or origin is None:
        return None
    offset = np.subtract(origin.position, pose.position) @ pose.rotation
    return vector3(offset)


def distance_to_box(phase: Phase, name: str, other: str, time: float) -> float | None:
    """Return the distance of another entity's origin from a thing's box [m]."""
    memo = phase.timeline.memo
    known = memo.get(("gaps", name, other))
    if known is None:
        known = memo["gaps", name, other] = _gaps_at_boundaries(phase, name, other)
    if time not in known:
        known[time] = _distance(phase, name, other, time)
    return known[time]


def _gaps_at_boundaries(phase: Phase, name: str, other: str) -> dict[float, float | None]:
    """Compute the distances of an entity's origin from another's box, at once for all times at which states
    or actions begin or end.

    Empty for parts, which follow their whole.
    """
    mine, its = _at_boundaries(phase, name), _at_boundaries(phase, other)
    if mine is None or its is None:
        return {}
    seen = seen_from(mine, its[:, :3])
    low, high = box_of(phase, name) or ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    outside = np.maximum(np.maximum(low - seen, seen - high), 0.0)
    return dict(zip(phase.timeline.cuts, np.linalg.norm(outside, axis=1).tolist(), strict=True))


def _at_boundaries(phase: Phase, name: str) -> Floats | None:
    """Poses (N, 7) of a thing at all times at which states or actions begin or end.

    None if they are unknown, or for a part of a thing.
    """
    cuts, track = phase.timeline.cuts, phase.episode.tracks.get(name)
    if track is not None and len(track.times):
        return track.poses[np.maximum(np.searchsorted(track.times, np.array(cuts), side="right") - 1, 0)]
    entity = phase.timeline.entities.get(name)
    pose = pose_of(phase, name, phase.start) if entity is not None and entity.part_of is None else None
    return None if pose is None else np.tile((*pose.position, *pose.quaternion), (len(cuts), 1))


def _distance(phase: Phase, name: str, other: str, time: float) -> float | None:
    """Distance of another entity's origin from an entity's box [m]."""
    point = relative_position(phase, name, other, time)
    if point is None:
        return None
    low, high = box_of(phase, name) or ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    return math.hypot(*(max(a - v, v - b, 0.0) for v, a, b in zip(point, low, high, strict=True)))

"""What stands on what, from shapes and poses: boxes around things, aligned with the world's axes."""

from __future__ import annotations

import itertools

import numpy as np

from cramlite.episode import Entity, Episode, Event
from cramlite.geometry import Floats, Pose

#: An underside this near to a top face [m] stands on it; trackers and drawn models are about this exact.
NEAR = 0.015
Box = tuple[Floats, Floats]


def supports(episode: Episode, held: dict[str, tuple[float, float]]) -> list[Event]:
    """SupportStates, inferred, of the objects that were held: before the grasp and after it.

    Args:
        episode: entities with sizes or shapes, and tracks.
        held: object -> when it was held [s].
    """
    first, last = episode.span
    found = []
    for name, (start, end) in held.items():
        for span in ((first, start), (end, last)):
            below = _under(episode, name, sum(span) / 2) if span[1] > span[0] else None
            if below is not None:
                found.append(
                    Event("", "soma:SupportState", "state", *span, {"supporter": below, "supportee": name}, True)
                )
    return found


def _under(episode: Episode, name: str, time: float) -> str | None:
    """The thing whose top is nearest to the underside of another, within NEAR, and that overlaps it seen from above."""
    box = _box(episode, episode.entity(name), time)
    others = [e for e in episode.entities if e.part_of is None and e.name not in (name, episode.effector)]
    gaps = []
    for other in others:
        around = _box(episode, other, time)
        if box is not None and around is not None:
            gap = abs(float(box[0][2] - around[1][2]))
            over = np.all(box[0][:2] < around[1][:2]) and np.all(around[0][:2] < box[1][:2])
            if over and gap < NEAR:
                gaps.append((gap, other.name))
    return min(gaps)[1] if gaps else None


def _box(episode: Episode, entity: Entity, time: float) -> Box | None:
    """Lowest and highest corner of an entity in the world; its size is taken as centred on its frame."""
    pose = episode.pose_at(entity.name, time)
    size = entity.size
    if pose is None or size is None:
        return None
    corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * size
    world: Floats = Pose(pose.position, pose.quaternion).apply(corners)
    return world.min(axis=0), world.max(axis=0)

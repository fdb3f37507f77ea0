"""What stands on, touches and lies in what, from shapes and poses: boxes around things, aligned with the world's axes.

A box around a turned or round thing is larger than the thing, so these are conclusions, and their events are marked
``inferred``: what is recorded of contacts is always preferred (motion.py asks here only where nothing is).
"""

from __future__ import annotations

import itertools

import numpy as np

from cramlite.episode import Entity, Episode, Event
from cramlite.geometry import Floats
from cramlite.world import Geom

from ..shapes.hull import hull_planes
from .entities import bounds

#: An underside this near to a top face [m] stands on it; trackers and drawn models are about this exact.
NEAR = 0.015
#: Boxes nearer than this touch [m].
TOUCH = 0.005
Box = tuple[Floats, Floats]


def resting(episode: Episode, held: list[tuple[str, float, float]]) -> list[Event]:
    """States, inferred, of the objects that were held: between grasps, where each is at rest.

    A SupportState and ContactState with what it stands on, a ContainmentState with what it lies in, and ContactStates
    with what else is nearer than TOUCH.

    Args:
        episode: entities with sizes or shapes, and tracks.
        held: object, and when it was held [s].
    """
    first, last = episode.span
    found = []
    for name in dict.fromkeys(n for n, _, _ in held):
        grasps = sorted((s, e) for n, s, e in held if n == name)
        rests = zip([first, *(e for _, e in grasps)], [*(s for s, _ in grasps), last], strict=True)
        for span in rests:
            if span[1] > span[0]:
                found += _at_rest(episode, name, span)
    return found


def _at_rest(episode: Episode, name: str, span: tuple[float, float]) -> list[Event]:
    time = sum(span) / 2
    box = box_of(episode, episode.entity(name), time)
    if box is None:
        return []
    boxes = {
        e.name: around
        for e in episode.entities
        if episode.whole(e.name) == e.name
        and e.name not in (name, episode.effector)
        and (around := box_of(episode, e, time)) is not None
    }
    container = next(
        (n for n, around in boxes.items() if encloses(around, box) and _hollow(episode, n, box, time)), None
    )
    supporter = container or _under(box, boxes)
    touching = dict.fromkeys(
        [*([supporter] if supporter else []), *(n for n, b in boxes.items() if gap(b, box) < TOUCH)]
    )
    states = [("soma:ContactState", {"a": name, "b": other}) for other in touching]
    if supporter is not None:
        states.append(("soma:SupportState", {"supporter": supporter, "supportee": name}))
    if container is not None:
        states.append(("soma:ContainmentState", {"container": container, "content": name}))
    return [Event("", type_, "state", *span, roles, True) for type_, roles in states]


def encloses(outer: Box, inner: Box) -> bool:
    """Whether a thing lies in another: seen from above it is inside, and its lower half at least is below the rim."""
    above = np.all(outer[0][:2] <= inner[0][:2] + TOUCH) and np.all(inner[1][:2] <= outer[1][:2] + TOUCH)
    middle = (inner[0][2] + inner[1][2]) / 2
    return bool(above and outer[0][2] - TOUCH <= inner[0][2] and middle <= outer[1][2])


def gap(a: Box, b: Box) -> float:
    """Distance of two boxes [m]; 0 where they overlap."""
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(a[0] - b[1], b[0] - a[1]))))


def _hollow(episode: Episode, name: str, box: Box, time: float) -> bool:
    """Whether there is room in a thing: no primitive of its shape fills the place. Of a shape that is not known, only the
    extents, there must be: solid things do not lie in each other."""
    pose = episode.pose_at(name, time)
    if pose is None:
        return False
    centre = pose.inverse().apply((box[0] + box[1]) / 2)
    return not any(_inside(g, g.pose.inverse().apply(centre)) for g in episode.entity(name).geoms)


def _inside(geom: Geom, point: Floats) -> bool:
    """Whether a point of a primitive's frame is in it."""
    if geom.shape == "box":
        return bool(np.all(np.abs(point) < geom.size))
    if geom.shape == "sphere":
        return float(np.linalg.norm(point)) < geom.size[0]
    if geom.shape == "convex":
        planes = hull_planes(geom.corners)
        return bool(np.all(planes[:, :3] @ point + planes[:, 3] < 0))
    beyond = max(abs(float(point[2])) - geom.size[1], 0.0)
    across = float(np.hypot(point[0], point[1]))
    return (
        across < geom.size[0] and beyond == 0 if geom.shape == "cylinder" else np.hypot(across, beyond) < geom.size[0]
    )


def _under(box: Box, boxes: dict[str, Box]) -> str | None:
    """The thing whose top is nearest to the underside of another, within NEAR, and that overlaps it seen from above."""
    gaps = []
    for name, around in boxes.items():
        height = abs(float(box[0][2] - around[1][2]))
        over = np.all(box[0][:2] < around[1][:2]) and np.all(around[0][:2] < box[1][:2])
        if over and height < NEAR:
            gaps.append((height, name))
    return min(gaps)[1] if gaps else None


def box_of(episode: Episode, entity: Entity, time: float) -> Box | None:
    """Lowest and highest corner of an entity in the world, around its primitives; where only its size is known, that is
    taken as centred on its frame. None if its pose or extents are unknown."""
    pose = episode.pose_at(entity.name, time)
    if pose is None or (entity.size is None and not entity.geoms):
        return None
    if entity.geoms:
        low, high = (np.array(c) for c in zip(*(bounds(g) for g in entity.geoms), strict=True))
        low, high = low.min(axis=0), high.max(axis=0)
    else:
        high = np.array(entity.size) / 2
        low = -high
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    world: Floats = pose.apply(corners)
    return world.min(axis=0), world.max(axis=0)

"""Support, contact and containment of objects at rest, inferred from shapes and poses: oriented boxes around things.

A box around a round or hollow thing is larger than the thing, so these are conclusions, and their events are marked
``inferred``: what is recorded of contacts is always preferred (from_motion.py asks here only where nothing is).
"""

from __future__ import annotations

import numpy as np

from cramlite.model import Episode, Event, Floats, Geom

from ...shapes.convex import hull_planes
from .oriented_box import OrientedBox, box_of, is_inside_outline, over, separation

#: An underside this near to a top face [m] stands on it; trackers and drawn models are about this exact.
NEAR = 0.015
#: OrientedBoxes nearer than this touch [m].
TOUCH = 0.005


def resting(episode: Episode, held: list[tuple[str, float, float]]) -> list[Event]:
    """Infer the states of the objects that were held: between grasps, where each is at rest.

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
    if container is not None:  # its floor is between the thing and what it stands on
        floor = boxes[container].low + NEAR
        boxes = {n: b for n, b in boxes.items() if n == container or b.high > floor}
    supporter = container or _under(box, boxes)
    touching = dict.fromkeys(
        [*([supporter] if supporter else []), *(n for n, b in boxes.items() if separation(b, box) < TOUCH)]
    )
    states = [("soma:ContactState", {"a": name, "b": other}) for other in touching]
    if supporter is not None:
        states.append(("soma:SupportState", {"supporter": supporter, "supportee": name}))
    if container is not None:
        states.append(("soma:ContainmentState", {"container": container, "content": name}))
    return [Event("", type_, "state", *span, roles, True) for type_, roles in states]


def encloses(outer: OrientedBox, inner: OrientedBox) -> bool:
    """Check by their boxes whether a thing lies in another: seen from above it is inside the other's outline, and at least its lower half
    is below the other's top."""
    middle = (inner.low + inner.high) / 2
    return is_inside_outline(inner, outer, TOUCH) and outer.low - TOUCH <= inner.low and middle <= outer.high


def _hollow(episode: Episode, name: str, box: OrientedBox, time: float) -> bool:
    """Whether a place in a thing is free: outside all primitives of its shape. An unknown shape counts as
    hollow, since solid things do not overlap."""
    pose = episode.pose_at(name, time)
    if pose is None:
        return False
    centre = pose.inverse().apply(box.centre)
    return not any(_inside(g, g.pose.inverse().apply(centre)) for g in episode.entity(name).geoms)


def _inside(geom: Geom, point: Floats) -> bool:
    """Whether a point in a primitive's frame is inside that primitive."""
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


def _under(box: OrientedBox, boxes: dict[str, OrientedBox]) -> str | None:
    """The thing whose top is nearest to the underside of another, within NEAR, and that overlaps it seen from above."""
    heights = {name: abs(box.low - around.high) for name, around in boxes.items()}
    near = [(height, name) for name, height in heights.items() if height < NEAR and over(box, boxes[name])]
    return min(near)[1] if near else None

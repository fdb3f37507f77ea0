"""Joints of drawers and doors: values that follow from believed poses, and mounts: the stated one, and
furniture whose bounding box meets the thing's."""

from __future__ import annotations

from cramlite.model import Belief, Pose, Thing, World

from .bounds import corners

GAP = 0.002  # between the boxes around a drawer and its cabinet at most [m]


def joint_value(belief: Belief, thing: str, pose: Pose) -> float:
    """Return the value of a thing's joint when the thing is at a pose in the world [m, rad]."""
    start = belief.world.thing(thing)
    assert start.joint is not None
    shift = belief.world.carrier_shift(
        thing, {n: e.pose for n, e in belief.poses.items() if n == start.joint.parent}
    )
    return start.joint.value + start.joint.between(shift * start.pose, pose)


def mounts(thing: Thing, world: World) -> tuple[str, ...]:
    """Find the mounts of a thing on a joint: the stated one, and furniture whose axis-aligned box meets the
    thing's.

    Of a thing on a thing that moves on a joint, such as a lever on a door, the stated one alone. Rails and
    hinges lead it clear of that, and it may run against its stop there. Of furniture on joints only what is
    mounted in the same thing counts, as the next drawer is; a latch on the jamb is an obstacle.
    """
    if thing.joint is None:
        return ()
    if any(t.name == thing.joint.parent and t.joint is not None for t in world.things):
        return (thing.joint.parent,)
    points = corners(thing, thing.pose)
    low, high = points.min(axis=0) - GAP, points.max(axis=0) + GAP
    found = [thing.joint.parent] if thing.joint.parent else []
    for other in world.things:
        beside = other.joint is None or other.joint.parent == thing.joint.parent
        if other.furniture and beside and other.name != thing.name and other.geoms:
            around = corners(other, other.pose)
            if (around.min(axis=0) <= high).all() and (around.max(axis=0) >= low).all():
                found.append(other.name)
    return tuple(dict.fromkeys(found))

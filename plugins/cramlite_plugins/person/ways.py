"""Paths of a person's hand over the things between start and goal, and free points to put things at."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from cramlite.model import Feature, Floats, Pose, Thing, World
from cramlite.plugin import Performer

from ..shapes.bounds import lowest, support
from .at_ease import facing, forward_and_down
from .sight_of_person import half_extents

#: Room above what the hand, or what it holds, passes over [m].
OVER = 0.05
#: How far palm and fingers reach below the tool frame's origin, whichever way the hand points [m].
HAND_BELOW = 0.03
#: A hand that turns by more than this turns by way of its rest [rad].
FAR_TURN = 2.0
#: Between what is put down and everything else there [m].
ROOM = 0.03
#: What reaches no higher than this above a surface does not stand on it [m].
LEVEL = 0.005
UP = (0.0, 0.0, 1.0)


def go(person: Performer, world: World, goal: Pose, speed: float, held: str = "") -> None:
    """Move the hand to a pose by an arc over all things between start and goal, steeply up and down at its ends.

    Args:
        held: the thing in the hand, whose underside is to clear them; "" for none.
    """
    here = person.aim
    reach = HAND_BELOW
    if held:
        thing, pose = world.thing(held), person.pose(held)
        reach = max(reach, person.tool().position[2] - pose.position[2] - lowest(thing, pose))
    tops = [
        support(t, person.pose(t.name), UP)
        for t in world.things
        if t.name != held and _between(person.pose(t.name), t, here.position, goal.position)
    ]
    ends = (here.position[2], goal.position[2])
    peak = max(*ends, *(top + reach + OVER for top in tops))
    rise = (8 * peak - sum(ends)) / 6  # where the control points of a cubic Bézier are, for its middle to be at the peak
    controls = [Pose((*p.position[:2], max(rise, p.position[2])), goal.quaternion) for p in (here, goal)]
    if not held and here.distance(goal)[1] > FAR_TURN:  # by way of rest, as a wrist turns
        middle = tuple(np.mean([c.position for c in controls], axis=0))
        person.move([controls[0], Pose(middle, forward_and_down(facing(world)).quaternion)], speed, curved=True)
        controls = controls[1:]
    person.move([*controls, goal], speed, curved=True)


def _between(pose: Pose, thing: Thing, a: tuple[float, float, float], b: tuple[float, float, float]) -> bool:
    """Whether a thing is near the straight line between two points, seen from above."""
    half = half_extents(thing)[:2]
    start, way = np.array(a[:2]), np.subtract(b, a)[:2]
    length = float(way @ way)
    middle = np.array(pose.position[:2])
    share = float(np.clip((middle - start) @ way / length, 0.0, 1.0)) if length > 1e-9 else 0.0
    return bool(np.linalg.norm(start + share * way - middle) < np.linalg.norm(half) + 0.08)


def top_of(thing: Thing, pose: Pose, wide: float = 0.0) -> tuple[Pose, Floats]:
    """Return the frame of the supporting area of a thing, z up, and half its sides (2,) [m]: surface,
    floor of a vessel, or top.

    Args:
        wide: half the narrower side of what is to lie there [m]; what does not fit into a vessel lies on its rim.
    """
    cavity, surfaces = thing.feature("cram:Cavity"), [f for f in thing.features if f.type == "vrps:SurfaceFeature"]
    surface = next((f for f in surfaces if (pose * f.pose).rotation[2, 2] > 0.9), None)  # not the one that it stands on
    if surface is not None:
        return pose * surface.pose, np.array(_sides(surface)) / 2
    if cavity is not None and wide <= min(_sides(cavity)) / 2:
        floor = pose * cavity.pose * Pose((0, 0, -cavity.size.get("height", 0.0)))
        return floor, np.array(_sides(cavity)) / 2
    return Pose((*pose.position[:2], support(thing, pose, UP)), pose.quaternion), half_extents(thing)[:2]


def narrow(thing: Thing) -> float:
    """Return half the narrower of a thing's level sides [m]."""
    return float(half_extents(thing)[:2].min())


def _sides(feature: Feature) -> tuple[float, float]:
    return feature.size.get("width", 0.0), feature.size.get("depth", 0.0)


def free_spot(person: Performer, world: World, thing: Thing, onto: Thing) -> Floats:
    """Draw a point (3,) of a support, in the world, where a thing overlaps no other: near the thing's place, else near the middle."""
    frame, half = top_of(onto, person.pose(onto.name), narrow(thing))
    own = float(np.linalg.norm(half_extents(thing)[:2]))
    room = np.maximum(half - own, 0.0)
    now = np.array(frame.inverse().apply(person.pose(thing.name).position)[:2])
    wanted = now if bool((np.abs(now) <= room).all()) else np.zeros(2)
    spots = [np.clip(wanted + person.rng.normal(0, 0.02 + 0.004 * k, 2), -room, room) for k in range(100)]
    level = frame.position[2] + LEVEL
    others = [t for t in world.things if t.name not in (thing.name, onto.name) and support(t, person.pose(t.name), UP) > level]
    places = [np.asarray(frame.apply((*spot, 0.0))) for spot in spots]
    return next((p for p in places if all(_apart(person, p, own, t) for t in others)), places[0])


def _apart(person: Performer, spot: Floats, radius: float, other: Thing) -> bool:
    local = person.pose(other.name).inverse().apply(tuple(spot))
    beside = np.maximum(np.abs(np.asarray(local)[:2]) - half_extents(other)[:2], 0.0)
    return float(np.linalg.norm(beside)) > radius + ROOM


def upright(pose: Pose) -> Pose:
    """Return the pose turned as little as makes its most upright axis vertical; an inverted thing stays
    inverted."""
    axes = pose.rotation
    k = int(np.argmax(np.abs(axes[2])))
    up = axes[:, k] * np.sign(axes[2, k])
    across = np.cross(up, UP)
    size = float(np.linalg.norm(across))
    if size < 1e-9:
        return pose
    turn = Pose.from_rotvec((0, 0, 0), tuple(across / size * np.arcsin(min(size, 1.0))))
    return Pose(pose.position, (turn * Pose((0, 0, 0), pose.quaternion)).quaternion)


def hand_for(person: Performer, thing: str, goal: Pose) -> Pose:
    """Return the target of the hand that brings its payload to a pose; the hand's lag behind its target is
    corrected."""
    hand = goal * person.pose(thing).inverse() * person.tool()
    lag = np.subtract(person.aim.position, person.tool().position)
    return replace(hand, position=tuple(np.add(hand.position, lag)))

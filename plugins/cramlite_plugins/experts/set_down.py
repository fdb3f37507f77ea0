"""Where to bring a held thing: into a container's opening, or onto a surface."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cramlite import (
    Answers,
    Belief,
    Context,
    Feature,
    Grounding,
    Location,
    Place,
    Pose,
    Refused,
    Thing,
    Unresolvable,
    hookimpl,
)

YAWS = (
    0.0,
    30.0,
    -30.0,
    60.0,
    -60.0,
    90.0,
    -90.0,
    135.0,
    -135.0,
    180.0,
)  # turns about the vertical that are tried [deg]
INTO = (-0.08, -0.05, -0.02, 0.01, 0.04)  # lowest point of the thing above a container's rim when let go [m]
ONTO = (0.02,)  # the same above a surface, from where a guarded motion goes on [m]
ABOVE = 0.06  # stand-off above a rim or surface [m]
PER_TURN, PER_HEIGHT = 0.1, 0.02  # cost of a radian of turn, and of each height above the lowest


@dataclass(frozen=True)
class Spot:
    """A pose for the held thing, and the TCP poses that bring it there."""

    name: str
    pose: Pose
    before: Pose
    height: float


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    wanted = {"in": ("cram:Cavity", INTO), "on": ("vrps:SurfaceFeature", ONTO)}
    if location.relation not in wanted:
        return None
    return _spots(location, belief, context, *wanted[location.relation])


def _spots(
    location: Location, belief: Belief, context: Context, needs: str, heights: tuple[float, ...]
) -> Iterator[Grounding | Refused]:
    """Every turn, the lowest height at which hand and thing are free."""
    from .reach import bound, held_pose, make_scene

    entity, now = bound(context, location.of), held_pose(belief, context)
    feature = belief.feature(entity, needs)
    if feature is None:
        raise Unresolvable(f"'{entity}' has no {needs} to put anything {location.relation}", (location.of or "",))
    target, scene = _target(belief, entity, feature), make_scene(belief, context)
    assert belief.held is not None
    for yaw in YAWS:
        for k, height in enumerate(heights):
            spot = _spot(target, now, belief, context, yaw, height)
            reason = _blocked(scene, context, spot, belief)
            if not reason:
                values = {"height_m": height}
                place = Place(spot.pose, spot.before, approach=(0, 0, -1), thing=belief.held.thing, values=values)
                yield Grounding(
                    place, f"'{entity}', {spot.name}", PER_TURN * abs(math.radians(yaw)) + PER_HEIGHT * k, key=spot.name
                )
                break
            yield Refused(spot.name, reason)


def _target(belief: Belief, entity: str, feature: Feature) -> Pose:
    """The feature in the base frame."""
    return belief.pose(entity.split("/")[0]) * feature.pose


def _spot(target: Pose, now: Pose, belief: Belief, context: Context, yaw: float, height: float) -> Spot:
    """Over the middle of the target, upright as held, turned from facing it by ``yaw`` [deg]."""
    from .reach import shift, tcp

    assert belief.held is not None
    hand, thing = tcp(belief, context), belief.world.thing(belief.held.thing)
    facing = math.atan2(target.position[1], target.position[0]) - math.atan2(hand.position[1], hand.position[0])
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, facing + math.radians(yaw)))
    centre = (*target.position[:2], target.position[2] + height - lowest(thing, now))
    pose = Pose(centre, (turn * Pose((0, 0, 0), now.quaternion)).quaternion) * belief.held.tcp_to_thing.inverse()
    name = f"turned {yaw:+.0f} deg, lowest point {1000 * height:+.0f} mm from it"
    return Spot(name, pose, shift(pose, (0, 0, max(ABOVE - height, ABOVE))), height)


def _blocked(scene: object, context: Context, spot: Spot, belief: Belief) -> str:
    from .reach import stance

    above = stance(scene, context, spot.before, belief.joints)  # type: ignore[arg-type]
    if isinstance(above, str):
        return f"above it: {above}"
    there = stance(scene, context, spot.pose, above)  # type: ignore[arg-type]
    return f"at it: {there}" if isinstance(there, str) else ""


def lowest(thing: Thing, pose: Pose) -> float:
    """How far the lowest point of a thing is from its origin, upwards, at this orientation [m].

    The support function of a box along the vertical, sum |r_z,i| h_i; round shapes by the box around them.
    """
    reach = []
    for geom in thing.geoms:
        if geom.shape == "convex":
            reach.append(float(pose.turn(geom.pose.apply(geom.corners))[:, 2].min()))
            continue
        down = (Pose((0, 0, 0), pose.quaternion) * geom.pose).rotation[2]
        centre = float(pose.turn(geom.pose.position)[2])
        half = geom.size if geom.shape == "box" else (geom.size[0], geom.size[0], sum(geom.size))
        reach.append(centre - float(np.abs(down) @ np.array(half)))
    return min(reach)

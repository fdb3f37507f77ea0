"""Touching poses of the empty hand: above the middle of a surface, pointing down, turned so that the arm reaches."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cramlite.model import Belief, Location, Place, Pose, replace, thing_of
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..motion_planning.reach import bound, collision_free_ik, make_scene, shift

YAWS = (0.0, 90.0, -90.0, 180.0, 45.0, -45.0)  # turns about the vertical that are tried, from facing away [deg]
ABOVE, ALMOST = 0.06, 0.005  # finger tips above the surface at the stand-off, and where feeling begins [m]
DOWN = Pose((0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))  # the tool's z axis down, its x axis ahead


def touch(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate places of the fingers' tips above a surface."""
    entity = bound(context, location.of)
    surface = belief.feature(entity, "vrps:SurfaceFeature")
    if surface is None:
        raise Unresolvable(f"'{entity}' has no vrps:SurfaceFeature to touch", (location.of or "",))
    middle = belief.pose(thing_of(entity)) * surface.pose
    free, near = make_scene(belief, context), make_scene(belief, context, [thing_of(entity)])
    tips = context.robot.gripper.pad[1] / 2
    facing = math.degrees(math.atan2(middle.position[1], middle.position[0]))
    for k, yaw in enumerate(YAWS):
        turn = Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(facing + yaw))) * DOWN
        at = shift(Pose(middle.position, turn.quaternion), (0, 0, tips + ALMOST))
        before = shift(at, (0, 0, ABOVE))
        for where, pose, scene in (("above it", before, free), ("at it", at, near)):
            there = collision_free_ik(scene, context, pose, belief.joints)
            if isinstance(there, Refused):
                yield replace(there, reason=f"{where}: {there.reason}").of(f"turned {yaw:+.0f} deg")
                break
        else:
            place = Place(at, before, approach=(0.0, 0.0, -1.0), thing=thing_of(entity))
            yield Grounding(place, f"finger tips over the middle of '{entity}'", 0.1 * k, key=f"turned {yaw:+.0f}")

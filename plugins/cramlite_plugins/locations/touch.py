"""Poses in which the empty hand touches a surface: above its middle, pointing down, turned so that the arm
reaches."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cramlite.model import Belief, Location, Place, Pose, Stage, thing_of
from cramlite.plugin import Answer, Context, Unresolvable

from ..motion_planning.reach import bound, shift
from .reached import Arm, Candidate, Leg, reached

# Turns about the vertical that are tried, from facing away [deg]
YAWS = (0.0, 90.0, -90.0, 180.0, 45.0, -45.0)
ABOVE, ALMOST = 0.06, 0.005  # finger tips above the surface at the stand-off, and where feeling begins [m]
DOWN = Pose((0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))  # the tool's z axis down, its x axis ahead


def touch(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate places of the fingers' tips above a surface."""
    entity = bound(context, location.of)
    surface = belief.feature(entity, "vrps:SurfaceFeature")
    if surface is None:
        raise Unresolvable(f"'{entity}' has no vrps:SurfaceFeature to touch", (location.of or "",))
    middle = belief.pose(thing_of(entity)) * surface.pose
    tips = context.robot.gripper.pad[1] / 2
    facing = math.degrees(math.atan2(middle.position[1], middle.position[0]))
    yield from reached(_turned(entity, shift(middle, (0, 0, tips + ALMOST)), facing), Arm(belief, context))


def _turned(entity: str, at: Pose, facing: float) -> Iterator[Candidate]:
    """Hand poses over the middle of a surface, turned about the vertical."""
    thing = thing_of(entity)
    for yaw in YAWS:
        pose = Pose.at(at.position, Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(facing + yaw))) * DOWN)
        place = Place(pose, shift(pose, (0, 0, ABOVE)), approach=(0.0, 0.0, -1.0), thing=thing)
        legs = (
            Leg(place.before, said="above it", where=Stage.BEFORE),
            Leg(pose, (thing,), said="at it", where=Stage.POSE),
        )
        said = f"the finger tips touch the middle of '{entity}'"
        yield Candidate(f"turned {yaw:+.0f} deg", place, legs, said)

"""Grasps across a slanted rim of a flat thing where it lies (``rim_pinches``), for the relation "grasp": after all others."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite.model import Belief, GripFacts, Place, Pose, Thing, pair_friction
from cramlite.plugin import Context, Grounding, Refused

from ..motion_planning.reach import collision_free_ik, make_scene, tcp
from .rim_pinches import OPENING, RimPinch, rim_pinches

COST = 1.0  # more than any grasp that holds a thing as it is
PER_RADIAN = 0.005  # as of other grasps: of what the hand turns on the way
STANDOFF = 0.06  # before it [m]: the thing is lower than the tips are then


def pinches(thing: Thing, belief: Belief, context: Context) -> list[RimPinch]:
    """Return the pinches of a thing where it is believed to be, those first for which the hand turns least."""
    friction = pair_friction(belief.world.physics.pad_friction, thing.least_friction)
    here = tcp(belief, context)
    found = rim_pinches(thing, belief.pose(thing.name), context.robot.gripper, friction)
    return sorted(found, key=lambda p: (round(here.distance(p.at)[1], 4), p.name))


def places(found: list[RimPinch], thing: Thing, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Yield those that the arm reaches, and from which it can lift the thing."""
    near, free = (make_scene(belief, context, touch, OPENING, clearance) for touch, clearance in (([thing.name], 0.0), ([], None)))
    here = tcp(belief, context)
    for pinch in found:
        before = pinch.at * Pose((0.0, 0.0, -STANDOFF))
        there = collision_free_ik(near, context, pinch.at, belief.joints)
        off = there if isinstance(there, Refused) else collision_free_ik(free, context, before, there)
        if isinstance(off, Refused):
            yield off.of(pinch.name)
            continue
        place = Place(
            pinch.at, before, OPENING, tuple(pinch.at.rotate((0, 0, 1)).tolist()), thing=thing.name, grip=GripFacts(pinch.width),
            swing=pinch.swing,
        )  # fmt: skip
        cost = COST + PER_RADIAN * here.distance(pinch.at)[1]
        yield Grounding(place, f"{pinch.name}: it swings down as it is lifted", cost, key=pinch.name, anew=True)


"""Grasps across a slanted rim of a flat thing where it lies (``rim_pinches``), tried after all other grasps
of the relation "grasp"."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite.model import Belief, GripFacts, Place, Pose, Thing, pair_friction
from cramlite.plugin import Context, Grounding, Refused

from ..motion_planning.reach import tcp
from .reached import Arm, Candidate, Leg, reached
from .rim_pinches import OPENING, RimPinch, rim_pinches

COST = 1.0  # beyond that of any grasp without a turn in the hand
PER_RADIAN = 0.005  # cost of a radian that the hand turns on its way, as for other grasps
STANDOFF = 0.06  # before it [m]: the thing is lower than the tips are then


def pinches(thing: Thing, belief: Belief, context: Context) -> list[RimPinch]:
    """Return the grasps across a sloping rim of a thing where it is believed to be, the least turn of the
    hand first."""
    friction = pair_friction(belief.world.physics.pad_friction, thing.least_friction)
    here = tcp(belief, context)
    found = rim_pinches(thing, belief.pose(thing.name), context.robot.gripper, friction)
    return sorted(found, key=lambda p: (round(here.distance(p.at)[1], 4), p.name))


def places(found: list[RimPinch], thing: Thing, arm: Arm) -> Iterator[Grounding | Refused]:
    """Yield the grasps across a rim that the arm reaches, and from which it can lift the thing."""
    return reached((_candidate(pinch, thing.name, arm) for pinch in found), arm)


def _candidate(pinch: RimPinch, thing: str, arm: Arm) -> Candidate:
    before = pinch.at * Pose((0.0, 0.0, -STANDOFF))
    place = Place(
        pinch.at, before, OPENING, tuple(pinch.at.rotate((0, 0, 1)).tolist()), thing=thing,
        grip=GripFacts(pinch.width), swing=pinch.swing,
    )  # fmt: skip
    cost = COST + PER_RADIAN * tcp(arm.belief, arm.context).distance(pinch.at)[1]
    legs = Leg(pinch.at, (thing,), OPENING, 0.0), Leg(before, opening=OPENING)
    return Candidate(
        pinch.name, place, legs, f"{pinch.name}: it swings down as it is lifted", cost, anew=True
    )

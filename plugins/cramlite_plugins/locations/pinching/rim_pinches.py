"""Pinches across a slanted rim: grips of a flat thing, such as a plate, on a support that hands cannot go
below; they are tried after all other grasps.

Hands are broad along their closing direction: over a table one leans by no more than some 20 deg, and no pad
comes below a rim that slopes by 19 deg. Its upper face then meets the tips of one finger, and its edge the
pad of the other one. Fingers that close on a slope turn it until it is flat between them: the thing's far
side is held up by what it lies on, and swings down once the hand lifts. How it hangs then follows from the
rim alone: its middle plane is between the pads, as far up them as its edge was (``cramlite.model.Swing``).

Measured in plain MuJoCo with LIBERO's plate, 11.5 g, and its Panda, leaning by 10 to 15 deg, the tips on the
slope's middle or 3 mm below or above it: 27 of 27 came up with the friction that robosuite states (pads 2),
and 25 of 27 with .9, of which 22 were laid down within 12 mm; the three others had the tips 3 mm above it.
With a friction of .5 to .7 two of four came up, with less none of six.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import (
    Belief,
    Floats,
    Geom,
    GripFacts,
    Gripper,
    Place,
    Pose,
    Swing,
    Thing,
    Value,
    pair_friction,
    vector3,
)
from cramlite.plugin import Answer, Context

from ...motion_planning.reach import shift, tcp
from ...shapes.bounds import centre_of_mass
from ...shapes.convex import hull_planes
from ..reached import Arm, Candidate, Leg, reached

SLOPES = math.radians(8.0), math.radians(50.0)
"""Least and greatest slope from level of a rim that is pinched [rad]: a flatter rim gives the finger tips
nothing to turn the thing by, and a steeper one is gripped as a wall."""
LEANS = (math.radians(15.0), math.radians(12.0))
"""Outward leans of the hand: at 20 deg the outer corner of a Panda's finger is in the table, at 10 deg
every third pinch slides off."""
THICKEST = 0.012  # largest thickness of a rim [m]: half of open fingers' room on both sides
SHORTEST, LONGEST = 0.015, 0.06  # along the slope [m]: pads need something to lie on
# How much deeper than the slope's upper face in its middle the tips go [m]: of those 3 mm above it a third
# was lost
DEEPER = 0.003
LEAST = 0.8  # friction of pads and thing: see above
# Opening of the fingers about the rim [m]: narrower ones come down on its edge (30 mm), wider ones meet the
# table sooner
OPENING = 0.04
COST = 1.0  # beyond that of any grasp without a turn in the hand
PER_RADIAN = 0.005  # cost of a radian that the hand turns on its way, as for other grasps
STANDOFF = 0.06  # before it [m]: the thing is lower than the tips are then


class RimPinch(Value):
    """Pinch across a rim.

    Args:
        at: the TCP in the frame of the pose that was asked for.
        swing: of the thing in the hand, as it is lifted.
        width: of the rim [m].
        name: for people.
    """

    at: Pose
    swing: Swing
    width: float
    name: str


class Rim(Value):
    """Rim of a thing, such as a plate: a part that rises away from the thing's middle, with points and unit
    vectors (3,) at the thing's pose.

    Args:
        middle: of the part [m].
        up: along the slope, outwards.
        normal: of its upper face.
        half, thick: half of its length along the slope, and its thickness [m].
    """

    middle: Floats
    up: Floats
    normal: Floats
    half: float
    thick: float

    @property
    def edge(self) -> Floats:
        """Point (3,) at the outer, upper end of a sloping rim, on the rim's lower side."""
        return self.middle + self.half * self.up - self.thick / 2 * self.normal


def rim_pinches(thing: Thing, pose: Pose, gripper: Gripper, friction: float) -> list[RimPinch]:
    """Return grasps of a thing across its slanted rim (pinches); none without such a rim, or with too little
    friction.

    The thing's pose is given in a frame whose z axis points up.

    Args:
        friction: of pads and thing.
    """
    centre = pose.apply(centre_of_mass(thing))
    rims = [r for g in thing.geoms if not g.part and (r := _rim(g, pose, centre)) is not None]
    ways = itertools.product(LEANS, rims, (1.0, -1.0))
    return [_pinch(rim, lean, side, pose, gripper) for lean, rim, side in ways] if friction > LEAST else []


def _rim(geom: Geom, pose: Pose, centre: Floats) -> Rim | None:
    """Return a part of a thing as a rim; None where it is too thick, too short or too long, or does not
    rise away from the thing's middle."""
    if (slab := _slab(geom, pose)) is None or slab[1] > THICKEST:
        return None
    normal, thick, corners = slab
    if not SLOPES[0] < (slope := math.acos(min(1.0, float(normal[2])))) < SLOPES[1]:
        return None
    out = _level(-normal)
    up = out * math.cos(slope) + np.array([0.0, 0.0, math.sin(slope)])
    half, middle = float(np.ptp(corners @ up)) / 2, corners.mean(axis=0)
    outwards = SHORTEST < 2 * half < LONGEST and (middle - centre) @ out > half
    return Rim(middle, up, normal, half, thick) if outwards else None


def _level(way: Floats) -> Floats:
    """The level unit vector (3,) that is nearest to a direction."""
    flat: Floats = way * (1.0, 1.0, 0.0)
    return flat / np.linalg.norm(flat)


def _slab(geom: Geom, pose: Pose) -> tuple[Floats, float, Floats] | None:
    """Thinnest direction of a box or hull as a unit vector that points up, its thickness that way [m], and
    its corners (n, 3); None for a round shape."""
    there = pose * geom.pose
    if geom.shape == "box":
        k = int(np.argmin(geom.size))
        normal, thick = there.rotation[:, k], 2 * geom.size[k]
        signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
        corners = there.apply(signs * np.asarray(geom.size))
    elif geom.shape == "convex":
        points, normals = np.asarray(geom.corners), hull_planes(geom.corners)[:, :3]
        spans = np.ptp(points @ normals.T, axis=0)
        k = int(np.argmin(spans))
        normal, thick, corners = there.rotate(normals[k]), float(spans[k]), there.apply(points)
    else:
        return None
    return normal * (1.0 if normal[2] >= 0 else -1.0), thick, corners


def _pinch(rim: Rim, lean: float, side: float, pose: Pose, gripper: Gripper) -> RimPinch:
    """Return the grasp across a sloping rim by a hand that leans away from the thing's middle.

    ``side`` turns the hand by half a turn. The fingertips reach to the middle of the slope.
    """
    out = _level(rim.up)
    down = np.array([0.0, 0.0, -1.0])
    approach = math.cos(lean) * down - math.sin(lean) * out
    closing = math.cos(lean) * out + math.sin(lean) * down
    tips = rim.middle + rim.thick / 2 * rim.normal + DEEPER * down
    at = Pose.from_axes(tips - gripper.pad[1] / 2 * approach, approach, np.cross(side * closing, approach))
    says = (
        f"across its rim at {math.degrees(math.atan2(out[1], out[0])):.0f} deg, leaning "
        f"{math.degrees(lean):.0f} deg outwards"
    )
    swing = _swing(*_centred(rim, at, pose, gripper.pad[1] / 2), at)
    return RimPinch(at, swing, rim.thick, f"{says}{', turned half way' if side < 0 else ''}")


def _centred(rim: Rim, at: Pose, pose: Pose, tips: float) -> tuple[Rim, Pose]:
    """Rim and pose of a thing after a pinch: one finger has pushed the edge inwards until the other finger
    touches the slope.

    The finger tips are ``tips`` [m] ahead of the TCP.
    """
    hand, out = at.inverse(), _level(rim.up)
    edge, face = hand.apply(rim.edge), hand.apply(rim.middle + rim.thick / 2 * rim.normal)
    up, inwards = hand.rotate(rim.up), -hand.rotate(out)
    steep = up[1] / up[2]
    # where the slope is at the height of the tips, across the fingers
    met, moves = face[1] - (face[2] - tips) * steep, inwards[1] - inwards[2] * steep
    by = -out * max(float(-(edge[1] + met) / (inwards[1] + moves)), 0.0)
    return replace(rim, middle=rim.middle + by), shift(pose, by)


def _swing(rim: Rim, pose: Pose, at: Pose) -> Swing:
    """Swing of a plate in the hand that lifts it, from how it lies until its rim is flat between the pads.

    The outer end of the rim then points to the palm, and comes as far up the pads as the rim's lower edge
    was.
    """
    end, hand = rim.middle + rim.half * rim.up, at.inverse()
    up, lies = hand.rotate(rim.up), hand * pose
    # about the hand's x, which is level
    angle = math.atan2(float(np.cross(up, (0.0, 0.0, -1.0))[0]), float(-up[2]))
    turned = Pose.from_rotvec((0.0, 0.0, 0.0), (angle, 0.0, 0.0)) * lies
    local = pose.inverse().apply(end)
    held = np.array([float(hand.apply(end)[0]), 0.0, float(hand.apply(rim.edge)[2])])
    return Swing(lies, Pose.at(held - turned.rotate(local), turned), vector3(local))


def pinches(thing: Thing, belief: Belief, context: Context) -> list[RimPinch]:
    """Return the grasps across a sloping rim of a thing where it is believed to be, the least turn of the
    hand first."""
    friction = pair_friction(belief.world.physics.pad_friction, thing.least_friction)
    here = tcp(belief, context)
    found = rim_pinches(thing, belief.pose(thing.name), context.robot.gripper, friction)
    return sorted(found, key=lambda p: (round(here.distance(p.at)[1], 4), p.name))


def places(found: list[RimPinch], thing: Thing, arm: Arm) -> Iterator[Answer]:
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
    said = f"{pinch.name}: it swings down as it is lifted"
    return Candidate(pinch.name, place, legs, said, cost, anew=True)

"""Grasps of a thing at its believed pose, the likeliest to succeed first: each of its grips, with two
orientations of the hand that differ by 180 deg.

Those with room for the whole hand, there, before and when it lifts, which leave its holes open, come first;
those of a hand that leans come after all others, and those by the ends of the pads after these. Among these
decide the lever and the part of the pads (``grips``), how far the hand turns to get there, and whether pads
that cannot press harder keep the thing from turning between them. Inverse kinematics and collisions are
looked at one by one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from msgspec.structs import replace

from cramlite.model import (
    Belief,
    Floats,
    GripFacts,
    Gripper,
    Held,
    Joints,
    Location,
    Place,
    Pose,
    Stage,
    Thing,
    Value,
    pair_friction,
)
from cramlite.plugin import Answer, Context, Grounding, Refused

from ..motion_planning.postures import CLEARANCE
from ..motion_planning.reach import SIGMAS, bound, reference_pose, shift, tcp, unfit
from ..motions import grip_force
from ..shapes import ray_casting as rays
from ..shapes.bounds import centre_of_mass
from .pinching import antipodal, rim_pinches
from .pinching.grips import AGAIN, SLACK, Grip, ranked, too_wide, varied, why_none
from .pinching.hand_room import HandRoom, Taken
from .places import slants
from .placing.for_later import suits_later
from .reached import Arm, Leg

STANDOFF = 0.10  # pre-grasp distance [m]: the longest finger pad and the tab of a product fit in between
ALONG = (1.0, 0.75, 0.5, 0.25)
"""Fractions of an oblique way, from the grasp outwards, at which the hand must not touch the thing; nearer to
the grasp the thing is between the open fingers."""
LIFTED = 0.10  # height to which most grasped things are then picked up [m]
HALF_TURN = Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
PER_RADIAN = 0.005
"""Cost of one radian by which the hand turns on its way to a grasp [m]. Of the two ways round the nearer one
comes first: half a turn more drives a last axis that starts in the middle of its range into its stop."""
PER_LOAD, MOST_LOAD = 0.02, 5.0
"""Cost of a lack of pad force against turning [m], per multiple of the gripper's greatest force that is
lacking, and the highest multiple that counts."""
PER_TIGHT = 2.0
"""Cost of each metre by which the gap between a fully open finger and the thing is less than two sigma of the
thing's place: a pad that meets a thing pushes it."""


class Grasp(Value):
    """Grasp of a thing at its present pose.

    Args:
        grip: in the thing's frame.
        at: the TCP in the base frame.
        opening: of the fingers on the way there, the least that will do [m].
        load: force that each pad needs to hold the weight and its moment, in shares of the gripper's most.
        name: for people.
        tight: whether boxes about the parts of the hand meet something there, before it or above it; the hand
            itself may not.
    """

    grip: Grip
    at: Pose
    opening: float
    load: float
    name: str
    tight: bool = False

    @property
    def before(self) -> Pose:
        """The TCP at the pre-grasp."""
        return self.at * Pose((0, 0, -STANDOFF))

    def legs(self, thing: str, opening: float) -> tuple[Leg, Leg]:
        """Return the poses that the arm has to reach, at the grasp with the fingers open by ``opening`` [m],
        and at the pre-grasp."""
        at = Leg(self.at, (thing,), opening, said="at the grasp", where=Stage.POSE)
        return at, Leg(self.before, opening=opening, said="at the pre-grasp", where=Stage.BEFORE)


def grasps(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate grasps of a thing that the arm reaches, best first."""
    thing, gripper = belief.thing(bound(context, location.of)), context.robot.gripper
    reference_pose(belief, location, context)
    grips = ranked(thing, gripper, pair_friction(belief.world.physics.pad_friction, thing.least_friction))
    rims = rim_pinches.pinches(thing, belief, context)
    if not grips and not rims:
        raise unfit(location, why_none(thing, gripper), too_wide(thing, gripper))
    arm = Arm(belief, context)
    ordered = _in_order(grips, thing, belief, context, HandRoom.about(thing, belief, arm.scene()))
    if not ordered and not rims:
        reason = f"at each of {len(grips)} grips of '{thing.name}' the hand would be inside it"
        raise unfit(location, reason, too_wide(thing, gripper))
    pinched_at = rim_pinches.places(rims, thing, arm)
    for cost, grasp in sorted(ordered, key=lambda found: found[1].tight) if rims else ordered:
        if grasp.tight:  # of what lies flat these are hundreds, and the hand is in what carries it
            yield from pinched_at
        led = arm.led(grasp.legs(thing.name, grasp.opening))
        if isinstance(led, Refused):
            yield led.of(grasp.name)
            if led.where is Stage.BEFORE:  # wider fingers have less room there, from wherever they come
                widest = next(_openings(grasp, thing, belief, gripper))
                yield from _from_aside(grasp, thing.name, cost, widest, arm)
            continue
        fits = partial(_fits, grasp, thing.name, led, arm)
        wide = next(filter(fits, _openings(grasp, thing, belief, gripper)), grasp.opening)
        place = _place(grasp, grasp.before, wide, thing.name)
        yield Grounding(place, _says(grasp), cost, key=grasp.name, anew=True)
    yield from pinched_at
    if broad := too_wide(thing, gripper):
        yield Refused("across its wide sides", broad.says, blocking=(), remedy=broad)


def _fits(grasp: Grasp, thing: str, led: Sequence[Joints], arm: Arm, opening: float) -> bool:
    """Whether the hand, opened by ``opening`` [m], is free at a grasp and at its pre-grasp."""
    legs = grasp.legs(thing, opening)
    return all(arm.of(leg).free(joints) for leg, joints in zip(legs, led, strict=True))


def _place(grasp: Grasp, before: Pose, opening: float, thing: str) -> Place:
    approach = tuple(grasp.at.rotate((0, 0, 1)))
    return Place(grasp.at, before, opening, approach, thing=thing, grip=GripFacts(grasp.grip.width))


def _from_aside(grasp: Grasp, thing: str, cost: float, opening: float, arm: Arm) -> Iterator[Grounding]:
    """Grasp under an overhang that leaves the hand no room for a straight approach: the hand, opened as far
    as there is room, comes in obliquely from above."""
    at, off = grasp.legs(thing, opening)
    if isinstance(there := arm.at(at), Refused):
        return
    for side, way in slants(STANDOFF):
        if arm.free_along(replace(off, pose=grasp.at), way, ALONG, there):
            said = f"{grasp.name}, from above and {side}"
            place = _place(grasp, shift(grasp.at, way), opening, thing)
            yield Grounding(place, _says(replace(grasp, name=said)), cost, key=said, anew=True)
            return


def _says(grasp: Grasp) -> str:
    grip = grasp.grip
    return (
        f"{grasp.name}: {1000 * grip.width:.0f} mm wide, {1000 * grip.lever:.0f} mm from the centre,"
        f" normals {math.degrees(grip.slant):.0f} deg off, {100 * grip.coverage:.0f} % of the pad,"
        f" {100 * grasp.load:.0f} % of the grip force"
    )


def _openings(grasp: Grasp, thing: Thing, belief: Belief, gripper: Gripper) -> Iterator[float]:
    """Openings of the fingers for a grasp without obstacles [m], best first.

    Around a thing whose pose is given not as wide as they can: they take 0.1 s to close by 10 mm. A thing
    that is 4 mm from where it is believed to be, and turned by 5 deg, is pushed by a pad that passes it by 5
    mm.
    """
    hand, most = antipodal.Hands.at([grasp.grip.pose]), np.array([gripper.opening[1]])
    doubted = belief.poses[thing.name].sigma > 0
    if doubted and antipodal.clear(rays.body(thing.geoms), hand, most, gripper).all():
        yield gripper.opening[1]
    yield grasp.grip.width + grasp.grip.slack


def _in_order(
    grips: Sequence[Grip], thing: Thing, belief: Belief, context: Context, room: HandRoom
) -> list[tuple[float, Grasp]]:
    """Grasps with their cost [m], in the order of trial; grasps with the hand inside the thing are left out.

    Grasps without room for the hand come last, and grips by leaning hands or by the ends of the pads after
    the other kinds. Those that suit the place to which a later task brings the thing come first.
    """
    pose, here, most = belief.pose(thing.name), tcp(belief, context), context.robot.gripper.opening[1]
    loads, found = _loads(grips, thing, belief, context), []
    doubt = SIGMAS * belief.poses[thing.name].sigma
    for grip, load in zip(grips, loads.tolist(), strict=True):
        straight = pose * grip.pose
        ways = ((grip.name, straight), (f"{grip.name}, turned half way", straight * HALF_TURN))
        tight = PER_TIGHT * max(0.0, doubt - (most - grip.width) / 2)
        turned = sorted((here.distance(at)[1], name, at) for name, at in ways)
        for k, (angle, name, at) in enumerate(turned):
            weak = PER_LOAD * min(max(load - 1.0, 0.0), MOST_LOAD)
            cost = grip.cost + AGAIN * k + PER_RADIAN * angle + weak + tight
            found.append((cost, grip, Grasp(grip, at, min(grip.width + SLACK, most), load, name)))
    hands, openings = antipodal.Hands.at([g.at for *_, g in found]), np.array([g.opening for *_, g in found])
    own = room.meets(room.own, hands, openings, 0.0)
    high = LIFTED * belief.base().inverse().rotate((0.0, 0.0, 1.0))
    up = antipodal.Hands(hands.positions + high, hands.turns)
    others = room.in_a_hole(hands, most)  # when it opens around what is threaded
    for there in (hands, hands.moved(-STANDOFF), up):
        others |= room.meets(room.others, there, openings, CLEARANCE)
    leaning = np.array([f[1].late == 1 for f in found], bool)
    unfit = ~suits_later(thing, belief, context, Taken(hands, openings, ~own & ~others, leaning))
    alike: dict[tuple[bool, int, bool], list[tuple[float, Grip, Grasp]]] = {}
    for f, no, it, bad in zip(found, others.tolist(), own.tolist(), unfit.tolist(), strict=True):
        if not it:
            alike.setdefault((bad, f[1].late, no), []).append(f)
    order = itertools.product((False, True), (0, 1, 2), (False, True))
    ranked = ((key[-1], *one) for key in order for one in varied(alike.get(key, ())))
    return [(cost, replace(grasp, tight=no)) for no, cost, grasp in ranked]


def _loads(grips: Sequence[Grip], thing: Thing, belief: Belief, context: Context) -> Floats:
    """Force that each pad needs at each grip to hold the weight and its moment, as a share of the gripper's
    greatest force."""
    gripper = context.robot.gripper
    weight = grip_force.grip_of(Held(thing.name, Pose(), 0.0), belief.world, gripper)
    pose = belief.base() * belief.pose(thing.name)
    hands = antipodal.Hands.at([pose * g.pose for g in grips])
    off = pose.apply(centre_of_mass(thing)) - hands.positions
    arms = np.abs(np.einsum("ni,ni->n", hands.closing, np.cross(off, (0.0, 0.0, 1.0))))
    radius = math.hypot(*gripper.pad) / 4 * np.sqrt(np.maximum([g.coverage for g in grips], 0.1))
    return np.asarray(weight.least * (1 + arms / radius) / gripper.force[1])

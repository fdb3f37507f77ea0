"""Checks of the room for payload, hand and arm on the way to a placement, and for open fingers there."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from cramlite.model import Pose, Stage
from cramlite.plugin import Refused

from ....kinematics.inverse import inverse, why_no_inverse
from ....kinematics.reach import reach_shortfall
from ....motion_planning.reach import shift
from ....motion_planning.space import refusal
from ....motion_planning.too_far import no_inverse
from ...pushing.around import CLEAR, LIFT
from ...reached import Leg
from ..query import PARTS, Placement, Query


def let_in(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload alone, whatever the grasp, has room on a way that leads in from the side."""
    return (placement.led and _met(placement, query, False)) or ""


def pushed_way(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload has room on its way in along the floor."""
    inside, close = shift(placement.rests, LIFT), replace(query, clearance=CLEAR)
    ends = query.hand(inside), query.hand(shift(placement.lies or placement.thing, LIFT))
    return let_in(Placement(placement.name, inside, *ends, float(LIFT[2]), led=True), close)


def room(placement: Placement, query: Query) -> str | Refused:
    """Check that hand and payload have room at the placement and at its stand-off, wherever the arm is; under
    an overhang also at points between the two."""
    no = _met(placement, query, True)
    if no is not None or placement.led or not query.covers:
        return no or ""
    out = np.subtract(placement.before.position, placement.pose.position)
    over = query.arm.scene(clearance=0.0)
    ways = (query.belief.base() * shift(placement.pose, part * out) for part in PARTS[1:-1])
    no = next((no for way in ways if (no := over.met(way)) is not None), None)
    return replace(no, reason=f"on its way down: {no.reason}", where=Stage.BEFORE) if no else ""


def _met(placement: Placement, query: Query, hand: bool) -> Refused | None:
    """Return a refusal if the payload (or the hand, if ``hand``) would meet an obstacle on the way to the
    place.

    A pose out of reach is left to another check.
    """
    for pose, far in placement.way:
        short = not placement.led and reach_shortfall(query.context.robot, pose)
        no: Refused | None = None if short else query.scene.met(query.belief.base() * pose, hand)
        if no is not None and not placement.led:
            return _at(placement, pose, no)
        if no is not None:
            return replace(no, reason=f"{1000 * far:.0f} mm from the place: {no.reason}") if far else no
    return None


def _at(placement: Placement, pose: Pose, no: Refused) -> Refused:
    """Prefix the reason of a refusal with the pose of a placement that it is about: "at the stand-off" or
    "at the place"."""
    early = pose == placement.before
    said, where = ("at the stand-off", Stage.BEFORE) if early else ("at the place", Stage.POSE)
    return replace(no, reason=f"{said}: {no.reason}", where=where)


def reachable(placement: Placement, query: Query) -> str | Refused:
    """Check that inverse kinematics has solutions for the placement and its approach, whatever is in the
    way."""
    robot = query.context.robot
    for pose in (placement.before, placement.pose):
        if not inverse(robot, pose, seed=query.belief.joints):
            why, remedy = why_no_inverse(robot, pose), no_inverse(robot, pose)
            return _at(placement, pose, refusal(why, blocking=query.standing_there(), remedy=remedy))
    return ""


def collision_free(placement: Placement, query: Query) -> str | Refused:
    """Check that arm and payload are free of collision at the placement and above it; on a way that leads
    aside or turns, all along it."""
    pose, before, back = placement.pose, placement.before, placement.back
    if placement.led:
        legs = [Leg(pose, along=(*reversed(placement.through), before), said="on its way out")]
    else:
        legs = [Leg(before, said="above it", where=Stage.BEFORE), Leg(pose, said="at it", where=Stage.POSE)]
    legs += [Leg(pose, along=(back,), said="back from it")] if back else []
    led = query.arm.led(replace(leg, clearance=query.clearance) for leg in legs)
    return led if isinstance(led, Refused) else ""


def room_to_open(placement: Placement, query: Query) -> str | Refused:
    """Check that the fingers have room to open for the release: beside the fingers there may be less room
    than around the payload."""
    found = opened(placement, query)
    return replace(found, reason=f"with open fingers {found.reason}") if isinstance(found, Refused) else ""


def opened(placement: Placement, query: Query) -> float | Refused:
    """Return the widest opening of the fingers [m] for which they have room to release the payload; or the
    refusal at the narrowest."""
    low = lowered(placement, query)
    for width in query.openings:
        there = query.arm.at(query.let_down(low, width))
        if not isinstance(there, Refused):
            return width
    assert isinstance(there, Refused)
    return there


def lowered(placement: Placement, query: Query) -> Pose:
    """Return the TCP pose at the release; before it, a payload that is put onto something is lowered to
    its support."""
    return placement.pose if query.depth else shift(placement.pose, (0.0, 0.0, -placement.height))


def hand_off(placement: Placement, query: Query) -> str | Refused:
    """Check that the payload comes to rest on its uneven support before the hand meets the support. A payload
    that is laid down is checked elsewhere, along its whole path."""
    if not query.settles or query.held.swing is not None:
        return ""
    there = query.arm.at(query.let_down(lowered(placement, query)))
    return replace(there, reason=f"lowered {there.reason}") if isinstance(there, Refused) else ""

"""Room for a door or a drawer that a later task closes: what is put down may neither stop it nor stick out of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

from msgspec.structs import replace

from cramlite.model import Belief, Estimate, Held, Joint, Pose, Thing, thing_of
from cramlite.plugin import Context, Refused

from ..motion_planning.reach import make_scene
from ..motions.gripping import LET_GO, fallen
from ..shapes.carried_along import carried_along
from ..shapes.itself import Itself
from .handles import ajar, joint_value
from .later import closes
from .place_filters import Spot, Wanted

SHUT = 0.05  # share of its range up to which something counts as closed
STEPS = 0.01, math.radians(2.0)  # between the values of a joint that are looked at [m, rad]: a door's edge goes on by less than it is thick
TIGHT = 100.0  # cost of a place that comes after all others, since it leaves little room for what is to be closed


def room_to_close(spot: Spot, wanted: Wanted) -> str | Refused:
    """Check that what later tasks close can be closed: a door with nothing in its way, a drawer with what it takes along.

    Later tasks are looked at only where something would be met, so that what follows elsewhere holds whatever they are.
    """
    return (is_tight(spot, wanted) and _stopped(spot, wanted, None)) or ""


def is_tight(spot: Spot, wanted: Wanted) -> bool:
    """Check whether what later tasks close would not get to its stop, with the room on the way that what is let go of may shift by."""
    return _tight(Itself(spot), Itself(wanted))


@lru_cache(maxsize=1)
def _tight(spot: Itself[Spot], wanted: Itself[Wanted]) -> bool:
    return _stopped(spot.it, wanted.it, LET_GO) is not None


def _stopped(spot: Spot, wanted: Wanted, clearance: float | None) -> Refused | None:
    return first_met(wanted.thing.name, let_go(spot, wanted), wanted.context, clearance)


def first_met(put: str, after: Belief, context: Context, clearance: float | None) -> Refused | None:
    """Return what is met by anything that a later task closes, with a thing where it is believed to be: until the rest is felt, where no
    clearance [m] is asked for, else to its stop."""
    for thing in after.world.things:
        if thing.joint is not None and thing.name in after.poses:
            met = _met(thing, put, after, context, clearance)
            if met is not None and closes(thing.name, put, context):
                return met
    return None


def let_go(spot: Spot, wanted: Wanted) -> Belief:
    """Return the belief once the thing is let go of there."""
    belief, name = wanted.belief, wanted.thing.name
    pose = fallen(belief, belief.base() * spot.thing)
    opening = belief.held.opening if belief.held else 0.0
    there = ("in" if wanted.depth else "on", name, thing_of(wanted.entity))
    return belief.released(Estimate(pose, 0.0, "predicted: let go there"), opening).related(there)


def _met(closing: Thing, put: str, after: Belief, context: Context, clearance: float | None) -> Refused | None:
    """What is met first between a thing that was put somewhere and one that closes; or, where it goes along with that, so that it does not
    matter where it shifts, between it and what is fixed."""
    assert closing.joint is not None
    joint, at, here = closing.joint, after.poses[closing.name].pose, after.poses[put].pose
    value, whole = joint_value(after, closing.name, at), joint.upper - joint.lower
    if value - joint.lower <= SHUT * whole:
        return None
    handle = closing.feature("cram:Handle")
    end = joint.lower + (ajar(joint, handle.pose) if handle and clearance is None else 0.0) * whole
    along = put in carried_along(after, closing.name)
    beside = [t.name for t in after.world.things if (t.name != put and (t.name == closing.name) == along) or (along and not t.furniture)]
    scene = make_scene(after.grasped(Held(put, Pose(), 0.0)), context, beside, clearance=0.0 if along else clearance or 0.0)
    for left, moved in _on_its_way(joint, at, value, end):
        no = scene.met(moved * at.inverse() * here if along else at * moved.inverse() * here, hand=False)
        if no is not None:
            far = f"{1000 * left:.0f} mm" if joint.kind == "slide" else f"{math.degrees(left):.0f} deg"
            said = f"with '{closing.name}', which a later task closes, open by {far} still, {no.reason}"
            there = {closing.name: moved, put: moved * at.inverse() * here if along else here}
            drawn = no.collision and replace(no.collision, moved={**no.collision.moved, **there})
            return replace(no, reason=said, blocking=(closing.name,), collision=drawn)
    return None


def _on_its_way(joint: Joint, at: Pose, value: float, end: float) -> Iterator[tuple[float, Pose]]:
    """How far something is open still as its joint goes from a value to an end [m, rad], and its pose in the world then; the end first,
    where it mostly meets what it meets at all."""
    count = max(1, math.ceil((value - end) / STEPS[joint.kind == "hinge"]))
    ways = ((value - end) * k / count for k in (count, *range(1, count)))
    return ((value - way - joint.lower, joint.moved(at, -way)) for way in ways)

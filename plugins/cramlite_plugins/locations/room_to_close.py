"""Room for a door or a drawer that a later task closes: a payload may neither stop it nor stick out of it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from msgspec.structs import replace

from cramlite.model import Belief, Held, Joint, Pose, Thing
from cramlite.plugin import Context, Refused

from ..motion_planning.reach import make_scene
from ..shapes.carried_along import carried_along
from ..shapes.joint_values import joint_value
from .handles import ajar
from .later import closes

SHUT = 0.05  # share of its range up to which a thing counts as closed
# Between the values of a joint that are looked at [m, rad]: a door's edge goes on by less than it is thick
STEPS = (0.01, math.radians(2.0))


def first_met(put: str, after: Belief, context: Context, clearance: float | None) -> Refused | None:
    """Return the refusal with the first obstacle that later tasks meet when they close a thing, with the
    placed thing at its believed place; None if they meet nothing.

    The way is looked at up to the stop, or without a clearance [m] only up to the last part, which is a
    guarded motion.
    """
    for thing in after.world.things:
        if thing.joint is not None and thing.name in after.poses:
            met = _met(thing, put, after, context, clearance)
            if met is not None and closes(thing.name, put, context):
                return met
    return None


def _met(
    closing: Thing, put: str, after: Belief, context: Context, clearance: float | None
) -> Refused | None:
    """Return the refusal with the first contact of a placed thing with a thing that closes, or with furniture
    if it moves along with that thing; None if nothing is met."""
    assert closing.joint is not None
    joint, at, here = closing.joint, after.poses[closing.name].pose, after.poses[put].pose
    value, whole = joint_value(after, closing.name, at), joint.upper - joint.lower
    if value - joint.lower <= SHUT * whole:
        return None
    handle = closing.feature("cram:Handle")
    end = joint.lower + (ajar(joint, handle.pose) if handle and clearance is None else 0.0) * whole
    along = put in carried_along(after, closing.name)
    beside = [
        t.name
        for t in after.world.things
        if (t.name != put and (t.name == closing.name) == along) or (along and not t.furniture)
    ]
    beside += (
        [] if along else ["arm"]
    )  # what stays is then moved about the one that closes, and the arm is elsewhere
    scene = make_scene(
        after.grasped(Held(put, Pose(), 0.0)), context, beside, clearance=0.0 if along else clearance or 0.0
    )
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
    """Yield positions at which to check a closing door or drawer: how far it is open [m, rad], and its pose
    in the world.

    The end comes first, since most contacts are there.
    """
    count = max(1, math.ceil((value - end) / STEPS[joint.kind == "hinge"]))
    ways = ((value - end) * k / count for k in (count, *range(1, count)))
    return ((value - way - joint.lower, joint.moved(at, -way)) for way in ways)

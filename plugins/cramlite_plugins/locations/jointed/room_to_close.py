"""Room for a door or a drawer that a later task closes: a payload may neither stop it nor stick out of it.

In a container a payload may not stop one that a later task opens, either, such as the drawer above. Beside
one it may be pushed along, but then a hand hardly takes hold of it again.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Held, Joint, Pose, Thing
from cramlite.plugin import Context, Refused

from ...motion_planning.reach import make_scene
from ...shapes.bounds import box_around
from ...shapes.box_overlaps import overlaps
from ...shapes.carried_along import carried_along
from ...shapes.itself import Itself
from ...shapes.joints import joint_value
from ...shapes.ray_casting import Body, body
from ..later import CLOSING, OPENING, moves
from .handles import ajar

HAND = 0.05  # around what has opened, for fingers that take hold of a thing beside or below it [m]
SHUT = 0.05  # share of its range up to which a thing counts as closed
OPENED = 0.8  # share of its range to which a task of opening opens a thing at least
# Between the values of a joint that are looked at [m, rad]: a door's edge goes on by less than it is thick
STEPS = (0.01, math.radians(2.0))
ROUNDING = 1e-4  # of boxes around shapes [m]
Passed = tuple[float, Pose, Pose]
"""Position on the way of a door or drawer: how far it is open still [m, rad], its pose in the world, and the
displacement of the placed thing, as what stays sees it."""


def first_met(put: str, after: Belief, context: Context, clearance: float | None) -> Refused | None:
    """Return the refusal with the first obstacle that later tasks meet when they close a thing, or open one
    past a container with the placed thing in it; None if they meet nothing.

    The placed thing is at its believed place. The way is looked at up to its end, or, of closing without a
    clearance [m], only up to the last part, which is a guarded motion.
    """
    kinds = (CLOSING, OPENING) if after.relates("in", put) else (CLOSING,)
    return _first(put, after, context, dict.fromkeys(kinds, clearance))


def opens_beside(put: str, after: Belief, context: Context) -> Refused | None:
    """Return the refusal with the first thing that a later task opens so near to a payload beside it that
    no hand has room there; None if there is none."""
    return None if after.relates("in", put) else _first(put, after, context, {OPENING: HAND})


def _first(
    put: str, after: Belief, context: Context, clearances: Mapping[str, float | None]
) -> Refused | None:
    """Refusal of the first motion of a door or drawer that meets the placed thing; ``clearances`` to it by
    kind of later task [m]."""
    for thing, (kind, clearance) in itertools.product(after.world.things, clearances.items()):
        if thing.joint is not None and thing.name in after.poses:
            met = _met(thing, kind, put, after, context, clearance)
            if met is not None:
                return met
    return None


def _met(
    moving: Thing, kind: str, put: str, after: Belief, context: Context, clearance: float | None
) -> Refused | None:
    """Return the refusal with the first contact of a placed thing with a thing that a later task closes or
    opens, or with furniture if it moves along with that thing; None if nothing is met.

    Later tasks are looked at where boxes meet, and exact shapes where a later task moves the thing.
    """
    assert moving.joint is not None
    joint, at, here = moving.joint, after.poses[moving.name].pose, after.poses[put].pose
    value, end = joint_value(after, moving.name, at), _end(moving, kind, clearance)
    if value <= joint.value_at(SHUT) if kind == CLOSING else value >= end:
        return None
    along = put in carried_along(after, moving.name)
    ways, apart = _on_its_way(joint, at, value, end, along), 0.0 if along else clearance or 0.0
    others = [t for t in after.world.things if t.furniture and t != moving] if along else [moving]
    near = _near(after.world.thing(put), here, ways, apart, others, after)
    if not near or not moves(moving.name, kind, put, context):
        return None
    beside = [
        t.name
        for t in after.world.things
        if (t.name != put and (t.name == moving.name) == along) or (along and not t.furniture)
    ]
    beside += [] if along else ["arm"]  # what stays is then moved about the other, and the arm is elsewhere
    scene = make_scene(after.grasped(Held(put, Pose(), 0.0)), context, beside, clearance=apart)
    for left, moved, by in near:
        no = scene.met(by * here, hand=False)
        if no is not None:
            far = f"{1000 * left:.0f} mm" if joint.kind == "slide" else f"{math.degrees(left):.0f} deg"
            does = f"closes, open by {far} still" if kind == CLOSING else f"opens, open by {far}"
            said = f"with '{moving.name}', which a later task {does}, {no.reason}"
            there = {moving.name: moved, put: by * here if along else here}
            drawn = no.collision and replace(no.collision, moved={**no.collision.moved, **there})
            return replace(no, reason=said, blocking=(moving.name,), collision=drawn)
    return None


def _near(
    thing: Thing, here: Pose, ways: Sequence[Passed], distance: float, others: Iterable[Thing], after: Belief
) -> list[Passed]:
    """Return those positions on a way at which the box around the placed thing is nearer to others than a
    distance [m]."""
    low, high = _box(Itself(thing))
    centres = np.array([by.apply(here.apply((low + high) / 2)) for *_, by in ways])
    turns = np.array([by.rotation for *_, by in ways]) @ here.rotation
    half, met = (high - low) / 2 + distance + ROUNDING, np.zeros(len(ways), bool)
    for other in others:
        at = after.poses[other.name].pose if other.name in after.poses else other.pose
        met |= overlaps(_there(Itself(other), at), centres, turns, half).any(axis=1)
    return [way for way, near in zip(ways, met.tolist(), strict=True) if near]


@lru_cache(maxsize=64)
def _box(thing: Itself[Thing]) -> tuple[Floats, Floats]:
    return box_around(thing.it.geoms)


@lru_cache(maxsize=256)
def _there(thing: Itself[Thing], at: Pose) -> Body:
    """Shapes of a thing at a pose."""
    return body(replace(g, pose=at * g.pose) for g in thing.it.geoms)


def _end(moving: Thing, kind: str, clearance: float | None) -> float:
    """Joint value [m, rad] up to which a thing that closes or opens is looked at; without a clearance, the
    guarded last part of closing is left out."""
    assert moving.joint is not None
    joint, handle = moving.joint, moving.feature("cram:Handle")
    left = ajar(joint, handle.pose) if handle and clearance is None else 0.0
    return joint.value_at(left if kind == CLOSING else OPENED)


@lru_cache(maxsize=64)
def _on_its_way(joint: Joint, at: Pose, value: float, end: float, along: bool) -> tuple[Passed, ...]:
    """Return the positions at which to check a moving door or drawer, with ``along`` with the placed thing.

    The end comes first, since most contacts are there.
    """
    count = max(1, math.ceil(abs(value - end) / STEPS[joint.kind == "hinge"]))
    ways = ((value - end) * k / count for k in (count, *range(1, count)))
    moved = ((value - way - joint.lower, joint.moved(at, -way)) for way in ways)
    back = at.inverse()
    return tuple((left, to, to * back if along else at * to.inverse()) for left, to in moved)

"""Placements in front of an overhang that is too low for the hand: a thing is put down on the level before it, and pushed in from there.

What carries it in front goes on under the overhang, as a table does under a shelf without a bottom board.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose
from cramlite.plugin import Refused

from ...motion_planning.reach import shift
from ...shapes.bounds import lowest
from ...shapes.roofs import open_sides
from ...shapes.standing_up import stood_up
from ...shapes.surfaces import FLAT
from .query import Groups, Placement, Query
from .stable_poses import about_vertical, carried_at, inside_from

DEEPS = (0.03, 0.016)  # of the origin from the edge of its region [m]
SHORT = (0.08, 0.06)
"""Distances from where a thing is put down to where it is pushed [m]: fingers that push it in come down 0.1 m behind its end."""
ACROSS = (0.0, 0.5, -0.5)  # positions across the way in, as shares of half of the room
KEPT = 0.008  # lowest point over what carries it when it is let go of [m]: what paths keep, and a little more
FAR = 0.06  # the stand-off from there, outwards [m]
HEADINGS, FEW = 12, 3  # turns of a thing about the vertical, and how many are tried
BACK = 0.1  # way of the hand back along its approach [m]


def short_of_it(asked: list[Query]) -> Groups:
    """Generate placements of an upright payload on the level before an overhang, from where it is pushed straight in."""
    query, none = asked[0], True
    upright = stood_up(query.thing, query.now)
    for out in open_sides(query.whole, query.at, query.target, -query.depth / 2):
        turns = _across(query, upright, out)
        for deep, share in product(DEEPS, ACROSS):
            to, said = inside_from(query, out, deep, share), f"{1000 * deep:.0f} mm in, at {100 * share:+.0f} % across"
            for short, turned in product(SHORT, turns):
                lies = _carried(query, turned, to, short * out)
                if lies is None:
                    continue
                none, no = False, query.scene.met(query.belief.base() * query.hand(shift(lies, (0.0, 0.0, KEPT))), False)
                if no is not None:
                    yield replace(no.of(said), reason=f"not lying there: {no.reason}")
                    break
                yield iter([(query, _before(query, lies, short * out, out, said))])
    if none:
        yield Refused("short of it", f"what carries it before '{query.entity}' does not go on under its roof")


def _across(query: Query, upright: Pose, out: Floats) -> list[Pose]:
    """Payload turned about the vertical so that the hand, which is broad where its fingers close, does that across the way in."""
    turned = [about_vertical(upright, math.tau * k / HEADINGS) for k in range(HEADINGS)]
    along = [abs(float(query.hand(pose).rotate((0.0, 1.0, 0.0)) @ out)) for pose in turned]
    return [turned[k] for k in sorted(range(HEADINGS), key=lambda k: (round(along[k], 2), k))[:FEW]]


def _carried(query: Query, turned: Pose, to: Floats, off: Floats) -> Pose | None:
    """Pose of a payload with its origin over a point (3,); None if what carries it there is not as high as what carries it before."""
    there, before = (carried_at(query.thing, turned, tuple((to + by).tolist()), query.belief) for by in (0.0 * off, off))
    if there is None or before is None or abs(there - before) > FLAT:
        return None
    return Pose((float(to[0]), float(to[1]), there - lowest(query.thing, turned)), turned.quaternion)


def _before(query: Query, lies: Pose, off: Floats, out: Floats, said: str) -> Placement:
    """Placement before the overhang, with the pose to which the payload is pushed as the one in which it comes to lie."""
    name = f"put down {1000 * math.hypot(*off):.0f} mm before where it is pushed, {said}"
    thing = shift(lies, off + KEPT * np.array([0.0, 0.0, 1.0]))
    pose = query.hand(thing)
    back = pose * Pose((0.0, 0.0, -BACK))
    return Placement(
        name, thing, pose, shift(pose, FAR * out), KEPT, "toppled", (), True, lies, back, reorients=True, opens=True
    )  # fmt: skip

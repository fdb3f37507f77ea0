"""The way of a drawer or a door along its joint: what it meets there, wherever the hand is."""

from __future__ import annotations

import math
from collections.abc import Sequence

from msgspec.structs import replace

from cramlite.model import Belief, Held, Pose, Thing
from cramlite.plugin import Context, InTheWay

from ..motion_planning.reach import make_scene
from ..motion_planning.space import Refusal
from ..shapes.carried_along import carried_along

STEPS = 0.005, math.radians(1.0)  # between the values of a joint that are looked at [m, rad]


def met_on_its_way(thing: Thing, value: float, goal: float, belief: Belief, context: Context) -> Refusal | None:
    """Return what a thing meets first, with what it takes along, while its joint goes from a value to a goal [m, rad], and all that is in
    the way; None where it is free, and where something touches it already, of which planned paths know more."""
    assert thing.joint is not None
    with_it = carried_along(belief, thing.name)
    scene = make_scene(belief.grasped(Held(thing.name, Pose(), 0.0, carries=with_it)), context, clearance=0.0)
    now, way, step = belief.pose(thing.name), goal - value, STEPS[thing.joint.kind == "hinge"]
    count = max(1, math.ceil(abs(way) / step))
    poses = (belief.base() * thing.joint.moved(now, way * k / count) for k in range(count + 1))
    met = {k: no for k, there in enumerate(poses) if (no := scene.met(there, hand=False))}
    if not met or 0 in met:
        return None
    first = min(met)
    gone = abs(way) * first / count
    far = f"{1000 * gone:.0f} mm" if thing.joint.kind == "slide" else f"{math.degrees(gone):.0f} deg"
    said, every = f"after {far} of its own way {met[first].reason}", _all_of([no.blocking for no in met.values()])
    return replace(met[first], reason=said, blocking=every)


def _all_of(blocking: Sequence[InTheWay]) -> InTheWay:
    """What has to be changed where something is in the way at several places: all of it; nothing where at one of them no task can."""
    if not all(blocking):
        return ()
    entries = (entry for entries in blocking for entry in entries or ())
    return (tuple(sorted({name for entry in entries for name in ((entry,) if isinstance(entry, str) else entry)})),)

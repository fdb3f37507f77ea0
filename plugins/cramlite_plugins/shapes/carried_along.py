"""What moves along with a thing: what is in it, stands on it or hangs on it, and what is in or on that."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Estimate, Place, Pose, Thing, thing_of

from .bounds import lowest
from .contents import within
from .surfaces import SUNK, resting_height

PUSHED = "pushed_m"
"""Value of a place: how far its thing comes along with fingers that go straight to it [m]."""
CAME_ALONG = "predicted: pushed, as far as the fingers went"
"""Source of the pose of what did."""
AT = ("on", "in", "hangs_on")
"""Relations of a belief that tie a thing to a place."""


def carried_along(belief: Belief, name: str) -> dict[str, Estimate]:
    """Find what moves along when a thing is moved, directly or through others: its poses in the thing's frame.

    What tasks or the scenario said to be in, on or hung on something is; of all else geometry says where it is.
    """
    there = belief.poses[name].pose.inverse()
    found, new = list[str](), [name]
    while new:
        new = [n for below in new for n in _directly(belief, below) if n not in (name, *found)]
        found += dict.fromkeys(new)
    return {n: replace(belief.poses[n], pose=there * belief.poses[n].pose) for n in found}


def pushed_along(belief: Belief, place: Place) -> Belief:
    """Return a belief in which the thing of a place that says so (``PUSHED``) has come along straight to it, with what is in it."""
    way, name = place.values.get(PUSHED, 0.0), place.thing
    if not way:
        return belief
    known, with_it = belief.poses[name], carried_along(belief, name)
    x, y, z = (np.asarray(known.pose.position) + way * np.asarray(place.approach)).tolist()
    there = Pose((x, y, z), known.pose.quaternion)
    poses = {name: replace(known, pose=there, source=CAME_ALONG)}
    poses |= {one: replace(e, pose=there * e.pose) for one, e in with_it.items()}
    return replace(belief, poses={**belief.poses, **poses})


def _directly(belief: Belief, name: str) -> Iterator[str]:
    carrier = belief.world.thing(name)
    for thing in belief.world.things:
        if thing.movable and thing.joint is None and thing.name in belief.poses and thing.name != name:
            said = {thing_of(place) for p, one, place in belief.relations if one == thing.name and p in AT}
            if name in said or (not said and (_is_in(belief, thing, carrier) or _stands_on(belief, thing, carrier))):
                yield thing.name


def _is_in(belief: Belief, thing: Thing, container: Thing) -> bool:
    pose, at = belief.poses[container.name].pose, belief.poses[thing.name].pose
    row, centre = np.array([[*pose.position, *pose.quaternion]]), np.array([[at.position]])
    return bool(within(container, row, centre).item())


def _stands_on(belief: Belief, thing: Thing, below: Thing) -> bool:
    pose = belief.poses[thing.name].pose
    height, _ = resting_height(thing, pose, [(below, belief.poses[below.name].pose)])
    return math.isfinite(height) and lowest(thing, pose) + pose.position[2] - height <= SUNK

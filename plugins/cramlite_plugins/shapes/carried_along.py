"""Things that move along with a thing: in it, on it, hanging on it, mounted on it, and in or on those."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Estimate, Floats, Place, Pose, Thing, thing_of
from cramlite.plugin import checkpoint

from .bounds import lowest
from .contents import are_in_cavity
from .surfaces import SUNK, resting_height

CAME_ALONG = "predicted: pushed, as far as the fingers went"
"""Source that a belief states for the pose of a thing that has been pushed or taken along."""
AT = ("on", "in", "hangs_on")
"""Relations of a belief that tie a thing to a place."""


def carried_along(belief: Belief, name: str) -> dict[str, Estimate]:
    """Find the things that move along when a thing is moved, directly or through others: poses in the
    thing's frame.

    What tasks or the scenario said to be in, on or hung on something is; of all else geometry says where it
    is.
    """
    there = belief.poses[name].pose.inverse()
    found, new = list[str](), [name]
    while new:
        checkpoint()
        new = [n for below in new for n in _directly(belief, below) if n not in (name, *found)]
        found += dict.fromkeys(new)
    return {n: replace(belief.poses[n], pose=there * belief.poses[n].pose) for n in found}


def pushed_along(belief: Belief, place: Place) -> Belief:
    """Return a belief in which a thing has been pushed straight to its new place, and its contents with it.

    It moved by the ``pushed_m`` of the place.
    """
    if place.carried is None or not place.carried.pushed_m:
        return belief
    return gone_along(belief, place.thing, place.carried.pushed_m * np.asarray(place.approach))


def gone_along(
    belief: Belief, name: str, way: Floats, sigma: float = 0.0, source: str = CAME_ALONG
) -> Belief:
    """Return a belief in which a thing and all that moves along with it have moved by a vector (3,) in the
    base frame [m], each with ``sigma`` more uncertainty."""
    known, with_it = belief.poses[name], carried_along(belief, name)
    there = Pose.at(known.pose.position + belief.base().rotate(way), known.pose)
    poses = {name: replace(known, pose=there, sigma=known.sigma + sigma, source=source)}
    poses |= {one: replace(e, pose=there * e.pose) for one, e in with_it.items()}
    return replace(belief, poses={**belief.poses, **poses})


def driven_before(belief: Belief, place: Place, way: Floats) -> Belief:
    """Return a belief in which the things that a thing pushes ahead of itself on the way to its place have
    moved along with it.

    ``way`` is the unit vector (3,) of this motion in the base frame.
    """
    for name, metres in driven(place).items():
        belief = gone_along(belief, name, metres * way, metres, "predicted: driven along")
    return belief


def driven(place: Place) -> Mapping[str, float]:
    """Return the distance by which each thing is pushed along on the way to a place [m]."""
    return place.carried.driven_m if place.carried else {}


def _directly(belief: Belief, name: str) -> Iterator[str]:
    carrier = belief.world.thing(name)
    yield from (t.name for t in belief.world.mounted_on(name) if t.name in belief.poses)
    for thing in belief.world.things:
        if not thing.furniture and thing.name in belief.poses and thing.name != name:
            said = {thing_of(place) for p, one, place in belief.relations if one == thing.name and p in AT}
            if name in said or (
                not said and (_is_in(belief, thing, carrier) or _stands_on(belief, thing, carrier))
            ):
                yield thing.name


def _is_in(belief: Belief, thing: Thing, container: Thing) -> bool:
    pose, at = belief.poses[container.name].pose, belief.poses[thing.name].pose
    row, centre = np.array([[*pose.position, *pose.quaternion]]), np.array([[at.position]])
    return bool(are_in_cavity(container, row, centre).item())


def _stands_on(belief: Belief, thing: Thing, below: Thing) -> bool:
    pose = belief.poses[thing.name].pose
    height, _ = resting_height(thing, pose, [(below, belief.poses[below.name].pose)])
    return math.isfinite(height) and lowest(thing, pose) + pose.position[2] - height <= SUNK

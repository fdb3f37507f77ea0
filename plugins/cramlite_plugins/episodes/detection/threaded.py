"""Detection of pegs in holes: a threaded thing rattles, and losing contact for a moment does not take it
off.

A peg that stands is loose in a hole that rests around it, and need not touch it: the hole is on it for as long as the peg is in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cramlite.model import EntityName, Feature, Floats, Pose, Rollout, Thing
from cramlite.plugin import checkpoint

from ...shapes.peg_fit import stands

Flags = NDArray[np.bool_]


def threaded(rollout: Rollout) -> Iterator[tuple[str, str, Flags]]:
    """Yield ("thing/hole", "hanger/peg", whether the peg passes through the hole at each sample) of every such pair."""
    things = rollout.world.things
    for owner in things:
        for other in things:
            for hole in (f for f in owner.features if f.type == "vrps:Hole"):
                for peg in (f for f in other.features if f.type == "vrps:Peg" and other is not owner):
                    if "diameter" not in hole.size or "length" not in peg.size:
                        continue  # of unknown size: contacts alone tell
                    flags = _passes(rollout, owner, hole, other, _polyline(other, peg))
                    yield str(EntityName(owner.name, hole.name)), str(EntityName(other.name, peg.name)), flags


def around_standing(hanger: Thing) -> bool:
    """Return whether a peg stands upright: a thing threaded onto it is on it without touching it."""
    peg = hanger.feature("vrps:Peg")
    return peg is not None and stands((hanger.pose * peg.pose).rotate((0.0, 0.0, 1.0)))


def _polyline(hanger: Thing, peg: Feature) -> Floats:
    """The peg's axis in its hanger's frame, (M, 3): from its root over its end to the end of its tip."""
    axis = peg.pose
    points = [axis.position, tuple(axis.apply((0, 0, peg.size["length"])))]
    tip = hanger.feature("vrps:Tip")
    return np.array([*points, tip.pose.position] if tip else points)


def _passes(rollout: Rollout, owner: Thing, hole: Feature, hanger: Thing, line: Floats) -> Flags:
    """Whether a segment of the line, in its hanger's frame, passes through the disc of the hole: its ends are
    on different sides of the disc's plane."""
    still = hanger.pose.inverse()
    rows = rollout.poses.get(hanger.name) if hanger.movable or hanger.joint else None
    frames = [still] * len(rollout.times) if rows is None else [Pose(tuple(r[:3]), tuple(r[3:])).inverse() for r in rows]
    tracked = zip(frames, rollout.poses[owner.name], strict=True)
    poses = [frame * Pose(tuple(row[:3]), tuple(row[3:])) * hole.pose for frame, row in tracked]
    radius = hole.size["diameter"] / 2
    return np.array([_meets(pose, radius, line) for pose in poses], dtype=bool)


def _meets(hole: Pose, radius: float, line: Floats) -> bool:
    checkpoint()
    local = hole.inverse().apply(line)
    for a, b in pairwise(local):
        if (a[2] > 0) != (b[2] > 0):
            x, y, _ = a + (b - a) * (a[2] / (a[2] - b[2]))
            if np.hypot(x, y) <= radius:
                return True
    return False


def held_on(touching: Flags, through: Flags) -> Flags:
    """Extend contact for as long as the peg stays in the hole: from the first contact of each stretch in which it does."""
    result = touching.copy()
    if not through.any():
        return result
    on = False
    for k in range(len(result)):
        on = bool(through[k] and (on or touching[k]))
        result[k] |= on
    return result

"""Detection of things threaded onto pegs, from poses: contact may be lost for a moment without the thing coming off.

A peg that stands is loose in a hole that rests around it, and need not touch it: the hole is on it for as long as the peg is in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cramlite.model import EntityName, Feature, Floats, Rollout, Thing
from cramlite.plugin import checkpoint

from ...shapes.peg_fit import stands
from .signals import rotate_into_frame

Flags = NDArray[np.bool_]


def threaded(rollout: Rollout) -> Iterator[tuple[str, str, Flags]]:
    """Yield each pair of a hole and another thing's peg, by their names, with whether the peg is in the hole
    at each sample."""
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
    """Check whether a thing's peg stands upright: a thing that is threaded onto such a peg hangs on it even without contact."""
    peg = hanger.feature("vrps:Peg")
    return peg is not None and stands((hanger.pose * peg.pose).rotate((0.0, 0.0, 1.0)))


def _polyline(hanger: Thing, peg: Feature) -> Floats:
    """Axis of a peg in its hanger's frame as a polyline (M, 3): the peg's root, its end, and the end of the
    bent tip if there is one."""
    axis = peg.pose
    points = [axis.position, tuple(axis.apply((0, 0, peg.size["length"])))]
    tip = hanger.feature("vrps:Tip")
    return np.array([*points, tip.pose.position] if tip else points)


def _passes(rollout: Rollout, owner: Thing, hole: Feature, hanger: Thing, line: Floats) -> Flags:
    """Whether a segment of the peg's axis ``line`` (hanger frame) passes through the disc of a hole, at each sample.

    Its ends are on different sides of the disc's plane, and it crosses the plane within the hole's radius.
    """
    checkpoint()
    rows = rollout.poses.get(hanger.name) if hanger.movable or hanger.joint else None
    still = np.array([(*hanger.pose.position, *hanger.pose.quaternion)])
    into = hole.pose.inverse()
    points = [into.apply(_into(rollout.poses[owner.name], _out_of(still if rows is None else rows, point))) for point in line]
    radius, found = hole.size["diameter"] / 2, np.zeros(len(rollout.times), dtype=bool)
    for a, b in pairwise(points):
        apart = (a[:, 2] > 0) != (b[:, 2] > 0)
        met = a + (b - a) * (a[:, 2] / np.where(apart, a[:, 2] - b[:, 2], 1.0))[:, None]
        found |= apart & (np.hypot(met[:, 0], met[:, 1]) <= radius)
    return found


def _into(poses: Floats, points: Floats) -> Floats:
    """Express points (N, 3) of the world in frames with poses (N, 7), one frame for each point."""
    return rotate_into_frame(_unit(poses), points - poses[:, :3])


def _out_of(poses: Floats, point: Floats) -> Floats:
    """Transform a point (3,) that is fixed in a moving frame to the world, (N, 3), for each pose (N, 7) of
    the frame."""
    return poses[:, :3] + rotate_into_frame(_unit(poses) * (1.0, -1.0, -1.0, -1.0), np.broadcast_to(point, (len(poses), 3)))


def _unit(poses: Floats) -> Floats:
    """Return the quaternions of poses (N, 7), scaled to length 1."""
    found: Floats = poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return found


def held_on(touching: Flags, through: Flags) -> Flags:
    """Extend contact with a peg: in each stretch in which the peg is in the hole, from the first contact to
    the end of the stretch."""
    result = touching.copy()
    if not through.any():
        return result
    on = False
    for k in range(len(result)):
        on = bool(through[k] and (on or touching[k]))
        result[k] |= on
    return result

"""Joint values, computed from the believed poses of the things that the joints move."""

from __future__ import annotations

from cramlite.model import Belief, Pose


def joint_value(belief: Belief, thing: str, pose: Pose) -> float:
    """Return the value of a thing's joint when the thing is at a pose in the world [m, rad]."""
    start = belief.world.thing(thing)
    assert start.joint is not None
    shift = belief.world.carrier_shift(
        thing, {n: e.pose for n, e in belief.poses.items() if n == start.joint.parent}
    )
    return start.joint.value + start.joint.between(shift * start.pose, pose)

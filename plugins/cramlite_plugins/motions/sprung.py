"""Levers in the hand: the pull of their springs, and the doors that they take along."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Pose
from cramlite.plugin import Context

from ..shapes.carried_along import carried_along


def tangent(belief: Belief, context: Context) -> Floats | None:
    """Return the direction in which the spring in a held thing's joint pulls the hand, as a unit vector (3,) in the base
    frame; None if the joint has no spring."""
    from ..motion_planning.reach import held_pose, tcp

    joint = belief.world.thing(belief.held.thing).joint if belief.held else None
    if joint is None or not joint.spring:
        return None
    frame = held_pose(belief, context) * joint.pose
    axis = np.asarray(frame.rotate((0.0, 0.0, 1.0)))
    way: Floats = axis if joint.kind == "slide" else np.cross(axis, np.subtract(tcp(belief, context).position, frame.position))
    return way / float(np.linalg.norm(way))


def across(pull: Floats, frame: Pose) -> Pose:
    """Turn a compliance frame about z until x is along a spring's pull, as nearly as it can be; y alone is compliant."""
    return Pose.from_axes((0.0, 0.0, 0.0), frame.rotate((0.0, 0.0, 1.0)), tuple(pull.tolist()))


def with_lever(thing: str, belief: Belief, context: Context) -> Belief:
    """Return the belief in which a hand that holds a thing's lever takes that thing along, with its content."""
    from ..motion_planning.reach import held_pose

    known, there = belief.poses[thing], (belief.base() * held_pose(belief, context)).inverse()
    along = {n: replace(e, pose=there * known.pose * e.pose) for n, e in carried_along(belief, thing).items()}
    held = belief.payload
    return belief.grasped(replace(held, carries={**held.carries, thing: replace(known, pose=there * known.pose), **along}))

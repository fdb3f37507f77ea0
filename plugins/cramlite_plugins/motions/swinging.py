"""Straight motions on which a thing pinched at its rim turns between the pads: raised until it hangs, lowered
until it lies."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Hang, Motion, MoveLinear, Pose
from cramlite.plugin import Answers, Context, Grounding, Refused, hookimpl

from ..motion_planning.cartesian import free_line, interpolate
from .free_motion import because, place_of
from .motion_kinds import value, word

RISES = 6  # parts of a lift, on each of which it hangs a little more: 20 mm of height each


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve motion "swing"; None for other kinds."""
    return _swing(motion, belief, context) if motion.kind == "swing" else None


def _swing(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    """Resolve motion "swing": "hangs" is one straight motion with the thing's whole turn, "lies" several with
    an equal part of it each."""
    held = belief.held
    assert held is not None and held.swing is not None, f"motion '{motion.name}' needs something that swings in the hand"
    place, hangs = place_of(motion, context), word(motion, "to", Hang) is Hang.HANGS
    targets, shares = (_raised(place.pose, belief, context), (0.0, 1.0)) if hangs else (place.path, (1.0, 0.0))
    swing = place.swing or held.swing
    steps, now = list[MoveLinear](), belief
    speed, acceleration = value(motion, "speed_m_s"), value(motion, "acceleration_m_s2")
    for target, (first, last) in zip(targets, pairwise(np.linspace(*shares, len(targets) + 1).tolist()), strict=True):
        points = _line(motion, now, swing.at(min(first, last)), target, context)
        turn = swing.part(first, last)
        steps.append(MoveLinear(target, speed, acceleration, points[-1], turn, origin=motion.name, comment=motion.reason))
        now = now.moved(points[-1])
    if hangs:
        steps = [replace(steps[-1], swing=swing)]
    comes_to = swing.end if hangs else swing.start * (place.release.settles if place.release else Pose())
    after = replace(now, held=replace(held, tcp_to_thing=comes_to))
    angle = math.degrees(math.hypot(*(swing.start.inverse() * swing.end).rotvec))
    yield Grounding(tuple(steps), f"turns by {angle:.0f} deg between the pads, in {len(steps)} straight motions", 0.0, after, key="swing")


def _raised(target: Pose, belief: Belief, context: Context) -> Sequence[Pose]:
    """Return TCP poses along the line up to a target, on which a thing swings down in the hand.

    Its near side rises from the start, its far side last of all.
    """
    from ..motion_planning.reach import tcp

    here = tcp(belief, context)
    return [interpolate(here, target, k / RISES) for k in range(1, RISES + 1)]


def _line(motion: Motion, belief: Belief, tcp_to_thing: Pose, target: Pose, context: Context) -> Sequence[tuple[float, ...]]:
    """Return joint positions along a straight line of the TCP, checked with the thing at one pose in the hand.

    That is its flattest pose on the line, with its far side as low as its support.
    """
    there = replace(belief, held=replace(belief.payload, tcp_to_thing=tcp_to_thing))
    found = free_line(motion, there, context, [target], belief)
    if isinstance(found, Refused):
        said = f"no straight line to {motion.to}, along which the payload swings: {found.reason}"
        raise found.impossible(said, because(motion, belief, context))
    return found.points

"""Ablation without force control: guarded motions are left out, compliant ones become plain lines."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite.model import Belief, Motion, MoveLinear
from cramlite.plugin import Answers, Context, Grounding, hookimpl
from cramlite_plugins.motions import free_motion
from cramlite_plugins.motions.motion_kinds import KINDS, value

ACCELERATION = 0.25  # [m/s2]
CORNERS = 3  # of an insertion's path that lead to its depth; the last one lets the hole down, which is a motion of its own
FELT_FOR = ("until_contact", "spiral_search")
DRIVEN = frozenset(k.name for k in KINDS.values() if k.widens > 0 and k.name not in FELT_FOR)
"""Kinds of contact motions that become plain lines: they add to the pose error of the payload in the hand."""


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    if motion.kind in FELT_FOR:
        return [Grounding((), "left out", key="none")]
    return _driven(motion, belief, context) if motion.kind in DRIVEN else None


def _driven(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    path = free_motion.place_of(motion, context).path
    corners = list(path[:CORNERS] if motion.kind == "force_insert" else path)
    points = free_motion.line(motion, belief, context, corners)
    speed = value(motion, "speed_m_s")
    steps = tuple(MoveLinear(c, speed, ACCELERATION, origin=motion.name) for c in corners)
    yield Grounding(steps, "driven without feeling", 0.0, belief.moved(points[-1]), key="plain")

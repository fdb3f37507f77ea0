"""An ablation: no force control. What would be felt for is left out; what would give way is driven as a plain line."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite import Answers, Belief, Context, Grounding, Motion, MoveLinear, hookimpl
from cramlite_plugins.motions import free_motion

ACCELERATION = 0.25  # [m/s2]
SPEED = 0.02  # of motions that name none [m/s]: what force insertion moves with
CORNERS = 3  # of an insertion's path that lead to its depth; the last one lets the hole down, which is a motion of its own


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    if motion.kind in ("until_contact", "spiral_search"):
        return [Grounding((), "left out", key="none")]
    return _driven(motion, belief, context) if motion.kind in ("force_path", "force_insert") else None


def _driven(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    path = free_motion.place_of(motion, context).path
    corners = list(path[:CORNERS] if motion.kind == "force_insert" else path)
    points = free_motion.line(motion, belief, context, corners)
    speed = float(motion.parameters.get("speed_m_s", SPEED))
    steps = tuple(MoveLinear(c, speed, ACCELERATION, origin=motion.name) for c in corners)
    yield Grounding(steps, "driven without feeling", 0.0, belief.moved(points[-1]), key="plain")

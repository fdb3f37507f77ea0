"""An ablation: no search by touch."""

from __future__ import annotations

from cramlite import Answers, Belief, Context, Grounding, Motion, hookimpl


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    return [Grounding((), "no search", key="none")] if motion.kind == "spiral_search" else None

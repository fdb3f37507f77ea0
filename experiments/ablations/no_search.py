"""Ablation without searching a hole by touch: spiral searches are left out."""

from __future__ import annotations

from cramlite.model import Belief, Motion
from cramlite.plugin import Answers, Context, Grounding, hookimpl


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    return [Grounding((), "no search", key="none")] if motion.kind == "spiral_search" else None

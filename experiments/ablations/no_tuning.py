"""Ablation without tuned numbers: each speed, force and distance of a motion is drawn between a third and three
times its value."""

from __future__ import annotations

from collections.abc import Mapping
from random import Random

from msgspec.structs import replace

from cramlite.model import Belief, Motion
from cramlite.plugin import Answers, Context, hookimpl
from cramlite_plugins.motions import contact_motion, free_motion
from cramlite_plugins.motions.motion_kinds import KINDS

MOVING = (contact_motion, free_motion)
KEPT = ("acceleration_rad_s2", "acceleration_m_s2", "force_limit_n", "speed_rad_s", "duration_s", "lost_s")
"""Parameters that keep their values: limits of the arm and of contacts, and numbers that say nothing about contact."""
TIMES = 3.0


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    drawn = replace(motion, parameters={**motion.parameters, **_drawn(motion, Random(context.seed))})
    found = (plugin.resolve_motion(drawn, belief, context) for plugin in MOVING)
    return next((answers for answers in found if answers is not None), None)


def _drawn(motion: Motion, random: Random) -> Mapping[str, float]:
    """Return a motion's parameters, each multiplied by a random factor that is as likely below 1 as above.

    Parameters that the motion does not state have the defaults of its kind.
    """
    kind = KINDS.get(motion.kind)
    said = {p.name: motion.parameters.get(p.name, p.default) for p in (kind.parameters if kind else ()) if p.name not in KEPT}
    return {name: float(number) * TIMES ** random.uniform(-1.0, 1.0) for name, number in said.items()}

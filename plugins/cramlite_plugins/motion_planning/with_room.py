"""Transfers with room for what a proof doubts: paths that stay free where things are a little off.

The twins of a proof move each thing by errors that no plan knows. A path that keeps the clearance alone from
where a thing is believed may touch it in a twin, and the whole program is refused. So a path with more room
is looked for first; where none is found, the clearance is enough.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from cramlite.model import Belief, ErrorModel
from cramlite.plugin import Context, Refused

from ..shapes.bounds import extents
from .planner import Path, plan
from .planning_scene import PlanningScene
from .reach import SIGMAS, WIDEST, make_scene, uncertainty_margins
from .space import Joints

SHARE = 8
"""One in so many of the samples may be spent on a path with room: where there is room, it is found soon."""


def planned(
    scene: PlanningScene, belief: Belief, context: Context, goals: Sequence[Joints], *,
    seed: int, speed: float, acceleration: float,
) -> tuple[Path | Refused, str]:  # fmt: skip
    """Plan a path from where the arm is, and name the distances that it keeps.

    It has room for the errors of the proof's twins, if such a path is found.

    Args:
        scene: of the belief, with the planner's clearance.
        goals: joint positions, in order of preference [rad].
        seed: of this query.
        speed, acceleration: of the leading axis [rad/s, rad/s2].
    """

    def path(there: PlanningScene, samples: int) -> Path | Refused:
        now = belief.joints
        return plan(there, now, goals, seed=seed, samples=samples, speed=speed, acceleration=acceleration)

    if context.errors is not None:
        roomy = make_scene(belief, context, wider=doubt_margins(belief, context.errors))
        if isinstance(found := path(roomy, context.samples // SHARE), Path):
            return found, "clearance and room for the proof's errors kept"
    return path(scene, context.samples), "clearance kept"


def doubt_margins(belief: Belief, errors: ErrorModel) -> dict[str, float]:
    """Return the distance [m] to keep from each thing beyond the clearance, so that a path stays free in the
    twins of a proof, too."""
    found = uncertainty_margins(belief)
    for thing in belief.world.things:
        if thing.geoms:
            width, depth, height = extents(thing.geoms)
            sigma = errors.sigma(thing.name, math.hypot(width / 2, depth / 2, height))
            found[thing.name] = max(found.get(thing.name, 0.0), min(SIGMAS * sigma, WIDEST))
    return found

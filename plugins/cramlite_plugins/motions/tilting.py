"""Tilting of a held vessel about its rim, and back: the poses of a path, blended to one joint-space motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from cramlite.model import Belief, Motion, Tilt
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

from .motion_kinds import value, word


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve motion "tilt"; None for other kinds."""
    return _tilt(motion, belief, context) if motion.kind == "tilt" else None


def _tilt(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    """Tilt to the end of the path ("tilted"), or back to its beginning ("upright")."""
    from ..kinematics.timing import leading
    from ..motion_planning.cartesian import plan_straight_line
    from ..motion_planning.joint_move import joint_move
    from ..motion_planning.reach import make_scene
    from ..motion_planning.round_off import blend_radii
    from .free_motion import place_of

    path = place_of(motion, context).path
    poses = path[1:] if word(motion, "to", Tilt) is Tilt.TILTED else path[-2::-1]
    scene, points = make_scene(belief, context), [belief.joints]
    for pose in poses:
        part = plan_straight_line(scene, context.robot, points[-1], pose)
        if isinstance(part, Refused):
            said, about = f"'{motion.name}' about the rim: {part.reason}", (motion.to.name if motion.to else "",)
            raise Unresolvable(said, about, blocking=part.blocking, collision=part.collision, remedy=part.remedy)
        points.append(part.points[-1])
    angle = sum(a.distance(b)[1] for a, b in pairwise(path))
    turned = sum(leading(a, b) for a, b in pairwise(points))
    speed = value(motion, "speed_rad_s") * turned / angle
    acceleration = value(motion, "acceleration_rad_s2")
    radii, seconds = blend_radii(scene, points, speed, acceleration)
    step = joint_move(motion, context.robot, points, (speed, acceleration), radii)
    seconds *= speed / step.speed
    reason = f"{math.degrees(angle):.0f} deg about the rim in {seconds:.1f} s, {len(radii)} corners rounded"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="tilt")

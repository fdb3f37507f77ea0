"""Motion along a path in the air: the poses of a place's path, blended to one joint-space motion, round after round."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from cramlite.model import Belief, Motion, Repeat
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from .motion_kinds import value

CLOSED = 1e-3
"""Largest turn of a joint between the ends of a round that is gone through again [rad]."""


def trace(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    """Generate the motion along the path of a place, as often as that says."""
    from ..kinematics.timing import leading
    from ..motion_planning.cartesian import plan_straight_line
    from ..motion_planning.joint_move import joint_move
    from ..motion_planning.reach import make_scene, tcp, touched
    from ..motion_planning.round_off import blend_radii
    from .free_motion import because, place_of  # which imports this module

    place = place_of(motion, context)
    rounds = max(round(place.values.get("rounds", 1.0)), 1)
    scene = make_scene(belief, context, touched(motion.may_touch, context), clearance=0.0)
    points, here, way = [tuple(belief.joints)], tcp(belief, context), 0.0
    for pose in place.path:
        part = plan_straight_line(scene, context.robot, points[-1], pose)
        if isinstance(part, Refused):
            said = f"'{motion.name}' along its path: {part.reason}"
            raise Unresolvable(said, because(motion, belief, context), blocking=part.blocking, collision=part.collision, remedy=part.remedy)
        points.append(part.points[-1])
        way, here = way + here.distance(pose)[0], pose
    same = rounds > 1 and leading(points[0], points[-1]) < CLOSED
    if same:
        points[-1] = points[0]
    elif rounds > 1:
        points += points[1:] * (rounds - 1)
    turned = sum(leading(a, b) for a, b in pairwise(points)) / (1 if same else rounds)
    speed, acceleration = value(motion, "speed_m_s") * turned / way, value(motion, "acceleration_rad_s2")
    radii, seconds = blend_radii(scene, points, speed, acceleration)
    step = joint_move(motion, context.robot, points, (speed, acceleration), radii)
    steps = (Repeat((step,), rounds, origin=motion.name, comment=f"{rounds} rounds"),) if same else (step,)
    took = seconds * speed / step.speed * (rounds if same else 1)
    reason = f"{1000 * way:.0f} mm of path, {rounds} times, in {took:.1f} s, {math.degrees(turned):.0f} deg of the leading axis each"
    yield Grounding(steps, reason, 0.0, belief.moved(points[-1]), key="trace")

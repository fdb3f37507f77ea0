"""Joint-space motions through all poses of a path, with rounded corners: tilting of a vessel, and paths that
demonstrations showed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from cramlite.model import Belief, Joints, Motion, Pose, Repeat, Tilt
from cramlite.plugin import Answers, Context, Grounding, Refused, hookimpl

from ..kinematics.timing import leading
from ..motion_planning.cartesian import plan_straight_line
from .free_motion import place_of
from .motion_kinds import value, word

if TYPE_CHECKING:
    from ..motion_planning.planning_scene import PlanningScene

CLOSED = 1e-3
"""Largest joint difference between the start and the end of a closed path up to which its rounds are programmed as a loop [rad]."""
SHY, DIGIT = 0.8, 1e-4
"""Factor on the largest blend radius at the corners of a path, and the step to which radii are rounded down [m]: the largest radius is half
of a line of 10 mm, and an arm stops off by some tenths of a millimetre."""


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve motions "tilt" and "trace"; None for other kinds."""
    kind = {"tilt": _tilt, "trace": _trace}.get(motion.kind)
    return kind(motion, belief, context) if kind else None


def _tilt(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    """Resolve motion "tilt": a motion to the end of the place's path ("tilted"), or back to the path's beginning ("upright")."""
    from ..motion_planning.joint_move import joint_move
    from ..motion_planning.reach import make_scene
    from ..motion_planning.round_off import blend_radii

    path = place_of(motion, context).path
    poses = path[1:] if word(motion, "to", Tilt) is Tilt.TILTED else path[-2::-1]
    scene = make_scene(belief, context)
    points = _through(motion, poses, scene, belief, context, "about the rim")
    angle = sum(a.distance(b)[1] for a, b in pairwise(path))
    speed = value(motion, "speed_rad_s") * _turned(points) / angle
    acceleration = value(motion, "acceleration_rad_s2")
    radii, seconds = blend_radii(scene, points, speed, acceleration)
    step = joint_move(motion, context.robot, points, (speed, acceleration), radii)
    seconds *= speed / step.speed
    reason = f"{math.degrees(angle):.0f} deg about the rim in {seconds:.1f} s, {len(radii)} corners rounded"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="tilt")


def _trace(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    """Resolve motion "trace": along the place's path; a closed path as many times as the place's value
    "rounds" says."""
    from ..motion_planning.joint_move import joint_move
    from ..motion_planning.reach import make_scene, tcp, touched
    from ..motion_planning.round_off import blend_radii

    place = place_of(motion, context)
    rounds = place.rounds
    scene = make_scene(belief, context, touched(motion.may_touch, context), clearance=0.0)
    points = _through(motion, place.path, scene, belief, context, "along its path")
    way = sum(a.distance(b)[0] for a, b in pairwise((tcp(belief, context), *place.path)))
    speed, acceleration = value(motion, "speed_m_s") * _turned(points) / way, value(motion, "acceleration_rad_s2")
    again = rounds > 1 and max(abs(a - b) for a, b in zip(points[0], points[-1], strict=True)) < CLOSED
    points = [*points[:-1], points[0]] if again else points + points[1:] * (rounds - 1)
    radii, seconds = blend_radii(scene, points, speed, acceleration)
    radii = tuple(round(math.floor(SHY * r / DIGIT) * DIGIT, 4) for r in radii)
    step = joint_move(motion, context.robot, points, (speed, acceleration), radii)
    seconds *= speed / step.speed * (rounds if again else 1)
    steps = (Repeat((step,), rounds, origin=motion.name, comment=f"{rounds} rounds"),) if again else (step,)
    reason = f"a path of {1000 * way:.0f} mm, traced {rounds} times in {seconds:.1f} s"
    yield Grounding(steps, reason, 0.0, belief.moved(points[-1]), key="trace")


def _through(
    motion: Motion, poses: Sequence[Pose], scene: PlanningScene, belief: Belief, context: Context, where: str
) -> list[Joints]:
    """Joint positions at poses of the TCP, connected by straight lines; the first are the arm's believed
    ones.

    Raises:
        Unresolvable: a line cannot be gone.
    """
    points = [belief.joints]
    for pose in poses:
        part = plan_straight_line(scene, context.robot, points[-1], pose)
        if isinstance(part, Refused):
            raise part.impossible(f"'{motion.name}' {where}: {part.reason}", (motion.to.name if motion.to else "",))
        points.append(part.points[-1])
    return points


def _turned(points: Sequence[Joints]) -> float:
    """Return the length of a joint path [rad]: on each line, that of the joint that moves farthest."""
    return sum(leading(a, b) for a, b in pairwise(points))

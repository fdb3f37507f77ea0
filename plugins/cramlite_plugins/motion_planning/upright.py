"""Transfers under an orientation constraint: a joint-space line if it keeps the load upright, else straight tcp lines.

How far a load may tilt is knowledge (``cram:tiltLimitDeg`` of its class). A sampling planner hardly ever stays in so
thin a set; straight lines between upright poses stay in it by themselves, on the branch that the arm is on. They lead
up, over and down: straight over, or around the robot's base, as high as it takes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Motion, MoveJoints, MoveLinear, Place, Pose, Value
from cramlite.plugin import Context, Grounding, Unresolvable

from ..kinematics.kinematics import forward
from ..kinematics.timing import duration, trapezoid
from .cartesian import interpolate, plan_straight_line, sampled, why_no_straight_line
from .planner import resampled, start_blocked
from .planning_scene import PlanningScene
from .space import Refusal

Joints = tuple[float, ...]
PROPERTY = "cram:tiltLimitDeg"
LIFTS = (0.0, 0.1, 0.2, 0.3)  # how far above the higher end the load is carried [m], tried in this order
ARC = 0.5  # between two corners of a way around the base, about its axis [rad]
STEP = 0.02, 0.05  # of the look at the tilt along a way [m, rad]; of a joint-space line the second
SPEED, ACCELERATION = 0.2, 0.5  # of the tcp [m/s, m/s2]: a level surface then tilts by atan(0.5 / 9.81) = 3 degrees
SLACK = math.radians(0.5)  # how far an executed tilt may be from a planned one: the servo's lag is below 7 mrad


class Load(Value):
    """Held thing with a tilt limit.

    Args:
        thing: its name.
        limit: largest angle between its z axis and the vertical [rad].
        in_tcp: its pose in the tcp frame.
        up: the vertical in the robot's base frame.
    """

    thing: str
    limit: float
    in_tcp: Pose
    up: tuple[float, float, float]

    def tilt(self, tcp: Pose) -> float:
        """Angle between the load's z axis and the vertical [rad]."""
        return float(math.acos(np.clip((tcp * self.in_tcp).rotate((0.0, 0.0, 1.0)) @ self.up, -1.0, 1.0)))


def load(belief: Belief, context: Context) -> Load | None:
    """Return what is held, if its class limits its tilt, and to as much as it leans by already if that is more; of what is held upside down
    nothing can be spilled any more."""
    if belief.held is None:
        return None
    thing = belief.world.thing(belief.held.thing)
    limits = [float(v) for v in context.taxonomy.fillers(thing.type, PROPERTY)]
    if not limits:
        return None
    x, y, z = belief.base().inverse().rotate((0.0, 0.0, 1.0)).tolist()
    found = Load(thing.name, math.radians(min(limits)) - SLACK, belief.held.tcp_to_thing, (x, y, z))
    now = found.tilt(forward(context.robot, belief.joints))
    return replace(found, limit=max(found.limit, now + SLACK)) if now <= math.pi / 2 else None


def carried(
    motion: Motion, place: Place, belief: Belief, context: Context, carry: Load, scene: PlanningScene, goals: Sequence[Joints],
    pace: tuple[float, float],
) -> Iterator[Grounding]:  # fmt: skip
    """Plan transfers to the stand-off of a place on which the load stays upright.

    Args:
        goals: free joint positions there, nearest first.
        pace: speed and acceleration of joint-space lines [rad/s, rad/s2].

    Raises:
        Unresolvable: it is tilted at the end, or no way keeps it upright.
    """
    here, there = forward(context.robot, belief.joints), forward(context.robot, goals[0])
    if carry.tilt(there) > carry.limit:
        raise Unresolvable(f"at the stand-off of {motion.to} {_tilted(carry, carry.tilt(there))}", _causes(motion, context), blocking=())
    about = f"'{carry.thing}' at most {math.degrees(carry.limit + SLACK):.0f} deg from upright ({PROPERTY})"
    if no := start_blocked(scene, belief.joints):
        raise Unresolvable(f"no path to {motion.to}: {no.reason}", blocking=no.blocking, collision=no.collision)
    for goal in goals:
        eased = scene.relaxed([belief.joints, goal])
        if _line_upright(context, carry, belief.joints, goal) and eased.line_free(belief.joints, goal):
            seconds = duration((belief.joints, goal), *pace)
            step = MoveJoints((goal,), *pace, origin=motion.name, comment=motion.reason)
            yield Grounding((step,), f"one line, {seconds:.1f} s, {about}", seconds / 100, belief.moved(goal), key=f"{goal}")
            break
    yield from _over(motion, place, belief, context, carry, scene, (here, there), about)


def _over(
    motion: Motion, place: Place, belief: Belief, context: Context, carry: Load, scene: PlanningScene, ends: tuple[Pose, Pose],
    about: str,
) -> Iterator[Grounding]:  # fmt: skip
    """Straight lines of the tcp, the first way that is free."""
    nearest, blocking = Refusal("none"), dict[str | tuple[str, ...], None]()
    for lift in LIFTS:
        for around in (False, True):
            corners = waypoints_over(*ends, carry.up, lift, around)
            found = _followed(corners, place, belief, context, carry, scene)
            if isinstance(found, Refusal):
                nearest, blocking = found, blocking | dict.fromkeys(found.blocking or ())
                continue
            steps = tuple(
                MoveLinear(pose, SPEED, ACCELERATION, q, origin=motion.name, comment=motion.reason)
                for pose, q in zip(corners, found, strict=True)
            )
            lengths = [a.distance(b)[0] for a, b in pairwise((ends[0], *corners))]
            seconds = sum(trapezoid(v, SPEED, ACCELERATION) for v in lengths)
            reason = f"{len(steps)} straight lines, {seconds:.1f} s, {about}"
            yield Grounding(steps, reason, 0.05 + seconds / 100, belief.moved(found[-1]), key=f"over {lift} {around}")
            return
    reason = f"no way to {motion.to} keeps {about}; the last one tried: {nearest.reason}"
    raise Unresolvable(reason, _causes(motion, context), blocking=tuple(blocking), collision=nearest.collision)


def waypoints_over(here: Pose, there: Pose, up: Sequence[float], lift: float, around: bool) -> list[Pose]:
    """Return the waypoints of a path up, over and down, the start left out; poses of the tcp in the base frame.

    Args:
        up: the vertical; a way around turns about the base's z axis.
        lift: above the higher end [m].
        around: keep the distance from the base's axis even, instead of going straight over.
    """
    heights = [float(np.dot(p.position, up)) for p in (here, there)]
    top = max(heights) + lift
    a, b = (_raised(p, up, top - h) for p, h in zip((here, there), heights, strict=True))
    corners = [a, *(_arc(a, b) if around else []), b, there]
    return [q for p, q in pairwise([here, *corners]) if max(p.distance(q)) > 1e-3]


def _raised(pose: Pose, up: Sequence[float], by: float) -> Pose:
    x, y, z = (float(p + by * u) for p, u in zip(pose.position, up, strict=True))
    return Pose((x, y, z), pose.quaternion)


def _arc(a: Pose, b: Pose) -> list[Pose]:
    """Corners between two poses with even angle about, and distance from, the base's z axis."""
    angles = [math.atan2(p.position[1], p.position[0]) for p in (a, b)]
    radii = [math.hypot(p.position[0], p.position[1]) for p in (a, b)]
    turn = math.remainder(angles[1] - angles[0], math.tau)
    count = max(1, math.ceil(abs(turn) / ARC))
    corners = []
    for k in range(1, count):
        part = k / count
        angle, radius, pose = angles[0] + part * turn, radii[0] + part * (radii[1] - radii[0]), interpolate(a, b, part)
        corners.append(Pose((radius * math.cos(angle), radius * math.sin(angle), pose.position[2]), pose.quaternion))
    return corners


def _followed(
    corners: list[Pose], place: Place, belief: Belief, context: Context, carry: Load, scene: PlanningScene
) -> list[Joints] | Refusal:
    """The joint position at each corner, or why the way cannot be gone, or does not lead straight on to the place."""
    here = forward(context.robot, belief.joints)
    worst = max(carry.tilt(p) for p in sampled(here, corners, *STEP))
    if worst > carry.limit:
        return Refusal(_tilted(carry, worst))
    for checked in (None, scene):  # whether the arm can follow is known sooner than whether it is free
        q, result = belief.joints, []
        for corner in corners:
            found = plan_straight_line(checked, context.robot, q, [corner], speed=SPEED)
            if isinstance(found, Refusal):
                return found
            q = found.points[-1]
            result.append(q)
    return why_no_straight_line(result[-1], place, context, None) or result


def _line_upright(context: Context, carry: Load, start: Joints, goal: Joints) -> bool:
    return all(carry.tilt(forward(context.robot, q)) <= carry.limit for q in resampled((start, goal), STEP[1]).tolist())


def _tilted(carry: Load, angle: float) -> str:
    most = math.degrees(carry.limit + SLACK)
    return f"'{carry.thing}' would be tilted by {math.degrees(angle):.0f} deg > {most:.0f} deg ({PROPERTY})"


def _causes(motion: Motion, context: Context) -> tuple[str, ...]:
    """The place, and everything that the hand was led to before: how the load is held and where the arm starts."""
    places = tuple(name for name, value in context.bindings.items() if isinstance(value, Place))
    return (*places, *((motion.to.name,) if motion.to else ()))

"""Transfers under an orientation constraint: a joint-space line if it keeps the load upright, else straight
tcp lines.

How far a load may tilt is knowledge (``cram:tiltLimitDeg`` of its class). A sampling planner hardly ever
stays in so thin a set; straight lines between upright poses stay in it by themselves, on the branch that the
arm is on. They lead up, over and down: straight over, or around the robot's base, as high as it takes; and
where something hangs over the end, down before that, nearer to the robot, and on to it. Joint-space lines
between points of such a way are shortened and rounded off as other transfers are, as far as they keep the
load upright, too: they stop nowhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache, partial
from itertools import pairwise, product

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Motion, MoveLinear, Place, Pose, Robot, Value, vector3
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..kinematics.blends import Corner
from ..kinematics.forward import forward, well_conditioned
from ..kinematics.timing import duration, trapezoid
from .cartesian import JointPath, interpolate, plan_straight_line, sampled, why_no_straight_line
from .joint_move import joint_move
from .planner import resampled, start_blocked
from .planning_scene import PlanningScene
from .round_off import blend_radii
from .shorten import shortened
from .space import Joints, refusal

PROPERTY = "cram:tiltLimitDeg"
LIFTS = (0.0, 0.1, 0.2, 0.3)  # how far above the higher end the load is carried [m], tried in this order
# How much nearer to the robot the load comes down [m], tried in this order: the second is more than half of
# what hands carry
BEFORE = (0.0, 0.12)
ARC = 0.5  # between two corners of a way around the base, about its axis [rad]
STEP = 0.02, 0.05  # of the look at the tilt along a way [m, rad]; of a joint-space line the second
# Of the tcp [m/s, m/s2]: a level surface then tilts by atan(0.5 / 9.81) = 3 degrees
SPEED, ACCELERATION = 0.2, 0.5
# How far an executed tilt may be from a planned one: the servo's lag is below 7 mrad
SLACK = math.radians(0.5)


DEVIATION = 0.0005  # of chords on which a load is looked at from a blend's parabola, in any joint [rad]
QUICK = 0.0125, 0.05  # steps of the quick look whether a line can be followed [m, rad]
SHORTEST = 4  # samples of a straight line that one in joint space is tried beside: 20 mm
ATTEMPTS = 120  # tries to shorten a way in joint space


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
        """Angle between the payload's z axis and the vertical [rad], with the TCP at a pose."""
        return float(math.acos(np.clip((tcp * self.in_tcp).rotate((0.0, 0.0, 1.0)) @ self.up, -1.0, 1.0)))


class UprightScene(Value):
    """Planner's space of joint positions in which a load is upright, and which are off singularities if the
    robot requires it.

    Args:
        scene: in which collisions are looked for.
        carry: the load.
    """

    scene: PlanningScene
    carry: Load

    def line_free(self, a: Sequence[float] | Floats, b: Sequence[float] | Floats) -> bool:
        """Check whether the straight joint-space line from a free position is free, and the load upright
        all along it."""
        return all(
            map(self._keeps, resampled((tuple(a), tuple(b)), STEP[1]).tolist())
        ) and self.scene.line_free(a, b)

    def blend_free(self, start: Floats, corner: Floats, goal: Floats) -> bool:
        """Check whether the parabola between two free positions is free, and the load upright all along
        it."""
        curve = Corner(start, corner, goal, 1.0).sampled(DEVIATION)
        places = resampled([tuple(q.tolist()) for q in curve], STEP[1])
        return all(map(self._keeps, places.tolist())) and self.scene.blend_free(start, corner, goal)

    def tip(self, q: Sequence[float] | Floats) -> Floats:
        """Return the position (3,) of the tcp [m]."""
        return self.scene.tip(q)

    def _keeps(self, q: Sequence[float]) -> bool:
        robot = self.scene.robot
        return self.carry.tilt(forward(robot, q)) <= self.carry.limit and well_conditioned(robot, q)


def load(belief: Belief, context: Context) -> Load | None:
    """Return the payload if its class limits its tilt, and that limit, or its present lean if larger; an
    upside-down payload has no limit."""
    if belief.held is None:
        return None
    thing = belief.world.thing(belief.held.thing)
    limits = [float(v) for v in context.taxonomy.fillers(thing.type, PROPERTY)]
    if not limits:
        return None
    up = vector3(belief.base().inverse().rotate((0.0, 0.0, 1.0)))
    found = Load(thing.name, math.radians(min(limits)) - SLACK, belief.held.tcp_to_thing, up)
    now = found.tilt(forward(context.robot, belief.joints))
    return replace(found, limit=max(found.limit, now + SLACK)) if now <= math.pi / 2 else None


def carried(
    motion: Motion, place: Place, belief: Belief, context: Context, carry: Load, scene: PlanningScene,
    goals: Sequence[Joints], pace: tuple[float, float],
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
        raise Unresolvable(
            f"at the stand-off of {motion.to} {_tilted(carry, carry.tilt(there))}",
            _causes(motion, context),
            blocking=(),
        )
    about = f"'{carry.thing}' at most {math.degrees(carry.limit + SLACK):.0f} deg from upright ({PROPERTY})"
    if no := start_blocked(scene, belief.joints):
        raise Unresolvable(
            f"no path to {motion.to}: {no.reason}", blocking=no.blocking, collision=no.collision
        )
    for goal in goals:
        eased = scene.relaxed([belief.joints, goal])
        if UprightScene(eased, carry).line_free(belief.joints, goal):
            step = joint_move(motion, context.robot, (belief.joints, goal), pace)
            seconds = duration((belief.joints, goal), step.speed, step.acceleration)
            yield Grounding(
                (step,),
                f"one line, {seconds:.1f} s, {about}",
                seconds / 100,
                belief.moved(goal),
                key=f"{goal}",
            )
            break
    yield from _over(motion, place, belief, context, carry, scene, (here, there), about, pace)


def _over(
    motion: Motion, place: Place, belief: Belief, context: Context, carry: Load, scene: PlanningScene,
    ends: tuple[Pose, Pose], about: str, pace: tuple[float, float],
) -> Iterator[Grounding]:  # fmt: skip
    """Yield motions on the first free path that lifts a load, carries it across and lowers it: one with
    rounded corners, and one of straight lines of the tcp."""
    nearest, blocking = refusal("none"), dict[str | tuple[str, ...], None]()
    for before, lift, around in product(BEFORE, LIFTS, (False, True)):
        corners = waypoints_over(*ends, carry.up, lift, around, before)
        found = _followed(corners, place, belief, context, carry, scene)
        if isinstance(found, Refused):
            nearest, blocking = found, blocking | dict.fromkeys(found.blocking or ())
            continue
        yield from _rounded_off(motion, belief, context, carry, scene, found, about, pace)
        steps = tuple(
            MoveLinear(pose, SPEED, ACCELERATION, line[-1], origin=motion.name, comment=motion.reason)
            for pose, line in zip(corners, found, strict=True)
        )
        lengths = [a.distance(b)[0] for a, b in pairwise((ends[0], *corners))]
        seconds = sum(trapezoid(v, SPEED, ACCELERATION) for v in lengths)
        reason = f"{len(steps)} straight lines, {seconds:.1f} s, {about}"
        yield Grounding(
            steps,
            reason,
            0.05 + seconds / 100,
            belief.moved(found[-1][-1]),
            key=f"over {lift} {around} {before}",
        )
        return
    reason = f"no way to {motion.to} keeps {about}; the last one tried: {nearest.reason}"
    raise Unresolvable(
        reason, _causes(motion, context), blocking=tuple(blocking), collision=nearest.collision
    )


@lru_cache(maxsize=256)
def _quickly(robot: Robot, q: Joints, corner: Pose) -> JointPath | Refused:
    """Plan a path along a straight line in coarse steps, with no regard to obstacles; or return the refusal.

    Answers are cached, since the ways to many places begin alike.
    """
    return plan_straight_line(None, robot, q, [corner], speed=SPEED, step_m=QUICK[0], step_rad=QUICK[1])


def _closely(scene: PlanningScene, robot: Robot, q: Joints, corner: Pose) -> JointPath | Refused:
    return plan_straight_line(scene, robot, q, [corner], speed=SPEED)


def _rounded_off(
    motion: Motion, belief: Belief, context: Context, carry: Load, scene: PlanningScene,
    lines: Sequence[Sequence[Joints]], about: str, pace: tuple[float, float],
) -> Iterator[Grounding]:  # fmt: skip
    """Yield one joint-space motion close to straight lines of the tcp, if such a motion keeps the payload
    upright.

    Args:
        lines: joint positions along each of them.
    """
    space = UprightScene(scene.relaxed([belief.joints, lines[-1][-1]]), carry)
    points: list[Joints] = [belief.joints]
    for line in lines:
        chords = _chords(space, line)
        if chords is None:
            return
        points += chords
    path = shortened(space, tuple(points), *pace, seed=context.seed, attempts=ATTEMPTS)
    radii, seconds = blend_radii(space, path, *pace)
    step = joint_move(motion, context.robot, path, pace, radii)
    seconds *= pace[0] / step.speed
    reason = (
        f"{len(radii)} corners, the arm stops at {sum(r == 0 for r in radii)} of them, {seconds:.1f} s, "
        f"{about}"
    )
    yield Grounding((step,), reason, 0.02 + seconds / 100, belief.moved(path[-1]), key="rounded off")


def _chords(space: UprightScene, line: Sequence[Joints]) -> list[Joints] | None:
    """Reduce joint positions along a line to few, joined by straight joint-space lines that are free; None if
    it takes too many."""
    if space.line_free(line[0], line[-1]):
        return [line[-1]]
    middle = len(line) // 2
    if middle < SHORTEST:
        return None
    halves = _chords(space, line[: middle + 1]), _chords(space, line[middle:])
    return None if halves[0] is None or halves[1] is None else [*halves[0], *halves[1]]


def waypoints_over(
    here: Pose, there: Pose, up: Sequence[float], lift: float, around: bool, before: float = 0.0
) -> list[Pose]:
    """Return the waypoints of a transfer up, across and down: poses of the tcp in the base frame, the start
    left out.

    Args:
        up: the vertical; a way around turns about the base's z axis.
        lift: above the higher end [m].
        around: keep the distance from the base's axis even, instead of going straight over.
        before: how much nearer to the base's axis it comes down [m].
    """
    low = _nearer(there, before)
    heights = [float(np.dot(p.position, up)) for p in (here, low)]
    top = max(heights) + lift
    a, b = (_raised(p, up, top - h) for p, h in zip((here, low), heights, strict=True))
    corners = [a, *(_arc(a, b) if around else []), b, low, there]
    return [q for p, q in pairwise([here, *corners]) if max(p.distance(q)) > 1e-3]


def _raised(pose: Pose, up: Sequence[float], by: float) -> Pose:
    x, y, z = (float(p + by * u) for p, u in zip(pose.position, up, strict=True))
    return Pose((x, y, z), pose.quaternion)


def _nearer(pose: Pose, by: float) -> Pose:
    """Return a pose shifted horizontally towards the base's z axis by a distance [m]."""
    x, y, z = pose.position
    share = 1.0 - by / max(math.hypot(x, y), by, 1e-9)
    return Pose((share * x, share * y, z), pose.quaternion)


def _arc(a: Pose, b: Pose) -> list[Pose]:
    """Return poses between two poses, evenly spaced in their angle about the base's z axis and their distance
    from it."""
    angles = [math.atan2(p.position[1], p.position[0]) for p in (a, b)]
    radii = [math.hypot(p.position[0], p.position[1]) for p in (a, b)]
    turn = math.remainder(angles[1] - angles[0], math.tau)
    count = max(1, math.ceil(abs(turn) / ARC))
    corners = []
    for k in range(1, count):
        part = k / count
        angle, radius, pose = (
            angles[0] + part * turn,
            radii[0] + part * (radii[1] - radii[0]),
            interpolate(a, b, part),
        )
        corners.append(
            Pose((radius * math.cos(angle), radius * math.sin(angle), pose.position[2]), pose.quaternion)
        )
    return corners


def _followed(
    corners: list[Pose], place: Place, belief: Belief, context: Context, carry: Load, scene: PlanningScene
) -> list[Sequence[Joints]] | Refused:
    """Follow straight lines from corner to corner of a path; return the joint positions, or why the arm
    cannot follow the lines and go on to the place."""
    here = forward(context.robot, belief.joints)
    worst = max(carry.tilt(p) for p in sampled(here, corners, *STEP))
    if worst > carry.limit:
        return refusal(_tilted(carry, worst))
    for follow in (
        _quickly,
        partial(_closely, scene),
    ):  # whether the arm can follow is known sooner than whether it is free
        q, result = belief.joints, list[Sequence[Joints]]()
        for corner in corners:
            found = follow(context.robot, q, corner)
            if isinstance(found, Refused):
                return found
            q = found.points[-1]
            result.append(found.points)
    return why_no_straight_line(q, place, context, None) or result


def _tilted(carry: Load, angle: float) -> str:
    most = math.degrees(carry.limit + SLACK)
    return f"'{carry.thing}' would be tilted by {math.degrees(angle):.0f} deg > {most:.0f} deg ({PROPERTY})"


def _causes(motion: Motion, context: Context) -> tuple[str, ...]:
    """Names of the choices that a transfer depends on: its place, and all earlier places, which decide how
    the load is held and where the arm starts."""
    places = tuple(name for name, value in context.bindings.items() if isinstance(value, Place))
    return (*places, *((motion.to.name,) if motion.to else ()))

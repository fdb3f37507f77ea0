"""Cartesian paths: straight motions of the tcp, inverse kinematics followed along the line on one branch.

The controller drives a straight line of the tcp with an even rotation about one axis (movel), so
the line is sampled in the same way (Shoemake, Animating rotation with quaternion curves, 1985)
and each sample is solved by Newton's method from the one before: the branch cannot change
without a jump, and a jump is refused.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from operator import add, sub
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from cramlite.model import (
    Belief,
    Motion,
    Place,
    Pose,
    Robot,
    Value,
    Vector3,
    quaternion_product,
    rotvec_quaternion,
    thing_of,
)
from cramlite.plugin import Context, Refused, Unresolvable, checkpoint

from ..kinematics.forward import Joints, conditioning, forward
from ..kinematics.inverse import nearest_branch, unturned
from ..kinematics.reach import out_of_limits, reach_shortfall
from ..kinematics.timing import joint_speed_excess, leading
from .space import refusal

if TYPE_CHECKING:
    from .planning_scene import PlanningScene

HAND = "effector"
"""Name of the hand in collisions; its parts have names such as "effector/left"."""
SAME = 0.001, 0.01  # a pose is reached already within this [m, rad]
# Steps of the quick look whether a line can follow [m, rad]; the line itself is checked finely
COARSE = (0.025, 0.1)


def why_no_straight_line(joints: Any, place: Place, context: Context, scene: Any) -> Refused | None:
    """Return why the arm cannot go straight from the stand-off to the place without a jump in its joints;
    None if it can.

    An empty hand must also be free there, but for the thing of the place; where something is held, what it
    may touch on its way is up to the motion that follows.
    """
    if near(place.before, place.pose):
        return None
    line = plan_straight_line(
        scene, context.robot, joints, [*place.via, place.pose], step_m=COARSE[0], step_rad=COARSE[1]
    )
    return line if isinstance(line, Refused) else None


def line(motion: Motion, belief: Belief, context: Context, targets: list[Pose]) -> Any:
    """Plan straight lines of the tcp from where it is through targets in the base frame; joint positions,
    checked [rad].

    Raises:
        Unresolvable: out of reach, singular, or something is in the way.
    """
    found = free_line(motion, belief, context, targets, belief)
    if isinstance(found, Refused):
        said = f"no straight line to {motion.to}: {found.reason}"
        raise _refused(said, motion, belief, context, found)
    return found.points


def free_line(
    motion: Motion, belief: Belief, context: Context, targets: list[Pose], left: Belief
) -> JointPath | Refused:
    """Plan straight lines of the tcp through targets that are free of collision; where none are, what touches
    the payload at the start may be pushed off it.

    Args:
        left: belief with the payload as it is at the start.
    """
    from .reach import make_scene, pushed_off, touched

    touch = touched(motion.may_touch, context)
    scene = make_scene(belief, context, touch, clearance=0.0)
    found = plan_straight_line(scene, context.robot, belief.joints, targets)
    if not isinstance(found, Refused) or not (pushes := pushed_off(left, context)):
        return found
    scene = make_scene(belief, context, touch, clearance=0.0, pushes=pushes)
    pushing = plan_straight_line(scene, context.robot, belief.joints, targets)
    return found if isinstance(pushing, Refused) else pushing


def _refused(said: str, motion: Motion, belief: Belief, context: Context, no: Refused) -> Unresolvable:
    """Refusal of a straight line that blames only those earlier choices that can have caused it.

    If hand or payload meets an obstacle, the arm's way to the line is not to blame; if a door or a drawer
    meets one, nor is the place of the hand on it.
    """
    pair = no.collision.pair if no.collision else ()
    if motion.to is None or no.collision is None or any(thing_of(n) == no.collision.robot for n in pair):
        return no.impossible(said)
    things = {thing_of(n) for n in pair}
    on_joint = (
        {t.name for t in belief.world.things if t.joint is not None} & things if HAND not in things else set()
    )
    places = (
        n
        for n, v in context.bindings.items()
        if isinstance(v, Place) and (n == motion.to.name or v.thing not in on_joint)
    )
    objects = (n for n, v in context.bindings.items() if isinstance(v, str))
    return Unresolvable.because_of_earlier_tasks(
        said, (*places, *objects), blocking=no.blocking, collision=no.collision, remedy=no.remedy
    )


def near(a: Pose, b: Pose) -> bool:
    """Check whether two poses are so close, within ``SAME``, that no motion between them is needed."""
    metres, radians = a.distance(b)
    return metres < SAME[0] and radians < SAME[1]


JUMP = 0.25  # a joint that turns further between two samples passes a singularity [rad]
LEAST = 0.03
"""Smallest singular value that a straight motion keeps: below it the controller, which starts a little off
the plan and gives way to forces, finds no inverse solution some millimetres aside. Of ten programs that
thread a product onto a hanger those with 0.017 and less needed up to four attempts, those with 0.08 and
more none (tests/benchmarks/hang_onto_hanger.py)."""


class JointPath(Value):
    """Joint positions along a straight motion of the TCP.

    Args:
        points: joint positions, start included [rad].
        ways: how far the tcp has come at each of them [m].
    """

    points: tuple[Joints, ...]
    ways: tuple[float, ...]

    @property
    def length(self) -> float:
        """Return the path length of the tcp [m]."""
        return self.ways[-1]


def interpolate(a: Pose, b: Pose, part: float) -> Pose:
    """Interpolate two poses at a fraction of the way: straight line and even rotation the short way round."""
    return _between(a, b, (a.inverse() * b).rotvec, part)


def _between(a: Pose, b: Pose, turn: Vector3, part: float) -> Pose:
    x, y, z = (v + part * (w - v) for v, w in zip(a.position, b.position, strict=True))
    return Pose((x, y, z), quaternion_product(a.quaternion, rotvec_quaternion([part * v for v in turn])))


def sampled(start: Pose, targets: Sequence[Pose], step_m: float, step_rad: float) -> list[Pose]:
    """Sample poses on the straight lines from a start through targets, neighbours at most a step apart; the
    start is left out."""
    result: list[Pose] = []
    for a, b in pairwise((start, *targets)):
        metres, radians = a.distance(b)
        count = max(1, math.ceil(metres / step_m - 1e-9), math.ceil(radians / step_rad - 1e-9))
        turn = (a.inverse() * b).rotvec
        result.extend(b if k == count else _between(a, b, turn, k / count) for k in range(1, count + 1))
    return result


def plan_straight_line(
    scene: PlanningScene | None,
    robot: Robot,
    start: Sequence[float],
    targets: Pose | Sequence[Pose],
    *,
    speed: float | None = None,
    step_m: float = 0.005,
    step_rad: float = 0.02,
) -> JointPath | Refused:
    """Plan a straight motion of the tcp from a joint position through one pose or several.

    Args:
        scene: checks every step for collisions, near start and end with the clearance that these have;
            None leaves that out.
        start: joint position [rad].
        targets: of the tcp in the base frame.
        speed: of the tcp [m/s]: no joint may have to exceed its limit for it; None is not checked.
        step_m, step_rad: of the samples [m, rad].

    Returns:
        The path, or a refusal with the fraction of the way that was reached and the reason there: reach,
        singularity, joint limit, joint speed or collision.
    """
    checkpoint()
    origin = tuple(float(v) for v in start)
    begin = forward(robot, unturned(origin))
    goals = sampled(begin, [targets] if isinstance(targets, Pose) else targets, step_m, step_rad)
    points, reason = _follow(robot, origin, goals)
    if not reason and speed is not None:
        reason = joint_speed_excess(robot, points, _ways(begin, goals), speed)
        if reason:
            reason = f"straight motion at {speed:.3f} m/s needs {reason}"
    ways = _ways(begin, goals)
    if scene is not None and (stopped := _stopped(scene, points)):
        reached, no = stopped
        return _refusal(no, reached, len(goals), ways)
    if reason:
        return _refusal(refusal(reason), len(points), len(goals), ways)
    return JointPath(tuple(points), tuple(ways))


def _ways(begin: Pose, goals: Sequence[Pose]) -> list[float]:
    ways = [0.0]
    for a, b in pairwise((begin, *goals)):
        ways.append(ways[-1] + math.dist(a.position, b.position))
    return ways


def _refusal(why: Refused, reached: int, total: int, ways: Sequence[float]) -> Refused:
    done = max(0, reached - 1)
    where = f"straight motion stops after {ways[done] * 1e3:.0f} of {ways[-1] * 1e3:.0f} mm"
    return replace(why, reason=f"{where}: {why.reason}", numbers={"fraction": done / total})


def _follow(robot: Robot, origin: Joints, goals: Sequence[Pose]) -> tuple[list[Joints], str]:
    """Joint positions up to the first pose that cannot be reached, and why it cannot."""
    if reason := out_of_limits(robot, origin):
        return [origin], reason
    near = unturned(origin)
    led, reason = _led(robot, near, tuple(goals))
    turns = tuple(map(sub, origin, near))
    points = [origin, *(tuple(map(add, q, turns)) for q in led)]
    outside = next((k for k, q in enumerate(points) if out_of_limits(robot, q)), None)
    return (points, reason) if outside is None else (points[:outside], out_of_limits(robot, points[outside]))


@lru_cache(maxsize=64)
def _led(robot: Robot, origin: Joints, goals: tuple[Pose, ...]) -> tuple[tuple[Joints, ...], str]:
    """Joint positions at the poses of a line up to the first that cannot be reached, and why it cannot;
    limits are not checked. Cached, since inverse solutions that differ by whole turns are led alike."""
    points = [origin]
    for pose in goals:
        checkpoint()
        found = nearest_branch(robot, pose, points[-1])
        if found is None:
            return tuple(points[1:]), reach_shortfall(robot, pose) or _singular(robot, points[-1])
        if (turn := leading(points[-1], found)) > JUMP:
            said = f"a joint would turn {turn:.2f} rad within one step, {_singular(robot, found)}"
            return tuple(points[1:]), said
        if conditioning(robot, found) < _least(robot):
            return tuple(points[1:]), _singular(robot, found)
        points.append(found)
    return tuple(points[1:]), ""


def _least(robot: Robot) -> float:
    return max(LEAST, robot.conditioning)


def _singular(robot: Robot, q: Joints) -> str:
    return f"near a singularity (smallest singular value {conditioning(robot, q):.4f}, limit {_least(robot)})"


def _stopped(scene: PlanningScene, points: Sequence[Joints]) -> tuple[int, Refused] | None:
    """Return how many joint positions come before the first collision of a path, with its refusal; None for a
    free path.

    The refusal names the things that must be moved.
    """
    eased = scene.relaxed([points[-1]], start=points[0])
    for k, (a, b) in enumerate(pairwise(points)):
        checkpoint()
        part = eased.blocked(a, b)
        if part is not None:
            at = [x + part * (y - x) for x, y in zip(a, b, strict=True)]
            blocking = tuple(filter(None, [eased.blocking(at)]))
            return k + 1, refusal(eased.why(at), blocking=blocking, collision=eased.collision(at))
    return None

"""Free-space motions: transfers planned in joint space, and straight lines of the TCP."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import TOOL_SPEED, Belief, Motion, MoveLinear, Place, Pose, Stage
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

from ..kinematics.forward import Joints
from ..kinematics.timing import STEADY, steady_speed
from ..kinematics.tool_speed import KEPT
from ..motion_planning.cartesian import line, near, why_no_straight_line
from ..motion_planning.too_far import no_inverse
from ..shapes.carried_along import pushed_along
from .motion_kinds import value, word
from .ontology_limits import adapted, noted

Groundings = Iterator[Grounding]
# The acceleration of paced motions whose speed is said grows with the square root of the pace: an arm that is led by its tool goes too far
# where its elbow is folded, by 5 mm with 0.5 m/s2 and by 7 mm with 1.25 m/s2.
GOALS = 6  # nearest inverse solutions that a transfer may end at


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve transfers and linear motions; None for other kinds."""
    kinds = {"transfer": _transfer, "linear": _linear}
    kind = kinds.get(motion.kind)
    return kind(adapted(motion, belief, context), belief, context) if kind else None


def _transfer(motion: Motion, belief: Belief, context: Context) -> Groundings:
    """Resolve a transfer: a joint-space motion to the stand-off of a place, one for each inverse solution
    that leads straight on to the place."""
    from ..motion_planning.joint_move import joint_move
    from ..motion_planning.reach import make_scene, tcp
    from ..motion_planning.upright import carried, load
    from ..motion_planning.with_room import planned

    place, here = place_of(motion, context), tcp(belief, context)
    if near(here, place.before) or near(here, place.pose):
        yield Grounding((), "the arm is there already", key="there")
        return
    scene = make_scene(belief, context)
    if (stuck := _stuck(motion, scene, belief, context)) is not None:
        raise stuck
    goals, attempt, (speed, acceleration) = _goals(motion, place, belief, context, scene), 0, _pace(motion, context)
    if not place.reorients and (upright := load(belief, context)) is not None:
        try:
            yield from carried(motion, place, belief, context, upright, scene, goals, (speed, acceleration))
            return
        except Unresolvable:
            if belief.held is None or belief.held.swing is None:
                raise  # what hangs in the hand leans anyway, and carries nothing
    again = list[Any]()
    while goals or again:
        goals, again = (goals, again) if goals else (again, [])
        found, kept = planned(scene, belief, context, goals, seed=context.seed + attempt, speed=speed, acceleration=acceleration)
        if isinstance(found, Refused) and again:
            goals = []
            continue
        if isinstance(found, Refused):
            said = f"no path to {motion.to}: {found.reason}"
            raise Unresolvable(said, blocking=found.blocking, collision=found.collision)  # where the arm starts matters too
        end = found.points[-1]
        step = joint_move(motion, context.robot, found.points, (speed, acceleration), found.radii)
        seconds = found.duration * speed / step.speed
        stops = sum(r == 0 for r in found.radii)
        corners = f"{len(found.radii)} corners, the arm stops at {stops} of them, " if found.radii else "one line, "
        reason = f"{corners}{seconds:.1f} s, {found.samples} samples, {kept}{noted(motion)}"
        cost, key = attempt + found.duration / 100, f"{attempt}:{end}"
        yield Grounding((step,), reason, cost, belief.moved(end), key=key, anew=True)
        left, attempt = [g for g in goals if math.dist(g, end) > 0.1], attempt + 1
        goals, again = [g for g in left if not _turned(g, end)], again + [g for g in left if _turned(g, end)]


def _stuck(motion: Motion, scene: Any, belief: Belief, context: Context) -> Unresolvable | None:
    """Return why an arm that has not moved yet cannot begin to, wherever it is led and however far its fingers open; None if it can."""
    from ..motion_planning.planner import start_blocked

    if belief.joints != context.mount.joints or (no := start_blocked(scene, belief.joints)) is None:
        return None
    low, high = context.robot.gripper.opening
    if any(start_blocked(scene.opened(width), belief.joints) is None for width in ((low + high) / 2, high)):
        return None
    said = f"no path to {motion.to}: {no.reason}"
    return Unresolvable.because_of_earlier_tasks(said, blocking=no.blocking, collision=no.collision)


def _turned(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two joint positions differ by whole turns only, so that the arm has the same posture in both.

    Such a position is tried last, since it mostly fails like the other one.
    """
    return all(abs(math.remainder(a - b, 2 * math.pi)) < 0.1 for a, b in zip(one, other, strict=True))


def _pace(motion: Motion, context: Context) -> tuple[float, float]:
    """Return a speed and an acceleration that keep every joint within its limits, whichever joint moves farthest.

    Of a speed limit only the share ``STEADY`` is used, as an arm that is streamed to catches up in steps.
    """
    pace = context.robot.pace
    speed, acceleration = pace * value(motion, "speed_rad_s"), pace * value(motion, "acceleration_rad_s2")
    return min(speed, *(STEADY * v for v in context.robot.velocity)), min(acceleration, *context.robot.acceleration)


def _goals(motion: Motion, place: Place, belief: Belief, context: Context, scene: Any) -> list[Any]:
    """Collision-free joint positions at the stand-off from which the arm can go on in a straight line to the place."""
    from ..kinematics.inverse import inverse, postures, unturned, why_no_inverse
    from ..motion_planning.planner import in_the_way
    from ..motion_planning.reach import make_scene
    from ..motion_planning.space import refusal

    if place.joints is not None:
        return [place.joints]
    around = None if belief.held else make_scene(belief, context, [place.thing], place.opening, clearance=0.0)
    solutions = inverse(context.robot, place.before, seed=belief.joints)
    room = {posture: scene.free(q) for posture, q in postures(solutions).items()}
    free = [q for q in solutions if room[unturned(q)]]
    goals, lines = _first_led((q, why_no_straight_line(q, place, context, around)) for q in free)
    if not goals:
        if not solutions:
            miss = refusal(why_no_inverse(context.robot, place.before), remedy=no_inverse(context.robot, place.before))
        else:
            miss = lines[0] if lines else refusal(scene.why(solutions[0]), collision=scene.collision(solutions[0]))
        count = f"{len(solutions)} inverse solutions at the stand-off of {motion.to}, {len(free)} of them free"
        blocking = (*in_the_way(scene, [q for q in solutions if q not in free]), *(b for no in lines for b in no.blocking or ()))
        said = f"{count}, from none of which a straight line leads to the place; the nearest miss: {miss.reason}"
        raise Unresolvable(
            said, because(motion, belief, context), blocking=tuple(dict.fromkeys(blocking)), collision=miss.collision, remedy=miss.remedy
        )
    return goals


def _first_led(looked: Iterable[tuple[Joints, Refused | None]]) -> tuple[list[Joints], list[Refused]]:
    """The first joint positions that lead on, at most ``GOALS``, and the refusals of those before."""
    goals, refused = list[Joints](), list[Refused]()
    for q, no in looked:
        if no is not None:
            refused.append(no)
            continue
        goals.append(q)
        if len(goals) == GOALS:
            break
    return goals, refused


def _linear(motion: Motion, belief: Belief, context: Context) -> Groundings:
    from ..motion_planning.reach import tcp

    place, here = place_of(motion, context), tcp(belief, context)
    end = (place.pose, *place.path)[-1]
    stages = {Stage.BEFORE: (place.before,), Stage.VIA: place.via, Stage.POSE: (*place.via, place.pose), Stage.END: (end,)}
    ways = stages[word(motion, "stage", Stage, Stage.POSE)]
    steps, after, length = list[MoveLinear](), belief, 0.0
    for target in ways if not ways or not near(here, ways[-1]) else ():
        length += tcp(after, context).distance(target)[0]
        steps.append(_straight(motion, target, after, context))
        after = after.moved(steps[-1].joints)
    if steps:
        reason = f"straight {1000 * length:.0f} mm, free of collision{noted(motion)}"
        there = pushed_along(belief, place) if ways[-1] == end else belief  # before the path of a push nothing is pushed
        yield Grounding(tuple(steps), reason, 0.0, there.moved(after.joints), key="line")
    else:
        yield Grounding((), "the tool is there already", key="there")


def _straight(motion: Motion, target: Pose, belief: Belief, context: Context) -> MoveLinear:
    """Straight line of the TCP from its present pose."""
    from ..motion_planning.reach import tcp

    points, way = line(motion, belief, context, [target]), tcp(belief, context).distance(target)[0]
    bare = "speed_m_s" not in motion.parameters
    pace = context.robot.pace if bare or value(motion, "paced") else 1.0
    slow, acceleration = value(motion, "speed_m_s"), (pace if bare else math.sqrt(pace)) * value(motion, "acceleration_m_s2")
    fast = max(slow, value(motion, "free_m_s")) if pace > 1.0 else slow
    quick = min(pace * fast, max(slow, KEPT * TOOL_SPEED))
    speed = steady_speed(context.robot, points, way, quick, slow)
    return MoveLinear(target, speed, acceleration, points[-1], origin=motion.name, comment=motion.reason)


def place_of(motion: Motion, context: Context) -> Place:
    """Return the place that a motion's location was resolved to."""
    assert motion.to is not None, f"motion '{motion.name}' needs a location"
    place: Place = context.bindings[motion.to.name]
    return _offset_across(place, motion.parameters["aside_m"]) if "aside_m" in motion.parameters else place


def _offset_across(place: Place, aside: tuple[float, float]) -> Place:
    """Return a place that is shifted to the left and up [m], as seen along its direction of approach."""
    from ..motion_planning.reach import shift

    up = np.array([0.0, 0.0, 1.0])
    left = np.cross(up, place.approach)
    by = aside[0] * left + aside[1] * np.cross(place.approach, left)
    return replace(place, pose=shift(place.pose, by), before=shift(place.before, by), path=tuple(shift(p, by) for p in place.path))


def because(motion: Motion, belief: Belief, context: Context) -> tuple[str, ...]:
    """Return the choices that a motion's failure is blamed on: the place that it leads to, and the grasps of
    loose things before it."""
    loose = {thing.name for thing in belief.world.things if thing.joint is None}
    grasps = tuple(n for n, v in context.bindings.items() if isinstance(v, Place) and v.grip is not None and v.thing in loose)
    return ((motion.to.name,) if motion.to else ()) + grasps

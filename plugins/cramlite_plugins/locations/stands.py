"""Base placements of a mobile robot near a thing, such that the arm reaches the things of the next tasks, and
sees them.

Places around the target are taken in the order of their cost: the way there, and how far they are from the
distance at which an arm works best. Each is refused, with the reason, unless the whole robot stands clear of
everything with its arm as it is, is at the destination, reaches every target from there (a grasp of what can
be taken with an empty hand, else a point over it), and, where it has a camera on its flange, can bring that
to a view of the target that nothing blocks.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator

import numpy as np

from cramlite.model import Belief, Location, Pose, Stand, Value, Vector3, thing_of
from cramlite.plugin import Answer, Context, Grounding, Refused, Unresolvable

from ..motion_planning.base_planner import CLEARANCES, Ground, at, level
from ..motion_planning.reach import bound
from ..motions.driving import floor_of
from ..predicates.places import BESIDE, apart
from ..shapes.bounds import box_around
from .grasps import grasps
from .reached import Arm, Candidate, Leg, reached
from .viewpoints import views

DISTANCES = (0.45, 0.55, 0.65, 0.75)  # of the arm's axis from the target [m]
BEST = 0.60  # two thirds of a UR5e's reach with its gripper pointing down [m]
# Places around, and where the target is from ahead [deg]
BEARINGS, ASIDE = 16, (0.0, 30.0, -30.0, 90.0, -90.0)
PER_METRE, PER_RADIAN = 0.10, 0.05  # cost of the way there and of a target that is not ahead
GRASPS = 12  # number of grasps of one thing that are tried at one stand
OVER, TURNS = 0.15, 8  # of the tool over a target that is not grasped [m], and about the vertical
EDGE = 0.10  # such a target is the nearest point of its box that is so far from the edge [m]
DRIVES = "soma:Navigating"
FEATURES = ("vrps:Peg", "cram:Cavity", "cram:Handle")  # where a fixed thing is reached


class Target(Value):
    """Thing that the arm has to reach from the platform: the variable bound to it, its name, and whether it
    is to be grasped."""

    variable: str
    thing: str
    grasped: bool


def stands(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate poses of the platform from which the arm reaches a thing."""
    destination = thing_of(bound(context, location.of))
    if belief.held is not None and belief.held.thing == destination:
        raise Unresolvable(f"'{destination}' is in the gripper and moves with the platform")
    robot, floor = context.robot, floor_of(belief, context, CLEARANCES[0])
    targets = _targets(location, belief, context)
    here = robot.stand_of(belief.base())
    for cost, name, arm in _around(belief.base() * _middle(belief, targets[0]), belief.base()):
        stand = level(at(robot.stand_of(arm)))
        there = belief.driven(robot.arm_at(stand))
        passed, why = _checked(stand, there, destination, targets, floor, context)
        if why:
            yield Refused(name, why, passed)
            continue
        what = " and ".join(f"'{t.thing}'" for t in targets)
        seen = ", in view of its camera" if context.camera is not None and context.camera.mount else ""
        far = math.dist(here.position, stand.position)
        reason = f"{name}: {what} within reach{seen}, {far:.2f} m from here"
        yield Grounding(Stand(stand, destination), reason, cost, key=name)


def _targets(location: Location, belief: Belief, context: Context) -> list[Target]:
    """Things, at known places, of the tasks up to the next drive; the destination if there are none."""
    found: dict[str, Target] = {}
    for task in itertools.takewhile(lambda t: t.action.task != DRIVES, context.later):
        for role, entity in zip(task.action.roles.values(), task.entities.values(), strict=True):
            thing = thing_of(entity)
            if thing in belief.poses and thing not in found:
                graspable = belief.held is None and belief.world.thing(thing).movable
                grasped = graspable and not any(t.grasped for t in found.values())
                found[thing] = Target(role.name, thing, grasped)
    if found:
        return list(found.values())
    destination = thing_of(bound(context, location.of))
    return [Target(location.of or "", destination, belief.world.thing(destination).movable)]


def _around(target: Pose, base: Pose) -> list[tuple[float, str, Pose]]:
    """Places of the arm's base around a point, as (cost, name for people, pose), the cheapest first; the base
    stays level."""
    x, y, _ = target.position
    found = []
    for k, distance, aside in itertools.product(range(BEARINGS), DISTANCES, ASIDE):
        bearing = math.tau * k / BEARINGS
        place = (x + distance * math.cos(bearing), y + distance * math.sin(bearing), base.position[2])
        turn = bearing + math.pi - math.radians(aside)
        way = math.dist(place[:2], base.position[:2])
        cost = PER_METRE * way + abs(distance - BEST) + PER_RADIAN * abs(math.radians(aside))
        name = f"{distance:.2f} m away at {math.degrees(bearing):.0f} deg"
        name += f", target {aside:+.0f} deg aside" if aside else ""
        found.append((cost, name, Pose(place, (math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)))))
    return sorted(found, key=lambda f: (round(f[0], 6), f[1]))


def _checked(
    stand: Pose, there: Belief, destination: str, targets: list[Target], floor: Ground, context: Context
) -> tuple[int, str]:
    """Number of checks that a pose of the platform passes, and why it fails the next one; "" if it passes
    all."""
    if blocked := floor.hit(at(stand)):
        return 0, blocked
    if (gap := _gap(stand, destination, there, context)) > BESIDE:
        return 1, f"{gap:.2f} m from '{destination}' > {BESIDE:.2f} m"
    for target in targets:
        if why := (_grasp(target, there, context) if target.grasped else _over(target, there, context)):
            return 2, f"'{target.thing}' is not within reach: {why}"
    for target in targets:
        if why := _unseen(target, there, context):
            return 3, f"'{target.thing}' cannot be seen: {why}"
    return 4, ""


def _gap(stand: Pose, thing: str, there: Belief, context: Context) -> float:
    """Distance from the platform's outline to a thing's [m]."""
    assert context.robot.platform is not None
    x, y, _ = (side / 2 for side in context.robot.platform.size)
    return apart(stand, ((-x, -y, 0.0), (x, y, 0.0)), there.poses[thing].pose, _box(there, thing))


def _grasp(target: Target, there: Belief, context: Context) -> str:
    """Why the arm cannot grasp a thing from where its platform stands; "" where it can."""
    try:
        answers = itertools.islice(grasps(Location("", "grasp", target.variable), there, context), GRASPS)
        return _none(answers, "nothing offers a grasp of it")
    except Unresolvable as impossible:
        return impossible.reason


def _over(target: Target, there: Belief, context: Context) -> str:
    """Why the tool cannot be brought to just above a thing, or in front of it on the robot's side; ""
    where it can."""
    arm, point = Arm(there, context), np.asarray(_middle(there, target).position)
    ahead = np.array([point[0], point[1], 0.0]) / max(float(np.hypot(point[0], point[1])), 1e-6)
    turns = [(math.cos(a), math.sin(a), 0.0) for a in (math.tau * k / TURNS for k in range(TURNS))]
    tries = [((0.0, 0.0, -1.0), x) for x in turns]
    tries += [(tuple(ahead), x) for x in ((0.0, 0.0, 1.0), (ahead[1], -ahead[0], 0.0))]
    poses = (Pose.from_axes(tuple(point - OVER * np.asarray(approach)), approach, x) for approach, x in tries)
    return _none(reached((Candidate("over it", pose, (Leg(pose),)) for pose in poses), arm), "")


def _none(answers: Iterable[Answer], otherwise: str) -> str:
    """Return the reason of the first refusal if no answer is a grounding, or ``otherwise`` if there are no
    answers; "" if an answer is a grounding."""
    first = ""
    for answer in answers:
        if isinstance(answer, Grounding):
            return ""
        first = first or answer.reason
    return first or otherwise


def _middle(belief: Belief, target: Target) -> Pose:
    """Return the pose to reach for on a thing, in the arm's frame: its own if it can move; else that of its
    peg, opening or handle, or of its top."""
    thing, pose = belief.thing(target.thing), belief.pose(target.thing)
    if thing.movable:
        return pose
    part = next((f for kind in FEATURES if (f := thing.feature(kind))), None)
    if part is not None:
        return pose * part.pose
    low, high = (np.asarray(v) for v in _box(belief, target.thing))
    centre, inner = (low + high) / 2, np.maximum((high - low) / 2 - EDGE, 0.0)
    own = pose.inverse().apply((0.0, 0.0, 0.0))
    x, y, _ = np.clip(own, centre - inner, centre + inner)
    return pose * Pose((float(x), float(y), float(high[2])))


def _box(belief: Belief, thing: str) -> tuple[Vector3, Vector3]:
    """Lowest and highest corner of a thing, in its frame."""
    (a, b, c), (d, e, f) = (v.tolist() for v in box_around(belief.thing(thing).geoms))
    return (a, b, c), (d, e, f)


def _unseen(target: Target, there: Belief, context: Context) -> str:
    """Why the camera on the flange cannot be brought to a free view of a thing; "" where it can, or there
    is no such camera."""
    if context.camera is None or context.camera.mount is None:
        return ""
    return _none(views(Location("", "view", target.variable), there, context), "")

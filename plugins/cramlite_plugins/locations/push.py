"""Pushing poses: closed fingers beside one of a thing's faces, low, and then straight on."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Feature, Floats, Gripper, Joint, Joints, Location, Place, Pose, Thing
from cramlite.plugin import Context, Grounding, Refused, Unresolvable

from ..motion_planning.cartesian import COARSE, plan_straight_line
from ..motion_planning.reach import bound, causes, collision_free_ik, make_scene, reference_pose, shift, tcp
from ..shapes.bounds import support
from ..shapes.ray_casting import body, intervals, spans
from .antipodal import FINGER
from .handles import ajar, along_joint, check_way, lever, way_along
from .parameters import Along, InnerSide, asked

BEHIND, ALMOST = 0.05, 0.003  # from the face to the fingers at the stand-off, and where feeling begins [m]
NEARER = 0.02
"""The stand-off last of all [m]: 50 mm before the handle of a microwave's door that was open by 110 deg, towards the robot, its elbow was
folded too far."""
LAST = 10.0  # cost of what comes after all else
INSIDE = 0.025  # the stand-off behind a door that stands ajar, where there is less room [m]
LOW, UNDER_PALM = 0.015, 0.010  # finger tips above what carries the thing; the palm above the thing [m]

SPOTS = ((0.0, 0.0), (0.8, 0.0), (-0.8, 0.0), (0.0, 0.6), (0.8, 0.6), (-0.8, 0.6))
"""On a front: at its handle, towards its edges, and higher."""
TILTS, TURNS = (0.0, -30.0, -45.0, -60.0), (90.0, -90.0, 0.0, 180.0)
"""Of the hand before a front about the level line across it, from above, and about its own axis, its slim side up first [deg]."""
FROM_ABOVE = ((0.55, 0.8), (0.8, 0.8), (0.3, 0.8), (0.0, 0.8)), (-70.0, -90.0), tuple(45.0 * k for k in range(8))
AT_BAR = ((0.0, 0.6), (0.0, 0.75), *FROM_ABOVE[0]), FROM_ABOVE[1], (0.0, 90.0, 180.0, 270.0, 45.0, 135.0, 225.0, 315.0)
"""Spots, tilts and turns of a hand over the upper edge of a front, its fingers alone before it: last, for what turns so far that no hand
before it comes along. Not near its side first: fingers slid 30 mm along a door, over its edge, and caught on that when they left. Of a door
at its bar before, and with a flat side before a corner: beside the bar of a microwave's door, and at the round end of that, fingers slid
off it, 15 mm out along the door, and pressed on what is beside that. Higher on the bar where the elbow folds too far else: the hand gives
way, and was seen to rise by 10 mm."""
OVER_EDGE = tuple(itertools.product((0.3, 0.0, 0.5, 0.7), (0.8, 0.9))), (-60.0, -45.0, -75.0, -90.0), FROM_ABOVE[2]
"""The same of a hand behind a door that stands ajar: towards its hinge, where an arm that its handle leads too far away still reaches;
slanting first, so that it leaves its upper edge as it follows."""
NEAR_HINGE = 0.5
"""A hand that is nearer to a hinge than this share of its handle's distance pushes with more than twice the force, and turns as much on
half the way: it is tried last."""
OFF, FIRM = 0.008, 0.002
"""How far a hand may be from where it is planned on a front [m], and how much less far out it may then meet that: fingers that had a bar by
the last 10 mm of it, which is round, slid over its end, and came 45 mm farther in."""
DOWN = (-45.0, -35.0, -30.0)
"""The same of a hand that presses on a bar from above."""
UPRIGHT = 0.9


def beside(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate one place for each of the four upright faces, the one that is pushed straight away from the robot first."""
    entity = bound(context, location.of)
    thing, gripper = belief.thing(entity), context.robot.gripper
    if not thing.movable:
        raise Unresolvable(f"'{entity}' is fixed and cannot be pushed", (location.of or "",))
    pose, shut = reference_pose(belief, location, context), gripper.opening[0]
    free, near = make_scene(belief, context, (), shut), make_scene(belief, context, [thing.name], shut)
    up = np.array([0.0, 0.0, 1.0])
    low, top = -support(thing, pose, -up), support(thing, pose, up)
    height = max(low + LOW + gripper.pad[1] / 2, top + UNDER_PALM - gripper.depth)
    for k, way in enumerate(_ways(pose)):
        face = support(thing, pose, -way)  # along -way, from the base's origin
        centre = np.asarray(pose.position)
        point = centre - way * (face + float(centre @ way) + gripper.pad[0] / 2 + ALMOST)
        at = Pose.from_axes((float(point[0]), float(point[1]), height), (0, 0, -1), way)
        before, name = shift(at, -BEHIND * way), f"towards ({way[0]:+.2f} {way[1]:+.2f})"
        tried = (
            collision_free_ik(free, context, before, belief.joints),
            collision_free_ik(near, context, at, belief.joints),
        )
        no = next((r for r in tried if isinstance(r, Refused)), None)
        if no is not None:
            yield no.of(name)
        else:
            place = Place(at, before, shut, (float(way[0]), float(way[1]), 0.0), thing=thing.name)
            yield Grounding(place, f"'{entity}' {name}", 0.1 * k, key=name)


def before_front(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate closed fingers before what sticks out farthest of a drawer's or a door's front at its handle, straight or tilted."""
    entity = bound(context, location.of)
    thing, handle = belief.thing(entity), belief.feature(entity, "cram:Handle")
    if handle is None or thing.joint is None:
        raise Unresolvable(f"'{entity}' has no handle and joint: nobody knows where its front is", (location.of or "",), blocking=())
    fronts = _at_front(thing, thing.joint, handle, belief.pose(thing.name), context.robot.gripper)
    yield from _pushing(thing, thing.joint, _nearer_first(fronts, tcp(belief, context)), belief, context, None)


def behind_door(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate closed fingers behind a door that stands ajar, over its upper edge, where the arm can follow it until it is "least" open."""
    entity = bound(context, location.of)
    thing, handle = belief.thing(entity), belief.feature(entity, "cram:Handle")
    if handle is None or thing.joint is None or thing.joint.kind != "hinge":
        raise Unresolvable(f"'{entity}' is no door with a handle: it has no side to be pushed open from", (location.of or "",), blocking=())
    spots = _at_inner_side(thing, thing.joint, handle, belief.pose(thing.name), context.robot.gripper)
    yield from _pushing(thing, thing.joint, spots, belief, context, asked(location, InnerSide).least)


def _pushing(
    thing: Thing, joint: Joint, spots: Iterator[tuple[Pose, str]], belief: Belief, context: Context, least: float | None
) -> Iterator[Grounding | Refused]:
    """Hands that are free at spots, and before them on the arc of a thing, and follow it: until it is all but shut, or open by a share."""
    shut, pose = context.robot.gripper.opening[0], belief.pose(thing.name)
    stand_offs = (BEHIND, NEARER) if least is None else (INSIDE,)
    late = list[Grounding]()
    free, near = make_scene(belief, context, (), shut), make_scene(belief, context, [thing.name], shut)
    for k, (at, name) in enumerate(spots):
        there = collision_free_ik(near, context, at, belief.joints)
        share = ajar(joint, pose.inverse() * at) if least is None else least
        no = there if isinstance(there, Refused) else _follows(thing, at, there, share, belief, context)
        if no is not None:
            yield no.of(name)
            continue
        assert not isinstance(there, Refused)
        way = way_along(joint, pose, at) if least is None else -way_along(joint, pose, at)
        tried = [collision_free_ik(free, context, shift(at, -far * way), there) for far in stand_offs]
        far = next((far for far, off in zip(stand_offs, tried, strict=True) if not isinstance(off, Refused)), None)
        if far is None:
            yield from (off.of(name) for off in tried[:1] if isinstance(off, Refused))
            continue
        x, y, z = (float(v) for v in way)
        place = Place(at, shift(at, -far * way), shut, (x, y, z), thing=thing.name)
        if far == stand_offs[0]:
            yield Grounding(place, name, 0.1 * k, key=name)
        else:
            late.append(Grounding(place, f"{name}, from nearer", 0.1 * k + LAST, key=name))
    yield from late


def _nearer_first(fronts: Iterable[tuple[Pose, str]], now: Pose) -> Iterator[tuple[Pose, str]]:
    """Hands before a front, of two in a row that are the same but for half a turn the one first that the hand has less far to turn to."""
    last: tuple[Pose, str] | None = None
    for found in fronts:
        if last is not None and math.isclose(_apart(last[0], found[0]), math.pi, abs_tol=1e-6):
            yield from sorted((last, found), key=lambda one: round(_apart(one[0], now), 6))
            last = None
            continue
        if last is not None:
            yield last
        last = found
    if last is not None:
        yield last


def _apart(one: Pose, other: Pose) -> float:
    """How far a hand turns from one pose to another [rad]."""
    return float(np.linalg.norm((one.inverse() * other).rotvec))


def _at_front(thing: Thing, joint: Joint, handle: Feature, pose: Pose, gripper: Gripper) -> Iterator[tuple[Pose, str]]:
    """Closed fingers before a front, and words for where; last those that may slip off what they meet, and those much nearer to a hinge
    than the handle is."""
    loose, near, far = list[tuple[Pose, str]](), list[tuple[Pose, str]](), NEAR_HINGE * lever(joint, handle.pose)
    over = AT_BAR if joint.kind == "hinge" else FROM_ABOVE
    for spot, tilt, turn in itertools.chain(itertools.product(SPOTS, TILTS, TURNS), itertools.product(*over)):
        at, firm = _against(thing, handle, pose, spot, (tilt, turn), gripper, joint.kind == "hinge")
        aside, up = (100 * share for share in spot)
        name = f"before its front at {aside:+.0f} % of its width, {up:+.0f} % of its height, tilted {tilt:+.0f} deg, turned {turn:.0f} deg"
        if joint.kind == "hinge" and lever(joint, pose.inverse() * at) < far:
            near.append((at, name))
        elif firm:
            yield at, name
        else:
            loose.append((at, name))
    yield from (*loose, *near)


def _at_inner_side(thing: Thing, joint: Joint, handle: Feature, pose: Pose, gripper: Gripper) -> Iterator[tuple[Pose, str]]:
    """Closed fingers behind a door, over its upper edge, and words for where; last those much nearer to its hinge than its handle is."""
    near, far = list[tuple[Pose, str]](), NEAR_HINGE * lever(joint, handle.pose)
    out, up = _facing(pose * handle.pose, inner=True)
    side = math.copysign(1.0, np.cross(up, out) @ np.subtract((pose * joint.pose).position, (pose * handle.pose).position))
    for (aside, high), tilt, turn in itertools.product(*OVER_EDGE):
        at, _ = _against(thing, handle, pose, (side * aside, high), (tilt, turn), gripper, True, inner=True)
        name = (
            f"behind it {100 * aside:.0f} % of the way from its handle to its hinge, {100 * high:+.0f} % of its height, "
            f"tilted {tilt:+.0f} deg, turned {turn:.0f} deg"
        )
        if lever(joint, pose.inverse() * at) < far:
            near.append((at, name))
        else:
            yield at, name
    yield from near


def _follows(thing: Thing, at: Pose, joints: Joints, share: float, belief: Belief, context: Context) -> Refused | None:
    """Why the arm cannot follow a front that it pushes to a share of its range, whatever is in the way; None where it can."""
    path = along_joint(thing, belief, at, share)
    line = plan_straight_line(None, context.robot, joints, path, step_m=COARSE[0], step_rad=COARSE[1])
    return line if isinstance(line, Refused) else None


def _against(
    thing: Thing, handle: Feature, pose: Pose, spot: tuple[float, float], turns: tuple[float, float], gripper: Gripper, swings: bool,
    inner: bool = False,
) -> tuple[Pose, bool]:
    """The TCP of closed fingers ``ALMOST`` before a front, and whether they still meet it there if they are ``OFF`` to any side.

    Args:
        spot: how far from its handle, to a side and up, as shares of the way to the edge of the thing.
        turns: of the hand about the level line across the front, and about its own axis [deg].
        swings: of a door all of the fingers is clear of its bar, which slides along them; a drawer goes straight.
        inner: behind it, where its handle is not.
    """
    out, up = _facing(pose * handle.pose, inner)
    level, hand = np.cross(up, out), _turned(out, up, turns)
    at = np.asarray((pose * handle.pose).position)
    ways = [share * way for share, way in zip(spot, (level, np.cross(out, level)), strict=True) if share]
    point = at + sum((w * (support(thing, pose, w) - w @ at) / np.linalg.norm(w) for w in ways), np.zeros(3))
    if not swings:
        met = spans(body(thing.geoms), pose.inverse().apply(point), pose.inverse().rotate(out))
        far = max((end for begin, end, _ in met if begin <= 0.0), default=0.0)
        # of the tips, a box as wide as the pads and as thick as two fingers, the corner that is farthest ahead
        ahead = np.abs(hand.inverse().rotate(out)) @ (gripper.pad[0] / 2, FINGER, gripper.pad[1] / 2)
        x, y, z = (float(v) for v in point + out * (far + ahead + ALMOST))
        return Pose((x, y, z), hand.quaternion), True
    across = [OFF * way / np.linalg.norm(way) for way in (level, np.cross(out, level))]
    points = [point, *(point + sign * way for way in across for sign in (1.0, -1.0))]
    reach, *beside = (_clear_of(thing, pose, replace(hand, position=tuple(p.tolist())), out, gripper) for p in points)
    x, y, z = (float(v) for v in point + out * (reach + ALMOST))
    return Pose((x, y, z), hand.quaternion), min(beside) > reach - FIRM


def _facing(handle: Pose, inner: bool) -> tuple[Floats, Floats]:
    """The direction out of a front, or out of its inner side, and the one that is up along it."""
    out = np.asarray(handle.rotate((0.0, 0.0, -1.0 if inner else 1.0)))
    return out, np.array([0.0, 0.0, 1.0]) if abs(out[2]) < UPRIGHT else np.asarray(handle.rotate((0.0, 1.0, 0.0)))


def _clear_of(thing: Thing, pose: Pose, hand: Pose, out: Floats, gripper: Gripper) -> float:
    """How far out closed fingers at a TCP pose must go until they are in nothing of a thing [m]: a bar beside where they point counts."""
    across, thick = np.linspace(-0.5, 0.5, 3) * gripper.pad[0], np.linspace(-FINGER, FINGER, 5)
    along = np.linspace(-gripper.depth, gripper.pad[1] / 2, 6)
    fingers, to = np.array(list(itertools.product(across, thick, along))), pose.inverse()
    _, high = intervals(body(thing.geoms), to.apply(hand.apply(fingers)), np.tile(to.rotate(out), (len(fingers), 1)))
    return max(float(high.max()), -gripper.depth)  # where they are beside all of it, no farther in than to the palm


def atop_handle(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate closed fingers over the bar of a drawer's handle, pointing down towards the front, so that it comes along when pressed."""
    entity = bound(context, location.of)
    thing, handle, shut = belief.thing(entity), belief.feature(entity, "cram:Handle"), context.robot.gripper.opening[0]
    out = belief.pose(thing.name).rotate(handle.pose.rotate((0.0, 0.0, 1.0))) if handle is not None else (0.0, 0.0, 1.0)
    if handle is None or thing.joint is None or thing.joint.kind != "slide" or abs(out[2]) > 1.0 - UPRIGHT:
        raise Unresolvable(f"'{entity}' has no handle of a drawer that could be pressed on from above", (location.of or "",), blocking=())
    check_way(location, thing, belief, context)
    free, near = make_scene(belief, context, (), shut), make_scene(belief, context, [thing.name], shut)
    for k, (tilt, turn) in enumerate(itertools.product(DOWN, (90.0, -90.0))):
        at = _upon(thing, handle, belief.pose(thing.name), (tilt, turn), context.robot.gripper)
        before, name = at * Pose((0.0, 0.0, -BEHIND)), f"upon its handle, tilted {tilt:+.0f} deg, turned {turn:.0f} deg"
        there = collision_free_ik(near, context, at, belief.joints)
        off = there if isinstance(there, Refused) else collision_free_ik(free, context, before, there)
        if isinstance(off, Refused):
            yield off.of(name)
        else:
            yield Grounding(Place(at, before, shut, tuple(at.rotate((0, 0, 1))), thing=thing.name), name, 0.1 * k, key=name)


def _upon(thing: Thing, handle: Feature, pose: Pose, turns: tuple[float, float], gripper: Gripper) -> Pose:
    """The TCP of closed fingers whose lowest edge is ``ALMOST`` over the middle of a bar."""
    up, middle = np.array([0.0, 0.0, 1.0]), np.asarray((pose * handle.pose).position)
    hand = _turned(pose.rotate(handle.pose.rotate(up)), up, turns)
    met = spans(body(thing.geoms), np.asarray(handle.pose.position), pose.inverse().rotate(up))
    top = max((end for begin, end, _ in met if begin <= 0.0), default=0.0)
    down = np.sign(np.round(hand.inverse().rotate(-up), 3))
    edge = hand.rotate(down * (gripper.pad[0] / 2, 0.0, gripper.pad[1] / 2))
    x, y, z = (float(v) for v in middle + up * (top + ALMOST) - edge)
    return Pose((x, y, z), hand.quaternion)


def _turned(out: Floats, up: Floats, turns: tuple[float, float]) -> Pose:
    """The hand that points into a front, tilted about the level line across it, and turned about its own axis [deg]."""
    tilted = Pose.from_axes((0, 0, 0), -out, np.cross(up, out)) * Pose.from_rotvec((0, 0, 0), (math.radians(turns[0]), 0, 0))
    return tilted * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(turns[1])))


def beyond(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Generate the place straight on from where the fingers are, in the direction of the place that they push from."""
    entity, distance = bound(context, location.of), asked(location, Along).distance_m
    start: Place = context.bindings[f"push({location.of})"]
    end = shift(tcp(belief, context), np.asarray(start.approach) * distance)
    there = collision_free_ik(make_scene(belief, context, [entity]), context, end, belief.joints)
    if isinstance(there, Refused):
        said = f"after {1000 * distance:.0f} mm: {there.reason}"
        raise Unresolvable(said, causes(location, context), blocking=there.blocking, collision=there.collision, remedy=there.remedy)
    yield Grounding(Place(end, end, thing=entity), f"{1000 * distance:.0f} mm on", key="on")


def _ways(pose: Pose) -> list[Floats]:
    """The horizontal directions of a thing's own x and y axes, outwards from the robot first."""
    out = np.array([*pose.position[:2], 0.0])
    x = pose.rotate((1.0, 0.0, 0.0))
    angle = math.atan2(float(x[1]), float(x[0]))
    turns = [angle + k * math.pi / 2 for k in range(4)]
    ways = [np.array([math.cos(a), math.sin(a), 0.0]) for a in turns]
    return sorted(ways, key=lambda w: -round(float(w @ out), 6))

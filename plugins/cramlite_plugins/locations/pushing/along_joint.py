"""Pushes along a joint: closed fingers in front of a door or drawer, behind a door that stands ajar, or upon
the bar of a drawer's handle."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator

import numpy as np

from cramlite.model import Belief, Joint, Joints, Location, Place, Pose, Thing
from cramlite.plugin import Answer, Context, Grounding, Refused

from ...motion_planning.cartesian import COARSE, plan_straight_line
from ...motion_planning.reach import bound, collision_free_ik, make_scene, shift, tcp, unfit
from ..jointed.handles import ajar, along_joint, check_way, way_along
from ..parameters import InnerSide, asked
from ..reached import Arm, Candidate, Leg, reached
from .contacts import DOWN, UPRIGHT, at_front, at_inner_side, upon
from .straight import BEHIND

NEARER = 0.02
"""Distance of the stand-off that is tried last [m]: at 50 mm before the handle of a microwave's door that was
open by 110 deg, the elbow was folded too far."""
LAST = 10.0  # cost of what comes after all else
INSIDE = 0.025  # the stand-off behind a door that stands ajar, where there is less room [m]


def before_front(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate TCP poses of closed fingers that face the part of a drawer's or a door's front that sticks out
    most at its handle."""
    entity = bound(context, location.of)
    thing, handle = belief.thing(entity), belief.feature(entity, "cram:Handle")
    if handle is None or thing.joint is None:
        raise unfit(location, f"'{entity}' has no handle and joint: nobody knows where its front is")
    check_way(location, thing, belief, context)
    fronts = at_front(thing, thing.joint, handle, belief.pose(thing.name), context.robot.gripper)
    spots = _nearer_first(fronts, tcp(belief, context))
    yield from _pushing(thing, thing.joint, spots, belief, context, None)


def behind_door(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate TCP poses of closed fingers behind a door that stands ajar, over its upper edge, for pushing
    it open.

    With each of them the arm can follow the door until it is "least" open.
    """
    entity = bound(context, location.of)
    thing, handle = belief.thing(entity), belief.feature(entity, "cram:Handle")
    if handle is None or thing.joint is None or thing.joint.kind != "hinge":
        raise unfit(location, f"'{entity}' is no door with a handle: it has no side to be pushed open from")
    spots = at_inner_side(thing, thing.joint, handle, belief.pose(thing.name), context.robot.gripper)
    yield from _pushing(thing, thing.joint, spots, belief, context, asked(location, InnerSide).least)


def _pushing(
    thing: Thing,
    joint: Joint,
    spots: Iterator[tuple[Pose, str]],
    belief: Belief,
    context: Context,
    least: float | None,
) -> Iterator[Answer]:
    """Ground hand poses that push a thing along its joint until it is all but shut, or open by the share
    ``least`` of the joint's range.

    A hand pose is refused if it is not free of collision, or if the arm cannot follow the arc with it.
    """
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
        far = next(
            (far for far, off in zip(stand_offs, tried, strict=True) if not isinstance(off, Refused)), None
        )
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
    """Yield hand poses in front of a thing; of two in a row that differ by half a turn, first the one to
    which the hand turns less."""
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
    """Angle that a hand turns from one pose to another [rad]."""
    return float(np.linalg.norm((one.inverse() * other).rotvec))


def _follows(
    thing: Thing, at: Pose, joints: Joints, share: float, belief: Belief, context: Context
) -> Refused | None:
    """Reason why the arm cannot follow the front of a thing that it pushes to a share of the joint's range;
    None if it can.

    Obstacles are not checked.
    """
    path = along_joint(thing, belief, at, share)
    line = plan_straight_line(None, context.robot, joints, path, step_m=COARSE[0], step_rad=COARSE[1])
    return line if isinstance(line, Refused) else None


def atop_handle(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate TCP poses of closed fingers over the bar of a drawer's handle, for moving the drawer by
    pressing on the bar.

    They point down and towards the front.
    """
    entity = bound(context, location.of)
    thing, bar = belief.thing(entity), belief.feature(entity, "cram:Handle")
    pose, gripper = belief.pose(thing.name), context.robot.gripper
    slides = thing.joint is not None and thing.joint.kind == "slide"
    if bar is None or not slides or abs((pose * bar.pose).rotation[2, 2]) > 1.0 - UPRIGHT:
        raise unfit(location, f"'{entity}' has no handle of a drawer that could be pressed on from above")
    check_way(location, thing, belief, context)
    shut = gripper.opening[0]

    def tilted(turns: tuple[float, float]) -> Candidate:
        at = upon(thing, bar, pose, turns, gripper)
        name = f"upon its handle, tilted {turns[0]:+.0f} deg, turned {turns[1]:.0f} deg"
        place = Place(at, at * Pose((0.0, 0.0, -BEHIND)), shut, tuple(at.rotate((0, 0, 1))), thing=thing.name)
        return Candidate(name, place, (Leg(at, (thing.name,), shut), Leg(place.before, (), shut)))

    yield from reached(map(tilted, itertools.product(DOWN, (90.0, -90.0))), Arm(belief, context))

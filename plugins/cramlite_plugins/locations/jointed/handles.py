"""Grasps of handles, and the paths along which drawers and doors move them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import (
    Belief,
    CarriedAlong,
    Estimate,
    Feature,
    Floats,
    GripFacts,
    Joint,
    Location,
    Place,
    Pose,
    Thing,
)
from cramlite.plugin import Answer, Context, Grounding, Refused, Unresolvable

from ...motion_planning.reach import bound, causes, held_pose, led_by, tcp, unfit
from ...motion_planning.space import refusal
from ...shapes import ray_casting as rays
from ...shapes.bounds import box_around
from ...shapes.joints import joint_value
from ..parameters import Handle, JointWay, Turned, asked
from ..pinching.antipodal import Hands, pinches
from ..reached import Arm, Leg
from .joint_obstacles import driven_along, met_on_its_way
from .levers import freeing, lever_of

# How much farther out the pads also take it, where their ends come too near to the front behind [m]
TIPS = 0.006
STANDOFF = 0.08  # in front of the handle [m]: the fingers, open, are clear of the bar
SLACK = (0.05, 0.03, 0.016, 0.01)
"""Openings of the fingers beyond the bar's width [m], of which the widest that obstacles allow is used; half
of it is the error of the bar's position that the fingers allow for."""
ROOM = 0.006  # about the hand, without which a grip comes last [m]: streamed arms come to rest within 4 mm
TILTS = (0.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0)
"""Turns of the hand about the bar [deg]: a low drawer is reached from above, a door beside a wall from its
free side."""
LEANS = (15.0, -15.0, 30.0, -30.0)
"""Tilts of the hand along a handle's bar [deg], with the bar between the finger tips only, since the palm
comes near to it: tried last, for arms that would be folded or stretched straight in front of the bar."""
# Between two corners, where the arm stops, a path is off the arc of a hinge by so much at most [m]:
# the arm gives way sideways, and a hand that only pushes slides on what it pushes.
CHORD, SLIDING_CHORD = 0.001, 0.004
TURN = math.radians(45)  # and turns no further [rad]
CLOSED, AJAR = 0.005, 0.08
"""Shares of its range to which a joint is closed: with a hand on its handle all but what friction leaves, and
with a pushing hand up to where a guarded motion takes over."""
LEFT = 0.015
"""Last part of a door's way that a pushing hand covers by a guarded motion [m]."""
OPENED = (0.95, 0.9)
"""Shares of its range to which a joint is opened, short of its stop; the first one that the arm reaches is
used."""
BEGUN = (0.4, 0.3, 0.25, 0.2, 0.175, 0.15)
"""Shares of its range to which a door is pulled ajar by its handle, before it is pushed on from inside; the
first one that the arm reaches is used. Of 2.1 rad the least is 0.3 rad, 75 mm at a handle 0.25 m from the
hinge: closed fingers 32 mm thick still get in behind it."""
CLOSER = (0.35, 0.5, 0.65, 0.75)
"""Shares of its range to which a door is closed by its handle, before it is pushed shut; the first one that
the arm reaches is used."""
PUSHED_ON = (*OPENED, 0.85, 0.8)
"""Shares of its range to which a door is pushed open from inside; the first one that the arm reaches is
used."""
PRESSED = math.radians(2.0)
"""Turn of the hand beyond the stop of a knob [rad]: streamed arms come to rest within 0.02 rad. Knobs of 1
kg m2 that were not pressed there sprang back from it by 3 mrad, and glided on by 2 mrad once they were let
go of."""
TURNED = (0.97, 0.6, 0.4)
"""Shares of its range to which a knob is turned on; the first one that the wrist reaches is used, and a knob
counts as on from a fifth of its range."""


def handle_grasps(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate grasps of a handle with the fingers across its bar: straight onto it, turned by 180 deg,
    tilted about the bar, and leaning along it."""
    entity = bound(context, location.of)
    door = belief.thing(entity)
    said = asked(location, Handle)
    lever = lever_of(location, door, belief) if said.lever else None
    if lever is not None:  # before any pose of the hand is tried
        freeing(location, lever, said.least or 1.0, belief.poses[lever.name].pose, belief, context)
    thing = lever or door
    handle = belief.feature(thing.name, "cram:Handle")
    if handle is None or thing.joint is None:
        lacks = "cram:Handle to hold it by" if handle is None else "joint to open it by"
        raise unfit(location, f"'{entity}' has no {lacks}")
    if lever is None:
        check_way(location, thing, belief, context)
    arm, late = Arm(belief, context), list[Answer]()
    tilted = itertools.product(TILTS, (0.0, 180.0), (0.0,), (0.0, TIPS))
    ways = [*tilted, *itertools.product((0.0,), (0.0, 180.0), LEANS, (TIPS,))]
    for k, (tilt, turn, lean, back) in enumerate(ways):
        across = _across(thing.joint, handle, tilt, turn, lean)
        width = 2 * handle.size["radius"] if tilt == 0.0 else _thickness(thing, across)
        name = f"across the handle, turned {turn:.0f} deg"
        name += f", tilted {tilt:+.0f} deg" if tilt else ""
        name += f", leaning {lean:+.0f} deg" if lean else ""
        name += ", by the tips" if back else ""
        at = belief.pose(thing.name) * across * Pose((0, 0, -back))
        found = _around(arm, thing.name, at, width, ROOM)
        if isinstance(found, Place):
            yield _held(name, found, 0.1 * k)
            continue
        found = _around(arm, thing.name, at, width)
        late.append(_held(name, found, 0.1 * (k + len(ways))) if isinstance(found, Place) else found.of(name))
    yield from late


def _around(arm: Arm, thing: str, at: Pose, width: float, room: float = 0.0) -> Place | Refused:
    """Find the widest opening at which the hand touches nothing, at a TCP pose around the bar of a thing's
    handle and at the stand-off before it.

    Args:
        at: of the TCP, in the base frame.
        width: of what is to be between the fingers [m].
        room: about the hand that must be free there [m].
    """
    refused = refusal(f"the bar is {1000 * width:.0f} mm thick, as wide as the hand opens")
    before = at * Pose((0, 0, -STANDOFF))
    most = arm.context.robot.gripper.opening[1]
    for opening in dict.fromkeys(round(min(width + s, most), 4) for s in SLACK if width + SLACK[-1] <= most):
        bare = arm.scene((), opening, room)
        there = arm.at(Leg(at, (thing,), opening))
        if not isinstance(there, Refused) and not bare.free(there):
            there = refusal(bare.why(there), collision=bare.collision(there))
        off = there if isinstance(there, Refused) else arm.at(Leg(before, opening=opening), there)
        if not isinstance(off, Refused):
            return Place(at, before, opening, tuple(at.rotate((0, 0, 1))), thing=thing, grip=GripFacts(width))
        refused = off
    return refused


def check_way(location: Location, thing: Thing, belief: Belief, context: Context) -> None:
    """Check that nothing stops a thing on its joint before the location's "least", or "most" on its way back
    (shares of the joint's range); hand poses are tried after this check.

    Raises:
        Unresolvable: something is in its way; whatever hand moves it, it meets that.
    """
    joint, said = thing.joint, asked(location, Handle)
    share = said.most if said.least is None else said.least
    if joint is None or share is None:
        return
    value = joint_value(belief, thing.name, belief.base() * belief.pose(thing.name))
    goal, opens = joint.value_at(share), said.least is not None
    met = met_on_its_way(thing, value, goal, belief, context) if (goal > value) is opens else None
    if met is None or not (met.in_the_way or opens):
        return
    free = context.limits.may_push and driven_along(thing, value, goal, belief, context)
    drives = context.limits.may_push and not isinstance(free, Refused)
    if drives and said.drives:
        return
    places = ((n, v) for n, v in context.bindings.items() if isinstance(v, Place))
    put = (n for n, v in places if v.thing in met.in_the_way and v.leaves_thing)
    # a lever may free the way; else moving what is in the way is all that helps
    ways = led_by(location, context) if drives or belief.world.mounted_on(thing.name) else ()
    raise met.impossible(met.reason, (location.of or "", *put, *ways))


def _held(name: str, place: Place, cost: float) -> Grounding:
    width, opening = place.grip.width_m if place.grip else 0.0, place.opening or 0.0
    said = f"{name}: {1000 * width:.0f} mm wide, open {1000 * opening:.0f} mm"
    return Grounding(place, said, cost, key=name)


def _across(joint: Joint, handle: Feature, tilt: float, turn: float, lean: float) -> Pose:
    """TCP pose at a handle, in the thing's frame: z into the handle, y across its bar; then turned about
    x, z and y [deg]."""
    # the handle's z comes out, and its x is along the bar of a door, across that of a drawer
    across = handle.pose.rotate((0, 1, 0) if joint.kind == "hinge" else (1, 0, 0))
    into = handle.pose.rotate((0, 0, -1))
    straight = Pose.from_axes(handle.pose.position, into, np.cross(across, into))
    for degrees, (x, y, z) in ((tilt, (1, 0, 0)), (turn, (0, 0, 1)), (lean, (0, 1, 0))):
        angle = math.radians(degrees)
        straight *= Pose.from_rotvec((0, 0, 0), (angle * x, angle * y, angle * z))
    return straight


def _thickness(thing: Thing, across: Pose) -> float:
    """Thickness of a handle between the fingers of a hand at a pose in its thing's frame [m]."""
    bar = [g for g in thing.geoms if g.part == "handle"] or list(thing.geoms)
    met = float(pinches(rays.body(bar), Hands.at([across])).width[0])
    low, high = box_around(replace(g, pose=across.inverse() * g.pose) for g in bar)
    return met if met > 0.0 else float(high[1] - low[1])


def joint_way(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate paths on which the hand moves a thing along its joint to the goal: holding its handle, or with
    closed fingers against its front."""
    thing, joint, now, there = _jointed(location, belief, context)
    if (said := asked(location, JointWay)).lever and location.relation == "opened":
        goals = freeing(location, thing, said.share or 1.0, belief.base() * now, belief, context)
        for k, goal in enumerate(goals):
            yield _led(thing, joint, belief, context, now, joint.share(goal), 0.1 * k)
        return
    pressed = PRESSED if location.relation != "opened" and said.turned else 0.0
    hand, held = now.inverse() * tcp(belief, context), belief.held is not None
    for k, share in enumerate(_shares(location, joint, hand, held, there)):
        led = _led(thing, joint, belief, context, now, share, 0.1 * k, pressed)
        yield _driving(led, thing, now, belief, context) if said.drives else led


def turn_on(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate the hand's path that turns a held thing about its joint by a given angle, from its present
    joint value."""
    thing, joint, now, there = _jointed(location, belief, context)
    by = float(np.dot(asked(location, Turned).turn, joint.pose.rotate((0.0, 0.0, 1.0))))
    share = there + by / (joint.upper - joint.lower)
    if joint.kind != "hinge" or not 0.0 <= share <= 1.0:
        left = math.degrees((1.0 - there if by > 0 else there) * (joint.upper - joint.lower))
        said = f"{math.degrees(abs(by)):.0f} deg are asked for, {left:.0f} deg are left"
        reason = f"'{thing.name}' cannot be turned as asked: {said if joint.kind == 'hinge' else 'it slides'}"
        raise Unresolvable(reason, causes(location, context), blocking=())
    yield _led(thing, joint, belief, context, now, share, 0.0)


def _jointed(location: Location, belief: Belief, context: Context) -> tuple[Thing, Joint, Pose, float]:
    """Thing on a joint, the joint, the thing's pose in the base frame, and the share of the joint's range
    that it is at."""
    entity = bound(context, location.of)
    thing = belief.thing(entity)
    thing = lever_of(location, thing, belief) if location.parameters.get("lever") else thing
    held = belief.held is not None and belief.held.thing == thing.name
    levers = {t.name for t in belief.world.mounted_on(thing.name)}
    if thing.joint is None or (belief.held and not held and belief.held.thing not in levers):
        reason = f"'{entity}' must have a joint, and the hand must hold no other thing"
        raise Unresolvable(reason, causes(location, context), blocking=())
    now = held_pose(belief, context) if held else belief.pose(thing.name)
    return thing, thing.joint, now, thing.joint.share(joint_value(belief, thing.name, belief.base() * now))


def _driving(led: Grounding, thing: Thing, now: Pose, belief: Belief, context: Context) -> Answer:
    """Path of a drawer with the distance that it pushes each loose thing ahead of it; or a refusal with the
    obstacles."""
    there, place = Estimate(belief.base() * now), led.value
    free = belief.released(there, belief.opening) if belief.held else belief
    value = joint_value(free, thing.name, there.pose)
    found = driven_along(thing, value, value + place.carried.joint, free, context)
    if isinstance(found, Refused):
        return found.of(led.key)
    said = f"{led.reason}; pushes {', '.join(map(repr, found)) or 'nothing'} along"
    return replace(led, value=replace(place, carried=replace(place.carried, driven_m=found)), reason=said)


def _shares(location: Location, joint: Joint, hand: Pose, held: bool, there: float) -> tuple[float, ...]:
    """Joint values to which a hand may move a drawer or a door, as shares of the joint's range, best first.

    ``hand`` is its pose in the thing's frame. A thing that is pushed shut goes on from there to its stop.
    """
    said = asked(location, JointWay)
    if said.share:
        return (said.share,)
    if said.ajar:
        opens = location.relation == "opened"
        most, begun = (said.ajar, BEGUN) if opens else (min(said.ajar, there), CLOSER)
        return tuple(share for share in begun if share < most) or (most / 2,)
    if location.relation == "opened" and joint.kind == "hinge" and not held:
        return PUSHED_ON
    if location.relation == "opened":
        return TURNED if said.turned else OPENED
    if said.lever:
        return (joint.share(joint.rest),)
    if location.relation == "stop" or said.turned:  # others may want a knob that is off exactly at its stop
        return (0.0,)
    return (CLOSED if held else ajar(joint, hand),)


def ajar(joint: Joint, hand: Pose) -> float:
    """Return how far a thing is still open (as a share of its joint's range) where the planned path of a hand
    that shuts it ends.

    The rest of the way is a guarded motion. ``hand`` is a pose in the thing's frame.
    """
    reach = lever(joint, hand) * (joint.upper - joint.lower) if joint.kind == "hinge" else 0.0
    return min(AJAR, LEFT / reach) if reach > 0.0 else AJAR


def lever(joint: Joint, hand: Pose) -> float:
    """Return the hand's distance from a hinge's axis, at a pose in the frame of the turning part [m]."""
    return float(np.linalg.norm((joint.pose.inverse() * hand).position[:2]))


def _led(
    thing: Thing,
    joint: Joint,
    belief: Belief,
    context: Context,
    now: Pose,
    share: float,
    cost: float,
    pressed: float = 0.0,
) -> Grounding:
    """Path on which a hand moves a thing along its joint to a share of the joint's range; if the joint stops
    there, the hand goes on by ``pressed`` [m, rad]."""
    goal, value = joint.value_at(share), joint_value(belief, thing.name, belief.base() * now)
    held, way = belief.held is not None, goal - value
    path = _corners(joint, now, tcp(belief, context), goal - pressed - value, held)
    said = f"'{thing.name}' from {value:.3f} to {goal:.3f} {'m' if joint.kind == 'slide' else 'rad'}"
    place = Place(path[-1], path[-1], path=path, thing=thing.name, carried=CarriedAlong(joint=way))
    return Grounding(place, said, cost, key=f"to {share:g}")


def along_joint(thing: Thing, belief: Belief, hand: Pose, share: float) -> tuple[Pose, ...]:
    """Return the TCP poses in the base frame that keep a pushing hand at a thing while its joint goes to a
    share of its range."""
    assert thing.joint is not None
    joint, now = thing.joint, belief.pose(thing.name)
    value = joint_value(belief, thing.name, belief.base() * now)
    return _corners(joint, now, hand, joint.value_at(share) - value, held=False)


def way_along(joint: Joint, now: Pose, hand: Pose) -> Floats:
    """Return the direction (3,) in which a hand at a drawer or door begins to move when the joint closes.

    Of a door it is not that into its front: at a handle that stands 40 mm before it the two were 14 deg
    apart, and fingers that went into the front, held to the bar by friction, pressed 14 N along the door
    without feeling 3 N into it.

    Args:
        now: of the thing, in the same frame as the hand.
    """
    frame = now * joint.pose
    axis, off = np.asarray(frame.rotate((0.0, 0.0, 1.0))), np.subtract(hand.position, frame.position)
    way: Floats = -axis if joint.kind == "slide" else np.cross(off, axis)
    return way / float(np.linalg.norm(way))


def _corners(joint: Joint, now: Pose, tcp: Pose, way: float, held: bool) -> tuple[Pose, ...]:
    """Return TCP poses that follow a thing while its joint moves on by ``way`` [m, rad]: along a line, or the
    chords of an arc, which are longer if the hand does not hold the thing."""
    hand = now.inverse() * tcp
    radius = lever(joint, hand)
    chord = CHORD if held else SLIDING_CHORD
    most = min(TURN, 2 * math.acos(max(0.0, 1.0 - chord / max(radius, chord))))
    count = max(1, math.ceil(abs(way) / most)) if joint.kind == "hinge" else 1
    return tuple(joint.moved(now, way * k / count) * hand for k in range(1, count + 1))

"""Hand poses and paths that need no search for grasps: home, straight back, straight up, oblique, along a
surface."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Collision, Floats, Location, Place, Pose, Swing
from cramlite.plugin import Answer, Context, Grounding, Refused, Unresolvable

from ..kinematics.forward import forward
from ..motion_planning.reach import led_here, shift, tcp, traverse
from .laying_down import dropped
from .parameters import Along, Back, Up, asked
from .reached import Arm, Candidate, Leg, reached

# Retreat distances that are tried [m]: the longest frees the pads of a 2F-85, 38 mm long
BACK = (0.12, 0.08, 0.05)
DIRECTIONS = (0.0, 180.0, 90.0, -90.0)  # of a slide, in the base frame [deg]
ANGLES = (180.0, 90.0, -90.0, 0.0)
"""Sideways directions of oblique ways in the base frame, the one towards the robot first [deg]."""
SHARES = (1.0, 0.7, 0.4)  # of its height that a lift leads aside, where straight up something is in the way
OFF = 0.03  # what it lay on a thing hangs when it is lifted [m]: room for the path that goes on from there
ALONG = (0.1, 0.2, 0.3, 0.45, 0.65, 1.0)
"""Fractions of a lift at which hand and payload must be free of collision: before the first one the payload
may touch its support."""


def home(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate a single answer for a location: the robot's home joint position and the TCP pose there."""
    pose = forward(context.robot, context.robot.home)
    yield Grounding(
        Place(pose, pose, joints=context.robot.home),
        f"the home position of '{context.robot.type}'",
        key="home",
    )


def retreat(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate poses to which the hand can retreat from where it is: back along its pointing direction, or
    up."""
    yield from _reachable(ways_back(tcp(belief, context), asked(location, Back).straight), belief, context)


def ways_back(here: Pose, straight: bool = False) -> list[tuple[str, Pose]]:
    """Return the poses to which a hand may retreat from a TCP pose, each with its name, best first.

    Args:
        straight: only against the direction in which the hand points, as fingers come off a bar.
    """
    ways = [("back", here.rotate((0, 0, -1)))]
    if not straight:
        ways.append(("up", np.array([0.0, 0.0, 1.0])))
    return [(f"{d * 1000:.0f} mm {way}", shift(here, v * d)) for way, v in ways for d in BACK]


def lift(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate lifts of the hand and its payload: straight up, then up and aside."""
    height, here = asked(location, Up).height_m, tcp(belief, context)
    if belief.held is not None and belief.held.swing is not None:
        yield from _until_it_hangs(here, height, belief, belief.held.swing, context)
        return
    heights = (height, 0.6 * height)  # a lower lift, where the full one is out of reach
    ways = [(f"{h * 1000:.0f} mm up", shift(here, (0, 0, h))) for h in heights]
    yield from _reachable(ways, belief, context)
    if height > 0:
        yield from _out_from_under(here, heights, belief, context)


def _until_it_hangs(
    here: Pose, height: float, belief: Belief, swing: Swing, context: Context
) -> Iterator[Answer]:
    """Yield lifts that are high enough for a payload that swings down in the hand to come off its support."""
    needed = dropped(belief.world.thing(belief.payload.thing), here, swing) + OFF
    hanging = replace(belief, held=replace(belief.payload, tcp_to_thing=swing.end))
    ways = [
        (f"{1000 * h:.0f} mm up", shift(here, (0, 0, h)))
        for h in dict.fromkeys((max(height, needed), needed))
    ]
    yield from _reachable(ways, hanging, context)


def _out_from_under(
    here: Pose, heights: Sequence[float], belief: Belief, context: Context
) -> Iterator[Answer]:
    """Yield lifts up and aside along which hand and payload are free; those that keep the clearance come
    first.

    Few where one straight up is free: what comes next fails for them as for that, unless that ends too near
    to something.
    """
    height, first, arm, done = heights[0], len(heights), Arm(belief, context), set[str]()
    keeping, touching = Leg(here), Leg(here, clearance=0.0)
    straight = any(arm.free_along(touching, np.array([0.0, 0.0, h]), ALONG) for h in heights)
    shares = SHARES[:1] if straight else SHARES
    ways = [
        (f"{height * 1000:.0f} mm up, and {1000 * s * height:.0f} mm {side}", w)
        for s in shares
        for side, w in slants(height, s)
    ]
    for leg, (name, way) in itertools.product((keeping, touching), ways):
        if name not in done and arm.free_along(leg, way, ALONG):
            done.add(name)
            place = shift(here, way)
            yield Grounding(Place(place, place), name, 0.1 * (first + len(done) - 1), key=name)


def slants(rise: float, share: float = 1.0) -> Iterator[tuple[str, Floats]]:
    """Generate named displacements (3,) of the hand [m]: up by ``rise``, and by ``share`` times ``rise`` to
    one of several sides.

    With ``share`` 1 they are ways at 45 deg to and from a place under an overhang, such as under the handle
    of an open drawer, or in a drawer that is half shut.
    """
    for angle in ANGLES:
        way: Floats = rise * np.array(
            [share * math.cos(math.radians(angle)), share * math.sin(math.radians(angle)), 1.0]
        )
        yield f"aside at {angle:.0f} deg", way


def _reachable(options: list[tuple[str, Pose]], belief: Belief, context: Context) -> Iterator[Answer]:
    """Groundings of the named poses that the arm reaches free of collision, in order, and refusals of the
    others."""
    ends = (Candidate(name, Place(pose, pose), (Leg(pose),)) for name, pose in options)
    yield from reached(ends, Arm(belief, context), led_here(context))


def slide(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate straight paths along a surface."""
    distance = asked(location, Along).distance_m
    for k, angle in enumerate(DIRECTIONS):
        way = (distance * math.cos(math.radians(angle)), distance * math.sin(math.radians(angle)), 0.0)
        name = f"{1000 * distance:.0f} mm at {angle:.0f} deg"
        try:
            yield traverse(location, belief, context, [way], name, float(k))
        except Unresolvable as blocked:
            seen = blocked.collision if isinstance(blocked.collision, Collision) else None
            yield Refused(
                name, blocked.reason, because=led_here(context), blocking=blocked.blocking, collision=seen
            )

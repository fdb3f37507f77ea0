"""Contacts of hands that push: behind or inside a loose thing, in front of a door or drawer, behind a door,
or upon the bar of a handle."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from cramlite.model import Feature, Floats, Gripper, Joint, Pose, Thing
from cramlite.plugin import Unresolvable

from ...shapes.bounds import support
from ...shapes.ray_casting import body, intervals, spans
from ..jointed.handles import lever
from ..pinching.antipodal import FINGER

GAP = 0.01  # from fingers to the thing behind which they are [m]
ALMOST = 0.003  # from fingers to a face, where feeling begins [m]
# Height of finger tips over the thing's support, as a share of its height: under a plate's rim, to meet it
LOW = 1 / 3
SHARES = (0.0, 0.35, 0.6)
"""End points of a push, from the region's middle towards the thing, as shares of the region's half side
lengths; the rest is left for the slip of the thing."""
HALVES = (0.0, 180.0)
"""Turns of a hand about the vertical [deg] at which its fingers open across the direction of a push."""
EIGHTHS = (0.0, 180.0, 90.0, 270.0, 45.0, 225.0, 135.0, 315.0)
"""Turns about the vertical of a hand whose closed fingers push from inside a thing [deg]."""
AMID = ((0.0, 0.0), (0.02, 0.0), (0.0, 0.02), (0.0, -0.02), (-0.02, 0.0))
"""Positions of closed fingers inside a thing, from its middle, ahead and to the left [m]: those off the
middle are for obstacles in the thing."""
# Finger tips in a thing, over its floor; the least that its rim stands up; before it [m]
OVER, DEEP, PLAY = 0.0005, 0.006, 0.001
SPOTS = ((0.0, 0.0), (0.8, 0.0), (-0.8, 0.0), (0.0, 0.6), (0.8, 0.6), (-0.8, 0.6))
"""Contact points on a front, as shares of the way from its handle to its edge, sideways and up."""
TILTS, TURNS = (0.0, -30.0, -45.0, -60.0), (90.0, -90.0, 0.0, 180.0)
"""Tilts of a hand in front of a door or drawer about the level line across the front, to come from above
[deg], and turns of the hand about its own axis: first those with the slim side up."""
FROM_ABOVE = (
    ((0.55, 0.8), (0.8, 0.8), (0.3, 0.8), (0.0, 0.8)),
    (-70.0, -90.0),
    tuple(45.0 * k for k in range(8)),
)
AT_BAR = (
    ((0.0, 0.6), (0.0, 0.75), *FROM_ABOVE[0]),
    FROM_ABOVE[1],
    (0.0, 90.0, 180.0, 270.0, 45.0, 135.0, 225.0, 315.0),
)
"""Contact points, tilts and turns of a hand over the upper edge of a door's front, with only its fingers in
front of the door: tried last, for doors that turn too far for a hand in front of them to follow. Not near its
side first: fingers slid 30 mm along a door, over its edge, and caught on that when they left. Of a door at
its bar before, and with a flat side before a corner: beside the bar of a microwave's door, and at the round
end of that, fingers slid off it, 15 mm out along the door, and pressed on what is beside that. Higher on the
bar where the elbow folds too far else: the hand gives way, and was seen to rise by 10 mm."""
OVER_EDGE = (
    tuple(itertools.product((0.3, 0.0, 0.5, 0.7), (0.8, 0.9))),
    (-60.0, -45.0, -75.0, -90.0),
    FROM_ABOVE[2],
)
"""Contact points, tilts and turns of a hand behind a door that stands ajar: points towards the hinge, where
an arm still reaches, and slanting tilts first, so that the hand leaves the door's upper edge as it
follows."""
NEAR_HINGE = 0.5
"""Distance from the hinge, as a share of the handle's distance, below which a hand is tried last: it would
push with more than twice the force, and turn as much on half the way."""
OFF, FIRM = 0.008, 0.002
"""Error of a hand across a front [m], and the depth by which the fingers may come farther in with that error
and still count as meeting the front [m]: fingers at the last 10 mm of a bar, whose end is round, slid over
that, and came 45 mm farther in."""
DOWN = (-45.0, -35.0, -30.0)
"""Tilts of a hand that presses on a bar from above [deg]."""
UPRIGHT = 0.9
STEEP = 0.85  # downward part of the hand's approach beyond which it counts as pointing down
UP = np.array([0.0, 0.0, 1.0])
Hand = tuple[Floats, Pose, float, str]
"""Push by a hand: the level displacement (3,) of the thing, the TCP pose at its start, the opening of the
fingers [m], and a description of the hand."""


def hands_behind(
    thing: Thing,
    pose: Pose,
    apart: float,
    gripper: Gripper,
    area: Feature,
    frame: Pose,
    shares: Sequence[float] = SHARES,
    leans: Sequence[float] = (0.0,),
) -> Iterator[Hand]:
    """Yield hand poses with the fingers behind a thing, opened to the share ``apart`` of the thing's width.

    Args:
        leans: angles from straight down by which the fingers point ahead [deg].
    """
    low, top = -support(thing, pose, -UP), support(thing, pose, UP)
    for share, lean, turn in itertools.product(shares, leans, HALVES):
        way = towards(pose, area, frame, share)
        ahead, across, hand = _axes(way, turn)
        hand = Pose.from_rotvec((0, 0, 0), -math.radians(lean) * across) * hand
        tips = (gripper.pad[0] / 2, 0.0, gripper.pad[1] / 2)
        reach, under = (float(np.abs(hand.inverse().rotate(v)) @ tips) for v in (ahead, UP))
        back, left, right = (support(thing, pose, v) for v in (-ahead, across, -across))
        opening = min(gripper.opening[1], max(gripper.opening[0], apart * (left + right)))
        start = -(back + GAP + reach) * ahead + (left - right) / 2 * across
        at = Pose.at(start + (low + LOW * (top - low) + under) * UP, hand)
        leaning = f", leaning by {lean:.0f} deg" if lean else ""
        yield way, at, opening, f"turned {turn:.0f} deg{leaning}"


def hands_in(thing: Thing, pose: Pose, gripper: Gripper, way: Floats, last: Floats) -> Iterator[Hand]:
    """Yield hand poses with closed fingers inside a thing, just above its floor, that push the thing's rim.

    The push at the rim is in the direction ``last`` (3,).

    They stay there where they take it along by friction, and else come there in the end, where the rim stops
    them.

    Raises:
        Unresolvable: it has no rim there that fingers could take it along at.
    """
    rim, closed = False, gripper.opening[0]
    for spot, turn in itertools.product(AMID, EIGHTHS):
        ahead, across, hand = _axes(last, turn)
        left, right, front, back = (support(thing, pose, v) for v in (across, -across, ahead, -ahead))
        x, y, _ = ((left - right) / 2 + spot[1]) * across + ((front - back) / 2 + spot[0]) * ahead
        floor = _floor(thing, pose, Pose.at((x, y, support(thing, pose, UP)), hand), gripper)
        if floor is not None:
            rim, where = True, f", {1000 * spot[0]:+.0f} {1000 * spot[1]:+.0f} mm from its middle"
            at = Pose.at((x, y, floor + OVER + gripper.pad[1] / 2), hand)
            gap = max(free_ahead(thing, pose, at, ahead, closed, gripper) - PLAY, 0.0)
            said = f"turned {turn:.0f} deg{where if any(spot) else ''}"
            yield way, Pose.at(at.position + gap * ahead, at), closed, said
    if not rim:
        reason = f"'{thing.name}' has no hollow at its middle: fingers lowered there meet no rim to push"
        raise Unresolvable(reason, (), blocking=())


def towards(pose: Pose, area: Feature, frame: Pose, share: float) -> Floats:
    """Return the level displacement (3,) [m] that brings a thing's origin into the middle part of an area.

    ``share`` is that part's share of the area's sides; 0 is the very middle.
    """
    half, local = share * np.array(sides(area)) / 2, frame.inverse().apply(pose.position)
    target = frame.apply((*np.clip(local[:2], -half, half), 0.0))
    return np.array([*(target - np.asarray(pose.position))[:2], 0.0])


def sides(area: Feature) -> list[float]:
    """Side lengths of a rectangular area, or of the inscribed square of a round one [m]."""
    if "radius" in area.size:
        return [area.size["radius"] * math.sqrt(2)] * 2
    return [area.size["width"], area.size["depth"]]


def _axes(way: Floats, turn: float) -> tuple[Floats, Floats, Pose]:
    """Unit vectors (3,) along a level way and to its left, and the orientation of a hand that points down,
    turned by ``turn`` [deg] from that way."""
    ahead = way / float(np.linalg.norm(way))
    hand = Pose.from_axes((0, 0, 0), -UP, ahead) * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(turn)))
    return ahead, np.cross(UP, ahead), hand


def _floor(thing: Thing, pose: Pose, over: Pose, gripper: Gripper) -> float | None:
    """Highest point of a thing's floor under closed fingers, along z of the base frame [m]; None if the
    thing's rim is hardly higher than that.

    Args:
        over: of the fingers' tips, as high as the thing's rim.
    """
    half, grid = gripper.opening[0] / 2 + FINGER, np.linspace(-1.0, 1.0, 5)
    tips = over.apply(np.array([(x * gripper.pad[0] / 2, y * half, 0.0) for x in grid for y in grid]))
    to = pose.inverse()
    met = intervals(body(thing.geoms), to.apply(tips), np.tile(to.rotate(-UP), (len(tips), 1)))[0].min()
    return over.position[2] - float(met) if math.isfinite(met) and met >= DEEP else None


def free_ahead(
    thing: Thing, pose: Pose, hand: Pose, ahead: Floats, opening: float, gripper: Gripper
) -> float:
    """Distance that fingers at a TCP pose go straight ahead until they meet a thing [m]; ``GAP`` if they miss
    it."""
    reach, long = gripper.pad[0] / 2, gripper.pad[1]
    tips = [
        (x, s * y, long / 2 - z)
        for x in (reach, -reach)
        for s in (-1.0, 1.0)
        for y in np.linspace(opening / 2, opening / 2 + FINGER, 5)
        for z in np.linspace(0.0, long, 11)
    ]
    to = pose.inverse()
    rays = to.apply(hand.apply(np.array(tips))), np.tile(to.rotate(ahead), (len(tips), 1))
    low, high = intervals(body(thing.geoms), *rays)
    met = float(np.where(high > 0.0, low, np.inf).min())
    return max(met, 0.0) if math.isfinite(met) else GAP


def at_front(
    thing: Thing, joint: Joint, handle: Feature, pose: Pose, gripper: Gripper
) -> Iterator[tuple[Pose, str]]:
    """Yield TCP poses of closed fingers that face the front of a drawer or door, with descriptions, for
    pushing it.

    Fingers that may slip off come last, and after them those much nearer to the hinge than the handle is.
    """
    loose, near = list[tuple[Pose, str]](), list[tuple[Pose, str]]()
    far = NEAR_HINGE * lever(joint, handle.pose)
    over = AT_BAR if joint.kind == "hinge" else FROM_ABOVE
    for spot, tilt, turn in itertools.chain(itertools.product(SPOTS, TILTS, TURNS), itertools.product(*over)):
        at, firm = _against(thing, handle, pose, spot, (tilt, turn), gripper, joint.kind == "hinge")
        aside, up = (100 * share for share in spot)
        name = (
            f"before its front at {aside:+.0f} % of its width, {up:+.0f} % of its height, tilted "
            f"{tilt:+.0f} deg, turned {turn:.0f} deg"
        )
        if joint.kind == "hinge" and lever(joint, pose.inverse() * at) < far:
            near.append((at, name))
        elif firm:
            yield at, name
        else:
            loose.append((at, name))
    yield from (*loose, *near)


def at_inner_side(
    thing: Thing, joint: Joint, handle: Feature, pose: Pose, gripper: Gripper
) -> Iterator[tuple[Pose, str]]:
    """Yield TCP poses of closed fingers behind a door, over its upper edge, with descriptions, for pushing it
    open.

    Those much nearer to the hinge than the handle is come last.
    """
    near, far = list[tuple[Pose, str]](), NEAR_HINGE * lever(joint, handle.pose)
    out, up = _facing(pose * handle.pose, inner=True)
    to_hinge = np.subtract((pose * joint.pose).position, (pose * handle.pose).position)
    side = math.copysign(1.0, np.cross(up, out) @ to_hinge)
    for (aside, high), tilt, turn in itertools.product(*OVER_EDGE):
        at, _ = _against(thing, handle, pose, (side * aside, high), (tilt, turn), gripper, True, inner=True)
        name = (
            f"behind it {100 * aside:.0f} % of the way from its handle to its hinge, {100 * high:+.0f} % of "
            f"its height, tilted {tilt:+.0f} deg, turned {turn:.0f} deg"
        )
        if lever(joint, pose.inverse() * at) < far:
            near.append((at, name))
        else:
            yield at, name
    yield from near


def _against(
    thing: Thing,
    handle: Feature,
    pose: Pose,
    spot: tuple[float, float],
    turns: tuple[float, float],
    gripper: Gripper,
    swings: bool,
    inner: bool = False,
) -> tuple[Pose, bool]:
    """Return the TCP pose of closed fingers ``ALMOST`` [m] before the front of a door or drawer, and
    whether they would meet the front also ``OFF`` [m] to each side.

    Args:
        spot: how far from its handle, to a side and up, as shares of the way to the edge of the thing.
        turns: of the hand about the level line across the front, and about its own axis [deg].
        swings: of a door all of the fingers is clear of its bar, which slides along them; a drawer goes
            straight.
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
        # of the tips, a box as wide as the pads and as thick as two fingers, the corner farthest ahead
        ahead = np.abs(hand.inverse().rotate(out)) @ (gripper.pad[0] / 2, FINGER, gripper.pad[1] / 2)
        return Pose.at(point + out * (far + ahead + ALMOST), hand), True
    across = [OFF * way / np.linalg.norm(way) for way in (level, np.cross(out, level))]
    points = [point, *(point + sign * way for way in across for sign in (1.0, -1.0))]
    reach, *beside = (_clear_of(thing, pose, Pose.at(p, hand), out, gripper) for p in points)
    return Pose.at(point + out * (reach + ALMOST), hand), min(beside) > reach - FIRM


def _facing(handle: Pose, inner: bool) -> tuple[Floats, Floats]:
    """Direction away from the front of a drawer or door (or from its inner side), and the direction up along
    the front, as unit vectors."""
    out = np.asarray(handle.rotate((0.0, 0.0, -1.0 if inner else 1.0)))
    return out, UP if abs(out[2]) < UPRIGHT else np.asarray(handle.rotate((0.0, 1.0, 0.0)))


def _clear_of(thing: Thing, pose: Pose, hand: Pose, out: Floats, gripper: Gripper) -> float:
    """Return how far closed fingers at a TCP pose must move outwards until they are clear of the whole thing,
    its bars included [m]."""
    across, thick = np.linspace(-0.5, 0.5, 3) * gripper.pad[0], np.linspace(-FINGER, FINGER, 5)
    along = np.linspace(-gripper.depth, gripper.pad[1] / 2, 6)
    fingers, to = np.array(list(itertools.product(across, thick, along))), pose.inverse()
    rays = to.apply(hand.apply(fingers)), np.tile(to.rotate(out), (len(fingers), 1))
    _, high = intervals(body(thing.geoms), *rays)
    return max(float(high.max()), -gripper.depth)  # beside all of it, no farther in than to the palm


def upon(thing: Thing, handle: Feature, pose: Pose, turns: tuple[float, float], gripper: Gripper) -> Pose:
    """Return the TCP pose of closed fingers above a handle's bar: their lowest edge is ``ALMOST`` [m]
    above the top of the bar's middle."""
    hand = _turned(pose.rotate(handle.pose.rotate(UP)), UP, turns)
    met = spans(body(thing.geoms), np.asarray(handle.pose.position), pose.inverse().rotate(UP))
    top = max((end for begin, end, _ in met if begin <= 0.0), default=0.0)
    down = np.sign(np.round(hand.inverse().rotate(-UP), 3))
    edge = hand.rotate(down * (gripper.pad[0] / 2, 0.0, gripper.pad[1] / 2))
    return Pose.at((pose * handle.pose).position + UP * (top + ALMOST) - edge, hand)


def _turned(out: Floats, up: Floats, turns: tuple[float, float]) -> Pose:
    """Orientation of a hand that points at the front of a drawer or door, tilted about the front's level
    axis, then turned about the hand's own axis [deg]."""
    tilt, turn = map(math.radians, turns)
    tilted = Pose.from_axes((0, 0, 0), -out, np.cross(up, out)) * Pose.from_rotvec((0, 0, 0), (tilt, 0, 0))
    return tilted * Pose.from_rotvec((0, 0, 0), (0, 0, turn))

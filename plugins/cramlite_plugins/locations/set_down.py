"""Placements of a held thing: into a container's opening, or onto a surface.

Positions are generated best first and lazily; filters (``place_filters``) refuse them, each with its name and numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Location, Place, Pose, thing_of
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

from ..shapes.bounds import lowest
from .place_filters import CHEAP, DEAR, EDGE, Filter, Spot, Wanted

Offset = tuple[float, float]
FEW_YAWS = (0.0, 90.0, -45.0)  # away from the middle of a surface [deg]
GRID = 0.05  # of positions [m]
INSET = 0.12  # of what is nearest to a robot that drove, from the edge [m]
POSITIONS, FEW = 80, 9  # how many are looked at, and where nothing constrains them
PER_PLACE = 0.5  # cost of each position that comes before: more than any turn and height
YAWS = (
    0.0,
    30.0,
    -30.0,
    60.0,
    -60.0,
    90.0,
    -90.0,
    135.0,
    -135.0,
    180.0,
)  # turns about the vertical that are tried [deg]
INTO = (-0.08, -0.05, -0.02, 0.01, 0.04)  # lowest point of the thing above a container's rim when let go [m]
ONTO = (0.02,)  # the same above a surface, from where a guarded motion goes on [m]
ABOVE = 0.06  # stand-off above a rim or surface [m]
PER_TURN, PER_HEIGHT = 0.1, 0.02  # cost of a radian of turn, and of each height above the lowest


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Resolve locations "on" and "in"; None for other relations."""
    wanted = {"in": ("cram:Cavity", INTO), "on": ("vrps:SurfaceFeature", ONTO)}
    if location.relation not in wanted:
        return None
    return _spots(location, belief, context, *wanted[location.relation])


def _spots(
    location: Location, belief: Belief, context: Context, needs: str, heights: tuple[float, ...]
) -> Iterator[Grounding | Refused]:
    """Positions, best first; at each every turn, at the lowest height at which hand and thing are free."""
    wanted, now = _wanted(location, belief, context, needs), held_now(belief, context)
    cheap = CHEAP[location.relation]
    placed = {name: cheap[name] for name in ("near", "beside")}  # which no turn changes
    for k, offset in enumerate(_offsets(wanted, 1 if location.relation == "in" else FEW)):
        reason = _refusal(_spot(wanted, now, offset, 0.0, heights[0]), wanted, placed)
        if reason:
            yield Refused(f"at {_says(offset)}", *reason)
            continue
        for yaw in YAWS if k == 0 else FEW_YAWS:
            for answer in _turned(wanted, now, offset, yaw, heights, cheap):
                yield replace(answer, cost=answer.cost + PER_PLACE * k) if isinstance(answer, Grounding) else answer


def _turned(
    wanted: Wanted, now: Pose, offset: Offset, yaw: float, heights: tuple[float, ...], cheap: Mapping[str, Filter]
) -> Iterator[Grounding | Refused]:
    for k, height in enumerate(heights):
        spot = _spot(wanted, now, offset, yaw, height)
        reason = _refusal(spot, wanted, {**cheap, **DEAR})
        if not reason:
            place = Place(
                spot.pose, spot.before, approach=(0, 0, -1), thing=wanted.thing.name, values={"height_m": height}
            )
            cost = PER_TURN * abs(math.radians(yaw)) + PER_HEIGHT * k
            yield Grounding(place, f"'{wanted.entity}', {spot.name}", cost, key=spot.name)
            return
        yield Refused(spot.name, *reason)


def _refusal(spot: Spot, wanted: Wanted, filters: Mapping[str, Filter]) -> tuple[str, int] | None:
    """Which filter objects and why, and how many passed before it."""
    for passed, (name, objects) in enumerate(filters.items()):
        reason = objects(spot, wanted)
        if reason:
            return f"not {name}: {reason}", passed
    return None


def _wanted(location: Location, belief: Belief, context: Context, needs: str) -> Wanted:
    from ..motion_planning.reach import bound, make_scene

    entity = bound(context, location.of)
    feature = belief.feature(entity, needs)
    if feature is None:
        raise Unresolvable(f"'{entity}' has no {needs} to put anything {location.relation}", (location.of or "",))
    if belief.held is None:
        raise Unresolvable("nothing is held that could be brought there")
    thing, target = belief.world.thing(belief.held.thing), belief.pose(thing_of(entity)) * feature.pose
    return Wanted(thing, entity, feature, target, belief, context, make_scene(belief, context), location.parameters)


def held_now(belief: Belief, context: Context) -> Pose:
    """Return the current pose of what is held, in the base frame."""
    from ..motion_planning.reach import held_pose

    return held_pose(belief, context)


def _offsets(wanted: Wanted, few: int) -> list[Offset]:
    """Positions on the target in its frame, the middle first, then outwards; those near a thing nearest to it first. A
    robot that drove there begins with what is nearest to it: a table's middle may be out of reach from all sides.

    Args:
        few: how many are enough where nothing constrains them.
    """
    size = wanted.feature.size
    rows = [
        np.arange(0, size.get(name, 0.0) / 2 - EDGE, GRID) * sign
        for name, sign in (("width", 1), ("depth", 1), ("width", -1), ("depth", -1))
    ]
    xs, ys = np.unique(np.concatenate([rows[0], rows[2]])), np.unique(np.concatenate([rows[1], rows[3]]))
    every = [(float(x) + 0.0, float(y) + 0.0) for x in xs for y in ys] or [(0.0, 0.0)]
    other = wanted.where.get("near")
    at = np.zeros(2)
    if other:
        at = wanted.target.inverse().apply(wanted.belief.pose(other).position)[:2]
    elif wanted.belief.at is not None:
        rim = np.array([max(size.get(name, 0.0) / 2 - INSET, 0.0) for name in ("width", "depth")])
        at = np.clip(wanted.target.inverse().apply((0.0, 0.0, 0.0))[:2], -rim, rim)
    every.sort(key=lambda o: (round(math.dist(o, at), 4), o))
    return every[: POSITIONS if wanted.where else few]


def _spot(wanted: Wanted, now: Pose, offset: Offset, yaw: float, height: float) -> Spot:
    """Over a position of the target, upright as held, turned from facing it by ``yaw`` [deg]."""
    from ..motion_planning.reach import shift, tcp

    assert wanted.belief.held is not None
    hand, target = tcp(wanted.belief, wanted.context), wanted.target.apply((*offset, 0.0))
    facing = math.atan2(target[1], target[0]) - math.atan2(hand.position[1], hand.position[0])
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, facing + math.radians(yaw)))
    turned = (turn * Pose((0, 0, 0), now.quaternion)).quaternion
    thing = Pose((float(target[0]), float(target[1]), float(target[2]) + height - lowest(wanted.thing, now)), turned)
    pose = thing * wanted.belief.held.tcp_to_thing.inverse()
    name = f"turned {yaw:+.0f} deg, lowest point {1000 * height:+.0f} mm from it"
    if any(offset):
        name = f"{_says(offset)}, {name}"
    return Spot(name, thing, pose, shift(pose, (0, 0, max(ABOVE - height, ABOVE))), height)


def _says(offset: Offset) -> str:
    return f"({1000 * offset[0]:+.0f} {1000 * offset[1]:+.0f}) mm from its middle"

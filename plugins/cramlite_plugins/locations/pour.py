"""Pouring poses: the rim of the held vessel over an opening, and the poses in which it tilts about its rim.

The lip, the point of the rim over which the contents leave, stays over one point of the other vessel. While
the vessel is upright all of it is below its rim, so the lip begins higher, and comes down as the vessel
tilts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Feature, Location, Place, Pose, Thing
from cramlite.plugin import Answer, Context, Unresolvable

from ..motion_planning.reach import bound, held_pose
from ..shapes.bounds import lowest
from .parameters import Tilting, asked
from .reached import Arm, Candidate, Leg, reached

# Of lips about the vessel, of its headings [deg]
TURNS = (0.0, 90.0, -90.0, 45.0, -45.0, 135.0, -135.0, 180.0)
CLEAR = 0.015  # of the vessel above the other one's rim [m]
# The lip is this share of the opening's radius before its middle: what leaves it flies on (measured)
SHORT = 0.3
STEP = math.radians(6)  # between two poses of a path [rad]


def pour(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate paths on which the payload tilts over another vessel."""
    entity = bound(context, location.of)
    if belief.held is None:
        raise Unresolvable("nothing is held that could be poured from")
    source, now = belief.world.thing(belief.held.thing), held_pose(belief, context)
    opening, target = _opening(belief, entity, location)
    hand = belief.held.tcp_to_thing.inverse()

    def candidates() -> Iterator[Candidate]:
        for lip, heading in _ways(now, target):
            name = f"over its rim at {math.degrees(lip):+.0f} deg, towards {math.degrees(heading):+.0f} deg"
            path = tuple(
                p * hand for p in tilted(source, lip, heading, target, opening, asked(location, Tilting))
            )
            yield Candidate(
                name, Place(path[0], path[0], path=path, thing=source.name), (Leg(path[0], along=path[1:]),)
            )

    yield from reached(candidates(), Arm(belief, context))


def _opening(belief: Belief, entity: str, location: Location) -> tuple[Feature, Pose]:
    """The cavity of the vessel to pour into, and the pose of the cavity's opening in the base frame."""
    thing = belief.thing(entity)
    cavity = thing.feature("cram:Cavity")
    if cavity is None:
        raise Unresolvable(f"'{entity}' has no cram:Cavity to pour into", (location.of or "",))
    return cavity, belief.pose(thing.name) * cavity.pose


def _ways(now: Pose, target: Pose) -> list[tuple[float, float]]:
    """Pairs of angles for pouring [rad]: the rim's point to pour over (vessel's frame) and the heading (base
    frame), least turn first."""
    facing = math.atan2(target.position[1], target.position[0]) - math.atan2(now.position[1], now.position[0])
    yaw = math.atan2(float(now.rotate((1, 0, 0))[1]), float(now.rotate((1, 0, 0))[0])) + facing
    lips = [math.radians(a) for a in TURNS]
    ways = [(abs(math.radians(t)), lip, yaw + lip + math.radians(t)) for lip in lips for t in TURNS]
    ways.sort(key=lambda w: round(w[0], 6))
    return [(lip, math.remainder(heading, math.tau)) for _, lip, heading in ways]


def tilted(
    source: Thing, lip: float, heading: float, target: Pose, opening: Feature, asked: Tilting
) -> Iterator[Pose]:
    """Yield poses of the vessel from upright to tilted, base frame.

    Args:
        lip: azimuth of the lip in the vessel's frame [rad].
        heading: the horizontal direction in which it pours, base frame [rad].
        target, opening: of the other vessel.
        asked: angle, and height of the lip over the other vessel's rim.
    """
    cavity = source.feature("cram:Cavity")
    assert cavity is not None
    rim = np.asarray(
        cavity.pose.apply((*(radius(cavity, lip) * v for v in (math.cos(lip), math.sin(lip))), 0.0))
    )
    way = np.array([math.cos(heading), math.sin(heading), 0.0])
    over = np.asarray(target.position) - SHORT * radius(opening, heading) * way
    stand = Pose.from_rotvec((0, 0, 0), (0, 0, heading - lip))
    count = max(1, math.ceil(asked.tilt_rad / STEP))
    for k in range(count + 1):
        angle = asked.tilt_rad * k / count
        turn = Pose.from_rotvec((0, 0, 0), (-angle * float(way[1]), angle * float(way[0]), 0.0)) * stand
        below = float(turn.rotate(rim)[2]) - lowest(source, turn)
        up = np.array([0.0, 0.0, max(asked.height_m, CLEAR + below)])
        yield Pose.at(over + up - turn.rotate(rim), turn)


def radius(cavity: Feature, azimuth: float) -> float:
    """Return the distance from the middle of an opening to its rim [m] at an azimuth [rad]."""
    if "radius" in cavity.size:
        return cavity.size["radius"]
    half = (cavity.size["width"] / 2, cavity.size["depth"] / 2)
    return min(
        h / max(abs(v), 1e-9) for h, v in zip(half, (math.cos(azimuth), math.sin(azimuth)), strict=True)
    )

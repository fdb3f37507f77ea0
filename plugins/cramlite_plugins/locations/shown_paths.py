"""Places on a path that demonstrations showed: the middle of the payload's lower face follows it, in the
frame of a reference object, or about the payload's own place."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Floats, Location, Place, Pose, ShownPath, Thing, foot
from cramlite.plugin import Answer, Context, Unresolvable

from ..motion_planning.reach import bound, held_pose, reference_pose, shift, taken_at
from .parameters import Followed, asked
from .reached import Arm, Candidate, Leg, reached

TURNS = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
"""Turns of the payload about the vertical from how it is held [deg], for paths whose demonstrations state no
heading."""
STARTS = 4
"""Number of places on a closed path from which a motion along it may start."""


def followed(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate ways along a shown path; along a closed path one full round, from several starts and in both
    directions."""
    path, entity = asked(location, Followed).path, bound(context, location.of)
    now = held_pose(belief, context)
    thing, about = belief.world.thing(belief.payload.thing), belief.thing(entity)
    if path.anchor.own:
        yield from _in_place(path, thing, now, belief, context)
        return
    frame = path.anchor.frame((f.type, f.pose, f.size) for f in about.features)
    if frame is None:
        reason = f"'{about.name}' has no {path.anchor.part}, relative to which the path was demonstrated"
        raise Unresolvable(reason, (location.of or "",))
    pose, under = reference_pose(belief, location, context) * frame[0], foot(thing.geoms)
    hand = belief.payload.tcp_to_thing.inverse()
    touching = (about.name,) if path.touching else ()
    turns = TURNS if path.heading is None else _aimed(thing, now, path.heading + _yaw(pose))

    def candidates() -> Iterator[Candidate]:
        for degrees, (name, corners) in itertools.product(turns, ways(path)):
            turned = Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(degrees))) * now
            below, size = turned.rotate(under), frame[1]
            places = (pose.apply((x * size, y * size, z)) - below for x, y, z in corners.tolist())
            way = tuple(Pose.at(place, turned) * hand for place in places)
            before = shift(way[0], (0.0, 0.0, path.stand_off))
            legs = (
                Leg(before, along=way[:1], touching=touching),
                Leg(way[0], touching, clearance=0.0, along=way[1:]),
            )
            place = Place(
                way[0], before, path=way[1:], approach=(0.0, 0.0, -1.0), thing=about.name,
                rounds=path.times if path.closed else 1,
            )  # fmt: skip
            yield Candidate(f"{name}, turned by {degrees:+.0f} deg", place, legs)

    yield from reached(candidates(), Arm(belief, context), taken_at(belief, context))


def _in_place(
    path: ShownPath, payload: Thing, now: Pose, belief: Belief, context: Context
) -> Iterator[Answer]:
    """Generate repeated motions along a path from the payload's present place, with the path turned to
    several headings."""
    hand = belief.payload.tcp_to_thing.inverse()

    def candidates() -> Iterator[Candidate]:
        for degrees in TURNS:
            corners = path.corners @ Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(degrees))).rotation.T
            way = tuple(shift(now, c) * hand for c in corners)
            place = Place(way[0], way[0], path=way[1:], thing=payload.name, rounds=path.times)
            legs = (Leg(way[0], clearance=0.0, along=way[1:]),)
            yield Candidate(f"about its own place, headed {degrees:+.0f} deg", place, legs)

    yield from reached(candidates(), Arm(belief, context), taken_at(belief, context))


def _yaw(frame: Pose) -> float:
    """Direction of a frame's x axis, seen from above [rad]."""
    return math.atan2(frame.rotation[1, 0], frame.rotation[0, 0])


def _aimed(payload: Thing, now: Pose, heading: float) -> tuple[float, ...]:
    """Turns about the vertical that bring a payload's x axis to a heading [deg]; a box looks the same
    after half a turn."""
    turn = math.degrees(math.remainder(heading - _yaw(now), math.tau))
    alike = len(payload.geoms) == 1 and payload.geoms[0].shape == "box"
    return (turn, math.remainder(turn + 180.0, 360.0)) if alike else (turn,)


def ways(path: ShownPath) -> Iterator[tuple[str, Floats]]:
    """Yield the orders in which a payload may follow the corners of a shown path, each with its name for
    people.

    A closed path may be begun at several corners, and be followed backwards if ``either`` is set.
    """
    corners = path.corners
    if not path.closed:
        yield "from its beginning to its end", corners
        return
    ring = corners[:-1]
    for k, back in itertools.product(range(STARTS), (False, True) if path.either else (False,)):
        begun = np.roll(ring[::-1] if back else ring, -(k * len(ring) // STARTS), axis=0)
        yield (
            f"one round{' backwards' if back else ''} from start {k} of {STARTS}",
            np.concatenate([begun, begun[:1]]),
        )

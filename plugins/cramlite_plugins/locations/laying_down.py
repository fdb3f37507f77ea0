"""Laying down of a thing that hangs from the fingers at its rim: its far side comes down first, then the hand
lowers its near side.

The hand keeps its attitude, in which it took hold of the thing where that lay: as its far side is held up by
what it is put onto, the thing turns back between the pads as it swung when it was lifted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Held, Location, Pose, Swing, Thing, thing_of
from cramlite.plugin import Answer, Context, Grounding, Refused

from ..motion_planning.reach import bound, collision_free_ik, make_scene, shift
from ..shapes.bounds import corners
from ..shapes.nesting import room_under

PART = math.radians(10.0)  # of the turn on each line: the chord of an arc of 0.13 m is then 0.5 mm from it
OVER = 0.001  # the surface its lowest point is led along [m]
ABOVE = 0.03  # the first contact the way begins [m]
LEFT = 0.008
"""Height of the hand above the end of its way down when it lets go of a payload [m]: over the last 7 mm, pads
that creep down a flattening rim would press the near side down and the far one up."""
PRESSED = 0.003  # below its first contact the edge of a hanging thing is led [m]: so far off may an arm be
EDGE = 0.0005  # points that are no higher than this over the lowest one touch as well [m]

Spots = Callable[[Location, Belief, Context], Iterator[Answer]]


def laid_down(location: Location, belief: Belief, context: Context, spots: Spots) -> Iterator[Answer]:
    """Yield placements that lay down a payload which hangs from the fingers, each with the path on which it
    turns.

    Args:
        spots: placements of what is held fast.
    """
    swing = belief.payload.swing
    assert swing is not None
    lying = replace(belief, held=replace(belief.payload, tcp_to_thing=swing.start))
    for answer in spots(location, lying, context):
        yield answer if isinstance(answer, Refused) else _led(answer, location, belief, context)


def hung(answer: Answer, held: Held) -> Answer:
    """Change a placement such that a hanging payload is released as it hangs, without being turned in the
    hand before."""
    if isinstance(answer, Refused) or held.swing is None:
        return answer
    place, hangs = answer.value, held.tcp_to_thing
    low = shift(place.pose, (0.0, 0.0, -place.release.height_m - PRESSED))
    settles = (low * hangs).inverse() * place.pose * hangs * place.release.settles
    led = replace(
        place, pose=low, via=place.via or (place.pose,), swing=Swing(hangs, hangs, held.swing.pivot),
        release=replace(place.release, height_m=0.0, settles=settles),
    )  # fmt: skip
    return replace(answer, value=led)


def _led(answer: Grounding, location: Location, belief: Belief, context: Context) -> Answer:
    """Placement with the path that lays the payload down, or the refusal if the arm cannot follow that
    path."""
    held, place = belief.payload, answer.value
    assert held.swing is not None
    lies = shift(place.pose, (0.0, 0.0, OVER - place.release.height_m))
    thing = belief.world.thing(held.thing)
    onto = bound(context, location.of)
    below = belief.thing(onto), belief.pose(thing_of(onto))
    share, hand = released(*rolled(thing, lies, held.swing, below))
    swing = held.swing.part(share, 1.0)
    settles = (hand * swing.start).inverse() * lies * held.swing.start * place.release.settles
    shares, way = rolled(thing, hand, swing, below)
    before, seed = shift(way[0], (0.0, 0.0, ABOVE)), belief.joints
    touching = ((s, h, (onto,)) for s, h in zip(shares, way, strict=True))
    for share, hand, touch in ((1.0, before, ()), *touching):
        there = replace(belief, held=replace(held, tcp_to_thing=swing.at(share)))
        scene = make_scene(there, context, touch, clearance=0.0, hand=False)
        found = collision_free_ik(scene, context, hand, seed)
        if isinstance(found, Refused):
            said = f"{answer.key}, laid down, {math.degrees(_angle(swing)) * share:.0f} deg to go"
            return replace(found, reason=f"not led down: {found.reason}").of(said)
        seed = found
    led = replace(
        place, pose=way[0], before=before, path=tuple(way[1:]), swing=swing,
        release=replace(place.release, settles=settles),
    )  # fmt: skip
    return replace(answer, value=led, reason=f"{answer.reason}, lowered by a turn about its far side")


def released(shares: list[float], hands: list[Pose]) -> tuple[float, Pose]:
    """Return the share of the payload's swing at which the hand lets go, and the TCP pose there.

    That pose is ``LEFT`` [m] above the end of the hand's way down.

    Args:
        shares, hands: as ``rolled`` returns them.
    """
    ways = np.array([hand.position for hand in hands])
    share = float(np.interp(ways[-1, 2] + LEFT, ways[::-1, 2], shares[::-1]))
    return share, Pose.at([np.interp(share, shares[::-1], way) for way in ways[::-1].T], hands[-1])


def rolled(
    thing: Thing, lies: Pose, swing: Swing, below: tuple[Thing, Pose] | None = None
) -> tuple[list[float], list[Pose]]:
    """Return TCP poses that lay a hanging thing down as it rolls over its lowest edge, with shares of the
    swing from 1 (hanging) to 0 (lying).

    It rolls on the level where it will lie, or on what is higher than that, such as the rim of a plate below.

    Args:
        lies: the TCP there.
        below: what it is put onto, and its pose.
    """
    count = max(1, math.ceil(_angle(swing) / PART))
    shares, hands, now = [0.0], [lies], lies * swing.start
    floor = float(corners(thing, now)[:, 2].min())
    for k in range(1, count + 1):
        at = swing.at(k / count)
        now = _resting(thing, Pose.at((0.0, 0.0, 0.0), lies * at), now, floor)
        over = max(0.0, -room_under(thing, now, *below)) if below else 0.0
        now = shift(now, (0.0, 0.0, over))
        shares.append(k / count)
        hands.append(now * at.inverse())
    return shares[::-1], hands[::-1]


def _resting(thing: Thing, turned: Pose, before: Pose, floor: float) -> Pose:
    """Pose of a thing that has rolled on the floor to another orientation: its now lowest edge is on the
    floor, where that edge was before."""
    points: Floats = corners(thing, turned)
    low = points[:, 2].min()
    edge = points[:, 2] < low + EDGE
    by = corners(thing, before)[edge].mean(axis=0) - points[edge].mean(axis=0)
    return Pose.at((by[0], by[1], floor - low), turned)


def _angle(swing: Swing) -> float:
    return math.hypot(*(swing.start.inverse() * swing.end).rotvec)


def dropped(thing: Thing, hand: Pose, swing: Swing) -> float:
    """Return how much farther below the hand the payload's lowest point is when it hangs than when it lies
    [m]."""
    lying, hanging = (float(corners(thing, hand * at)[:, 2].min()) for at in (swing.start, swing.end))
    return lying - hanging

"""Hand poses near a thing, for the empty hand or the payload: above, below, left or right of it, or between
it and the robot."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Floats, Location, Place, Pose
from cramlite.plugin import Answer, Context, Refused

from ..motion_planning.reach import bound, reference_pose, shift, tcp
from ..predicates.places import NEAR
from ..shapes.bounds import support
from .reached import Arm, Candidate, Leg, reached

GAPS = (0.03, 0.06)
"""Gaps between a thing and the hand or payload that is brought near it [m]: wider than the clearance of
paths, and narrow enough that most things that fit a hand are then within ``NEAR``."""
TURNS = (0.0, 45.0, -45.0, 90.0, -90.0)  # of the hand about the vertical, from facing it [deg]
PER_TURN = 0.1  # cost of a radian of turn, as in placing
PER_METRE = 1.0  # cost of the way there: the nearest place that is near is near enough


def near_thing(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate one place on each side of a thing, the nearest side first.

    What fails later at one place fails in all turns and at all distances of its side, and each of those would
    be searched.
    """
    there, entity = reference_pose(belief, location, context), bound(context, location.of)
    hand, to_body = tcp(belief, context), belief.held.tcp_to_thing if belief.held else Pose()
    now, options = Pose.at((0, 0, 0), hand * to_body), []
    for side, name, point, gap in _around(entity, there, now, belief):
        if gap >= NEAR:
            reason = (
                f"its middle would be {1000 * gap:.0f} mm away; less than {1000 * NEAR:.0f} mm count as near"
            )
            yield Refused(name, reason, numbers={"gap_m": gap, "limit_m": NEAR}, blocking=())
            continue
        facing = math.atan2(point[1], point[0]) - math.atan2(hand.position[1], hand.position[0])
        for yaw in TURNS:
            turned = Pose.from_rotvec((0, 0, 0), (0, 0, facing + math.radians(yaw))) * now
            pose = shift(turned, point) * to_body.inverse()
            cost = PER_METRE * math.dist(pose.position, hand.position) + PER_TURN * abs(math.radians(yaw))
            said = f"{name} '{entity}', turned {yaw:+.0f} deg"
            one = Candidate(said, Place(pose, pose), (Leg(pose),), cost=cost, group=side)
            options.append((cost, said, one))
    ordered = (one for *_, one in sorted(options, key=lambda option: option[:2]))
    yield from reached(ordered, Arm(belief, context))


def _around(entity: str, there: Pose, now: Pose, belief: Belief) -> Iterator[tuple[str, str, Floats, float]]:
    """Positions beside a thing, one for each side and gap: side, name, position of the hand's or payload's
    origin in the base frame, distance [m]."""
    thing, held = belief.thing(entity), belief.thing(belief.held.thing) if belief.held else None
    out = np.array([*there.position[:2], 0.0]) / max(math.hypot(*there.position[:2]), 1e-9)
    side, up = np.array([-out[1], out[0], 0.0]), np.array([0.0, 0.0, 1.0])
    middle = np.array([support(thing, there, w) - support(thing, there, -w) for w in np.eye(3)]) / 2
    ways = {"above": up, "before": -out, "left of": side, "right of": -side, "below": -up}
    for name, way in ways.items():
        own = support(held, now, -way) if held else 0.0
        reach = support(thing, there, way) - float(middle @ way)
        for gap in GAPS:
            yield name, f"{1000 * gap:.0f} mm {name}", middle + way * (reach + gap + own), gap + own

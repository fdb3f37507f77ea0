"""Orientations of a payload in the hand: upright or leaning with its far edge down, in a hand that points
into the target from the side; and lying below a hand that points down."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from cramlite.model import Floats, Pose, Thing, Vector3

from ...shapes.bounds import height
from ...shapes.standing_up import carrying_faces, stood_up, turned_down
from ...shapes.surfaces import LEVEL
from .query import Query
from .stable_poses import TURNLESS, put_down

PITCHES = (0.0, 20.0)  # of a hand that points inwards, downwards [deg]
LEVEL_FINGERS, UPRIGHT_FINGERS = ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0)), ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
"""Closing directions of a hand that points into a target from the side: fingers level, or one above the
other."""
STEEPER = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0)
"""Pitches of a hand whose fingers are one above the other [deg]: a hand is broad in that direction, and
over a floor it has room only from above."""
FLAT_FALL = math.radians(32.0)  # lean of a flat thing from lying, from which it falls flat once released

POINTS_DOWN = -math.sin(math.radians(30.0))
"""Largest upward component of a hand's unit approach vector above a payload that lies in a container: a hand
that is more level is in the walls."""
LOWER = 0.01  # by which a payload must be lower on a side than it stands, to be laid on that [m]


def attitudes(query: Query, upright: Pose) -> Iterator[tuple[str, Pose]]:
    """Generate orientations of a payload for its release: upright, and as held by a hand that points into the
    target from the side.

    One that hangs from the fingers is released with its far edge down. Each has a kind of placement: "on" or
    "within" for a payload that then stands, "dropped" for one that falls over.
    """
    turned = not query.where.attitude and query.thing.filling is None and not query.held.carries
    stands = "within" if query.depth else "on"
    if query.held.swing is not None:
        for lean, now in far_edge_down(query) if turned else ():
            yield stands if lean <= LEVEL else "dropped", now
        return
    yield stands, upright
    for pitch, across in product(PITCHES if turned else (), LEVEL_FINGERS):
        now = _pointing(query, pitch, across)
        yield stands if stood_up(query.thing, now).distance(now)[1] <= TURNLESS else "dropped", now


def lying(query: Query) -> Iterator[Pose]:
    """Generate orientations in which a payload lies on a side, lower than it stands, below a hand that points
    down; the steepest hand first."""
    now, found = put_down(query), list[tuple[float, int, Pose]]()
    for k, turned in enumerate(sides_down(query.thing, now)):
        up = float(query.hand(turned).rotate((0.0, 0.0, 1.0))[2])
        if up <= POINTS_DOWN:
            found.append((round(up, 2), k, turned))
    yield from (turned for _, _, turned in sorted(found, key=lambda one: one[:2]))


def sides_down(thing: Thing, now: Pose) -> list[Pose]:
    """Return the orientations of a thing on those of its sides on which it is lower than at the pose ``now``,
    each turned the shortest way."""
    turned = (turned_down(now, face) for face in carrying_faces(thing))
    return [pose for pose in turned if height(thing, pose) < height(thing, now) - LOWER]


def far_edge_down(query: Query) -> Iterator[tuple[float, Pose]]:
    """Generate orientations of a payload in a hand with one finger above the other, each with its lean from
    lying flat [rad].

    The lean is at most ``FLAT_FALL``. The hand points along x, and the less downwards the earlier it comes.
    """
    face = _face(query)
    if face is None:
        return
    for pitch, across in product(STEEPER, UPRIGHT_FINGERS):
        now = _pointing(query, pitch, across)
        x, _, z = now.rotate(face)
        if x <= math.sin(LEVEL) and (lean := math.acos(max(-1.0, min(1.0, -float(z))))) <= FLAT_FALL:
            yield lean, now


def _face(query: Query) -> Floats | None:
    """Outward normal (3,) of the face on which a hanging payload lay when it was grasped; None if no face
    is fit to lie on."""
    faces, swing = carrying_faces(query.thing), query.held.swing
    if swing is None:
        return None
    down = swing.start.inverse().rotate((0.0, 0.0, 1.0))
    return max(faces, key=lambda face: float(face @ down), default=None)


def _pointing(query: Query, pitch: float, across: Vector3) -> Pose:
    """Pose of a payload in a hand that points along the base's x axis, tilted downwards by an angle [deg].

    Args:
        across: direction (3,) nearest to which the fingers close.
    """
    ahead = (math.cos(math.radians(pitch)), 0.0, -math.sin(math.radians(pitch)))
    return (
        Pose.from_axes(query.hand(query.now).position, ahead, np.cross(across, ahead))
        * query.held.tcp_to_thing
    )

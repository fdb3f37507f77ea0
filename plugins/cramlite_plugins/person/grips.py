"""Grasps that a person considers: by a handle, else around the body of a thing or a part of it, the handiest first.

What a thing has says how people take it: a handle is taken by it, what hangs by a hole from the front and below the hole, a vessel
from the side, so that nothing is over its opening; everything else from above.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Feature, Floats, Pose, Thing, Value
from cramlite.plugin import Performer

from ..shapes.bounds import box_around
from ..simulation.model.hand_model import FARTHEST, OPENING
from .at_ease import forward_and_down
from .hand_moves import MARGIN

#: From the top of a thing down to the middle of the pads that hold it from above [m]: most of the pads' half length.
DEEP = 0.013
#: The wrist's half thickness and 7 mm: so far above what a thing stands on is a hand that comes from the side [m].
FLOOR = 0.035
#: How far below a hole the hand is that holds the thing from the front: the palm's half width and 20 mm [m].
BELOW_HOLE = 0.07
#: From the fingertips' middle to the palm, less 10 mm [m]: nothing reaches farther into the hand.
REACH = 0.055
#: Along the approach, the hand is free of everything from so far away on [m].
AWAY = (0.0, 0.03, 0.06, 0.1)
UP = np.array([0.0, 0.0, 1.0])
#: A wrist is turned by less than this from rest to take something [rad]: 45 degrees less than it can, for what it then does.
TURNED = FARTHEST - math.radians(45)
#: Cosine of the largest angle from the vertical at which an approach counts as one from above: 25 degrees.
STEEP = 0.9


class PersonGrip(Value):
    """A grasp: where the tool frame is when the fingers close, in the world, and the width between them then [m]."""

    tool: Pose
    width: float

    @property
    def opening(self) -> float:
        """Return the opening with which the fingers go around the thing [m]."""
        return min(self.width + 2 * MARGIN, OPENING)


def choose_grip(person: Performer, thing: Thing, ahead: Floats) -> PersonGrip | None:
    """Choose the first grasp that the hand can reach without touching anything; None where there is none.

    Args:
        ahead: unit vector (3,) that the person looks along, world axes.
    """
    return next((g for g in _grips(thing, person.pose(thing.name), ahead) if _is_free(person, g)), None)


def _is_free(person: Performer, grip: PersonGrip) -> bool:
    return all(person.fits(grip.tool * Pose((0, 0, -back)), grip.opening) for back in AWAY)


def _grips(thing: Thing, pose: Pose, ahead: Floats) -> Iterator[PersonGrip]:
    """All grasps of a thing that fit the hand, the handiest first.

    Each is tried with the hand as it is and turned by half a turn, the orientation nearer to the hand's rest
    orientation first.
    """
    rest = forward_and_down(ahead)
    for grip in (*_by_handle(thing, pose), *_by_body(thing, pose, ahead)):
        if grip.width + MARGIN <= OPENING:
            both = (grip.tool, grip.tool * Pose((0, 0, 0), (0, 0, 0, 1)))
            yield from (PersonGrip(t, grip.width) for t in sorted(both, key=lambda t: rest.distance(t)[1]) if rest.distance(t)[1] < TURNED)


def _by_handle(thing: Thing, pose: Pose) -> Iterator[PersonGrip]:
    """Grasps across a handle's bar, upright or level, approaching against the handle's outward direction."""
    handle = thing.feature("cram:Handle")
    if handle is None:
        return
    at = pose * handle.pose
    width = handle.size.get("width", 2 * handle.size.get("radius", 0.01))
    for closing in (np.cross(UP, at.rotate((0, 0, 1))), UP):
        yield PersonGrip(_tool(at.position, -at.rotate((0, 0, 1)), closing), width)


def _by_body(thing: Thing, pose: Pose, ahead: Floats) -> Iterator[PersonGrip]:
    """Grasps around the whole body of a thing, then around its single parts."""
    if thing.joint is not None:  # a drawer or a door is moved by its handle
        return
    body = [g for g in thing.geoms if not g.part] or list(thing.geoms)
    boxes = [box_around(body), *(box_around([g]) for g in body)]
    hole = thing.feature("vrps:Hole")
    for low, high in boxes:
        yield from _around(low, high, pose, hole, _preferred(thing, pose, hole, ahead))


def _preferred(thing: Thing, pose: Pose, hole: Feature | None, ahead: Floats) -> list[Floats]:
    """Directions (3,) in which a person's hand may approach a thing, world axes, the handiest first."""
    aside = np.cross(ahead, UP)
    sides = [ahead, aside, -aside, -ahead]
    if hole is not None:
        front = -(pose * hole.pose).rotate((0, 0, 1))
        return [front, -UP, *sides]
    return [*sides, -UP] if thing.feature("cram:Cavity") is not None else [-UP, *sides]


def _around(low: Floats, high: Floats, pose: Pose, hole: Feature | None, ways: list[Floats]) -> Iterator[PersonGrip]:
    """Generate grasps around a box, whose corners are given in the thing's frame.

    The directions of approach are taken in their order, and for each the narrow side of the box comes first.
    """
    size = np.subtract(high, low)
    for way in ways:
        local = pose.inverse().rotate(way)
        axis = int(np.argmax(np.abs(local)))
        approach = np.sign(local[axis]) * np.eye(3)[axis]
        others = [k for k in range(3) if k != axis]
        if not way @ UP < -STEEP:  # from the side the fingers close level: palm and wrist stay off the ground
            others = [k for k in others if abs(pose.rotate(np.eye(3)[k]) @ UP) < 0.5]
        place = _place(low, high, pose, approach, axis, hole)
        for k in sorted(others, key=lambda k: float(size[k])):
            yield PersonGrip(_tool(pose.apply(place), pose.rotate(approach), pose.rotate(np.eye(3)[k])), float(size[k]))


def _place(low: Floats, high: Floats, pose: Pose, approach: Floats, axis: int, hole: Feature | None) -> Floats:
    """Place of the pads on a box, in the thing's frame: as deep as the hand reaches, and off the ground."""
    middle, half = np.add(low, high) / 2, np.subtract(high, low) / 2
    from_above = float(pose.rotate(approach) @ UP) < -STEEP
    depth = min(half[axis], DEEP) if from_above else min(half[axis], REACH)
    place = np.asarray(middle - approach * (half[axis] - depth))
    if from_above:
        return place
    up = pose.inverse().rotate(UP)
    k = int(np.argmax(np.abs(up)))
    if k != axis:
        rise = max(FLOOR - half[k], 0.0)
        if hole is not None:
            rise = min(rise, float(hole.pose.position[k] * np.sign(up[k])) - BELOW_HOLE - float(middle[k] * np.sign(up[k])))
        place[k] += np.sign(up[k]) * rise
    return place


def _tool(place: Floats | tuple[float, float, float], approach: Floats, closing: Floats) -> Pose:
    return Pose.from_axes(tuple(place), approach, np.cross(closing, approach))

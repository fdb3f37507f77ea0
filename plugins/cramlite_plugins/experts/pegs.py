"""How to lead a held thing's hole off a peg, or onto it: lift to the middle, along the axis, over the bent tip."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cramlite import Answers, Belief, Context, Grounding, Location, Unresolvable, hookimpl
from cramlite.geometry import Floats

CLEAR = 0.04  # past the tip before a pull ends, and where a push begins [m]: more than a tab's rim, 8 mm
DEEPEST = 0.06  # how far onto the peg a thing is pushed at most [m]: 60 mm deep was measured to hang safely
PLAY = 0.0003  # least radial play of a hole on a peg that moves [m]: MuJoCo's resting contact depth


@dataclass(frozen=True)
class Peg:
    """A peg and a hole, vectors in the base frame.

    Args:
        root, axis: where the peg begins, and its direction towards the tip.
        length: of its straight part [m].
        over_tip: from the end of the straight part to the end of the tip [m].
        play: radial play of the hole on the peg [m].
        hole: the hole's centre.
    """

    root: Floats
    axis: Floats
    length: float
    over_tip: Floats
    play: float
    hole: Floats

    @property
    def along(self) -> float:
        """How far from the root the hole is, along the axis [m]."""
        return float((self.hole - self.root) @ self.axis)

    @property
    def to_middle(self) -> Floats:
        """Up to where the peg passes through the middle of the hole: no rim is jammed there."""
        sunk = float(self.root[2] + self.along * self.axis[2] - self.hole[2])
        return np.array([0.0, 0.0, min(max(sunk, 0.0), self.play)])


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    ways = {"extract": _extract, "insert": _insert}
    way = ways.get(location.relation)
    return way(location, belief, context) if way else None


def _extract(location: Location, belief: Belief, context: Context) -> Iterator[Grounding]:
    from .reach import causes, traverse

    peg = find_peg(location, belief, context)
    if not 0 <= peg.along <= peg.length:
        where = f"the hole is {1000 * peg.along:.0f} mm along a peg of {1000 * peg.length:.0f} mm: not on it"
        raise Unresolvable(where, causes(location, context))
    rest = peg.length - peg.along
    steps = (peg.to_middle, peg.axis * rest, peg.over_tip, peg.axis * CLEAR)
    yield traverse(
        location, belief, context, np.cumsum(steps, axis=0), f"{1000 * rest:.0f} mm along the peg, over its tip"
    )


def _insert(location: Location, belief: Belief, context: Context) -> Iterator[Grounding]:
    from .reach import traverse

    peg = find_peg(location, belief, context)
    depth = min(peg.length / 2, DEEPEST)
    start = peg.root + peg.axis * (peg.length + CLEAR) + peg.over_tip - peg.hole
    steps = (start, -peg.axis * CLEAR, -peg.over_tip, -peg.axis * depth)
    yield traverse(
        location, belief, context, np.cumsum(steps, axis=0), f"over the tip, {1000 * depth:.0f} mm along the peg"
    )


def find_peg(location: Location, belief: Belief, context: Context) -> Peg:
    """The peg that a location is about, and the hole of what is held.

    Raises:
        Unresolvable: one of them is missing, or the peg is too thick for the hole.
    """
    from .reach import bound, causes, held_pose

    thing = held_pose(belief, context)
    assert belief.held is not None
    owner, held = belief.thing(bound(context, location.of)), belief.world.thing(belief.held.thing)
    peg, tip, hole = owner.feature("vrps:Peg"), owner.feature("vrps:Tip"), held.feature("vrps:Hole")
    if peg is None or hole is None:
        missing = f"'{owner.name}' has no peg" if peg is None else f"'{held.name}' has no hole"
        raise Unresolvable(missing, causes(location, context))
    diameter, thickness = hole.size["diameter"], 2 * peg.size["radius"]
    if diameter / 2 - thickness / 2 <= PLAY:
        reason = f"a hole of {1000 * diameter:.1f} mm does not move on a peg of {1000 * thickness:.1f} mm"
        raise Unresolvable(reason, causes(location, context))
    base, length = belief.pose(owner.name), peg.size["length"]
    root = base * peg.pose
    end = root.apply((0, 0, length))
    over = np.array((base * tip.pose).position) - end if tip else np.zeros(3)
    hole_at = np.array((thing * hole.pose).position)
    return Peg(np.array(root.position), root.turn((0, 0, 1)), length, over, (diameter - thickness) / 2, hole_at)

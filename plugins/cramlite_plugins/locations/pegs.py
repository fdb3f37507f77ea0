"""Paths of a held thing's hole off a peg, or onto it: lift to the middle, along the axis, over the bent tip."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Location, Place, Pose, Value
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

if TYPE_CHECKING:
    from ..motion_planning.space import Refusal

CLEAR = 0.04  # past the tip before a pull ends, and where a push begins [m]: more than a tab's rim, 8 mm
DEEPEST = 0.06  # how far onto the peg a thing is pushed at most [m]: 60 mm deep was measured to hang safely
SAME = 0.002  # a thing this near to where it was has not been moved: grasping shifts it by less [m]
PLAY = 0.0003  # least radial play of a hole on a peg that moves [m]: MuJoCo's resting contact depth


class Peg(Value):
    """Peg and the hole on it, vectors in the base frame.

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
        """Return the distance of the hole from the root, along the axis [m]."""
        return float((self.hole - self.root) @ self.axis)

    @property
    def to_middle(self) -> Floats:
        """Return the upward shift (3,) [m] that brings the peg to the middle of the hole: no rim is jammed there."""
        sunk = float(self.root[2] + self.along * self.axis[2] - self.hole[2])
        return np.array([0.0, 0.0, min(max(sunk, 0.0), self.play)])


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Resolve locations "extract" and "insert"; None for other relations."""
    ways = {"extract": _extract, "insert": _insert}
    way = ways.get(location.relation)
    return way(location, belief, context) if way else None


def _extract(location: Location, belief: Belief, context: Context) -> Iterator[Grounding]:
    from ..motion_planning.reach import causes, traverse

    peg = find_peg(location, belief, context)
    if not 0 <= peg.along <= peg.length:
        where = f"the hole is {1000 * peg.along:.0f} mm along a peg of {1000 * peg.length:.0f} mm: not on it"
        far = max(-peg.along, peg.along - peg.length) > SAME
        if far and _unmoved(belief, context):
            meant = tuple(name for name, value in context.bindings.items() if isinstance(value, str))
            raise Unresolvable.because_of_earlier_tasks(where, meant)
        raise Unresolvable(where, causes(location, context))
    rest = peg.length - peg.along
    steps = (peg.to_middle, peg.axis * rest, peg.over_tip, peg.axis * CLEAR)
    yield traverse(
        location, belief, context, np.cumsum(steps, axis=0), f"{1000 * rest:.0f} mm along the peg, over its tip"
    )


def _insert(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """The hole before the tip, its y axis up, from either side; then at the tip, past its bend, deep, let down.

    The path's corners are the last four; ``values`` has the radial play and the way to push from tip to deep.
    """
    from ..motion_planning.reach import causes

    peg = find_peg(location, belief, context)
    depth = min(peg.length / 2, DEEPEST)
    tip = peg.root + peg.axis * peg.length + peg.over_tip
    steps = np.array(
        [peg.axis * CLEAR, -peg.axis * CLEAR, -peg.over_tip, -peg.axis * depth, np.array([0.0, 0.0, -peg.play])]
    )
    centres = tip + np.cumsum(steps, axis=0)
    values = {"play_m": peg.play, "push_m": depth + float(peg.over_tip @ peg.axis)}
    no: Refusal | None = None
    for side, sign in (("front", 1.0), ("back", -1.0)):
        corners = [_hand(belief, centre, sign * peg.axis) for centre in centres]
        name = f"{side} of the hole along the peg, {1000 * depth:.0f} mm onto it"
        no = _unreachable(location, belief, context, corners)
        if no is not None:
            yield no.refused(name)
            continue
        axis = -peg.axis
        place = Place(
            corners[-1], corners[0], approach=(float(axis[0]), float(axis[1]), float(axis[2])), path=tuple(corners[1:]),
            thing=belief.held.thing if belief.held else "", values=values,
        )  # fmt: skip
        yield Grounding(place, name, 0.0 if sign > 0 else 0.1, key=side, anew=True)
    if no is not None:
        said = f"the hole cannot be led onto the peg: {no.reason}"
        raise Unresolvable(said, causes(location, context), blocking=no.blocking, collision=no.collision)


def _hand(belief: Belief, hole: Floats, facing: Floats) -> Pose:
    """The TCP for which the held thing's hole is at a point, its axis along ``facing`` and its y axis up."""
    assert belief.held is not None
    feature = belief.world.thing(belief.held.thing).feature("vrps:Hole")
    assert feature is not None
    wanted = Pose.from_axes(tuple(hole), facing, np.cross((0.0, 0.0, 1.0), facing))
    return wanted * (belief.held.tcp_to_thing * feature.pose).inverse()


def _unreachable(location: Location, belief: Belief, context: Context, corners: list[Pose]) -> Refusal | None:
    """Why the arm cannot stand at all corners, one after the other; None when it can."""
    from ..motion_planning.reach import bound, collision_free_ik, make_scene
    from ..motion_planning.space import Refusal

    free, near = make_scene(belief, context), make_scene(belief, context, [bound(context, location.of)], clearance=0.0)
    seed = belief.joints
    for k, pose in enumerate(corners):
        there = collision_free_ik(near if k else free, context, pose, seed)
        if isinstance(there, Refusal):
            where = ("before the tip", "at the tip", "past its bend", "on the peg", "let down")[k]
            return replace(there, reason=f"{where}: {there.reason}")
        seed = there
    return None


def _unmoved(belief: Belief, context: Context) -> bool:
    """Whether the held thing is where it was at the very beginning: then that depends on which things were meant, and on what was
    done, but on no place that the hand was led to, the grasp among them."""
    from ..motion_planning.reach import held_pose

    assert belief.held is not None
    initial = belief.base().inverse() * belief.world.thing(belief.held.thing).pose
    return held_pose(belief, context).distance(initial)[0] <= SAME


def find_peg(location: Location, belief: Belief, context: Context) -> Peg:
    """Return the peg that a location is about, and the hole of what is held.

    Raises:
        Unresolvable: one of them is missing, or the peg is too thick for the hole.
    """
    from ..motion_planning.reach import bound, causes, held_pose

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
        raise Unresolvable(reason, causes(location, context), {"hole_m": diameter, "peg_m": thickness})
    base, length = belief.pose(owner.name), peg.size["length"]
    root = base * peg.pose
    end = root.apply((0, 0, length))
    over = np.array((base * tip.pose).position) - end if tip else np.zeros(3)
    hole_at = np.array((thing * hole.pose).position)
    return Peg(np.array(root.position), root.rotate((0, 0, 1)), length, over, (diameter - thickness) / 2, hole_at)

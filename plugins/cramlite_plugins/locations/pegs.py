"""Paths of a held thing's hole off a peg or onto it: along the peg's axis, with the hole centred on it, and
over the bent tip."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, Floats, Location, PegFit, Place, Pose, Remedy, Thing, Value, vector3
from cramlite.plugin import Answer, Context, Grounding, Refused, Unresolvable

from ..motion_planning.reach import bound, causes, held_pose, taken_at, traverse
from ..shapes import ray_casting
from ..shapes.peg_fit import PLAY, aligned, play, stands
from .reached import Arm, Candidate, Leg, reached

CLEAR = 0.04  # past the tip before a pull ends, and where a push begins [m]: more than a tab's rim, 8 mm
DEEPEST = 0.06  # how far onto the peg a thing is pushed at most [m]: 60 mm deep was measured to hang safely
SAME = 0.002  # a thing this near to where it was has not been moved: grasping shifts it by less [m]
GAP = 0.002  # left between what is threaded onto a standing peg and its root [m]: the last of it is felt
SHORT = 0.010  # so far above its root [m] the fast way along a standing peg ends: twice what a pose is off by
# Distance between the tip of a standing peg and what is brought over it [m]: more than the 5 mm that planned
# paths keep
OVER = 0.008
TURNS = 8  # ways round in which a hole that may turn on its peg is tried


class Peg(Value):
    """Peg and the hole on it, vectors in the base frame.

    Args:
        root, axis: where the peg begins, and its direction towards the tip.
        length: of its straight part [m].
        over_tip: from the end of the straight part to the end of the tip [m].
        play: radial play of the hole on the peg [m].
        hole: the hole's centre.
        thick: half the depth of the hole [m].
        side: along one of its sides, if hole and peg have sides that must be aligned.
    """

    root: Floats
    axis: Floats
    length: float
    over_tip: Floats
    play: float
    hole: Floats
    thick: float
    side: Floats | None = None

    @property
    def along(self) -> float:
        """Return the distance of the hole from the peg's root, along the peg's axis [m]."""
        return float((self.hole - self.root) @ self.axis)

    @property
    def onto(self) -> Floats:
        """Return the way of a hole onto the peg as displacements (5, 3) [m], one after the other, from the
        peg's tip.

        They lead out in front of the tip, back to it, past the peg's bend, along the peg, and down onto it.
        """
        if stands(self.axis):
            deep = max(self.length - self.thick - SHORT, self.length / 2)
            down, off = -self.axis * max(self.length - self.thick - GAP - deep, 0.0), self.thick + OVER
        else:
            deep, down, off = min(self.length / 2, DEEPEST), np.array([0.0, 0.0, -self.play]), CLEAR
        return np.array([self.axis * off, -self.axis * off, -self.over_tip, -self.axis * deep, down])

    @property
    def to_middle(self) -> Floats:
        """Return the upward shift (3,) [m] that brings the hole's centre to the peg's axis, so that no rim
        jams."""
        sunk = float(self.root[2] + self.along * self.axis[2] - self.hole[2])
        return np.array([0.0, 0.0, min(max(sunk, 0.0), self.play)])


def extract(location: Location, belief: Belief, context: Context) -> Iterator[Grounding]:
    """Generate the path on which a thing with a hole is taken off its peg."""
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
    said = f"{1000 * rest:.0f} mm along the peg, over its tip"
    yield traverse(location, belief, context, np.cumsum(steps, axis=0), said)


def insert(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate the path of a payload's hole onto a peg, for each way to turn it: in front of the peg's tip,
    at the tip, past the tip's bend, along the peg, and down onto it.

    The path's corners are the last four; ``fit`` has the radial play and the way to push from tip to deep.
    """
    peg = find_peg(location, belief, context)
    steps = peg.onto
    centres = peg.root + peg.axis * peg.length + peg.over_tip + np.cumsum(steps, axis=0)
    depth = float(np.linalg.norm(steps[3]))
    fit = PegFit(
        peg.play, depth + float(peg.over_tip @ peg.axis), _feet(peg, bound(context, location.of), belief)
    )

    def candidates() -> Iterator[Candidate]:
        for side, hole in _ways_round(peg, belief, context):
            corners = [_hand(belief, Pose.at(centre, hole)) for centre in centres]
            held, path = belief.held.thing if belief.held else "", tuple(corners[1:])
            down = vector3(-peg.axis)
            place = Place(corners[-1], corners[0], approach=down, path=path, thing=held, fit=fit)
            name = f"{side} of the hole along the peg, {1000 * depth:.0f} mm onto it"
            yield Candidate(name, place, tuple(_legs(location, context, corners)), key=side, anew=True)

    answers = list[Answer]()
    for answer in reached(candidates(), Arm(belief, context)):
        answers.append(answer)
        yield answer
    if isinstance(no := answers[-1], Refused):
        blocked = any(isinstance(r, Refused) and r.blocking for r in answers)
        because = causes(location, context) if blocked else _held_so(location, belief, context)
        raise no.impossible(f"the hole cannot be led onto the peg: {no.reason}", because)


def _held_so(location: Location, belief: Belief, context: Context) -> tuple[str, ...]:
    """Return the choices that decide whether the arm reaches a peg with the payload: the peg and the grasps.

    If the grasp is unknown, all earlier places decide it.
    """
    grasps = taken_at(belief, context)
    return (*grasps, location.of or "") if grasps else causes(location, context)


def _feet(peg: Peg, owner: str, belief: Belief) -> tuple[str, ...]:
    """Things other than the payload and the peg's owner that are at the root of a standing peg, or right
    below it."""
    if not stands(peg.axis):
        return ()
    apart = {owner, belief.held.thing if belief.held else ""}
    return tuple(
        t.name for t in belief.world.things if t.name not in apart and _reaches(belief.pose(t.name), t, peg)
    )


def _reaches(pose: Pose, thing: Thing, peg: Peg) -> bool:
    inverse = pose.inverse()
    root, down = np.asarray(inverse.apply(peg.root)), np.asarray(inverse.rotate(-peg.axis))
    met = ray_casting.spans(ray_casting.body(thing.geoms), root, down)
    return any(low <= SHORT and high >= -GAP for low, high, _ in met)


def _ways_round(peg: Peg, belief: Belief, context: Context) -> Iterator[tuple[str, Pose]]:
    """Ways to put the payload's hole on a peg, each as a name and an orientation of the hole.

    On a level peg the hole's y axis is up, seen from its front or back; on a standing peg the smallest turn
    about it comes first, and the hole is never turned over.
    """
    if not stands(peg.axis):
        for side, facing in (("front", peg.axis), ("back", -peg.axis)):
            yield side, Pose.from_axes((0.0, 0.0, 0.0), facing, np.cross((0.0, 0.0, 1.0), facing))
        return
    now = _hole_now(belief, context)
    facing = math.copysign(1.0, float(now.rotation[:, 2] @ peg.axis)) * peg.axis
    first = Pose.from_axes((0.0, 0.0, 0.0), facing, now.rotation[:, 0] if peg.side is None else peg.side)
    count = TURNS if peg.side is None else 4
    turns = ((0.0, 0.0, math.tau * k / count) for k in range(count))
    turned = [first * Pose.from_rotvec((0.0, 0.0, 0.0), turn) for turn in turns]
    for pose in sorted(turned, key=lambda p: -float(p.rotation[:, 0] @ now.rotation[:, 0])):
        was, x = now.rotation[:, 0], pose.rotation[:, 0]
        degrees = math.degrees(math.acos(max(-1.0, min(1.0, float(x @ was)))))
        around = math.copysign(degrees, float(np.cross(was, x) @ peg.axis))
        yield f"{around:+.0f} deg round", pose


def _hole_now(belief: Belief, context: Context) -> Pose:
    hole = belief.world.thing(belief.payload.thing).feature("vrps:Hole")
    assert hole is not None
    return held_pose(belief, context) * hole.pose


def _hand(belief: Belief, hole: Pose) -> Pose:
    """Return the TCP pose at which the held thing's hole is at a pose."""
    feature = belief.world.thing(belief.payload.thing).feature("vrps:Hole")
    assert feature is not None
    return hole * (belief.payload.tcp_to_thing * feature.pose).inverse()


def _legs(location: Location, context: Context, corners: list[Pose]) -> Iterator[Leg]:
    """Legs of the hand's way along the peg, one for each TCP pose in ``corners``.

    On all legs but the first the payload may touch the peg, but the hand may not.
    """
    near = Leg(corners[0], (bound(context, location.of),), clearance=0.0, hand=False)
    yield Leg(corners[0], said="before the tip")
    stages = ("at the tip", "past its bend", "on the peg", "let down")
    yield from (replace(near, pose=p, said=said) for said, p in zip(stages, corners[1:], strict=True))


def _unmoved(belief: Belief, context: Context) -> bool:
    """Whether the payload is where it was at the start of the plan.

    A failure then depends on the chosen things and on earlier tasks, but on no place of the hand.
    """
    initial = belief.base().inverse() * belief.world.thing(belief.payload.thing).pose
    return held_pose(belief, context).distance(initial)[0] <= SAME


def find_peg(location: Location, belief: Belief, context: Context) -> Peg:
    """Return the peg that a location is about, and the payload's hole.

    Raises:
        Unresolvable: one of them is missing, or the peg is too thick for the hole.
    """
    thing = held_pose(belief, context)
    owner, held = belief.thing(bound(context, location.of)), belief.world.thing(belief.payload.thing)
    peg, tip, hole = owner.feature("vrps:Peg"), owner.feature("vrps:Tip"), held.feature("vrps:Hole")
    if peg is None or hole is None:
        missing = f"'{owner.name}' has no peg" if peg is None else f"'{held.name}' has no hole"
        raise Unresolvable(missing, causes(location, context))
    radial = play(hole, peg)
    if radial <= PLAY:
        diameter, thickness = hole.size["diameter"], 2 * peg.size["radius"]
        reason = f"a hole of {1000 * diameter:.1f} mm does not move on a peg of {1000 * thickness:.1f} mm"
        short, numbers = thickness + 2 * PLAY - diameter, {"hole_m": diameter, "peg_m": thickness}
        lacks = f"the hole of '{held.name}' lacks {1000 * short:.1f} mm for the peg of '{owner.name}'"
        wider = Remedy(f"hole {held.name}", f"{lacks}: take a wider hole or a thinner peg", short)
        raise Unresolvable(reason, causes(location, context), numbers, remedy=wider)
    base, length = belief.pose(owner.name), peg.size["length"]
    root = base * peg.pose
    end = root.apply((0, 0, length))
    over = np.array((base * tip.pose).position) - end if tip else np.zeros(3)
    return Peg(
        np.array(root.position), root.rotate((0, 0, 1)), length, over, radial,
        np.array((thing * hole.pose).position), hole.size.get("depth", 0.0) / 2,
        root.rotate((1, 0, 0)) if aligned(hole, peg) else None,
    )  # fmt: skip

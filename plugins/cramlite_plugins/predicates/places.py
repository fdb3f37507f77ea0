"""Predicates on places: near, above, in view. They read poses and sizes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Floats, Pose, Vector3, thing_of
from cramlite.plugin import Phase, Predicate, Row

from ..shapes.ray_casting import body, crossed
from ..shapes.surfaces import SUNK
from . import extents, fluents, unknowns
from .phase_poses import Box, box_of, distance_to_box, each, pairs, pose_of, relative_position, things, tips

REACH = 0.15
"""Distance of the effector's frame from a thing's box below which the thing is within reach [m]: a recorded hand's frame is about 0.15 m
from what it picks up."""
RIM = 0.05
"""Height above a container's rim up to which an origin counts as in the cavity [m]: a product that stands in a shallow basket has its
middle there."""
NEAR = 0.15
"""Distance of a thing from a place below which it is near the place [m]."""
ELSEWHERE = 0.05
"""Least displacement of a thing that counts as carried to another place [m]: less than things are lifted."""
UNSIZED = 0.15
"""Assumed radius of a place of unknown size [m]: half the width of a large bowl or plate."""
VIEW = np.deg2rad(30.0)
"""Largest angle from the camera's axis at which a point is in view [rad]: half the 60 deg that common depth cameras see."""
DRAWN_IN = 0.9
"""Factor that draws the corners of a box inwards before their visibility is checked: the box's edge may touch the thing's support."""
BESIDE = 0.6
"""Distance of a mobile base's outline from that of its destination, below which the arm reaches things at the destination's edge [m]."""
APPROACHED = 0.01
"""Least decrease of a distance that counts as an approach [m]."""


def all_predicates() -> tuple[Predicate, ...]:
    """Return the predicates on places, such as ``near``, ``in_or_above`` and ``in_view``."""
    return (
        Predicate(
            "approaches", 1, approaches, frozenset({"run"}), cost=5, doc="The effector comes 10 mm nearer to a thing.",
            unknown=unknowns.no_pose,
        ),
        Predicate("within_reach", 1, within_reach, cost=5, doc="The effector is within 0.15 m of a thing.", unknown=unknowns.no_pose),
        Predicate(
            "between_fingers", 1, between_fingers, cost=5, doc="The way from one finger tip to another leads through a thing.",
            possible=lambda timeline: len(tips(timeline)) > 1, unknown=unknowns.no_fingers,
        ),
        Predicate(
            "in_or_above", 2, in_or_above, cost=5, doc="A thing is over the footprint of another, not below its floor, or in its cavity.",
            fluent=fluents.IN_OR_ABOVE, unknown=unknowns.no_box,
        ),
        Predicate(
            "in_cavity", 2, in_cavity, cost=5, doc="The middle of a thing is in the cavity of another, up to 50 mm over its rim."
        ),
        Predicate(
            "in_region", 2, in_region, cost=5, doc="The origin of a thing is in a cavity, or over an area of a surface, of another."
        ),
        Predicate("near", 2, near, cost=5, doc="Two things are within 0.15 m.", unknown=unknowns.no_pose_of),
        Predicate(
            "distance_seen_from_above", 2, distance_seen_from_above, value=True, cost=5,
            doc="How far apart the origins of two things are, seen from above [m].", unknown=unknowns.no_pose_of,
        ),
        Predicate(
            "recedes", 2, recedes, frozenset({"run"}), cost=6, doc="A thing moves by 50 mm, and comes no nearer to another."
        ),
        Predicate(
            "flat", 1, flat, cost=4, doc="A thing is at least four times as wide as it is high, in its own frame.",
            timeless=True, complete=True, static=fluents.is_flat, unknown=unknowns.no_box,
        ),
        Predicate("stands_at", 2, stands_at, cost=5, doc="Seen from above, two things are within 0.6 m of each other."),
        Predicate(
            "in_view", 1, in_view, cost=5, doc="A thing is within 30 deg of a camera's axis, and no other hides it.",
            possible=lambda timeline: bool(timeline.entities_of("cram:Camera")),
        ),
        Predicate("pose_known", 1, pose_known, cost=4, steady=True, complete=True, doc="Where a thing is has been recorded by now."),
        Predicate(
            "thing", 1, thing, cost=3, doc="An object of the world: no part, and not the effector.",
            timeless=True, complete=True, static=fluents.is_thing,
        ),
    )


def thing(phase: Phase, _name: str | None) -> Iterator[Row]:
    """Evaluate thing(X): X is a thing of the recorded episode."""
    yield from ((name,) for name in things(phase))


def flat(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate flat(Thing): the box around it is too low for fingers to grip it from the side."""
    for one in each(phase, name):
        box = box_of(phase, one)
        if box is not None and fluents.low(np.subtract(box[1], box[0])):
            yield (one,)


def approaches(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate approaches(Thing): the hand's distance to the thing's box is smaller at the end of the
    phase than at the start."""
    for other in each(phase, name):
        before, after = _from_hand(phase, other, phase.start), _from_hand(phase, other, phase.end)
        if before is not None and after is not None and before - after > APPROACHED:
            yield (other,)


def within_reach(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate within_reach(Thing): the hand is less than ``REACH`` from Thing's box at the end of the phase."""
    for other in each(phase, name):
        gap = _from_hand(phase, other, phase.end)
        if gap is not None and gap < REACH:
            yield (other,)


def between_fingers(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate between_fingers(Thing): Thing is between the pads at the end of the phase.

    The line between two finger tips, or one between their pads further on or at their edges, meets its shape, or its box where no more is
    known: by its round side a mug was held between the ends of the pads' edges, 2 mm deep, and not between their middles.
    """
    lines = _between_pads(phase)
    for other in each(phase, name):
        pose, box = pose_of(phase, other, phase.end), box_of(phase, other)
        if pose is None or box is None:
            continue
        local = [tuple(pose.inverse().apply(end) for end in ends) for ends in lines]
        geoms = phase.timeline.entities[other].geoms
        if any(_meets(one, two, *box) and (not geoms or crossed(body(geoms), one[None], two[None])) for one, two in local):
            yield (other,)


def _between_pads(phase: Phase) -> list[tuple[Floats, Floats]]:
    """Lines between two fingers, as pairs of points (3,): between the middles of their pads; of pads of
    known size also between their edges and towards their ends."""
    names = tips(phase.timeline)[:2]
    poses = [p for n in names if (p := pose_of(phase, n, phase.end)) is not None]
    if len(poses) < 2:
        return []
    one, two = poses
    length, width = (min(phase.timeline.entities[n].properties.get(f"pad_{size}", 0.0) for n in names) for size in ("length", "width"))
    along, across = np.linspace(0.0, length / 2, 4 if length else 1), (-width / 2, 0.0, width / 2) if width else (0.0,)
    alike = math.copysign(1.0, float(one.rotate((1.0, 0.0, 0.0)) @ two.rotate((1.0, 0.0, 0.0))))  # one may be turned half way round
    return [(one.apply((x, 0.0, z)), two.apply((alike * x, 0.0, z))) for x, z in itertools.product(across, along)]


def _meets(one: Floats, two: Floats, low: Vector3, high: Vector3) -> bool:
    """Whether a segment meets a box (slabs: Kay and Kajiya, Ray tracing complex scenes, 1986)."""
    enter, leave = 0.0, 1.0
    for a, b, lower, upper in zip(one.tolist(), two.tolist(), low, high, strict=True):
        if a == b:
            if not lower <= a <= upper:
                return False
            continue
        near, far = sorted(((lower - a) / (b - a), (upper - a) / (b - a)))
        enter, leave = max(enter, near), min(leave, far)
    return enter <= leave


def in_or_above(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """Evaluate in_or_above(Thing, Place): the thing's origin is over the bottom of the place's box and, seen
    from above, within the box; or it is in a cavity of the place.

    Thing's origin, in Place's frame, is within its box seen from above and over its bottom. Places without a size are
    left out. A cavity may reach below the box: that of a shelf without a bottom ends on the table.
    """
    over = dict.fromkeys(_over_boxes(phase, name, place))
    yield from over
    yield from (row for row in in_cavity(phase, name, place) if row not in over)


def _over_boxes(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """Pairs of a thing and a place whose box is below the thing's origin, or around it."""
    for below in each(phase, place):
        corners = box_of(phase, below)
        if corners is None:
            continue
        for above in each(phase, name):
            point = relative_position(phase, below, above, phase.end)
            if above != below and point is not None and _over(point, *corners):
                yield above, below


def in_cavity(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """Evaluate in_cavity(Thing, Container): Thing's origin is in a cavity of Container at the end of the phase.

    Thing's origin is taken in the frame of a cavity of Container, whose origin is the middle of the opening
    and whose z axis leads out of it; a thing that stands on the cavity's floor may be ``SUNK`` below that. Cavities without a size
    are left out.
    """
    for cavity in phase.timeline.entities_of("cram:Cavity"):
        container, size = phase.timeline.wholes[cavity][-1], phase.timeline.entities[cavity].properties
        if place not in (None, container):
            continue
        for one in each(phase, name):
            point = relative_position(phase, cavity, one, phase.end)
            if one != container and point is not None and extents.in_cavity(point, size, RIM, SUNK):
                yield one, container


def in_region(phase: Phase, name: str | None, region: str | None) -> Iterator[Row]:
    """Evaluate in_region(Thing, Region): the origin of the thing is in the cavity or over the area of
    another thing."""
    yield from in_region_by(phase, name, region, (0.0, 0.0, 0.0))


def in_region_by(phase: Phase, name: str | None, region: str | None, margin: Vector3) -> Iterator[Row]:
    """Generate the pairs (thing, region) in which the thing's origin is in the region, also if moved by a
    margin along any axis of the region [m]."""
    moved = np.vstack([np.zeros(3), np.diag(margin), -np.diag(margin)])
    for type_ in extents.REGIONS:
        for place in phase.timeline.entities_of(type_):
            size, whole = phase.timeline.entities[place].properties, phase.timeline.wholes[place][-1]
            for one in each(phase, name):
                point = relative_position(phase, place, one, phase.end)
                if region not in (None, place) or one == whole or point is None:
                    continue
                if all(extents.in_extent(type_, size, np.asarray(point) + by) for by in moved):
                    yield one, place


def near(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """Evaluate near(Thing, Place): the distance of Thing's origin from Place's box is less than ``NEAR``.

    For a place of unknown size, whose origin stands for the box, the limit is larger by ``UNSIZED``.
    """
    for other, one in pairs(phase, place, name):
        gap = distance_to_box(phase, other, one, phase.end)
        if gap is not None and gap < NEAR + (UNSIZED if box_of(phase, other) is None else 0.0):
            yield one, other


def distance_seen_from_above(phase: Phase, name: str | None, other: str | None) -> Iterator[Row]:
    """Evaluate distance_seen_from_above(Thing, Other): the horizontal distance of their origins [m]."""
    for another, one in pairs(phase, other, name):
        here, there = pose_of(phase, one, phase.end), pose_of(phase, another, phase.end)
        if here is not None and there is not None:
            yield one, another, math.dist(here.position[:2], there.position[:2])


def recedes(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """Evaluate recedes(Thing, Place): Thing moves, by ``ELSEWHERE`` or more, and comes no nearer to Place.

    Neither its origin's distance from Place's box nor, seen from above, that from Place's middle shrinks by
    more than ``APPROACHED``.
    """
    for one in each(phase, name):
        poses = [pose_of(phase, one, t) for t in (phase.start, phase.end)]
        if None in poses or math.dist(*(p.position for p in poses if p is not None)) < ELSEWHERE:
            continue
        for other in each(phase, place):
            before, after = (
                (distance_to_box(phase, other, one, t), _horizontal_distance(phase, one, other, t)) for t in (phase.start, phase.end)
            )
            if one != other and not any(b is not None and a is not None and b - a > APPROACHED for b, a in zip(before, after, strict=True)):
                yield one, other


def _horizontal_distance(phase: Phase, one: str, other: str, time: float) -> float:
    """Distance of two origins, seen from above [m]."""
    here, there = pose_of(phase, one, time), pose_of(phase, other, time)
    return 0.0 if here is None or there is None else math.dist(here.position[:2], there.position[:2])


def stands_at(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """Evaluate stands_at(Base, Place): Base is less than ``BESIDE`` from Place, on the floor.

    The distance is from outline to outline on the floor; without a size, from an origin.
    """
    for other, one in pairs(phase, place, name):
        here, there = pose_of(phase, one, phase.end), pose_of(phase, other, phase.end)
        if here is not None and there is not None:
            boxes = [box_of(phase, n) or ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)) for n in (one, other)]
            if apart(here, boxes[0], there, boxes[1]) < BESIDE:
                yield one, other


def apart(one: Pose, box: Box, other: Pose, its: Box) -> float:
    """Return the distance of two boxes (lowest and highest corner, each in its own frame) seen from above [m].

    Points of one's outline, a tenth of a side apart, are measured against the other, whose z axis is upright or level.
    """
    (a, b, _), (c, d, _) = box
    shares = np.linspace(0.0, 1.0, 11)
    sides = [(a + s * (c - a), y) for s in shares for y in (b, d)] + [(x, b + s * (d - b)) for s in shares for x in (a, c)]
    points = one.apply(np.array([(x, y, 0.0) for x, y in sides]))
    corners = other.apply(np.array(list(itertools.product(*zip(*its, strict=True)))))
    low, high = _upright(corners, other)
    flat = _flat(other)
    seen = (points[:, :2] - np.asarray(other.position)[:2]) @ flat
    return float(np.linalg.norm(np.maximum(np.maximum(low - seen, seen - high), 0.0), axis=1).min())


def _flat(pose: Pose) -> Floats:
    """(2, 2) horizontal axes of a frame: its most horizontal axis, projected and of unit length, and the
    direction across it."""
    axes = pose.rotation.T
    x = axes[int(np.argmin(np.abs(axes[:, 2])))][:2]
    x = x / np.linalg.norm(x)
    return np.array([[x[0], -x[1]], [x[1], x[0]]])


def _upright(corners: Floats, pose: Pose) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates of corners along the horizontal axes of a frame, from its origin."""
    seen = (corners[:, :2] - np.asarray(pose.position)[:2]) @ _flat(pose)
    return seen.min(axis=0), seen.max(axis=0)


def in_view(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate in_view(Thing): a camera sees Thing's origin, or a corner of the box around Thing.

    It looks along its z axis (the optical frame of ROS REP 103); the way to the thing's origin, or to one of the
    corners of its box, drawn in by a tenth, is free of other things whose shapes are known.
    """
    for camera in phase.timeline.entities_of("cram:Camera"):
        eye = pose_of(phase, camera, phase.end)
        for other in each(phase, name):
            pose = pose_of(phase, other, phase.end)
            if eye is not None and pose is not None and other != camera:
                x, y, z = eye.inverse().apply(pose.position)
                if np.arctan2(np.hypot(x, y), z) < VIEW and not _hidden(phase, other, eye):
                    yield (other,)


def _hidden(phase: Phase, name: str, eye: Pose) -> bool:
    """Whether other things hide every point of a thing from a camera at the end of a phase."""
    pose, box = pose_of(phase, name, phase.end), box_of(phase, name)
    assert pose is not None
    inside = np.array([(0.0, 0.0, 0.0), *(itertools.product(*zip(*box, strict=True)) if box else ())]) * DRAWN_IN
    points, whole = pose.apply(inside), thing_of(name)
    free = np.ones(len(points), dtype=bool)
    for other in things(phase):
        geoms, its = phase.timeline.entities[other].geoms, pose_of(phase, other, phase.end)
        if other != whole and geoms and its is not None:
            shape, back = body(geoms), its.inverse()
            start, ends = back.apply(eye.position)[None], back.apply(points)
            free &= [not crossed(shape, start, end[None]) for end in ends]
    return not free.any()


def pose_known(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate pose_known(Thing): it has an initial pose, or was tracked at or before the phase's end."""
    yield from ((other,) for other, since in phase.timeline.located.items() if since <= phase.end)


def _from_hand(phase: Phase, name: str, time: float) -> float | None:
    """Distance of the effector's frame from a thing's box [m]."""
    return distance_to_box(phase, name, phase.episode.effector or "", time)


def _over(point: Vector3, low: Vector3, high: Vector3) -> bool:
    return low[0] <= point[0] <= high[0] and low[1] <= point[1] <= high[1] and point[2] >= low[2]

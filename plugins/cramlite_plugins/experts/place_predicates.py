"""Predicates about places: near, above, in view. They read poses and sizes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from cramlite.geometry import Floats, Pose, Vector3
from cramlite.phases import Phase, Predicate, Row, Timeline

from ..episodes.entities import bounds
from .antipodal import body, crossed

REACH = 0.15
"""[m] from the effector's frame to a thing's box: a recorded hand's frame is about 0.15 m from what it picks up."""
NEAR = 0.15
"""[m] between a thing and a place it was brought to."""
VIEW = np.deg2rad(30.0)
"""[rad] from the camera's axis: half the 60 deg that common depth cameras see."""
DRAWN_IN = 0.9
"""Share of a box's corners' distances: its very edge may touch what it stands on."""
BESIDE = 0.6
"""[m] from the outline of what drives to that of what it stands at: an arm on it still reaches what lies at the edge."""
APPROACHED = 0.01
"""[m] by which a distance must shrink to count."""


def all_predicates() -> tuple[Predicate, ...]:
    return (
        Predicate(
            "approaches", 1, approaches, frozenset({"run"}), cost=5, doc="The effector comes 10 mm nearer to a thing."
        ),
        Predicate("within_reach", 1, within_reach, cost=5, doc="The effector is within 0.15 m of a thing."),
        Predicate(
            "between_fingers",
            1,
            between_fingers,
            cost=5,
            possible=lambda timeline: len(_tips(timeline)) > 1,
            doc="The way from one finger tip to another leads through a thing.",
        ),
        Predicate(
            "in_or_above", 2, in_or_above, cost=5, doc="A thing is over the footprint of another, not below its floor."
        ),
        Predicate("near", 2, near, cost=5, doc="Two things are within 0.15 m."),
        Predicate("stands_at", 2, stands_at, cost=5, doc="Seen from above, two things are within 0.6 m of each other."),
        Predicate(
            "in_view",
            1,
            in_view,
            cost=5,
            possible=lambda timeline: bool(timeline.entities_of("cram:Camera")),
            doc="A thing is within 30 deg of a camera's axis, and no other hides it.",
        ),
        Predicate(
            "pose_known",
            1,
            pose_known,
            cost=4,
            steady=True,
            complete=True,
            doc="Where a thing is has been recorded by now.",
        ),
        Predicate(
            "thing",
            1,
            thing,
            cost=3,
            doc="An object of the world: no part, and not the effector.",
            timeless=True,
            complete=True,
        ),
    )


def thing(phase: Phase, _name: str | None) -> Iterator[Row]:
    """thing(X)."""
    yield from ((name,) for name in _things(phase))


def approaches(phase: Phase, name: str | None) -> Iterator[Row]:
    """approaches(Thing): distance to its box at the end against that at the start."""
    for other in [name] if name is not None else _things(phase):
        before, after = _from_hand(phase, other, phase.start), _from_hand(phase, other, phase.end)
        if before is not None and after is not None and before - after > APPROACHED:
            yield (other,)


def within_reach(phase: Phase, name: str | None) -> Iterator[Row]:
    """within_reach(Thing), at the end of the phase."""
    for other in [name] if name is not None else _things(phase):
        gap = _from_hand(phase, other, phase.end)
        if gap is not None and gap < REACH:
            yield (other,)


def between_fingers(phase: Phase, name: str | None) -> Iterator[Row]:
    """between_fingers(Thing), at the end of the phase: the line between two finger tips meets its shape, or its box where
    no more is known."""
    ends = [_pose(phase, tip, phase.end) for tip in _tips(phase.timeline)[:2]]
    if len(ends) < 2 or any(e is None for e in ends):
        return
    for other in [name] if name is not None else _things(phase):
        pose, box = _pose(phase, other, phase.end), _box(phase, other)
        if pose is not None and box is not None:
            one, two = (pose.inverse().apply(e.position) for e in ends if e is not None)
            geoms = phase.timeline.entities[other].geoms
            if _meets(one, two, *box) and (not geoms or crossed(body(geoms), one[None], two[None])):
                yield (other,)


def _tips(timeline: Timeline) -> tuple[str, ...]:
    """The finger tips of the effector that are tracked."""
    episode = timeline.episode
    if "tips" not in timeline.memo:
        own = (e.name for e in episode.entities if e.part_of is not None and e.part_of == episode.effector)
        timeline.memo["tips"] = tuple(
            n for n in own if n in episode.tracks and "cram:Camera" not in timeline.entities[n].types
        )
    return timeline.memo["tips"]  # type: ignore[no-any-return]


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
    """in_or_above(Thing, Place): Thing's origin, in Place's frame, is within its box seen from above and over its
    bottom. Places without a size are left out."""
    for below in [place] if place is not None else _things(phase):
        corners = _box(phase, below)
        if corners is None:
            continue
        for above in [name] if name is not None else _things(phase):
            point = _seen_from(phase, below, above, phase.end)
            if above != below and point is not None and _over(point, *corners):
                yield above, below


def near(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """near(Thing, Place): from Thing's origin to Place's box."""
    for other in [place] if place is not None else _things(phase):
        for one in [name] if name is not None else _things(phase):
            gap = _gap(phase, other, one, phase.end)
            if one != other and gap is not None and gap < NEAR:
                yield one, other


def stands_at(phase: Phase, name: str | None, place: str | None) -> Iterator[Row]:
    """stands_at(Base, Place): from outline to outline on the floor, at the end of the phase; without a size, an origin."""
    for other in [place] if place is not None else _things(phase):
        for one in [name] if name is not None else _things(phase):
            here, there = _pose(phase, one, phase.end), _pose(phase, other, phase.end)
            if one != other and here is not None and there is not None:
                boxes = [_box(phase, n) or ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)) for n in (one, other)]
                if apart(here, boxes[0], there, boxes[1]) < BESIDE:
                    yield one, other


def apart(one: Pose, box: tuple[Vector3, Vector3], other: Pose, its: tuple[Vector3, Vector3]) -> float:
    """The distance of two boxes (lowest and highest corner, each in its own frame) seen from above [m].

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
    """(2, 2) horizontal axes of a frame: of its two flattest axes the first, and the one across it."""
    axes = pose.rotation.T
    x = axes[int(np.argmin(np.abs(axes[:, 2])))][:2]
    x = x / np.linalg.norm(x)
    return np.array([[x[0], -x[1]], [x[1], x[0]]])


def _upright(corners: Floats, pose: Pose) -> tuple[Floats, Floats]:
    """Lowest and highest of corners along the horizontal axes of a frame, from its origin."""
    seen = (corners[:, :2] - np.asarray(pose.position)[:2]) @ _flat(pose)
    return seen.min(axis=0), seen.max(axis=0)


def in_view(phase: Phase, name: str | None) -> Iterator[Row]:
    """in_view(Thing): the camera looks along its z axis (the optical frame of ROS REP 103); the way to the thing's origin,
    or to one of the corners of its box, drawn in by a tenth, is free of other things whose shapes are known."""
    for camera in phase.timeline.entities_of("cram:Camera"):
        eye = _pose(phase, camera, phase.end)
        for other in [name] if name is not None else _things(phase):
            pose = _pose(phase, other, phase.end)
            if eye is not None and pose is not None and other != camera:
                x, y, z = eye.inverse().apply(pose.position)
                if np.arctan2(np.hypot(x, y), z) < VIEW and not _hidden(phase, other, eye):
                    yield (other,)


def _hidden(phase: Phase, name: str, eye: Pose) -> bool:
    """Whether another thing is before each point of a thing that is looked at, at the end of a phase."""
    pose, box = _pose(phase, name, phase.end), _box(phase, name)
    assert pose is not None
    inside = np.array([(0.0, 0.0, 0.0), *(itertools.product(*zip(*box, strict=True)) if box else ())]) * DRAWN_IN
    points, whole = pose.apply(inside), name.split("/")[0]
    free = np.ones(len(points), dtype=bool)
    for other in _things(phase):
        geoms, its = phase.timeline.entities[other].geoms, _pose(phase, other, phase.end)
        if other != whole and geoms and its is not None:
            shape, back = body(geoms), its.inverse()
            start, ends = back.apply(eye.position)[None], back.apply(points)
            free &= [not crossed(shape, start, end[None]) for end in ends]
    return not free.any()


def pose_known(phase: Phase, name: str | None) -> Iterator[Row]:
    """pose_known(Thing): it has an initial pose, or was tracked at or before the phase's end."""
    yield from ((other,) for other, since in phase.timeline.located.items() if since <= phase.end)


def _things(phase: Phase) -> tuple[str, ...]:
    memo = phase.timeline.memo
    if "things" not in memo:
        effectors = set(phase.timeline.entities_of("soma:PhysicalEffector")) | {phase.episode.effector}
        memo["things"] = tuple(
            n for n, e in phase.timeline.entities.items() if e.part_of is None and n not in effectors
        )
    return memo["things"]  # type: ignore[no-any-return]


def _from_hand(phase: Phase, name: str, time: float) -> float | None:
    """Distance of the effector's frame from a thing's box [m]."""
    return _gap(phase, name, phase.episode.effector or "", time)


def _gap(phase: Phase, name: str, other: str, time: float) -> float | None:
    """Distance of another entity's origin from a thing's box [m]."""
    memo = phase.timeline.memo
    known = memo.get(("gaps", name, other))
    if known is None:
        known = memo["gaps", name, other] = _gaps_at_boundaries(phase, name, other)
    if time not in known:
        known[time] = _distance(phase, name, other, time)
    return known[time]


def _gaps_at_boundaries(phase: Phase, name: str, other: str) -> dict[float, float | None]:
    """The distances at all boundaries of the timeline at once; the same that ``_distance`` gives one by one.
    Nothing for parts: they follow their whole."""
    mine, its = _at_boundaries(phase, name), _at_boundaries(phase, other)
    if mine is None or its is None:
        return {}
    seen = np.einsum("ni,nij->nj", its[:, :3] - mine[:, :3], rotations(mine[:, 3:]))
    low, high = _box(phase, name) or ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    outside = np.maximum(np.maximum(low - seen, seen - high), 0.0)
    return dict(zip(phase.timeline.cuts, np.linalg.norm(outside, axis=1).tolist(), strict=True))


def _at_boundaries(phase: Phase, name: str) -> Floats | None:
    """The poses of a thing at all boundaries of the timeline (N, 7); None if it is a part, or nobody knows where."""
    cuts, track = phase.timeline.cuts, phase.episode.tracks.get(name)
    if track is not None and len(track.times):
        return track.poses[np.maximum(np.searchsorted(track.times, np.array(cuts), side="right") - 1, 0)]
    entity = phase.timeline.entities.get(name)
    pose = _pose(phase, name, phase.start) if entity is not None and entity.part_of is None else None
    return None if pose is None else np.tile((*pose.position, *pose.quaternion), (len(cuts), 1))


def rotations(quaternions: Floats) -> Floats:
    """Rotation matrices (N, 3, 3) of quaternions (N, 4) as (w, x, y, z), of any length but 0."""
    w, x, y, z = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _distance(phase: Phase, name: str, other: str, time: float) -> float | None:
    """Distance of another entity's origin from an entity's box [m]."""
    point = _seen_from(phase, name, other, time)
    if point is None:
        return None
    low, high = _box(phase, name) or ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    return math.hypot(*(max(a - v, v - b, 0.0) for v, a, b in zip(point, low, high, strict=True)))


def _seen_from(phase: Phase, name: str, other: str, time: float) -> Vector3 | None:
    """Another entity's origin in an entity's frame."""
    pose, origin = _pose(phase, name, time), _pose(phase, other, time)
    if pose is None or origin is None:
        return None
    offset = np.subtract(origin.position, pose.position) @ pose.rotation
    return _vector(offset)


def _vector(values: Floats) -> Vector3:
    x, y, z = values.tolist()
    return (x, y, z)


def _pose(phase: Phase, name: str, time: float) -> Pose | None:
    """The pose of an entity; one that is tracked nowhere is looked up once."""
    timeline = phase.timeline
    if name not in timeline.entities and name not in phase.episode.tracks:
        return None
    moving = any(w in phase.episode.tracks for w in timeline.wholes.get(name, (name,)))
    key = ("pose", name, time if moving else None)
    if key not in timeline.memo:
        timeline.memo[key] = phase.episode.pose_at(name, time)
    return timeline.memo[key]  # type: ignore[no-any-return]


def _box(phase: Phase, name: str) -> tuple[Vector3, Vector3] | None:
    """Lower and upper corner of an entity's box in its frame: of its shape, else of its size about its origin."""
    memo = phase.timeline.memo
    if ("box", name) not in memo:
        memo["box", name] = _find_box(phase, name)
    return memo["box", name]  # type: ignore[no-any-return]


def _find_box(phase: Phase, name: str) -> tuple[Vector3, Vector3] | None:
    entity = phase.timeline.entities.get(name)
    if entity is None:
        return None
    if entity.geoms:
        corners = [bounds(g) for g in entity.geoms]
        low = np.min([c[0] for c in corners], axis=0)
        high = np.max([c[1] for c in corners], axis=0)
        return _vector(low), _vector(high)
    if entity.size is None:
        return None
    half = np.asarray(entity.size) / 2
    return _vector(-half), _vector(half)


def _over(point: Vector3, low: Vector3, high: Vector3) -> bool:
    return low[0] <= point[0] <= high[0] and low[1] <= point[1] <= high[1] and point[2] >= low[2]

"""Predicates on motion: moving things during an action, and their distances."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from itertools import pairwise

import numpy as np

from cramlite.model import Floats, opened
from cramlite.plugin import Phase, PhaseName, Predicate, Row, Timeline

from . import fluents, unknowns
from .samples import Motion, Range

ARM_MOVED = 0.001
"""Least displacement of the end effector that counts as motion [m]."""
GRIPPER_MOVED = 0.020
"""Least change of the distance between the finger tips that counts as motion [m]."""
THING_MOVED = 0.005
"""Least displacement of a thing that counts as motion [m]: five times the arm's threshold, because tracked things are less exact."""
TURNED = 0.1
"""Least turn of a thing that counts as motion [rad]: a box of 0.1 m then moves its corners by 5 mm."""
TILTED = np.deg2rad(30.0)
"""Least angle from a thing's first recorded attitude at which it counts as tilted [rad]: the usual angle of repose of granular material."""
CLOSED, OPENED = 0.25, 0.75
"""Shares of the gripper's widest opening below which it counts as closed, and above which as open."""
JOINT_CLOSED, JOINT_OPEN = 0.05, 0.20
"""Shares of a joint's range up to which a door counts as closed, and from which as open."""
SWUNG, SWING = 0.016, 1.0
"""Least distance from one reversal of a swing to the next, three times a tracker's error [m], and longest time between them [s]."""
TREMOR = 0.1
"""Time over which positions are averaged before reversals are searched for [s]: a quarter of the shortest swing that is detected."""
PARKED = 0.05
"""Largest deviation of a joint from the park posture [rad]."""

_RUN: frozenset[PhaseName] = frozenset({"run"})


DRIVEN = 0.025
"""Least displacement of a thing that counts as pushed by the hand [m]: more than the difference of two poses that are each 5 mm off on
every axis."""


def all_predicates() -> tuple[Predicate, ...]:
    """Return the predicates on motion and joints, such as ``arm_moves``, ``tilts`` and ``joint_open``."""
    of_joints = partial(Predicate, possible=_has_joints)
    return (
        Predicate(
            "arm_moves", 0, arm_moves, _RUN, cost=3, doc="The effector leaves its place by more than 1 mm.", unknown=unknowns.no_hand
        ),
        Predicate(
            "gripper_moves", 0, gripper_moves, _RUN, cost=3, doc="The finger tips' distance changes by more than 20 mm.",
            unknown=unknowns.no_fingers,
        ),
        Predicate(
            "moves", 1, moves, _RUN, cost=4, doc="A thing leaves its place by more than 5 mm, or turns by 0.1 rad.",
            unknown=unknowns.no_pose_of,
        ),
        Predicate(
            "driven", 1, driven, _RUN, cost=4, doc="A thing ends more than 5 mm from where it began, the way the effector went.",
            unknown=unknowns.no_pose,
        ),
        Predicate("tilts", 1, tilts, _RUN, cost=4, doc="A thing turns its upward axis by more than 30 deg.", unknown=unknowns.no_pose_of),
        Predicate(
            "swings", 1, swings, _RUN, value=True, cost=6,
            doc="How often a thing goes to or fro in turn, by 16 mm at least and within 1 s each.", unknown=unknowns.no_pose_of,
        ),
        Predicate("gripper_closed", 0, gripper_closed, cost=3, doc="The opening is below 25 % of the widest.", unknown=unknowns.no_fingers),
        Predicate("gripper_open", 0, gripper_open, cost=3, doc="The opening is above 75 % of the widest.", unknown=unknowns.no_fingers),
        of_joints(
            "on_joint", 1, on_joint, cost=1, doc="A thing slides or turns on a joint, as drawers and doors do.", static=fluents.on_joint
        ),
        of_joints("joint_rises", 1, joint_rises, _RUN, cost=3, doc="A thing's joint value grows by 5 % of its range."),
        of_joints(
            "joint_falls", 1, joint_falls, _RUN, cost=3, doc="A thing's joint value shrinks by 5 % of its range."
        ),
        of_joints(
            "joint_closed", 1, joint_closed, cost=3, doc="A thing's joint is within 5 % of closed.", fluent=fluents.JOINT_CLOSED
        ),
        of_joints(
            "joint_open", 1, joint_open, cost=3, doc="A thing's joint is open by 20 % or more.", fluent=fluents.JOINT_OPEN
        ),
        of_joints(
            "joint_wide", 1, joint_wide, cost=3, doc="A thing's joint is open by 80 % or more.", fluent=fluents.JOINT_WIDE
        ),
        of_joints("joint_share", 1, joint_share, value=True, cost=3, doc="How far a thing's joint is open, as a share of its range."),
        Predicate(
            "parked", 0, parked, cost=3, doc="All arm joints are at the park state.",
            possible=lambda timeline: "park" in timeline.episode.extras,
        ),
    )


def _has_joints(timeline: Timeline) -> bool:
    return any(key.startswith("joint:") for key in timeline.episode.extras)


def arm_moves(phase: Phase) -> Iterator[Row]:
    """Evaluate arm_moves(): at some time in the phase the effector is displaced by more than ``ARM_MOVED`` from where it began.

    So there-and-back motion counts; the published rule compares end points only.
    """
    motion = _motion(phase, phase.episode.effector or "")
    if motion is not None and motion.leaves(phase.start, phase.end, ARM_MOVED):
        yield ()


def gripper_moves(phase: Phase) -> Iterator[Row]:
    """Evaluate gripper_moves(): the distance of the finger tips varies by more than ``GRIPPER_MOVED`` over the phase."""
    opening = _opening(phase)
    if opening is not None:
        least, largest = opening.over(phase.start, phase.end)
        if largest - least > GRIPPER_MOVED:
            yield ()


def moves(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate moves(Thing): at some time in the action Thing is displaced or turned by more than a threshold
    from its start pose."""
    for name in _candidates(phase, thing):
        motion = _motion(phase, name)
        if motion is not None and (
            motion.leaves(phase.start, phase.end, THING_MOVED) or motion.turns(phase.start, phase.end, TURNED)
        ):
            yield (name,)


def driven(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate driven(Thing): from start to end, Thing is displaced by more than ``DRIVEN``, within 60 deg of the effector's own
    displacement.

    What falls away from an opening hand is not pushed.
    """
    hand = _motion(phase, phase.episode.effector or "")
    for name in _candidates(phase, thing) if hand is not None else []:
        mine, its = _displacement(hand, phase), _displacement(_motion(phase, name), phase)
        along = math.sqrt(its @ its)
        if along > DRIVEN and mine @ its > 0.5 * math.sqrt(mine @ mine) * along:
            yield (name,)


def _displacement(motion: Motion | None, phase: Phase) -> Floats:
    assert motion is not None
    return motion.poses[motion.row(phase.end), :3] - motion.poses[motion.row(phase.start), :3]


def tilts(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate tilts(Thing): at some time in the phase Thing leans away from its attitude at the start of the
    recording."""
    for name in _candidates(phase, thing):
        track = phase.episode.tracks[name]
        upright = track.at(float(track.times[0])).rotation[:, 2]
        w, x, y, z = _values_over(track.times, track.poses[:, 3:], phase).T
        up = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
        if len(w) and float((upright @ up).min()) < np.cos(TILTED):
            yield (name,)


def swings(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate swings(Thing) = count: the most strokes to and fro in a row, along any axis of the world."""
    for name in _candidates(phase, thing):
        track = phase.episode.tracks[name]
        times, points = (_values_over(track.times, v, phase) for v in (track.times, track.poses[:, :3]))
        yield name, float(max(_swings(times, _smoothed(times, points[:, axis])) for axis in range(3)))


def _smoothed(times: Floats, values: Floats) -> Floats:
    """Moving average of a signal over the time ``TREMOR``, which suppresses a tracker's noise.

    It leaves 2 mm of 5 mm of a tracker's noise at 45 Hz.
    """
    count = round(TREMOR / float(np.median(np.diff(times)))) if len(times) > 2 else 1
    half = count // 2
    padded = np.pad(values, half, mode="edge")
    return np.convolve(padded, np.ones(2 * half + 1) / (2 * half + 1), mode="valid")


def _swings(times: Floats, values: Floats) -> int:
    """Largest number of half swings of a signal in a row that take at most ``SWING`` each.

    A half swing leads from one extreme that ``_turns`` gives to the next.
    """
    best = row = 0
    for one, other in pairwise(_turns(values.tolist())):
        row = row + 1 if times[other] - times[one] <= SWING else 0
        best = max(best, row)
    return best


def _turns(values: list[float]) -> list[int]:
    """Indices of a signal's extremes after which it reverses by ``SWUNG`` or more, and of its last extreme."""
    found: list[int] = []
    way = low = high = 0
    for k, value in enumerate(values):
        low, high = (k if value < values[low] else low), (k if value > values[high] else high)
        if way <= 0 and value - values[low] >= SWUNG:
            found.append(low)
            way, high = 1, k
        elif way >= 0 and values[high] - value >= SWUNG:
            found.append(high)
            way, low = -1, k
    return [*found, high if way > 0 else low] if found else found


def gripper_closed(phase: Phase) -> Iterator[Row]:
    """Evaluate gripper_closed(): the fingers are closed at an instant, or all through a phase."""
    share = _share(phase)
    if share is not None and share[1] < CLOSED:
        yield ()


def gripper_open(phase: Phase) -> Iterator[Row]:
    """Evaluate gripper_open(): the fingers are open at an instant, or all through a phase."""
    share = _share(phase)
    if share is not None and share[0] > OPENED:
        yield ()


def on_joint(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate on_joint(Thing): the episode has its joint's values."""
    yield from ((n,) for n, _ in _joints(phase, thing))


def joint_rises(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate joint_rises(Thing): the value of Thing's joint is higher at the end of the phase than at the start."""
    yield from ((n,) for n, values in _joints(phase, thing) if values[-1] - values[0] > JOINT_CLOSED)


def joint_falls(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate joint_falls(Thing): the value of Thing's joint is lower at the end of the phase than at the start."""
    yield from ((n,) for n, values in _joints(phase, thing) if values[0] - values[-1] > JOINT_CLOSED)


def joint_closed(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate joint_closed(Thing): Thing's joint is closed all through the phase."""
    yield from ((n,) for n, values in _joints(phase, thing) if values.max() <= JOINT_CLOSED)


def joint_open(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate joint_open(Thing): Thing's joint is open all through the phase."""
    yield from ((n,) for n, values in _joints(phase, thing) if values.min() >= JOINT_OPEN)


def joint_wide(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate joint_wide(Thing): Thing's joint is open by ``WIDE`` of its range or more, all through the phase."""
    yield from ((n,) for n, values in _joints(phase, thing) if values.min() >= fluents.WIDE)


def joint_share(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate joint_share(Thing): how far the thing's joint is open at the end of the phase, from 0 (closed)
    to 1 (open)."""
    yield from ((n, float(values[-1])) for n, values in _joints(phase, thing))


def parked(phase: Phase) -> Iterator[Row]:
    """Evaluate parked(): the arm is in its park posture, which the episode's extra "park" states [rad]."""
    extras = phase.episode.extras
    if {"joints", "times", "park"} <= set(extras) and extras["joints"].ndim == 2:
        joints = _values_over(extras["times"], extras["joints"], phase)
        if joints.shape[1:] == extras["park"].shape and np.all(np.abs(joints - extras["park"]) < PARKED):
            yield ()


def _candidates(phase: Phase, thing: str | None) -> list[str]:
    if thing is not None:
        tracked = phase.episode.tracks.get(thing)
        return [thing] if tracked is not None and len(tracked.times) else []
    return [n for n, e in phase.timeline.entities.items() if e.part_of is None and n in phase.episode.tracks]


def _values_over(times: Floats, values: Floats, phase: Phase) -> Floats:
    """Return the values of a recorded signal during a phase, and the last one before it, since a value lasts until the next sample."""
    first = max(int(times.searchsorted(phase.start, side="right")) - 1, 0)
    return values[first : max(int(times.searchsorted(phase.end, side="left")), first + 1)]


def _motion(phase: Phase, name: str) -> Motion | None:
    """Tracked poses of a thing, cut at the boundaries of the timeline; None if the thing is not tracked."""
    memo = phase.timeline.memo
    if ("motion", name) not in memo:
        track = phase.episode.tracks.get(name)
        tracked = track is not None and len(track.times)
        memo["motion", name] = Motion(track, phase.timeline.cuts) if track is not None and tracked else None
    return memo["motion", name]  # type: ignore[no-any-return]


def _opening(phase: Phase) -> Range | None:
    """The finger tips' distance [m] over time, from the extra "opening", else from the tips' tracks; None if unknown."""
    memo = phase.timeline.memo
    if "opening" not in memo:
        found = _find_opening(phase)
        memo["opening"] = Range(*found, phase.timeline.cuts) if found is not None and len(found[0]) else None
    return memo["opening"]  # type: ignore[no-any-return]


def _find_opening(phase: Phase) -> tuple[Floats, Floats] | None:
    episode = phase.episode
    if "opening" in episode.extras and len(episode.extras["opening"]) == len(episode.extras.get("times", ())):
        return episode.extras["times"], episode.extras["opening"]
    tips = [
        episode.tracks[e.name]
        for e in episode.entities
        if e.part_of == episode.effector and e.part_of is not None and e.name in episode.tracks
    ]
    if len(tips) < 2 or any(len(t.times) == 0 for t in tips):
        return None
    times = np.union1d(tips[0].times, tips[1].times)
    a, b = (t.poses[np.maximum(np.searchsorted(t.times, times, side="right") - 1, 0), :3] for t in tips[:2])
    return times, np.linalg.norm(a - b, axis=1)


def _share(phase: Phase) -> tuple[float, float] | None:
    """Least and largest opening in the phase, as shares of the widest opening that the recording states or
    shows."""
    opening = _opening(phase)
    if opening is None:
        return None
    widest = phase.timeline.memo.get("widest")
    if widest is None:
        entity = phase.timeline.entities.get(phase.episode.effector or "")
        said = entity.properties.get("max_opening") if entity else None
        widest = phase.timeline.memo["widest"] = said or float(opening.values.max())
    least, largest = opening.over(phase.start, phase.end)
    return (least / widest, largest / widest) if widest > 0 else None


def _joints(phase: Phase, thing: str | None) -> Iterator[tuple[str, Floats]]:
    """Yield each thing that has a joint, with the joint's values during the phase as shares of the joint's range.

    The episode's extra "joint:<thing>" holds the values at the extra "times"; the range is the
    entity's properties joint_lower and joint_upper; it is closed at joint_closed, else at the lower end.
    """
    extras = phase.episode.extras
    for key, values in extras.items():
        name = key.removeprefix("joint:")
        if key != name and thing in (None, name) and "times" in extras and name in phase.timeline.entities:
            limits = phase.timeline.entities[name].properties
            lower = limits.get("joint_lower", float(values.min()))
            upper = limits.get("joint_upper", float(values.max()))
            if upper > lower:
                yield name, opened(_values_over(extras["times"], values, phase), lower, upper, limits.get("joint_closed", lower))

"""Event detection from poses alone, for recordings without contacts.

Without contacts, a grasp can only be concluded: an object that moves, and keeps its place in a moving hand, is held by
it. From the held object's path follow lifting, putting back, shaking and pouring; from shapes, where they are known,
what an object at rest stands on. Every event is marked ``inferred``.

Recordings are sparse and often written on change only, so the last pose is held between documents.
"""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from cramlite.model import Entity, Episode, Event, Floats, Repair, Track, Value

from ..tracks import compose
from .standing import resting

#: Everything is looked at on a common time grid of this step [s]; recordings have 5 to 60 samples a second.
STEP = 0.02
#: Speeds are taken over this window [s]; an object moves above this speed [m/s].
WINDOW, MOVING = 0.3, 0.02
#: A held object stays within this of its place in the hand [m]: VR hands are compliant (1.5 cm on a real recording).
STEADY = 0.025
#: A held object travels this far at least [m]. Pauses in which it also keeps its place in the hand are bridged.
TRAVEL = 0.05
#: Lifted: this much higher than where it stood [m].
LIFTED = 0.02
#: Shaking: this many swings to and fro, each of this amplitude [m] and shorter than this [s] (0.7 Hz and faster).
SWINGS, AMPLITUDE, SWING = 5, 0.008, 0.75
#: Pouring: tilted this far [rad] from how it stood, for this long [s]; a full cup spills from about 60 degrees.
TILT, POURED = np.radians(60), 0.5

#: Longest recording looked at [s]: a grid of STEP over six hours takes 0.2 GB. One wrong stamp can make a recording
#: of 50 years out of one of a minute.
LONGEST = 6 * 3600.0

Flags = NDArray[np.bool_]


class _Motion(Value):
    """Hand and object on one grid.

    Args:
        times: (N,) [s].
        hand, thing: (N, 7) poses.
    """

    times: Floats
    hand: Floats
    thing: Floats


def infer(episode: Episode) -> Episode:
    """Infer the events of an episode from its tracks; unchanged if it has states, or nothing that acts.

    Adds ContactState and GraspState of the effector with each object that moves along with it; SupportState, ContactState
    and ContainmentState of objects at rest where shapes are known; and the actions soma:PickingUp, soma:PuttingDown,
    cram:Shaking and soma:Pouring.
    """
    if episode.of("state") or episode.effector not in episode.tracks:
        return episode
    first, last = episode.span
    if last - first > LONGEST:
        why = f"it lasts {last - first:.0f} s, and up to {LONGEST:.0f} s are looked at; is a stamp wrong?"
        return replace(episode, repairs=(*episode.repairs, Repair("no events were inferred", (first, last), why)))
    effector = str(episode.effector)
    found: list[Event] = []
    for name, track in episode.tracks.items():
        own = name == effector or _whole(episode, name) == effector
        if not own and len(track.times) > 1:
            motion = _motion(episode.tracks[effector], track)
            for start, end in _held(motion):
                found += _events(effector, name, motion, start, end)
    held = [(e.roles["object"], e.start, e.end) for e in found if e.type == "cram:GraspState"]
    found += resting(episode, held)
    found.sort(key=lambda e: (e.start, e.end, e.type))
    numbered = (replace(e, id=f"inferred_{k}") for k, e in enumerate(found, 1))
    return replace(episode, events=(*episode.events, *numbered))


def _whole(episode: Episode, name: str) -> str | None:
    entity: Entity | None = next((e for e in episode.entities if e.name == name), None)
    return None if entity is None else entity.part_of


def _motion(hand: Track, thing: Track) -> _Motion:
    """Both, while both are known."""
    start, end = max(hand.times[0], thing.times[0]), max(hand.times[-1], thing.times[-1])
    times = np.arange(start, end + STEP / 2, STEP) if end > start else np.array([start])
    return _Motion(times, _sampled(hand, times), _sampled(thing, times))


def _sampled(track: Track, times: Floats) -> Floats:
    """The last pose at or before each time."""
    return track.poses[np.clip(np.searchsorted(track.times, times, side="right") - 1, 0, None)]


def _held(motion: _Motion) -> list[tuple[int, int]]:
    """Index ranges in which the thing moves and keeps its place in the hand."""
    place = _in_hand(motion)
    runs = [run for s, e in _runs(_speed(motion.thing) > MOVING) for run in _steady(place, s, e)]
    merged: list[tuple[int, int]] = []
    for start, end in runs:
        if merged and _steady(place, merged[-1][0], end) == [(merged[-1][0], end)]:
            merged[-1] = (merged[-1][0], end)
        else:
            merged.append((start, end))
    return [(s, e) for s, e in merged if _travel(motion.thing[s:e]) > TRAVEL and _travel(motion.hand[s:e]) > TRAVEL]


def _in_hand(motion: _Motion) -> Floats:
    """The thing's position in the hand's frame."""
    inverse = motion.hand * [0, 0, 0, 1, -1, -1, -1]
    shifted = np.hstack([motion.thing[:, :3] - motion.hand[:, :3], motion.thing[:, 3:]])
    return compose(inverse, shifted)[:, :3]


def _steady(place: Floats, start: int, end: int) -> list[tuple[int, int]]:
    """The parts of a range in which a place differs little from the range's median."""
    near = np.linalg.norm(place[start:end] - np.median(place[start:end], axis=0), axis=1) < STEADY
    return [(start + s, start + e) for s, e in _runs(near)]


def _speed(poses: Floats) -> Floats:
    """Speed over WINDOW, centred [m/s]."""
    half = max(round(WINDOW / STEP / 2), 1)
    padded = np.pad(poses[:, :3], ((half, half), (0, 0)), mode="edge")
    return np.asarray(np.linalg.norm(padded[2 * half :] - padded[: -2 * half], axis=1) / (2 * half * STEP))


def _travel(poses: Floats) -> float:
    """The largest distance from where it began [m]."""
    return float(np.max(np.linalg.norm(poses[:, :3] - poses[0, :3], axis=1), initial=0.0))


def _runs(on: Flags) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return [(int(s), int(e)) for s, e in edges.reshape(-1, 2)]


def _events(effector: str, name: str, motion: _Motion, start: int, end: int) -> list[Event]:
    """The grasp, and what was done with the object in it."""
    times = np.append(motion.times, motion.times[-1] + STEP)
    span = (float(times[start]), float(times[end]))
    roles = {"performer": effector, "object": name}
    states = [
        Event("", "soma:ContactState", "state", *span, {"a": effector, "b": name}, True),
        Event("", "cram:GraspState", "state", *span, {"gripper": effector, "object": name}, True),
    ]
    height = motion.thing[start:end, 2]
    up = np.flatnonzero(height > height[0] + LIFTED)
    if not len(up):
        return states
    above = np.flatnonzero(height > height[-1] + LIFTED)
    lift, down = start + int(up[0]), start + int(above[-1]) + 1 if len(above) else end
    spans = [("soma:PickingUp", start, lift), *_shaking(motion, lift, down), *_pouring(motion, start, lift, down)]
    if end < len(motion.times) and down < end:
        spans.append(("soma:PuttingDown", down, end))
    return states + [Event("", t, "action", float(times[s]), float(times[e]), roles, True) for t, s, e in spans]


def _shaking(motion: _Motion, start: int, end: int) -> list[tuple[str, int, int]]:
    """Swings to and fro about the moving mean, along the direction in which there are most."""
    half = round(SWING / STEP)
    path = motion.thing[start:end, :3]
    if len(path) <= 2 * half:
        return []
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    padded = np.pad(path, ((half, half), (0, 0)), mode="edge")
    swing = path - np.column_stack([np.convolve(padded[:, i], kernel, mode="valid") for i in range(3)])
    axis = np.linalg.svd(swing, full_matrices=False)[2][0]
    turns = _crossings(swing @ axis)
    chains = np.split(turns, np.flatnonzero(np.diff(turns) > SWING / STEP) + 1)
    return [("cram:Shaking", start + int(c[0]), start + int(c[-1])) for c in chains if len(c) >= SWINGS]


def _crossings(signal: Floats) -> NDArray[np.intp]:
    """Where a signal goes from one side to the other, AMPLITUDE beyond zero at least."""
    outside = np.flatnonzero(np.abs(signal) > AMPLITUDE)
    flips = np.flatnonzero(np.diff(np.sign(signal[outside])) != 0)
    return np.asarray(outside[flips + 1])


def _pouring(motion: _Motion, stood: int, start: int, end: int) -> list[tuple[str, int, int]]:
    """Tilted away from how it stood."""
    upright = motion.thing[stood] * [1, 1, 1, 1, -1, -1, -1]
    axis = compose(upright[None] * [0, 0, 0, 1, 1, 1, 1], np.array([[0, 0, 1, 1, 0, 0, 0.0]]))[0, :3]
    turned = motion.thing[start:end] * [0, 0, 0, 1, 1, 1, 1]
    up = compose(turned, np.tile([*axis, 1, 0, 0, 0], (end - start, 1)))[:, 2]
    tilted = np.arccos(np.clip(up, -1, 1)) > TILT
    return [("soma:Pouring", start + s, start + e) for s, e in _runs(tilted) if (e - s) * STEP >= POURED]

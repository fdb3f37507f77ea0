"""Assembly of an episode from a table of poses: entities, tracks, openings and joints; events are inferred from motion and shapes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from cramlite.model import Entity, Episode, Event, Floats, Pose, Repair, Track
from cramlite.plugin import UserError

from ...shapes.bounds import extents
from ..detection.co_motion import SMOOTH
from ..detection.from_motion import infer
from ..tracks import world_tracks
from .convention import Convention
from .mapping import GripperSpec, Mapping, OpensSpec, PlaceSpec, ThingSpec, read_mapping
from .stated_shapes import geoms_of
from .table import Table, read_table
from .tracked import Recorded, recorded, rows_of

HAND = ("soma:Hand", "soma:PrehensileEffector")
"""Ontology classes of the hand or gripper in a recording."""


def read_recording(file: Path) -> Episode | None:
    """Read the recording that a mapping file describes, as an episode with inferred events; None if the file is no mapping.

    Raises:
        UserError: the mapping or the recording cannot be used; names the file and what to do.
    """
    mapping = read_mapping(file)
    if mapping is None:
        return None
    both = set(mapping.hands) & set(mapping.things)
    if both:
        raise UserError(f"{file}: '{min(both)}' is both a hand and a thing; give each its own name ('track' is for the recording's name).")
    return episode_of(file, mapping, read_table(file.parent / mapping.recording, mapping.kind))


def episode_of(file: Path, mapping: Mapping, table: Table, states: tuple[Event, ...] | None = None) -> Episode:
    """Return a table of poses as an episode.

    Args:
        file: named in errors, and the episode is named after it.
        mapping: what the columns of the table mean.
        table: poses at each time.
        states: known contacts and other states; None to infer all events from motion.

    Raises:
        UserError: the mapping or the recording cannot be used; names the file and what to do.
    """
    try:
        return _episode(file, mapping, table, recorded(table, mapping), states)
    except UserError as error:
        text = str(error)
        raise error if text.startswith(str(file.parent)) else UserError(f"{file}: {text}") from None


def _episode(file: Path, mapping: Mapping, table: Table, found: Recorded, states: tuple[Event, ...] | None) -> Episode:
    tracks, repairs = world_tracks(found.rows)
    hands = tuple(Entity(n, HAND, pose=tracks[n].at(-math.inf)) for n in mapping.hands)
    things = tuple(_thing(n, t, tracks, found.convention, file.parent) for n, t in mapping.things.items())
    first = next(iter(mapping.hands)) if len(mapping.hands) == 1 else None
    repairs = (*repairs, *_gaps(found))
    name = file.resolve().parent.name if file.name == "recording.yaml" else file.stem
    joints = _joints(mapping, tracks, found)
    times = {"times": np.unique(found.times)} if joints else {}
    episode = Episode(name, (*hands, *things), states or (), tracks, first, repairs, {**times, **joints})
    episode = infer(episode) if states is None else episode
    return _with_opening(_following(episode, mapping), mapping, table, found)


def _following(episode: Episode, mapping: Mapping) -> Episode:
    """Episode in which a grasp of a drawer or door that moves on its joint becomes an action that opens or
    closes it.

    Of a lever on a door, the action's object is the one of both whose joint moves by the larger share of its
    range.
    """
    opened = {n for n, t in mapping.things.items() if t.opens is not None}
    held = [e for e in episode.events if e.type == "cram:GraspState" and e.roles["object"] in opened]
    repairs, events = list(episode.repairs), {e.id: e for e in episode.events}
    why = "it slides or turns on a joint; the hand follows it, and carries nothing"
    for grasp in held:
        shares = {n: _shares(episode, n, grasp) for n in _mounted(grasp.roles["object"], mapping)}
        name, (before, after) = max(shares.items(), key=lambda item: abs(item[1][1] - item[1][0]))
        roles = {"performer": grasp.roles["gripper"], "object": name}
        task = "soma:Opening" if after > before else "soma:Closing"
        events[grasp.id] = Event(grasp.id, task, "action", grasp.start, grasp.end, roles, True)
        what = f"read the grasp of '{grasp.roles['object']}' by '{grasp.roles['gripper']}' as {task} of '{name}'"
        repairs.append(Repair(what, (grasp.start, grasp.end), why, removed=(grasp,), added=(events[grasp.id],)))
    return replace(episode, events=tuple(events.values()), repairs=tuple(repairs)) if held else episode


def _mounted(name: str, mapping: Mapping) -> list[str]:
    """Return the names of a thing and of those that it is mounted on, directly or through others; things without a
    joint are left out."""
    found = [name]
    while (spec := mapping.things[found[-1]].opens) is not None and spec.on in mapping.things and spec.on not in found:
        found.append(spec.on)
    return [n for n in found if mapping.things[n].opens is not None]


def _shares(episode: Episode, name: str, event: Event) -> tuple[float, float]:
    """How far a thing is open at the start and at the end of an event, as shares of its range."""
    entity, times = episode.known(name), episode.extras["times"]
    upper = entity.properties["joint_upper"] if entity is not None else 1.0
    before, after = (float(np.interp(t, times, episode.extras[f"joint:{name}"])) / upper for t in (event.start, event.end))
    return before, after


def _thing(name: str, spec: ThingSpec, tracks: dict[str, Track], convention: Convention, folder: Path) -> Entity:
    geoms = geoms_of(spec.shape, convention, folder) if spec.shape is not None else ()
    types = (spec.type,) if spec.type is not None else ()
    pose = _placed(spec.at, convention, name) if spec.at is not None else tracks[name].at(-math.inf)
    opens = {"joint_lower": 0.0, "joint_upper": _range(spec.opens, convention)} if spec.opens is not None else {}
    return Entity(name, types, None, pose, extents(geoms) if geoms else None, geoms, opens)


def _placed(at: PlaceSpec, convention: Convention, name: str) -> Pose:
    position = convention.positions(np.array([at.position]))[0]
    if not at.rotation:
        return Pose(tuple(position))
    if len(at.rotation) != convention.numbers:
        raise UserError(f"the rotation of '{name}' has {len(at.rotation)} numbers, and '{convention.rotation}' needs {convention.numbers}.")
    if not np.any(at.rotation) and convention.numbers == 4:
        raise UserError(f"the rotation of '{name}' is a quaternion of zeros; leave it out where the thing is not turned.")
    return Pose(tuple(position), tuple(convention.quaternions(np.array([at.rotation]))[0]))


def _range(opens: OpensSpec, convention: Convention) -> float:
    return opens.slides * convention.unit if opens.slides is not None else math.radians(opens.turns or 0.0)


def _joints(mapping: Mapping, tracks: dict[str, Track], found: Recorded) -> dict[str, Floats]:
    """Opening of each drawer [m] and door [rad], relative to its first pose, at the recording's instants."""
    times = np.unique(found.times)
    values: dict[str, Floats] = {}
    for name, spec in mapping.things.items():
        if spec.opens is not None and name in tracks:
            track = tracks[name] if spec.opens.on is None else _seen_from(tracks[name], tracks[spec.opens.on])
            away = _pulled(track) if spec.opens.slides is not None else _turned(track)
            values[f"joint:{name}"] = np.interp(times, track.times, away)
    return values


def _seen_from(track: Track, other: Track) -> Track:
    """Track in the frame of another track."""
    poses = [other.at(float(t)).inverse() * track.at(float(t)) for t in track.times]
    return Track(track.times, np.array([[*p.position, *p.quaternion] for p in poses]))


def _pulled(track: Track) -> Floats:
    """Return how far a thing has moved at each sample (N,) [m], along the direction from its first to its
    farthest position.

    The plain distance would add up noise.
    """
    away = _smooth(track.poses[:, :3] - _smooth(track.poses[:, :3], track.times)[0], track.times)
    far = away[np.argmax(np.linalg.norm(away, axis=1))]
    return np.asarray(np.clip(away @ (far / max(float(np.linalg.norm(far)), 1e-9)), 0.0, None))


def _turned(track: Track) -> Floats:
    """Angle (N,) of a thing from its first orientation [rad]."""
    first = track.poses[0, 3:]
    return _smooth(2 * np.arccos(np.clip(np.abs(track.poses[:, 3:] @ first), 0.0, 1.0))[:, None], track.times)[:, 0]


def _smooth(values: Floats, times: Floats) -> Floats:
    """Values (N, D) as a moving average over the time ``SMOOTH``."""
    half = round(SMOOTH / float(np.median(np.diff(times)) or SMOOTH) / 2)
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    return np.column_stack([np.convolve(column, np.full(2 * half + 1, 1 / (2 * half + 1)), mode="valid") for column in padded.T])


def _gaps(found: Recorded) -> list[Repair]:
    span = (float(found.times[0]), float(found.times[-1]))
    why = "it was not seen then; gaps up to 0.5 s are bridged, over longer ones it is where it was"
    return [Repair(f"left out {n} of {of} rows of '{name}'", span, why) for name, (n, of) in found.unseen.items() if n]


def _with_opening(episode: Episode, mapping: Mapping, table: Table, found: Recorded) -> Episode:
    """Episode with the opening of the acting hand or gripper, if the mapping names a column for it."""
    spec = mapping.hands[episode.effector].gripper if episode.effector in mapping.hands else None
    if spec is None or episode.effector is None:
        return episode
    values = table.numbers(spec.column, f"the gripper of '{episode.effector}'", frozenset(str(g) for g in mapping.gaps))
    seen = rows_of(table, mapping, episode.effector) & np.isfinite(values)
    if not seen.any():
        raise UserError(f"{table.path}: the column '{spec.column}' is always empty; leave the gripper out of the mapping.")
    opening = _opening(values[seen], spec, found.convention)
    times = episode.extras.get("times", np.unique(found.times))
    widest = float(opening.max())
    entities = tuple(replace(e, properties={"max_opening": widest}) if e.name == episode.effector else e for e in episode.entities)
    extras = {**episode.extras, "times": times, "opening": np.interp(times, found.times[seen], opening)}
    return replace(episode, entities=entities, extras=extras)


def _opening(values: Floats, spec: GripperSpec, convention: Convention) -> Floats:
    """Opening of the hand (N,) [m], from the values in the column that the mapping names for it."""
    if spec.closed is None or spec.open is None:
        return np.asarray(np.clip(values * convention.unit, 0.0, None))
    return np.asarray(spec.width * np.clip((values - spec.closed) / (spec.open - spec.closed), 0.0, 1.0))

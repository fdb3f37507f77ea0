"""Episodic memory (NEEM) of one demonstration or run.

Three parts, as in the NEEM handbook: a semantic map (entities), a timeline of
events (states and actions), and pose data (tracks).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from functools import cached_property
from itertools import accumulate
from typing import Literal

import numpy as np
from msgspec import field

from ..base.value import Value
from .geometry import Floats, Pose, Vector3
from .world.thing import Geom


class Entity(Value):
    """Thing, part, feature or effector of the semantic map.

    Args:
        name: unique in the episode.
        types: classes as CURIEs or IRIs, most specific first.
        part_of: the entity that this is a part or feature of; its pose is then fixed in that entity.
        pose: initial pose: in ``part_of``'s frame if set, else in the world frame; None if unknown.
        size: extents along its own axes [m], None if unknown.
        geoms: shape, where known.
        properties: named numbers, e.g. {"constrained_dof": 4} or {"mass": 0.3}.
    """

    name: str
    types: tuple[str, ...]
    part_of: str | None = None
    pose: Pose | None = None
    size: Vector3 | None = None
    geoms: tuple[Geom, ...] = ()
    properties: dict[str, float] = field(default_factory=dict)


class Event(Value):
    """State, action or situation of the timeline.

    Args:
        id: unique in the episode.
        type: class as a CURIE: "soma:ContactState", "soma:SupportState", "cram:GraspState",
            "soma:PhysicalAction" for an anonymous action, or a task's class for a labelled one.
        kind: what the class is.
        start, end: [s], end exclusive.
        roles: role -> entity. ContactState: a, b (symmetric). SupportState: supporter, supportee.
            GraspState: gripper, object. Actions: performer, object where known.
        inferred: True when it was concluded from motion instead of measured contact.
    """

    id: str
    type: str
    kind: Literal["state", "action", "situation"]
    start: float
    end: float
    roles: dict[str, str] = field(default_factory=dict)
    inferred: bool = False


class Track(Value):
    """Poses of one frame over time, world frame.

    Args:
        times: (N,) ascending [s].
        poses: (N, 7) position [m] and quaternion (w, x, y, z).
    """

    times: Floats
    poses: Floats

    def at(self, time: float) -> Pose:
        """Return the last pose recorded at or before ``time`` [s], in the world frame; for an earlier time
        the first one.

        Recorders that write on change only make holding right, and interpolating wrong.
        """
        k = max(int(np.searchsorted(self.times, time, side="right")) - 1, 0)
        row = self.poses[k]
        return Pose.from_row(row)


class Repair(Value):
    """Correction of a recording, by code that reads or smooths it: what was changed, and the data before the
    change.

    Args:
        what: was changed, for people.
        when: first and last instant concerned [s].
        why: the reason, with numbers.
        removed, added: events.
        track: name of the entity whose poses were changed, if any were.
        recorded: its rows (time, x, y, z, qw, qx, qy, qz) in ``when``, end exclusive, as they were recorded.
    """

    what: str
    when: tuple[float, float]
    why: str
    removed: tuple[Event, ...] = ()
    added: tuple[Event, ...] = ()
    track: str | None = None
    recorded: tuple[tuple[float, ...], ...] = ()


class Episode(Value, dict=True):
    """Episode of one demonstration or run: semantic map, timeline and pose data.

    Args:
        name: for people.
        entities: the semantic map, parts and effectors included.
        events: the timeline, sorted by start.
        tracks: entity name -> poses over time. Finger tips are entities that are part of the effector.
        effector: name of the hand or gripper that acts; None if unknown.
        repairs: what was changed since it was recorded.
        extras: further arrays, e.g. "joints" (N, J), "wrench" (N, 6), "opening" (N,), with "times" (N,).
    """

    name: str
    entities: tuple[Entity, ...]
    events: tuple[Event, ...]
    tracks: dict[str, Track] = field(default_factory=dict)
    effector: str | None = None
    repairs: tuple[Repair, ...] = ()
    extras: dict[str, Floats] = field(default_factory=dict)

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last record of the episode [s]."""
        starts = [e.start for e in self.events] + [float(t.times[0]) for t in self.tracks.values() if len(t.times)]
        ends = [e.end for e in self.events] + [float(t.times[-1]) for t in self.tracks.values() if len(t.times)]
        return (min(starts), max(ends)) if starts else (0.0, 0.0)

    def entity(self, name: str) -> Entity:
        """Return the entity with a given name.

        Raises:
            KeyError: there is none.
        """
        entity = self.known(name)
        if entity is None:
            raise KeyError(f"no entity '{name}' in episode '{self.name}'")
        return entity

    @cached_property
    def _entities(self) -> dict[str, Entity]:
        return {e.name: e for e in reversed(self.entities)}

    def known(self, name: str) -> Entity | None:
        """Return the entity of a given name; None if there is none."""
        return self._entities.get(name)

    def whole(self, name: str) -> str:
        """Return the thing that an entity is a part or feature of; the entity itself if it is no part.

        In a cycle of parts the last entity before the cycle closes.
        """
        seen = {name}
        entity = self.known(name)
        while entity is not None and entity.part_of is not None and entity.part_of not in seen:
            name = entity.part_of
            seen.add(name)
            entity = self.known(name)
        return name

    def pose_at(self, name: str, time: float) -> Pose | None:
        """Return the pose of an entity in the world frame at a time [s], or None if it is unknown. Parts follow their whole."""
        inside: Pose | None = None
        for _ in range(len(self.entities) + 1):  # a cycle of parts ends with it
            if name in self.tracks and len(self.tracks[name].times):
                here: Pose | None = self.tracks[name].at(time)
                return here if inside is None or here is None else here * inside
            entity = self.known(name)
            if entity is None or entity.pose is None:
                return None
            inside = entity.pose if inside is None else entity.pose * inside
            if entity.part_of is None:
                return inside
            name = entity.part_of
        return None

    def sampled(self, name: str, time: float) -> Floats | None:
        """Return the row of an array in ``extras`` ("joints", "wrench") last recorded at or before a time [s]; None if there is none."""
        times, values = self.extras.get("times"), self.extras.get(name)
        if times is None or values is None or len(times) != len(values) or not len(times) or time < times[0]:
            return None
        row: Floats = values[int(np.searchsorted(times, time, side="right")) - 1]
        return row

    def at(self, time: float) -> tuple[Event, ...]:
        """Return the events that hold at a time [s], in order of their start times."""
        return self.between(time, time)

    def between(self, start: float, end: float) -> tuple[Event, ...]:
        """Return the events that hold at some time of [start, end] [s], in order of their start times. An
        event's end is exclusive.

        Takes O(log n) and what is found, unless long events nest deeply.
        """
        starts, latest, ordered = self._starts
        last = bisect_right(starts, end)
        first = bisect_right(latest, start, 0, last)  # before it, every event has ended by ``start``
        return tuple(e for e in ordered[first:last] if e.end > start)

    @cached_property
    def _starts(self) -> tuple[list[float], list[float], list[Event]]:
        """Start times of the events, the latest end time up to each, and the events themselves, in the order
        of the starts.

        Bisection in these lists finds the events at a time.
        """
        ordered = sorted(self.events, key=lambda e: e.start)
        return [e.start for e in ordered], list(accumulate((e.end for e in ordered), max)), ordered

    def of(self, kind: str, types: Iterable[str] = ()) -> tuple[Event, ...]:
        """Return the events of one kind, optionally of certain classes only."""
        wanted = set(types)
        return tuple(e for e in self.events if e.kind == kind and (not wanted or e.type in wanted))

"""Assembly of an episode from the contents of its files: impossible events dropped, unknown entities added, all reported."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from cramlite.model import Entity, Episode, Event, Repair, Track, thing_of

from ..detection.from_motion import infer, with_grasps
from ..repair.names import FINGER, HAND, one_namespace
from ..tracks import rigid_links, world_tracks
from .parts import Parts

HANDLING = frozenset(f"soma:{n}" for n in ("Grasping", "PickingUp", "Placing", "PuttingDown", "Releasing", "Ungrasping", "Lifting"))
"""Classes of actions that take a thing or let go of it; a recording that names no such action labels the task as a whole, not its steps."""
EPOCH = 1e8
"""Least time stamp that counts as seconds since 1970 [s]: 1e8 s is in 1973, and no recording lasts three years."""
LATER = 10.0
"""Longest time after the last recorded pose at which an event may still end [s]."""


def episode_of(parts: Parts) -> Episode:
    """Assemble an episode; impossible events are dropped and unknown entities added, and each is noted as a repair."""
    tracks, repairs = world_tracks(parts.rows)
    parts.repairs += repairs
    _one_clock(parts, tracks)
    events = _sound(parts)
    entities = _complete(parts, events, tracks)
    effector = parts.effector or _guess_effector(events, tracks)
    episode = Episode(parts.name, entities, events, tracks, effector, tuple(parts.repairs), parts.extras)
    if not parts.foreign:
        return episode
    episode = one_namespace(_with_hands(one_namespace(_with_links(episode, parts)), parts))
    return with_grasps(episode) if any(e.kind == "state" or e.type in HANDLING for e in events) else _from_motion(episode)


def _one_clock(parts: Parts, tracks: dict[str, Track]) -> None:
    """Shift events whose times count from the start of the recording to the dates of the poses: the start is
    the first pose of a moving thing."""
    spans = [(float(t.times[0]), float(t.times[-1])) for t in tracks.values() if len(t.times) > 1 and np.ptp(t.poses, axis=0).any()]
    first, last = min((s for s, _ in spans), default=0.0), max((e for _, e in spans), default=0.0)
    ends = [e.end for e in parts.events]
    if not ends or first < EPOCH or max(ends) > last - first + LATER:
        return
    parts.events = tuple(replace(e, start=e.start + first, end=e.end + first) for e in parts.events)
    why = "event times count from the start of the recording, and pose times are dates"
    parts.repairs.append(Repair(f"dated {len(ends)} events", (first, last), why))


def _from_motion(episode: Episode) -> Episode:
    """Replace the recorded actions of an episode, none of which takes or releases a thing, by events inferred from
    motion.

    If no event is found, the actions stay.
    """
    repairs = episode.repairs
    if episode.events:
        named = ", ".join(sorted({e.type for e in episode.events}))
        what = f"left out {len(episode.events)} action{'s' * (len(episode.events) > 1)} ({named})"
        why = "none of them takes a thing or lets go of it: events are inferred from motion"
        repairs = (*repairs, Repair(what, episode.span, why, episode.events))
    found = infer(replace(episode, events=(), repairs=repairs))
    return found if found.events or not episode.events else episode


def _with_hands(episode: Episode, parts: Parts) -> Episode:
    """Episode in which entities named like hands have the class soma:Hand, including hands without any pose."""
    unseen = [Entity(n, ()) for n in parts.rows if _is_hand(n) and episode.known(n) is None]
    known = (*episode.entities, *unseen)
    named = {e.name for e in known if not e.types and e.part_of is None and _is_hand(e.name)}
    entities = tuple(replace(e, types=("soma:Hand",)) if e.name in named else e for e in known)
    repairs = [Repair(f"read '{n}' as a hand", episode.span, "it is named so") for n in sorted(named)]
    return replace(episode, entities=entities, repairs=(*episode.repairs, *repairs))


def _is_hand(name: str) -> bool:
    return HAND.search(name) is not None and FINGER.search(name) is None and thing_of(name) == name


def _with_links(episode: Episode, parts: Parts) -> Episode:
    """Make each link that never moves in its parent link a part of that link.

    A track of a single pose is dropped, since the entity has that pose.
    """
    links = {n: p for n, p in rigid_links(parts.rows).items() if n in episode.tracks and p in episode.tracks}
    tracks = {n: t for n, t in episode.tracks.items() if len(t.times) > 1}
    entities = []
    for e in episode.entities:
        if e.name in links and e.part_of is None:
            whole, own = (episode.tracks[n].at(np.inf) for n in (links[e.name], e.name))
            e = replace(e, part_of=links[e.name], pose=whole.inverse() * own)
        entities.append(e)
    return replace(episode, entities=tuple(entities), tracks=tracks)


def _sound(parts: Parts) -> tuple[Event, ...]:
    kept: list[Event] = []
    ids: set[str] = set()
    for event in parts.events:
        if not event.start <= event.end:
            why = f"the event ends at {event.end:g} s, before it starts at {event.start:g} s"
            parts.repairs.append(Repair(f"left out event '{event.id}'", (event.end, event.start), why, (event,)))
            continue
        if event.id in ids:
            renamed = replace(event, id=f"{event.id}_{len(ids)}")
            why = "another event has this id"
            parts.repairs.append(
                Repair(f"renamed event '{event.id}'", (event.start, event.end), why, (event,), (renamed,))
            )
            event = renamed
        ids.add(event.id)
        kept.append(event)
    return tuple(sorted(kept, key=lambda e: e.start))


def _complete(parts: Parts, events: tuple[Event, ...], tracks: dict[str, Track]) -> tuple[Entity, ...]:
    """Entities of the episode: those described in maps, and one of unknown class for every other name in
    tracks or roles."""
    entities = dict(parts.entities)
    for name in tracks:
        entities.setdefault(name, Entity(name, (), pose=tracks[name].at(-np.inf)))
    dangling = {f: e for e in reversed(events) for f in e.roles.values() if f not in entities}
    for name, event in sorted(dangling.items()):
        entities[name] = Entity(name, ())
        why = f"event '{event.id}' names this entity, and no semantic map describes it"
        parts.repairs.append(Repair(f"added entity '{name}'", (event.start, event.end), why))
    for name, entity in entities.items():
        if entity.part_of is not None and entity.part_of not in entities:
            parts.repairs.append(
                Repair(f"'{name}' taken as free", (0.0, 0.0), f"its whole '{entity.part_of}' is not described")
            )
            entities[name] = replace(entity, part_of=None)
    return _acyclic(entities, parts)


def _acyclic(entities: dict[str, Entity], parts: Parts) -> tuple[Entity, ...]:
    """Make entities that are described as parts of themselves, directly or through others, separate things."""
    for name in list(entities):
        seen, at = {name}, entities[name].part_of
        while at is not None and at not in seen:
            seen.add(at)
            at = entities[at].part_of
        if at == name:
            parts.repairs.append(Repair(f"'{name}' taken as free", (0.0, 0.0), "it is described as a part of itself"))
            entities[name] = replace(entities[name], part_of=None)
    return tuple(entities.values())


def _guess_effector(events: tuple[Event, ...], tracks: dict[str, Track]) -> str | None:
    """Name of the entity that grasps or performs most often; without such roles, the track named like a hand
    that has most poses."""
    acting = [r for e in events for k, r in e.roles.items() if k in ("gripper", "performer")]
    if acting:
        return max(sorted(set(acting)), key=acting.count)
    hands = [n for n in tracks if _is_hand(n)]
    return max(hands, key=lambda n: len(tracks[n].times), default=None)

"""NEEMs on disk: an episode as a folder of the field's formats, and back without loss.

    <Id>_ED.owl              events, RobCoG event data
    <Id>_SM.owl              entities, RobCoG semantic map
    tf/roslog/tf.bson        poses, KnowRob's mongodump layout
    wrench/roslog/...        forces, where there are some
    triples/roslog/...       the same events and entities as SOMA triples
    extras.npz               further arrays (joints, gripper opening), NumPy's format

Any of these may be absent. Events and entities are taken from RobCoG's files, else from triples or RDF.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cramlite.episode import Entity, Episode, Event, Repair, Track
from cramlite.errors import UserError
from cramlite.geometry import Floats

from . import mongodump, robcog, robcog_writer, soma
from .fields import compact, local_name, repairs_from
from .frames import Rows, world_tracks
from .motion import infer

if TYPE_CHECKING:
    from .xmlgraph import Individuals

_RDF = (".owl", ".rdf", ".ttl", ".nt", ".n3", ".jsonld")
#: Arrays of an episode beside its poses: an hour of joints, wrench and opening at 500 Hz is 0.2 GB.
MAX_EXTRAS = 2**29
#: How hands and grippers are called in recordings that do not say which frame acts.
_EFFECTOR = re.compile(r"hand|gripper|ee_link|tool0|effector", re.IGNORECASE)


def write_neem(episode: Episode, folder: Path | str) -> Path:
    """Write an episode; what ``read_neem`` gives back is equal, times and poses to the last bit.

    Args:
        folder: is created; files of an earlier episode of the same name are replaced. A name that ends in .ttl or .nt
            is a file instead: entities and events as RDF, without poses.

    Returns:
        The folder or file.

    Raises:
        UserError: the folder cannot be written to.
    """
    folder = Path(folder)
    id_ = re.sub(r"[^\w.-]+", "_", episode.name) or "episode"
    try:
        if folder.suffix.lower() in (".ttl", ".nt"):
            folder.write_text("".join(soma.ntriples(soma.triples_of(episode))), encoding="utf-8")
            return folder
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{id_}_ED.owl").write_text(robcog_writer.event_data(episode, id_, f"{id_}_map"), encoding="utf-8")
        (folder / f"{id_}_SM.owl").write_text(robcog_writer.semantic_map(episode, f"{id_}_map"), encoding="utf-8")
        mongodump.write_tf(episode.tracks, folder)
        mongodump.write_triples(soma.triples_of(episode), folder)
        _write_extras(episode, folder)
    except OSError as error:
        raise UserError(
            f"{folder}: the episode cannot be written: {error.strerror or error}. Choose another folder."
        ) from None
    return folder


def _write_extras(episode: Episode, folder: Path) -> None:
    """Wrenches go into their collection, everything else, and the times, into extras.npz."""
    rest = dict(episode.extras)
    times, wrench = rest.get("times"), rest.get("wrench")
    if times is not None and wrench is not None and wrench.shape == (len(times), 6) and wrench.any():
        mongodump.write_wrench(times, rest.pop("wrench"), episode.effector or "sensor", folder)
    if rest:
        np.savez_compressed(folder / "extras.npz", **rest)  # type: ignore[arg-type]


@dataclass
class _Parts:
    """What the files of one episode held."""

    name: str
    entities: dict[str, Entity] = field(default_factory=dict)
    events: tuple[Event, ...] = ()
    rows: dict[str, Rows] = field(default_factory=dict)
    effector: str | None = None
    repairs: list[Repair] = field(default_factory=list)
    extras: dict[str, Floats] = field(default_factory=dict)
    found: bool = False
    mapped: bool = False
    foreign: bool = False


def read_neem(path: Path | str) -> Episode | None:
    """The episode in a folder or file, or None if there is no NEEM.

    Reads RobCoG event data, semantic maps and world states, KnowRob mongodumps and NEEMs as RDF, alone
    or together; see the module's docstring for the names. Repairs are listed in the episode.

    Raises:
        UserError: a file cannot be read; names the file, the place and what to do.
    """
    path = Path(path)
    parts = _Parts(re.sub(r"_(ED|SM|WS)$", "", path.stem if path.is_file() else path.resolve().name))
    for file in _files(path):
        try:
            _read(file, parts)
        except OSError as error:
            raise UserError(f"{file}: cannot be read: {error.strerror or error}.") from None
    return _episode(parts) if parts.found else None


def _files(path: Path) -> list[Path]:
    """The files of one episode, maps and events first: triples fill in only what these lack."""
    if path.is_file():
        return [path]
    owl = sorted(f for f in path.glob("*") if f.is_file() and f.suffix.lower() in _RDF)
    logs = [f for f in owl if f.stem.endswith("_ED")]
    if len(logs) > 1:
        raise UserError(
            f"{path}: holds {len(logs)} episodes ({', '.join(f.name for f in logs)}). Name one of the files, "
            "or put each episode into a folder of its own."
        )
    states = sorted(f for pattern in ("*_WS.json", "*world_state*.json", "*.jsonl") for f in path.glob(pattern))
    dumps = [f for n in mongodump.COLLECTIONS if (f := mongodump.collection_file(path, n)) is not None]
    extras = [f for f in (path / "extras.npz",) if f.is_file()]
    return [
        *sorted(owl, key=lambda f: (not f.stem.endswith("_SM"), not f.stem.endswith("_ED"))),
        *states,
        *dumps,
        *extras,
    ]


def _read(file: Path, parts: _Parts) -> None:
    suffix = file.suffix.lower()
    if suffix in _RDF:
        _read_rdf(file, parts)
    elif suffix == ".bson":
        _read_dump(file, parts)
    elif suffix in (".json", ".jsonl"):
        _add_world_state(file, parts)
    elif suffix == ".npz":
        _read_extras(file, parts)


def _read_rdf(file: Path, parts: _Parts) -> None:
    from .xmlgraph import individuals, parse

    graph = parse(file)
    found = individuals(graph)
    if robcog.is_semantic_map(found):
        entities, repairs = robcog.read_map(found, file)
        parts.entities |= {e.name: e for e in entities}
        parts.repairs += repairs
        parts.found = parts.mapped = True
    if robcog.is_event_data(found):
        _add_events(found, parts)
    elif not parts.found:
        triples = (mongodump.Triple(str(s), str(p), _value(o)) for s, p, o in graph)
        _merge(soma.episode_of(triples, parts.name), parts)


def _value(node: object) -> str | float:
    """A number for a numeric literal, else the text."""
    value = getattr(node, "value", None)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else str(node)


def _add_events(found: Individuals, parts: _Parts) -> None:
    parts.events, repairs = robcog.read_events(found)
    about = robcog.experiment(found)
    parts.name = about.get("name", [parts.name])[0]
    parts.effector = about.get("effector", [parts.effector])[0]
    parts.repairs = [*(repairs_from(about["repairs"][0]) if "repairs" in about else ()), *parts.repairs, *repairs]
    for name, properties in found.items():
        types = [t for t in properties.get("type", ()) if local_name(t) != "NamedIndividual"]
        if types and name in {f for e in parts.events for f in e.roles.values()}:
            parts.entities.setdefault(name, Entity(name, tuple(compact(t) for t in types)))
    parts.found = True


def _read_dump(file: Path, parts: _Parts) -> None:
    kind = file.stem
    if kind in ("triples", "annotations", "inferred"):
        if not parts.events and not parts.mapped:
            _merge(soma.episode_of(mongodump.read_triples(file), parts.name), parts)
    elif kind == "wrench":
        times, wrench = mongodump.read_wrench(file)
        parts.extras |= {"times": times, "wrench": wrench}
    elif kind == "world_state" or "individuals" in next(iter(mongodump.documents(file)), {}):
        _add_world_state(file, parts)
    else:
        rows = mongodump.read_tf(file)
        parts.rows |= rows
        parts.foreign = not all(r.trusted for r in rows.values())
    parts.found = parts.found or bool(parts.rows) or "wrench" in parts.extras


def _merge(other: Episode | None, parts: _Parts) -> None:
    if other is None:
        return
    parts.found = True
    parts.name, parts.events, parts.effector = other.name, other.events, other.effector
    parts.entities = {e.name: e for e in other.entities} | parts.entities
    parts.repairs += other.repairs


def _add_world_state(file: Path, parts: _Parts) -> None:
    rows, hands = robcog.read_world_state(file)
    parts.rows |= rows
    parts.found = parts.foreign = True
    for hand in hands:
        parts.entities.setdefault(hand, Entity(hand, ("soma:Hand",)))
        tips = (n for n in rows if n.startswith(f"{hand}/"))
        parts.entities |= {n: Entity(n, ("soma:Finger",), part_of=hand) for n in tips if n not in parts.entities}


def _read_extras(file: Path, parts: _Parts) -> None:
    from zipfile import ZipFile

    try:
        with ZipFile(file) as archive:
            size = sum(i.file_size for i in archive.infolist())
        if size > MAX_EXTRAS:
            raise ValueError(f"it would take {size / 1e9:.1f} GB, and {MAX_EXTRAS / 1e9:.1f} GB are allowed")
        with np.load(file, allow_pickle=False) as arrays:
            parts.extras |= {k: np.asarray(arrays[k], dtype=float) for k in arrays.files}
    except Exception as error:  # zipfile and NumPy raise a dozen kinds for damaged archives
        why = " ".join(str(error).split())[:200]
        raise UserError(f"{file}: no NumPy archive: {why}. Remove it to read the episode without joints.") from None


def _episode(parts: _Parts) -> Episode:
    """Everything together: impossible events dropped, unknown entities added, each with its repair."""
    tracks, repairs = world_tracks(parts.rows)
    parts.repairs += repairs
    events = _sound(parts)
    entities = _complete(parts, events, tracks)
    effector = parts.effector or _guess_effector(events, tracks)
    episode = Episode(parts.name, entities, events, tracks, effector, tuple(parts.repairs), parts.extras)
    return infer(episode) if parts.foreign and not events else episode


def _sound(parts: _Parts) -> tuple[Event, ...]:
    kept: list[Event] = []
    ids: set[str] = set()
    for event in parts.events:
        if not event.start <= event.end:
            why = f"it ends at {event.end:g} s, before it starts at {event.start:g} s"
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


def _complete(parts: _Parts, events: tuple[Event, ...], tracks: dict[str, Track]) -> tuple[Entity, ...]:
    """Frames and fillers that no map describes become entities of unknown class."""
    entities = dict(parts.entities)
    for name in tracks:
        entities.setdefault(name, Entity(name, (), pose=tracks[name].at(-np.inf)))
    dangling = {f: e for e in reversed(events) for f in e.roles.values() if f not in entities}
    for name, event in sorted(dangling.items()):
        entities[name] = Entity(name, ())
        why = f"event '{event.id}' refers to it, and no map describes it"
        parts.repairs.append(Repair(f"added entity '{name}'", (event.start, event.end), why))
    for name, entity in entities.items():
        if entity.part_of is not None and entity.part_of not in entities:
            parts.repairs.append(
                Repair(f"'{name}' taken as free", (0.0, 0.0), f"its whole '{entity.part_of}' is not described")
            )
            entities[name] = replace(entity, part_of=None)
    return _acyclic(entities, parts)


def _acyclic(entities: dict[str, Entity], parts: _Parts) -> tuple[Entity, ...]:
    """Parts that contain themselves are taken as free."""
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
    """Who grasps or performs; else the frame named like a hand that was recorded most often."""
    acting = [r for e in events for k, r in e.roles.items() if k in ("gripper", "performer")]
    if acting:
        return max(sorted(set(acting)), key=acting.count)
    hands = [n for n in tracks if _EFFECTOR.search(n) and "/" not in n]
    return max(hands, key=lambda n: len(tracks[n].times), default=None)

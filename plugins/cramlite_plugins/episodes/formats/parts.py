"""Readers of the single files of an episode, one for each kind of file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct, field

from cramlite.model import Entity, EntityName, Event, Floats, Repair
from cramlite.plugin import UserError, read_arrays

from ..tracks import Rows
from . import mongodump, robcog, soma
from .fields import compact, local_name, repairs_from

if TYPE_CHECKING:
    from .xmlgraph import Individuals

RDF = (".owl", ".rdf", ".ttl", ".nt", ".n3", ".jsonld")
#: Arrays of an episode beside its poses: an hour of joints, wrench and opening at 500 Hz is 0.2 GB.
MAX_EXTRAS = 2**29


class Parts(Struct):
    """Contents of the files of one episode."""

    name: str
    entities: dict[str, Entity] = field(default_factory=dict)
    events: tuple[Event, ...] = ()
    rows: dict[str, Rows] = field(default_factory=dict)
    effector: str | None = None
    repairs: list[Repair] = field(default_factory=list)
    extras: dict[str, Floats] = field(default_factory=dict)
    triples: list[mongodump.Triple] = field(default_factory=list)
    found: bool = False
    mapped: bool = False
    foreign: bool = False


def read_file(file: Path, parts: Parts) -> None:
    """Read one file of an episode by its kind, and add its contents to ``parts``, which collects those of all the
    episode's files."""
    suffix = file.suffix.lower()
    if suffix in RDF:
        _read_rdf(file, parts)
    elif suffix in (".bson", ".gz") or (suffix == ".json" and mongodump.kind_of(file) in mongodump.COLLECTIONS[:-1]):
        _read_dump(file, parts)
    elif suffix in (".json", ".jsonl"):
        _add_world_state(file, parts)
    elif suffix == ".npz":
        _read_extras(file, parts)


def _read_rdf(file: Path, parts: Parts) -> None:
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
        parts.triples += (mongodump.Triple(str(s), str(p), _value(o)) for s, p, o in graph)


def _value(node: object) -> str | float:
    """Value of an RDF node: a number for a numeric literal, else its text."""
    value = getattr(node, "value", None)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else str(node)


def _add_events(found: Individuals, parts: Parts) -> None:
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


def _read_dump(file: Path, parts: Parts) -> None:
    kind = mongodump.kind_of(file)
    if kind in ("triples", "annotations", "inferred"):
        parts.triples += mongodump.read_triples(file)
    elif kind == "wrench":
        times, wrench = mongodump.read_wrench(file)
        parts.extras |= {"times": times, "wrench": wrench}
    elif kind == "world_state" or "individuals" in next(iter(mongodump.documents(file)), {}):
        _add_world_state(file, parts)
    else:
        rows = mongodump.read_tf(file)
        parts.rows |= rows
        parts.foreign = not all(r.trusted for r in rows.values())
    parts.found = True


def add_triples(parts: Parts) -> None:
    """Add the events and objects that RDF statements describe, if other files gave no events.

    To be called once all files are read, because statements about one event may stand in several collections.
    """
    if parts.events or not parts.triples:
        return
    other = soma.episode_of(parts.triples, parts.name)
    if other is None:
        if parts.found:
            n, why = len(parts.triples), "they describe no event and no object: labels, comments, or axioms"
            parts.repairs.append(Repair(f"left out {n} statements", (0.0, 0.0), why))
        return
    parts.found = True
    parts.name, parts.events, parts.effector = other.name, other.events, other.effector
    if not parts.mapped:
        parts.entities = {e.name: e for e in other.entities} | parts.entities
    parts.repairs += other.repairs


def _add_world_state(file: Path, parts: Parts) -> None:
    rows, hands = robcog.read_world_state(file)
    parts.rows |= rows
    parts.found = parts.foreign = True
    for hand in hands:
        parts.entities.setdefault(hand, Entity(hand, ("soma:Hand",)))
        tips = {str(EntityName(hand, tip)) for tip in robcog.TIPS.values()} - {*parts.entities}
        parts.entities |= {n: Entity(n, ("soma:Finger",), part_of=hand) for n in rows if n in tips}


def _read_extras(file: Path, parts: Parts) -> None:
    try:
        parts.extras |= {k: np.asarray(v, dtype=float) for k, v in read_arrays(file, MAX_EXTRAS).items()}
    except (UserError, ValueError, TypeError) as error:
        raise UserError(f"{str(error).removesuffix('.')}. Remove it to read the episode without joints.") from None

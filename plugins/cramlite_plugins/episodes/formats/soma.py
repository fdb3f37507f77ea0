"""Conversion of an episode to SOMA triples and back: KnowRob's triples collection, and NEEMs as RDF.

Events are classified by SOMA's classes, have a time interval with ``hasIntervalBegin`` and
``hasIntervalEnd``, and participants; an action executes a task. What SOMA cannot say goes beside it
as literals of our own (see fields.py), which our reader prefers.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from urllib.parse import quote, unquote

from cramlite.model import Entity, Episode, Event, Repair

from .fields import (
    CRAM,
    DUL,
    SOMA,
    Fields,
    compact,
    entity_fields,
    entity_from,
    event_fields,
    event_from,
    expand,
    local_name,
    repairs_from,
    repairs_text,
)
from .mongodump import Triple, seconds

RDF_TYPE = "http://www.w3.org/1999/02/22-rdf-syntax-ns#type"
NEEM = "http://cramlite.org/neem/"
#: Classes of states in other vocabularies, as ours. soma:GraspState is in no published SOMA file.
STATES = {
    "soma:ContactState": ("a", "b"),
    "soma:SupportState": ("supporter", "supportee"),
    "cram:GraspState": ("gripper", "object"),
    "soma:GraspState": ("gripper", "object"),
    "soma:ContainmentState": ("container", "content"),
}
#: Properties whose objects are IRIs.
_LINKS = {
    RDF_TYPE,
    *(
        DUL + p
        for p in ("includesObject", "includesEvent", "hasPart", "executesTask", "hasTimeInterval", "hasParticipant")
    ),
}
#: Statements that some writers make the other way round.
_INVERSES = {
    DUL + "isParticipantIn": DUL + "hasParticipant",
    DUL + "isExecutedIn": DUL + "executesTask",
    DUL + "isTimeIntervalOf": DUL + "hasTimeInterval",
}
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\r": "\\r", "\t": "\\t"}
Index = dict[str, dict[str, list[str | float]]]


def triples_of(episode: Episode) -> Iterator[Triple]:
    """Yield the statements of an episode: itself, its entities and its events."""
    base = f"{NEEM}{quote(episode.name, safe='')}#"
    top = base + "episode"
    yield Triple(top, RDF_TYPE, SOMA + "Episode")
    yield Triple(top, CRAM + "name", episode.name)
    if episode.effector is not None:
        yield Triple(top, CRAM + "effector", episode.effector)
    if episode.repairs:
        yield Triple(top, CRAM + "repairs", repairs_text(episode.repairs))
    for order, entity in enumerate(episode.entities):
        yield Triple(top, DUL + "includesObject", _iri(base, "object", entity.name))
        yield from _entity_triples(entity, base, order)
    for order, event in enumerate(episode.events):
        yield Triple(top, DUL + "includesEvent", _iri(base, "event", event.id))
        yield from _event_triples(event, base, order)


def ntriples(triples: Iterable[Triple]) -> Iterator[str]:
    """Format statements as lines of N-Triples, which is Turtle too; numbers keep every digit, unlike rdflib's Turtle."""
    for s, p, o in triples:
        if isinstance(o, str):
            literal = "".join(_ESCAPES.get(c, c) for c in o)
            node = f"<{o}>" if p in _LINKS else f'"{literal}"'
        else:
            kind = "integer" if isinstance(o, int) else "double"
            node = f'"{o!r}"^^<http://www.w3.org/2001/XMLSchema#{kind}>'
        yield f"<{s}> <{p}> {node} .\n"


def _iri(base: str, kind: str, name: str) -> str:
    return f"{base}{kind}_{quote(name, safe='')}"


def _entity_triples(entity: Entity, base: str, order: int) -> Iterator[Triple]:
    me = _iri(base, "object", entity.name)
    yield Triple(me, CRAM + "order", order)
    for type_ in entity.types:
        yield Triple(me, RDF_TYPE, expand(type_))
    if entity.part_of is not None:
        yield Triple(_iri(base, "object", entity.part_of), DUL + "hasPart", me)
    for key, text in entity_fields(entity).items():
        yield Triple(me, CRAM + key, text)


def _event_triples(event: Event, base: str, order: int) -> Iterator[Triple]:
    me = _iri(base, "event", event.id)
    yield Triple(me, CRAM + "order", order)
    task = event.kind == "action" and event.type != "soma:PhysicalAction"
    yield Triple(me, RDF_TYPE, SOMA + "PhysicalAction" if task else expand(event.type))
    if task:
        yield Triple(me, DUL + "executesTask", f"{me}_task")
        yield Triple(f"{me}_task", RDF_TYPE, expand(event.type))
    yield Triple(me, DUL + "hasTimeInterval", f"{me}_interval")
    yield Triple(f"{me}_interval", RDF_TYPE, DUL + "TimeInterval")
    yield Triple(f"{me}_interval", SOMA + "hasIntervalBegin", float(event.start))
    yield Triple(f"{me}_interval", SOMA + "hasIntervalEnd", float(event.end))
    for filler in event.roles.values():
        yield Triple(me, DUL + "hasParticipant", _iri(base, "object", filler))
    for key, text in event_fields(event).items():
        yield Triple(me, CRAM + key, text)


def episode_of(triples: Iterable[Triple], name: str) -> Episode | None:
    """Build the episode that statements describe: entities, events, effector; no tracks. None when they hold no event.

    Args:
        triples: statements in any order; IRIs may have angle brackets.
        name: for an episode that does not name itself.
    """
    index = _index(triples)
    top = next((s for s, p in index.items() if SOMA + "Episode" in p.get(RDF_TYPE, ())), None)
    repairs: list[Repair] = []
    intervals = {str(o) for p in index.values() for o in p.get(DUL + "hasTimeInterval", ())}
    timed = [s for s, p in index.items() if s != top and s not in intervals and _interval(p, index) is not None]
    events = [e for s in sorted(timed, key=lambda s: _order(index[s])) if (e := _event(s, index, repairs))]
    fillers = {str(o) for s in timed for o in index[s].get(DUL + "hasParticipant", ())}
    things = [s for s, p in index.items() if s in fillers or (CRAM + "types" in p)]
    entities = [t for s in sorted(things, key=lambda s: _order(index.get(s, {}))) if (t := _entity(s, index, repairs))]
    if not events and not entities:
        return None
    about = index.get(top or "", {})
    written = repairs_from(str(about[CRAM + "repairs"][0])) if CRAM + "repairs" in about else ()
    effector = str(about[CRAM + "effector"][0]) if CRAM + "effector" in about else None
    own = str(about.get(CRAM + "name", [name])[0])
    return Episode(own, tuple(entities), tuple(events), {}, effector, (*written, *repairs))


def _index(triples: Iterable[Triple]) -> Index:
    index: Index = defaultdict(lambda: defaultdict(list))
    for s, p, o in triples:
        index[s.strip("<>")][p.strip("<>")].append(o.strip("<>") if isinstance(o, str) and o.startswith("<") else o)
    for s, inverse, direct in ((s, i, d) for s, p in list(index.items()) for i, d in _INVERSES.items() if i in p):
        for o in index[s][inverse]:
            if s not in index[str(o)][direct]:
                index[str(o)][direct].append(s)
    return {s: dict(p) for s, p in index.items()}


def _order(properties: dict[str, list[str | float]]) -> float:
    try:
        return float(properties.get(CRAM + "order", [float("inf")])[0])
    except ValueError:
        return float("inf")


def _literals(properties: dict[str, list[str | float]]) -> Fields:
    return {p[len(CRAM) :]: str(o[0]) for p, o in properties.items() if p.startswith(CRAM)}


def _interval(properties: dict[str, list[str | float]], index: Index) -> tuple[float, float] | None:
    """Begin and end of an event [s], which its NEEM states either at the event or at its time interval; None
    if one is missing."""
    holder = index.get(str(properties.get(DUL + "hasTimeInterval", [""])[0]), properties)
    begin, end = (holder.get(SOMA + k) for k in ("hasIntervalBegin", "hasIntervalEnd"))
    if begin is None or end is None or DUL + "TimeInterval" in properties.get(RDF_TYPE, ()):
        return None
    try:
        return seconds(float(begin[0])), seconds(float(end[0]))
    except ValueError:
        return None


def _event(iri: str, index: Index, repairs: list[Repair]) -> Event | None:
    properties = index[iri]
    start, end = _interval(properties, index) or (0.0, 0.0)
    try:
        if CRAM + "id" in properties:
            return event_from(_literals(properties), start, end)
        return _foreign_event(iri, properties, index, start, end)
    except (KeyError, TypeError, ValueError) as error:
        repairs.append(Repair(f"left out event '{local_name(iri)}'", (start, end), f"it cannot be read: {error}"))
        return None


def _foreign_event(iri: str, properties: dict[str, list[str | float]], index: Index, start: float, end: float) -> Event:
    """Event of a foreign writer's NEEM: a state if its class is one, else an action with the class of the
    task that it executes (soma:PhysicalAction without a task)."""
    types = [compact(str(t)) for t in properties.get(RDF_TYPE, ()) if "NamedIndividual" not in str(t)]
    fillers = [_name(str(o), index) for o in properties.get(DUL + "hasParticipant", ())]
    state = next((t for t in types if t in STATES), None)
    if state is not None:
        roles = dict(zip(STATES[state], fillers, strict=False))
        return Event(local_name(iri), state.replace("soma:Grasp", "cram:Grasp"), "state", start, end, roles)
    tasks = [
        compact(str(t))
        for o in properties.get(DUL + "executesTask", ())
        for t in index.get(str(o), {}).get(RDF_TYPE, ())
    ]
    type_ = next((t for t in tasks if "NamedIndividual" not in t), "soma:PhysicalAction")
    roles = dict(zip(("object", *(f"participant_{k}" for k in range(2, len(fillers) + 1))), fillers, strict=False))
    return Event(local_name(iri), type_, "action", start, end, roles)


def _name(iri: str, index: Index) -> str:
    return str(index.get(iri, {}).get(CRAM + "name", [unquote(local_name(iri))])[0])


def _entity(iri: str, index: Index, repairs: list[Repair]) -> Entity | None:
    properties = index.get(iri, {})
    try:
        if CRAM + "name" in properties:
            return entity_from(_literals(properties))
    except (KeyError, TypeError, ValueError) as error:
        repairs.append(Repair(f"left out entity '{local_name(iri)}'", (0.0, 0.0), f"it cannot be read: {error}"))
        return None
    types = tuple(compact(str(t)) for t in properties.get(RDF_TYPE, ()) if "NamedIndividual" not in str(t))
    return Entity(_name(iri, index), types)

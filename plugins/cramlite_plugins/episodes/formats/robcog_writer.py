"""Writers of RobCoG's event data and semantic map, as the RDF/XML that RobCoG's own tools write.

What RobCoG cannot express is added as literals in the cram namespace (fields.py), so that nothing is lost.
"""

from __future__ import annotations

from collections.abc import Iterator
from urllib.parse import quote
from xml.sax.saxutils import escape, quoteattr

from cramlite.model import Entity, Episode, Event, Pose

from .fields import CRAM, entity_fields, event_fields, expand, local_name, repairs_text
from .robcog import EVENTS, to_unreal

#: Stands for the + of _fragment; no XML text can contain it.
_PLUS = "\x00"
LOG = "http://knowrob.org/kb/ameva_log.owl#"
_NAMESPACES = {
    "owl": "http://www.w3.org/2002/07/owl#",
    "xsd": "http://www.w3.org/2001/XMLSchema#",
    "knowrob": "http://knowrob.org/kb/knowrob.owl#",
    "rdfs": "http://www.w3.org/2000/01/rdf-schema#",
    "rdf": "http://www.w3.org/1999/02/22-rdf-syntax-ns#",
    "log": LOG,
}
#: Ours -> RobCoG's class; the first of each, so that SlicingSomething is no anonymous action's name.
_CLASSES = {ours: theirs for theirs, (ours, _) in reversed(EVENTS.items()) if ours != "soma:PhysicalAction"}


def event_data(episode: Episode, id_: str, map_id: str) -> str:
    """Return the text of the file ``<id>_ED.owl``, in which RobCoG keeps the events of an episode."""
    times = sorted({t for e in episode.events for t in (e.start, e.end)})
    return _document(
        line
        for part in (
            _experiment(episode, id_, map_id),
            *(_event(order, e, id_) for order, e in enumerate(episode.events)),
            *(_individual(_timepoint(t), ("knowrob:TimePoint",)) for t in times),
        )
        for line in part
    )


def semantic_map(episode: Episode, map_id: str) -> str:
    """Return the text of ``<id>_SM.owl``: a class for each type and size, individuals, and their poses in the world."""
    classes = {e.name: _class_name(e) for e in episode.entities}
    blocks = {classes[e.name]: e for e in episode.entities}
    start = episode.span[0]
    return _document(
        line
        for part in (
            _individual(map_id, ("knowrob:SemanticEnvironmentMap",)),
            *(_class(name, entity) for name, entity in blocks.items()),
            *(_entity(order, e, episode, map_id, classes[e.name], start) for order, e in enumerate(episode.entities)),
        )
        for line in part
    )


def _document(lines: Iterator[str]) -> str:
    entities = "\n".join(f'\t<!ENTITY {k} "{v}">' for k, v in _NAMESPACES.items())
    xmlns = "\n".join(f'\t xmlns:{k}="{v}"' for k, v in (_NAMESPACES | {"cram": CRAM}).items())
    head = f'<?xml version="1.0" encoding="utf-8"?>\n<!DOCTYPE rdf:RDF[\n{entities}\n]>\n\n'
    root = f'<rdf:RDF xmlns="{LOG}"\n\t xml:base="{LOG}"\n{xmlns}>\n'
    ontology = (
        '\t<owl:Ontology rdf:about="http://knowrob.org/kb/ameva_log.owl">\n'
        '\t\t<owl:imports rdf:resource="package://knowrob/owl/knowrob.owl"/>\n\t</owl:Ontology>\n'
    )
    return head + root + ontology + "".join(f"\t{line}\n" for line in lines) + "</rdf:RDF>\n"


def _fragment(name: str) -> str:
    """Return a name as the percent-encoded end of an IRI; in "kind+name" the plus stays.

    A name has no plus once it is encoded, so names of different kinds never clash.
    """
    kind, plus, rest = name.rpartition(_PLUS)
    return f"{kind}+{quote(rest, safe='')}" if plus else quote(name, safe="")


def _kind(kind: str, name: str) -> str:
    return f"{kind}{_PLUS}{name}"


def _individual(name: str, types: tuple[str, ...], *properties: str) -> Iterator[str]:
    """Write an OWL individual as XML lines; its types are CURIEs of the document, or IRIs."""
    yield f'<owl:NamedIndividual rdf:about="&log;{_fragment(name)}">'
    for type_ in types:
        prefix, _, local = type_.partition(":")
        iri = f'"&{prefix};{quote(local)}"' if prefix in _NAMESPACES else quoteattr(expand(type_))
        yield f"\t<rdf:type rdf:resource={iri}/>"
    yield from (f"\t{p}" for p in properties)
    yield "</owl:NamedIndividual>"


def _link(property_: str, name: str) -> str:
    return f'<{property_} rdf:resource="&log;{_fragment(name)}"/>'


def _text(property_: str, value: str, datatype: str = "string") -> str:
    return f'<{property_} rdf:datatype="&xsd;{datatype}">{escape(value)}</{property_}>'


def _timepoint(time: float) -> str:
    return f"timepoint_{float(time)!r}"


def _experiment(episode: Episode, id_: str, map_id: str) -> Iterator[str]:
    start, end = episode.span
    properties = [
        _link("knowrob:startTime", _timepoint(start)),
        _link("knowrob:endTime", _timepoint(end)),
        _link("knowrob:performedInMap", map_id),
        _text("cram:name", episode.name),
    ]
    if episode.effector is not None:
        properties.append(_link("knowrob:performedBy", episode.effector))
        properties.append(_text("cram:effector", episode.effector))
    if episode.repairs:
        properties.append(_text("cram:repairs", repairs_text(episode.repairs)))
    properties += [_link("knowrob:subAction", _kind("event", e.id)) for e in episode.events]
    return _individual(id_, ("knowrob:AmevaExperiment",), *properties)


def _event(order: int, event: Event, id_: str) -> Iterator[str]:
    class_ = _CLASSES.get(event.type, local_name(event.type.replace(":", "#")))
    roles = {ours: theirs for theirs, ours in EVENTS.get(class_, ("", {}))[1].items()}
    if event.type == "soma:ContactState":
        roles = {"a": "inContact", "b": "inContact"}
    properties = [
        _link("knowrob:startTime", _timepoint(event.start)),
        _link("knowrob:endTime", _timepoint(event.end)),
        _link("knowrob:inEpisode", id_),
    ]
    properties += [_link(f"knowrob:{roles[r]}", f) for r, f in event.roles.items() if r in roles]
    fields = event_fields(event)
    fields["eventType"] = fields.pop("type")
    properties += [_text(f"cram:{k}", v) for k, v in fields.items()]
    return _individual(
        _kind("event", event.id), (f"knowrob:{class_}",), *properties, _text("cram:order", str(order), "integer")
    )


def _class_name(entity: Entity) -> str:
    """Name of an entity's RobCoG class: its type and its size in mm, since RobCoG states sizes for classes
    only."""
    local = local_name(expand(entity.types[0])) if entity.types else "Thing"
    size = "" if entity.size is None else "_" + "x".join(f"{v * 1000:.3f}".rstrip("0").rstrip(".") for v in entity.size)
    return f"{local}{size}"


def _class(name: str, entity: Entity) -> Iterator[str]:
    yield f'<owl:Class rdf:about="&knowrob;{quote(name)}">'
    for type_ in entity.types[:1]:
        yield f"\t<rdfs:subClassOf rdf:resource={quoteattr(expand(type_))}/>"
    lengths = zip(("depth", "width", "height"), entity.size or (), strict=False)
    for what, value in lengths:
        yield "\t<rdfs:subClassOf><owl:Restriction>"
        yield f'\t\t<owl:onProperty rdf:resource="&knowrob;{what}OfObject"/>'
        yield "\t\t" + _text("owl:hasValue", f"{value * 100:.6f}", "float")
        yield "\t</owl:Restriction></rdfs:subClassOf>"
    yield "</owl:Class>"


def _entity(order: int, entity: Entity, episode: Episode, map_id: str, class_: str, start: float) -> Iterator[str]:
    world = episode.pose_at(entity.name, start)
    properties = [
        _link("knowrob:describedInMap", map_id),
        _text("knowrob:mobility", "dynamic" if "mass" in entity.properties else "static"),
    ]
    properties += [_link("knowrob:child", e.name) for e in episode.entities if e.part_of == entity.name]
    if world is not None:
        properties.append(_link("knowrob:pose", _kind("pose", entity.name)))
    fields = entity_fields(entity)
    if "pose" in fields:
        fields["cramPose"] = fields.pop("pose")
    properties += [_text(f"cram:{k}", v) for k, v in fields.items()]
    properties.append(_text("cram:order", str(order), "integer"))
    yield from _individual(entity.name, (f"knowrob:{class_}", *entity.types), *properties)
    if world is not None:
        yield from _pose(_kind("pose", entity.name), world)


def _pose(name: str, pose: Pose) -> Iterator[str]:
    numbers = [f"{v:.6f}" for v in to_unreal(pose)]
    return _individual(
        name,
        ("knowrob:Pose",),
        _text("knowrob:quaternion", " ".join(numbers[3:])),
        _text("knowrob:translation", " ".join(numbers[:3])),
    )

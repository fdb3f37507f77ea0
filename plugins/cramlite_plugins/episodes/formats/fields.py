"""Codec of episode values as named text fields, without loss.

RobCoG's and SOMA's vocabularies cannot say everything that an episode holds (shapes, roles by
name, exact numbers). What they cannot say is written beside them as literals of cramlite's own
namespace; this module is the one codec for these literals, whatever file they are written to.

Numbers are written with Python's ``repr``, the shortest text that reads back to the same double.
"""

from __future__ import annotations

import json
import math
import re
from typing import Any

from msgspec import to_builtins

from cramlite.model import Entity, Event, Geom, Pose, Repair

CRAM = "http://cramlite.org/ont/cram.owl#"
DUL = "http://www.ontologydesignpatterns.org/ont/dul/DUL.owl#"
SOMA = "http://www.ease-crc.org/ont/SOMA.owl#"
#: Prefixes of CURIEs, as everywhere in cramlite.
PREFIXES = {
    "cram": CRAM,
    "dul": DUL,
    "soma": SOMA,
    "artm": "http://www.artiminds.com/kb/artm.owl#",
    "vrps": "http://www.artiminds.com/kb/vr_program_synthesis.owl#",
    "knowrob": "http://knowrob.org/kb/knowrob.owl#",
}

Fields = dict[str, str]


def expand(curie: str) -> str:
    """Expand a CURIE to its IRI: a name without a prefix, or with an unknown one, gets an IRI in the cram
    namespace; an IRI stays as it is."""
    prefix, colon, local = curie.partition(":")
    if not colon or local.startswith("//"):
        return curie if colon else CRAM + curie
    return PREFIXES[prefix] + local if prefix in PREFIXES else f"{CRAM}{prefix}.{local}"


def compact(iri: str) -> str:
    """Convert an IRI to its CURIE, where its namespace has a prefix. Stray slash IRIs of SOMA are read as hash IRIs."""
    iri = iri.replace("/SOMA.owl/", "/SOMA.owl#")
    for prefix, namespace in PREFIXES.items():
        if iri.startswith(namespace):
            return f"{prefix}:{iri[len(namespace) :]}"
    return iri


def local_name(iri: str) -> str:
    """Return the local name of an IRI, which follows its last # or /.

    RobCoG's generations differ in their namespaces only.
    """
    return re.split(r"[#/]", iri)[-1]


def entity_fields(entity: Entity) -> Fields:
    """Encode an entity as fields; properties that are unknown are left out."""
    fields = {"name": entity.name, "types": json.dumps(entity.types)}
    if entity.part_of is not None:
        fields["partOf"] = entity.part_of
    if entity.pose is not None:
        fields["pose"] = _pose_text(entity.pose)
    if entity.size is not None:
        fields["size"] = _numbers_text(entity.size)
    if entity.geoms:
        fields["geoms"] = json.dumps([to_builtins(g) for g in entity.geoms])
    if entity.properties:
        fields["properties"] = json.dumps(entity.properties)
    return fields


def entity_from(fields: Fields) -> Entity:
    """Decode the entity that ``entity_fields`` wrote.

    Raises:
        KeyError, TypeError, ValueError: the fields are no entity.
    """
    return Entity(
        name=fields["name"],
        types=tuple(json.loads(fields.get("types", "[]"))),
        part_of=fields.get("partOf"),
        pose=_pose(fields["pose"]) if "pose" in fields else None,
        size=_vector(fields["size"]) if "size" in fields else None,
        geoms=tuple(_geom(g) for g in json.loads(fields.get("geoms", "[]"))),
        properties={str(k): float(v) for k, v in json.loads(fields.get("properties", "{}")).items()},
    )


def event_fields(event: Event) -> Fields:
    """Encode the class and participants of an event; its times are written where the file format has a place for them."""
    fields = {"id": event.id, "type": event.type, "kind": event.kind, "roles": json.dumps(event.roles)}
    return fields | ({"inferred": "true"} if event.inferred else {})


def event_from(fields: Fields, start: float, end: float) -> Event:
    """Decode the event that ``event_fields`` wrote.

    Raises:
        KeyError, TypeError, ValueError: the fields are no event.
    """
    kind = fields["kind"]
    if kind not in ("state", "action", "situation"):
        raise ValueError(f"the event kind '{kind}' is none of state, action, situation")
    roles = {str(k): str(v) for k, v in json.loads(fields["roles"]).items()}
    inferred = fields.get("inferred") == "true"
    return Event(fields["id"], fields["type"], kind, start, end, roles, inferred)  # type: ignore[arg-type]


def repairs_text(repairs: tuple[Repair, ...]) -> str:
    """Encode repairs, with the events they removed and added, as JSON."""
    return json.dumps([to_builtins(r) for r in repairs])


def repairs_from(text: str) -> tuple[Repair, ...]:
    """Decode the repairs that ``repairs_text`` wrote; a damaged text gives one repair that says so."""
    try:
        return tuple(_repair(r) for r in json.loads(text))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        return (Repair("left out the earlier repairs", (0.0, 0.0), f"their list cannot be read: {error}"),)


def _repair(record: dict[str, Any]) -> Repair:
    removed, added = (tuple(Event(**e) for e in record[k]) for k in ("removed", "added"))
    start, end = map(float, record["when"])
    recorded = tuple(tuple(map(float, row)) for row in record.get("recorded", ()))
    if any(len(row) != 8 for row in recorded):
        raise ValueError("a recorded pose has not 8 numbers")
    return Repair(record["what"], (start, end), record["why"], removed, added, record.get("track"), recorded)


def _pose_text(pose: Pose) -> str:
    return _numbers_text((*pose.position, *pose.quaternion))


def _numbers_text(values: tuple[float, ...]) -> str:
    return " ".join(repr(float(v)) for v in values)


def _pose(text: str) -> Pose:
    return Pose.from_row([float(v) for v in text.split()])


def _vector(text: str) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in text.split())
    if not math.isfinite(x + y + z):
        raise ValueError(f"size {text} is not finite")
    return x, y, z


def _geom(record: dict[str, Any]) -> Geom:
    pose = Pose(**{k: tuple(v) for k, v in record["pose"].items()})
    corners = tuple(tuple(c) for c in record.get("corners", ()))
    plain = {"pose": pose, "size": tuple(record["size"]), "rgba": tuple(record["rgba"]), "corners": corners}
    return Geom(**{**record, **plain})

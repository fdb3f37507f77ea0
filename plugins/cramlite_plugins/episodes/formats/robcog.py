"""Reader of RobCoG's files: event data (``*_ED.owl``), semantic maps (``*_SM.owl``) and world states (JSON or BSON).

Both generations (ameva_log.owl, unreal_log.owl) are read by matching local names. Conventions are those of
the published converter (ease-crc/vr-neem-converter): lengths in cm, left-handed Unreal coordinates;
position (y, x, z)/100, quaternion (-qx, qy, -qz, qw). That pair is not one rigid change of frame (it omits
a quarter turn about z in the orientation), but poses from other tools agree with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from cramlite.model import Entity, EntityName, Event, Pose, Repair, Vector3
from cramlite.plugin import UserError

from ..tracks import Rows
from .fields import compact, entity_from, event_from, local_name
from .jsonframes import json_frames
from .mongodump import documents
from .xmlgraph import Individuals

#: RobCoG class -> ours, and its role properties -> ours. Other classes are aligned by ontologies (robcog.ttl).
_HAND = {"performedBy": "performer", "objectActedOn": "object", "deviceUsed": "device"}
EVENTS: dict[str, tuple[str, dict[str, str]]] = {
    "TouchingSituation": ("soma:ContactState", {}),
    "SupportedBySituation": ("soma:SupportState", {"isSupporting": "supporter", "isSupported": "supportee"}),
    "GraspingSomething": ("cram:GraspState", {"performedBy": "gripper", "objectActedOn": "object"}),
    "ReachingForSomething": ("soma:Reaching", _HAND),
    "PreGraspSituation": ("soma:Grasping", _HAND),
    "PickUpSituation": ("soma:PickingUp", _HAND),
    "PutDownSituation": ("soma:PuttingDown", _HAND),
    "SlidingSituation": ("artm:Sliding", _HAND),
}
#: Bones of RobCoG's hand skeleton: thumb and index tip.
TIPS = {3: "left", 7: "right"}
#: Links of an event that are no roles. Events of classes that are not listed above keep their class and all their links,
#: so that an alignment in an ontology can say what they mean (cramlite.interpretation.class_alignment).
_NO_ROLES = {"type", "startTime", "endTime", "inEpisode", "performedInMap", "outputsCreated"}
_NOT_OBJECTS = {
    "Pose",
    "SemanticEnvironmentMap",
    "Ontology",
    "Class",
    "ObjectProperty",
    "DatatypeProperty",
    "Restriction",
}


def unreal_pose(numbers: Iterable[float]) -> Pose:
    """Convert seven numbers x y z [cm] qx qy qz qw in Unreal's left-handed coordinates to a pose.

    Raises:
        ValueError: they are not seven, or no pose.
    """
    x, y, z, qx, qy, qz, qw = (float(v) for v in numbers)
    return Pose((y / 100, x / 100, z / 100), (qw, -qx, qy, -qz))


def to_unreal(pose: Pose) -> tuple[float, ...]:
    """Convert a pose to Unreal's coordinates: the inverse of ``unreal_pose``."""
    (x, y, z), (qw, qx, qy, qz) = pose.position, pose.quaternion
    return (y * 100, x * 100, z * 100, -qx, qy, -qz, qw)


def is_event_data(found: Individuals) -> bool:
    """Check whether individuals are RobCoG event data."""
    return any("startTime" in p for p in found.values())


def is_semantic_map(found: Individuals) -> bool:
    """Check whether the individuals of an OWL file describe a RobCoG semantic map."""
    return any("describedInMap" in p for p in found.values())


def read_events(found: Individuals) -> tuple[tuple[Event, ...], tuple[Repair, ...]]:
    """Read the events, in the order that their writer numbered, else by start; entries that are no events are
    left out and reported."""
    events: list[tuple[float, Event]] = []
    repairs: list[Repair] = []
    for name, properties in found.items():
        if "startTime" in properties and "endTime" in properties and not _is_experiment(properties):
            new, repair = _events(name, properties)
            events += [(_order(properties), e) for e in new]
            repairs += repair
    events.sort(key=lambda pair: (pair[0], pair[1].start, pair[1].end, pair[1].id))
    return tuple(e for _, e in events), tuple(repairs)


def _order(properties: dict[str, list[str]]) -> float:
    try:
        return float(properties.get("order", ["inf"])[0])
    except ValueError:
        return math.inf


def experiment(found: Individuals) -> dict[str, list[str]]:
    """Return the properties of the individual that stands for the whole experiment in RobCoG's event data; empty if
    there is none."""
    return next((p for p in found.values() if _is_experiment(p)), {})


def _is_experiment(properties: dict[str, list[str]]) -> bool:
    return any(local_name(t).endswith("Experiment") for t in properties.get("type", ()))


def _events(name: str, properties: dict[str, list[str]]) -> tuple[list[Event], list[Repair]]:
    """Return the events that an RDF individual describes: one, or several if events were written with the same id.

    An individual that cannot be read gives a repair that says so.
    """
    spans: list[tuple[float, float]] = []
    try:
        starts, ends = (sorted(_seconds(v) for v in properties[k]) for k in ("startTime", "endTime"))
        spans = list(zip(starts, ends, strict=True))
        events = [_event(name, properties, *span) for span in spans]
    except (KeyError, TypeError, ValueError) as error:
        when = spans[0] if spans else (0.0, 0.0)
        return [], [Repair(f"left out event '{name}'", when, f"it cannot be read: {error}")]
    if len(events) == 1:
        return events, []
    split = tuple(Event(f"{e.id}_{k}", e.type, e.kind, e.start, e.end, e.roles) for k, e in enumerate(events, 1))
    return list(split), [
        Repair(f"split event '{name}' in {len(split)}", spans[0], "several events share this id", (), split)
    ]


def _seconds(timepoint: str) -> float:
    """Time of a timepoint [s]: the number behind the last _ of its IRI."""
    value = float(unquote(local_name(timepoint)).rsplit("_", 1)[-1])
    if not math.isfinite(value):
        raise ValueError(f"time {value} is not finite")
    return value


def _event(name: str, properties: dict[str, list[str]], start: float, end: float) -> Event:
    if "kind" in properties:
        own = {k: v[0] for k, v in properties.items() if k in ("id", "kind", "roles", "inferred")}
        return event_from(own | {"type": properties["eventType"][0]}, start, end)
    class_ = next((local_name(t) for t in properties.get("type", ()) if local_name(t) != "NamedIndividual"), "")
    whole = next((t for t in properties.get("type", ()) if local_name(t) == class_), "soma:PhysicalAction")
    type_, roles = EVENTS.get(class_, (compact(whole), _HAND))
    links = (
        {k: k for k, v in properties.items() if k not in _NO_ROLES and "://" in v[0]} if class_ not in EVENTS else {}
    )
    fillers = {
        ours: unquote(local_name(properties[theirs][0]))
        for theirs, ours in (links | roles).items()
        if theirs in properties
    }
    if class_ == "TouchingSituation":
        a, *b = (unquote(local_name(v)) for v in properties["inContact"])
        fillers = {"a": a, "b": b[0] if b else a}
    kind = "state" if type_.endswith("State") else "action"
    return Event(unquote(name), type_, kind, start, end, fillers)  # type: ignore[arg-type]


def read_map(found: Individuals, place: Path) -> tuple[tuple[Entity, ...], tuple[Repair, ...]]:
    """Read the entities of a semantic map: types, sizes, poses, parts."""
    entities: list[Entity] = []
    repairs: list[Repair] = []
    mine = {n: p for n, p in found.items() if "describedInMap" in p}
    parents = {local_name(c): n for n, p in mine.items() for c in p.get("child", ())}
    for name, properties in sorted(mine.items(), key=lambda i: _order(i[1])):
        try:
            own = {k: v[0] for k, v in properties.items()} | {"pose": properties.get("cramPose", [""])[0]}
            if "types" in own:
                entities.append(entity_from({k: v for k, v in own.items() if v}))
            else:
                entities.append(_map_entity(name, properties, found, parents.get(name)))
        except (KeyError, TypeError, ValueError) as error:
            repairs.append(Repair(f"left out '{name}' of {place.name}", (0.0, 0.0), f"it cannot be read: {error}"))
    return tuple(entities), tuple(repairs)


def _map_entity(name: str, properties: dict[str, list[str]], found: Individuals, parent: str | None) -> Entity:
    types = [t for t in properties.get("type", ()) if local_name(t) not in ("NamedIndividual", *_NOT_OBJECTS)]
    class_ = found.get(local_name(types[0]), {}) if types else {}
    mass = {"mass": float(class_["mass"][0])} if "mass" in class_ else {}
    pose = _map_pose(properties, found)
    if parent is not None and pose is not None:
        whole = _map_pose(found[parent], found)
        pose = pose if whole is None else whole.inverse() * pose
    whole_name = None if parent is None else unquote(parent)
    return Entity(
        unquote(name), tuple(compact(t) for t in types), whole_name, pose, _class_size(class_, found), (), mass
    )


def _map_pose(properties: dict[str, list[str]], found: Individuals) -> Pose | None:
    literal = found.get(local_name(properties.get("pose", [""])[0]), {})
    if "translation" not in literal or "quaternion" not in literal:
        return None
    return unreal_pose(float(v) for v in f"{literal['translation'][0]} {literal['quaternion'][0]}".split())


def _class_size(class_: dict[str, list[str]], found: Individuals) -> Vector3 | None:
    """Size of a class along x, y, z [m], from its restrictions on depth, width and height [cm]; None if one
    is missing."""
    restrictions = [found.get(local_name(r), {}) for r in class_.get("subClassOf", ())]
    values = {local_name(r["onProperty"][0]): float(r["hasValue"][0]) for r in restrictions if "hasValue" in r}
    names = ("depthOfObject", "widthOfObject", "heightOfObject")
    if not all(n in values for n in names):
        return None
    return (values[names[0]] / 100, values[names[1]] / 100, values[names[2]] / 100)


def read_world_state(path: Path) -> tuple[dict[str, Rows], tuple[str, ...]]:
    """Read the poses of every individual, and the names of those that have a skeleton (hands).

    Raises:
        UserError: a frame has no timestamp or a pose is none.
    """
    frames: dict[str, tuple[list[float], list[Any]]] = {}
    hands: dict[str, None] = {}
    for count, document in enumerate(documents(path) if path.suffix in (".bson", ".gz") else json_frames(path)):
        try:
            time = float(document["timestamp"])
            for name, pose in _frame(document, hands):
                columns = frames.setdefault(name, ([], []))
                columns[0].append(time)
                columns[1].append(pose)
        except (KeyError, TypeError, ValueError) as error:
            raise UserError(
                f"{path}: frame {count} is no world state: {error!s}. A frame has 'timestamp' and 'individuals', "
                "each with 'id' and 'pose' [x, y, z, qx, qy, qz, qw]."
            ) from None
    return {n: _world_rows(times, poses) for n, (times, poses) in frames.items()}, tuple(hands)


def _world_rows(times: list[float], poses: list[list[float]]) -> Rows:
    """Rows of poses in metres and right-handed axes from Unreal's seven numbers [cm]; rows with nan are kept, and a later repair removes
    them."""
    t = np.array(poses, dtype=float)
    ours = np.column_stack([t[:, 1] / 100, t[:, 0] / 100, t[:, 2] / 100, t[:, 6], -t[:, 3], t[:, 4], -t[:, 5]])
    return Rows(np.array(times, dtype=float), ours, np.zeros(len(t), dtype=np.int32), ("map",), True)


def _frame(document: dict[str, Any], hands: dict[str, None]) -> Iterator[tuple[str, list[float]]]:
    for thing in document.get("individuals", ()):
        yield str(thing["id"]), _seven(thing)
    for hand in document.get("skel_individuals", ()):
        name = str(hand["id"])
        hands[name] = None
        yield name, _seven(hand)
        for bone in hand.get("bones", ()):
            if bone["idx"] in TIPS:
                yield str(EntityName(name, TIPS[bone["idx"]])), _seven(bone)


def _seven(record: dict[str, Any]) -> list[float]:
    """Pose of a record as seven numbers; RobCoG's writers give either seven numbers, or 'loc' and 'quat'."""
    pose = record.get("pose", record)
    if isinstance(pose, dict):
        pose = [*(pose["loc"][k] for k in "xyz"), *(pose["quat"][k] for k in "xyzw")]
    if len(pose) != 7:
        raise ValueError(f"pose of '{record.get('id', record.get('idx'))}' has {len(pose)} numbers instead of 7")
    return [float(v) for v in pose]

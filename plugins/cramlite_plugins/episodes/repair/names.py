"""One namespace for a recording: a thing has one name, however events, maps and frames write it.

Logs name the same cup ``http://knowrob.org/kb/map.owl#Cup_1``, ``map:Cup_1``, ``/Cup_1``, ``Cup_1`` or, as Unreal labels it,
``SM_Cup_1``. What a hand's parts are is often said by their names alone, too; a finger is no thing to reach for.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from cramlite.model import Entity, Episode, Repair
from cramlite.plugin import EpisodeRepair, hookimpl

#: How hands and grippers are called in recordings that do not say what acts.
HAND = re.compile(r"hand(?!le)|gripper|ee_link|tool0|effector", re.IGNORECASE)
#: How parts of hands are called.
FINGER = re.compile(r"finger|thumb|index|middle|ring|pinky|little|palm|knuckle|wrist|_tip|bone", re.IGNORECASE)
_SLASHED = re.compile(r"<|/|\w[\w.+-]*://")
_UNREAL = re.compile(r"^(SM|SK|BP|SKM|AD)_|_C(?=_\d+$)|_?Component$")


@hookimpl
def episode_repairs() -> Iterable[EpisodeRepair]:
    """Declare the repair that gives each thing of an episode one name."""
    return [EpisodeRepair("names", 5, one_namespace)]


def local(name: str) -> str:
    """Return a name without its namespace: the last part of an IRI, a CURIE without prefix, no leading
    slash."""
    bare = name.strip("<>")
    if "://" in bare:
        return re.split(r"[#/]", bare.rstrip("#/"))[-1]
    prefixed = re.fullmatch(r"[A-Za-z][\w.-]*:([^:/\s]+)", bare)
    return prefixed[1] if prefixed else re.sub("^/+", "", bare)


def unlabelled(name: str) -> str:
    """Return a name without the additions of Unreal's editor, in lower case."""
    return _UNREAL.sub("", local(name)).lower()


def one_namespace(episode: Episode) -> Episode:
    """Give each thing one name, and make fingers parts of their hands; an episode without such defects is
    returned unchanged."""
    return _with_fingers(_named_once(episode))


def _named_once(episode: Episode) -> Episode:
    said = dict(_renamings(episode))
    if not said:
        return episode

    def name(old: str) -> str:
        return said.get(old, old)

    merged: dict[str, Entity] = {}
    for entity in episode.entities:
        mine = replace(entity, name=name(entity.name), part_of=name(entity.part_of) if entity.part_of else None)
        merged[mine.name] = _joined(merged[mine.name], mine) if mine.name in merged else mine
    events = tuple(replace(e, roles={r: name(f) for r, f in e.roles.items()}) for e in episode.events)
    repairs = [Repair(f"read '{old}' as '{new}'", episode.span, "it is the same name") for old, new in said.items()]
    return replace(
        episode, entities=tuple(merged.values()), events=events, tracks={name(n): t for n, t in episode.tracks.items()},
        effector=name(episode.effector) if episode.effector else None, repairs=(*episode.repairs, *repairs),
    )  # fmt: skip


def _renamings(episode: Episode) -> Iterator[tuple[str, str]]:
    """Yield (old, new) for things with several names: the described name is kept, else the shorter one, and
    never an IRI, whose "/" would mean a part.

    Names that each have a track are different things; so are two described entities whose names only look
    alike.
    """
    names = dict.fromkeys([*(e.name for e in episode.entities), *episode.tracks])
    done: set[str] = set()
    for shortened in (local, unlabelled):
        groups: dict[str, list[str]] = defaultdict(list)
        for name in names:
            if name not in done:
                groups[shortened(name)].append(name)
        for same in groups.values():
            both_described = shortened is unlabelled and sum(_described(episode, n) for n in same) > 1
            if len(same) > 1 and not both_described and sum(n in episode.tracks for n in same) <= 1 and _one_place(episode, same):
                kept = min(same, key=lambda n: (_SLASHED.match(n) is not None, not _described(episode, n), len(n), n))
                kept = local(kept) if _SLASHED.match(kept) and local(kept) not in names else kept
                done |= {*same}
                yield from ((n, kept) for n in same if n != kept)
            elif len(same) == 1 and shortened is local and _SLASHED.match(same[0]) and local(same[0]) not in names:
                done |= {*same}
                yield same[0], local(same[0])


def _one_place(episode: Episode, names: Iterable[str]) -> bool:
    wholes = {e.part_of for n in names if (e := episode.known(n)) is not None and e.part_of is not None}
    return len(wholes) <= 1


def _described(episode: Episode, name: str) -> bool:
    entity = episode.known(name)
    return entity is not None and bool(entity.types or entity.size or entity.geoms)


def _joined(one: Entity, other: Entity) -> Entity:
    return Entity(
        one.name, one.types or other.types, one.part_of or other.part_of, one.pose or other.pose, one.size or other.size,
        one.geoms or other.geoms, {**other.properties, **one.properties},
    )  # fmt: skip


def _with_fingers(episode: Episode) -> Episode:
    """Episode in which a finger or other entity that is named after a hand becomes a part of that hand."""
    hands = [e.name for e in episode.entities if e.part_of is None and (e.name == episode.effector or "soma:Hand" in e.types)]
    of = {e.name: hand for e in episode.entities for hand in hands if e.part_of is None and _is_part(e, hand)}
    if not of:
        return episode
    entities = tuple(
        replace(e, part_of=of[e.name], types=e.types or ("soma:Finger",)) if e.name in of else e for e in episode.entities
    )
    repairs = [Repair(f"read '{n}' as a part of '{h}'", episode.span, "it is named so") for n, h in of.items()]
    return replace(episode, entities=entities, repairs=(*episode.repairs, *repairs))


def _is_part(entity: Entity, hand: str) -> bool:
    mine, its = _UNREAL.sub("", local(entity.name)), unlabelled(hand)
    rest = mine[len(its) :]
    return mine.lower().startswith(its) and re.match(r"[\W_]|[A-Z]", rest) is not None and FINGER.search(rest) is not None

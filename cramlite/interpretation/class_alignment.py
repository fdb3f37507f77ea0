"""Alignment of the event classes of foreign logs with the classes of the loaded ontologies.

A log's classes are matched by their last part against ``skos:closeMatch`` and alternative labels of
the ontologies (``ontologies/robcog.ttl``, and whatever users add), so that a user teaches cramlite a
new class with one line of Turtle.
"""

from __future__ import annotations

from msgspec.structs import replace

from ..model.episode import Episode, Event, Repair
from ..ontology.foundation import ACTION, STATE, STATE_ROLES
from ..ontology.taxonomy import Taxonomy

_OURS = ("cram", "soma", "dul", "artm", "vrps")


def aligned(episode: Episode, taxonomy: Taxonomy) -> Episode:
    """Return the episode with the classes of its events replaced by those of the taxonomy.

    A class that the taxonomy does not know, or that means no more than an action, becomes an anonymous action; for
    each unknown class a repair says so.
    """
    foreign = {e.type for e in episode.events if e.type.partition(":")[0] not in _OURS}
    if not foreign:
        return episode
    meant = {type_: taxonomy.resolve(type_) for type_ in sorted(foreign)}
    events = tuple(_aligned(e, meant[e.type], taxonomy) if e.type in meant else e for e in episode.events)
    repairs = [_unknown(type_, episode) for type_, ours in meant.items() if ours is None]
    return replace(episode, events=events, repairs=(*episode.repairs, *repairs))


def _aligned(event: Event, type_: str | None, taxonomy: Taxonomy) -> Event:
    if type_ is None:
        return replace(event, type=ACTION)
    if not taxonomy.is_a(type_, STATE):
        return replace(event, type=type_)
    said = taxonomy.fillers(type_, STATE_ROLES)
    names = tuple(str(said[0]).split()) if said else ()  # fillers take them in this order where theirs have other names
    known = {k: v for k, v in event.roles.items() if k in names}
    rest = [v for k, v in event.roles.items() if k not in names]
    free = [n for n in names if n not in known]
    roles = known | dict(zip(free, rest, strict=False)) if names else event.roles
    return replace(event, type=type_, kind="state", roles=roles)


def _unknown(type_: str, episode: Episode) -> Repair:
    mine = [e for e in episode.events if e.type == type_]
    what = f"{len(mine)} events of class '{type_}' taken as anonymous actions"
    why = "no ontology says what the class means; a line '<class> skos:closeMatch soma:...' in one of yours would"
    return Repair(what, (min(e.start for e in mine), max(e.end for e in mine)), why)

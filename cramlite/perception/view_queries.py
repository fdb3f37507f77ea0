"""Object queries of a plan: what to look for, and at which furniture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..model.control_flow import Compound
from ..model.designators import Action, Designator, Object
from ..model.plan import Plan
from ..model.world import Thing, World
from ..ontology.foundation import BEARS
from .query import ObjectQuery, query_from

if TYPE_CHECKING:
    from ..ontology.taxonomy import Taxonomy

HANGING, STANDING, INSIDE = "hanging", "standing", "inside"
"""How a part of a thing bears others: what ontologies say with ``foundation.BEARS``."""

Queries = tuple[tuple[ObjectQuery, ...], ...]


def queries_of(plan: Plan, furniture: World, taxonomy: Taxonomy) -> Queries:
    """Return the queries to a camera for the things of a plan that the map does not have.

    For each thing they stand in the order in which they are asked until one is answered; before them one for each kind
    of furniture of which a peg is used, to see where it really is.

    A thing is looked for at the furniture that tasks name together with it, in the order of the tasks; where they name
    none, everywhere. Its class is not demanded where features or affordances say what will do in its stead.
    """
    wholes = tuple(o for o in plan.objects if o.part_of is None)
    places = {o.name: _things(o, furniture, taxonomy) for o in wholes}
    felt = [o.part_of for o in plan.objects if o.part_of and _borne(o.features, taxonomy, HANGING) and places.get(o.part_of)]
    found: dict[str, tuple[ObjectQuery, ...]] = {}
    for wanted in (o for o in wholes if not places[o.name]):
        at = [p for place in _beside(wanted, plan) for p in _views(places.get(place, ()), taxonomy)]
        at = at or list(_views(furniture.things, taxonomy))
        needs = replace(wanted, types=()) if wanted.features or wanted.affords else wanted
        found[wanted.name] = tuple(query_from(needs, on=p) for p in dict.fromkeys(at)) or (query_from(needs),)
    covered = {q.value("on") for queries in found.values() for q in queries[:1]}
    pegs = (p for name in dict.fromkeys(felt) for p in _views(places[name], taxonomy) if p not in covered)
    return (*((query_from(Object(""), on=p),) for p in pegs), *found.values())


def _things(wanted: Object, furniture: World, taxonomy: Taxonomy) -> tuple[Thing, ...]:
    """The furniture that a designator can mean: the named thing, or all of its class."""
    if wanted.entity:
        return tuple(t for t in furniture.things if t.name == wanted.entity)
    return tuple(t for t in furniture.things if any(taxonomy.is_a(t.type, c) for c in wanted.types))


def _beside(wanted: Object, plan: Plan) -> Iterator[str]:
    """What tasks name together with a thing, in order: variables, parts standing for their wholes."""
    wholes = {o.name: o.part_of or o.name for o in plan.objects}
    for action in _actions(plan.actions):
        names = [o.name for o in action.roles.values()]
        if wanted.name in names:
            yield from (wholes.get(n, n) for n in names if n != wanted.name)


def _actions(steps: Iterable[Designator]) -> Iterator[Action]:
    for step in steps:
        if isinstance(step, Compound):
            for branch in step.branches:
                yield from _actions(branch)
        elif isinstance(step, Action):
            yield step


def bears(thing: Thing, taxonomy: Taxonomy, *ways: str) -> bool:
    """Check whether a part of a thing bears others in one of these ways: "hanging", "standing", "inside"."""
    return _borne((f.type for f in thing.features), taxonomy, *ways)


def _borne(features: Iterable[str], taxonomy: Taxonomy, *ways: str) -> bool:
    return any(way in taxonomy.fillers(f, BEARS) for f in features for way in ways)


def _views(things: tuple[Thing, ...], taxonomy: Taxonomy) -> Iterator[str]:
    """What a camera looks at in one picture: pegs of one class at once, by the class; else one thing after another, the
    smallest first: less is expected on a floor than on a table."""
    hangers = [t for t in things if bears(t, taxonomy, HANGING)]
    carriers = [t for t in things if t not in hangers and bears(t, taxonomy, STANDING, INSIDE)]
    yield from dict.fromkeys(t.type for t in hangers)
    yield from (t.name for t in sorted(carriers, key=_size))


def _size(thing: Thing) -> float:
    return max((g.bounding_radius for g in thing.geoms), default=0.0)

"""Object queries for a plan: the things to look for, and the furniture at which to look."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..model.control_flow import Compound
from ..model.designators import Action, Designator, Object
from ..model.plan import Plan
from ..model.world.thing import Thing
from ..model.world.world import World
from ..ontology.foundation import BEARS
from .query import ObjectQuery, query_from

if TYPE_CHECKING:
    from ..ontology.taxonomy import Taxonomy
    from ..plugin.task_type import TaskType

HANGING, STANDING, INSIDE = "hanging", "standing", "inside"
"""Ways in which a feature of a thing carries other things, as ontologies declare with ``foundation.BEARS``."""

Queries = tuple[tuple[ObjectQuery, ...], ...]


def queries_of(plan: Plan, furniture: World, taxonomy: Taxonomy, tasks: Mapping[str, TaskType]) -> Queries:
    """Return the camera queries for the things that a plan needs and that the map of the furniture does not hold.

    For each thing they stand in the order in which they are asked until one is answered; before them one for each kind
    of furniture of which a peg is used, to see where it really is, behind them one for each piece of furniture that
    something is put on, to see what stands there already; what falls into a container needs no place of its own.

    A thing is looked for at the furniture that tasks name together with it, in the order of the tasks; where they name
    none but what it is to be put on, everywhere, and there at last. Its class is not demanded where features or affordances
    say what will do in its stead.

    Args:
        tasks: types of the plan's tasks; those that put something down (``TaskType.places``) say where it goes, not where it is.
    """
    wholes = tuple(o for o in plan.objects if o.part_of is None)
    places = {o.name: _things(o, furniture, taxonomy) for o in wholes}
    felt = [o.part_of for o in plan.objects if o.part_of and _borne(o.features, taxonomy, HANGING) and places.get(o.part_of)]
    found: dict[str, tuple[ObjectQuery, ...]] = {}
    for wanted in (o for o in wholes if not places[o.name]):
        here, there = (
            [p for place in _named_together(wanted, plan, tasks, put) for p in _views(places.get(place, ()), taxonomy)]
            for put in (False, True)
        )
        at = here or [*(p for p in _views(furniture.things, taxonomy) if p not in there), *there]
        needs = replace(wanted, types=()) if wanted.features or wanted.affords else wanted
        found[wanted.name] = tuple(query_from(needs, **_at(p, furniture, taxonomy)) for p in dict.fromkeys(at)) or (query_from(needs),)
    covered = {q.value("on") or q.value("in") for queries in found.values() for q in queries[:1]}
    pegs = (p for name in dict.fromkeys(felt) for p in _views(places[name], taxonomy) if p not in covered)
    ends = dict.fromkeys(n for o in wholes if not places[o.name] for n in _named_together(o, plan, tasks, put=True) if n not in felt)
    tops = [t for name in ends for t in places.get(name, ()) if not bears(t, taxonomy, INSIDE)]
    goals = dict.fromkeys(p for p in _views(tuple(tops), taxonomy) if p not in covered)
    return (*((query_from(Object(""), on=p),) for p in pegs), *found.values(), *((query_from(Object(""), on=p),) for p in goals))


def queries_everywhere(furniture: World, taxonomy: Taxonomy) -> Queries:
    """Return a query for everything on or in each piece of furniture that can carry things."""
    return tuple((query_from(Object(""), **_at(p, furniture, taxonomy)),) for p in _views(furniture.things, taxonomy))


def _at(place: str, furniture: World, taxonomy: Taxonomy) -> dict[str, str]:
    """Return the condition that an object is at a place: "in" an open container, else "on" the place."""
    thing = next((t for t in furniture.things if t.name == place), None)
    hollow = thing is not None and bears(thing, taxonomy, INSIDE) and not bears(thing, taxonomy, STANDING)
    return {"in" if hollow else "on": place}


def _things(wanted: Object, furniture: World, taxonomy: Taxonomy) -> tuple[Thing, ...]:
    """Return the furniture that an object designator can mean: the named thing, or all things of its
    class."""
    if wanted.entity:
        return tuple(t for t in furniture.things if t.name == wanted.entity)
    return tuple(t for t in furniture.things if any(taxonomy.is_a(t.type, c) for c in wanted.types))


def _named_together(wanted: Object, plan: Plan, tasks: Mapping[str, TaskType], put: bool) -> Iterator[str]:
    """Yield the other objects of those tasks of a plan in which a wanted object has a role.

    With ``put``, these are only tasks that place something; without, only the others.

    The whole is given in the place of a part.
    """
    wholes = {o.name: o.part_of or o.name for o in plan.objects}
    for action in _actions(plan.actions):
        names = [o.name for o in action.roles.values()]
        if wanted.name in names and (action.task in tasks and tasks[action.task].places) == put:
            yield from (wholes.get(n, n) for n in names if n != wanted.name)


def _actions(steps: Iterable[Designator]) -> Iterator[Action]:
    for step in steps:
        if isinstance(step, Compound):
            for branch in step.branches:
                yield from _actions(branch)
        elif isinstance(step, Action):
            yield step


def bears(thing: Thing, taxonomy: Taxonomy, *ways: str) -> bool:
    """Check whether a thing has a feature that carries others in one of the given ways: "hanging",
    "standing", "inside"."""
    return _borne((f.type for f in thing.features), taxonomy, *ways)


def _borne(features: Iterable[str], taxonomy: Taxonomy, *ways: str) -> bool:
    return any(way in taxonomy.fillers(f, BEARS) for f in features for way in ways)


def _views(things: tuple[Thing, ...], taxonomy: Taxonomy) -> Iterator[str]:
    """Yield the subjects of pictures to take: the class of each thing that others hang on, then the name of each support or container.

    Of supports and containers the smallest comes first.
    """
    hangers = [t for t in things if bears(t, taxonomy, HANGING)]
    carriers = [t for t in things if t not in hangers and bears(t, taxonomy, STANDING, INSIDE)]
    yield from dict.fromkeys(t.type for t in hangers)
    yield from (t.name for t in sorted(carriers, key=_size))


def _size(thing: Thing) -> float:
    return max((g.bounding_radius for g in thing.geoms), default=0.0)

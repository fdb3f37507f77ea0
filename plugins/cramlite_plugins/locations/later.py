"""Demands of later tasks on a place: things that they close, bring somewhere or put into a container, and
retractions of the hand."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from msgspec.structs import replace

from cramlite.model import Action, Belief, EntityName, enclosing_names, thing_of
from cramlite.plugin import Context, LaterTask

CLOSING, OPENING = "soma:Closing", "soma:Opening"
RELEASING, RETRACTING = "soma:Releasing", "soma:Retracting"


def moves(name: str, kind: str, put: str, context: Context) -> bool:
    """Check whether a later task of a kind, closing or opening, is about a thing, before another one takes
    the payload away; to release it and to retract the hand from it does not."""
    now = _whole(context.agenda[0].name) if context.agenda else ""
    for task in context.later:
        if name in task.things and context.taxonomy.is_a(task.action.task, kind):
            return True
        if put in task.things and _whole(task.action.name) != now and not _lets_go(task, context):
            return False
    return False


def _lets_go(task: LaterTask, context: Context) -> bool:
    """Whether a task releases something, or retracts the hand from it."""
    return any(context.taxonomy.is_a(task.action.task, one) for one in (RELEASING, RETRACTING))


def goes_on(put: str, context: Context) -> bool:
    """Check whether a later task is about other things than the payload, and the first such task is not an
    opening task.

    Opening would need more room.
    """
    others = (task for task in context.later if task.things and put not in task.things)
    return any(not context.taxonomy.is_a(task.action.task, OPENING) for task in itertools.islice(others, 1))


def retracts_from(put: str, context: Context) -> bool:
    """Check whether the task right after the release retracts the hand from the payload."""
    for release, after in itertools.pairwise(context.later):
        if context.taxonomy.is_a(release.action.task, RELEASING):
            return put in after.things and context.taxonomy.is_a(after.action.task, RETRACTING)
    return False


def brings(thing: str, belief: Belief, context: Context) -> Iterator[tuple[EntityName, str, Context]]:
    """Generate the supports and containers, at known places, to which later tasks bring a thing, each with
    the name of its region or "", and the context as it will be when that task is grounded."""
    for k, item in enumerate(context.agenda):
        task = LaterTask(item, context.bindings) if isinstance(item, Action) else None
        named = {role: EntityName.parse(entity) for role, entity in task.entities.items()} if task else {}
        what, onto = named.get("Locatum"), named.get("Relatum")
        if task and what and onto and what.thing == thing and onto.thing in belief.poses:
            yield onto, _region(task, onto), replace(context, agenda=context.agenda[k:])


def puts_into(entity: str, belief: Belief, context: Context, region: str = "") -> tuple[str, ...]:
    """Return the names of the things that later tasks bring to a container, or to a region of a support, each
    once."""
    held, into, found = belief.held.thing if belief.held else "", thing_of(entity), dict[str, None]()
    for task in context.later:
        named = {role: EntityName.parse(name) for role, name in task.entities.items()}
        what, onto = named.get("Locatum"), named.get("Relatum")
        if what is None or onto is None or onto.thing != into or what.thing in (held, into):
            continue
        elsewhere = bool(region) and _region(task, onto) != region
        if not elsewhere and not belief.relates("in", what.thing) and what.thing in belief.poses:
            found[what.thing] = None
    return tuple(found)


def _region(task: LaterTask, onto: EntityName) -> str:
    """Region of a support or container to which a task brings a thing; "" for none."""
    return str(task.action.parameters.get("where", {}).get("region") or onto.part)


def _whole(name: str) -> str:
    """The task of the plan that a designator is part of."""
    return [*enclosing_names(name)][-1]

"""Object resolver: which thing of the world plays a role, by class, else by features and affordances."""

from __future__ import annotations

import math
from collections.abc import Iterator

from msgspec.structs import replace

from cramlite.model import Belief, EntityName, Late, Object, Remedy, Thing, thing_of
from cramlite.plugin import Answer, Answers, Context, Grounding, Refused, hookimpl

from ..motion_planning.too_far import too_far

SUBSTITUTE = 10.0  # cost of a thing of another class: after every thing of the class itself
# Cost of what has no contents where contents matter: after every thing that has some, before substitutes
EMPTY = 5.0


@hookimpl
def resolve_object(designator: Object | Late, belief: Belief, context: Context) -> Answers:
    """Resolve an object designator among the believed things.

    A late designator is resolved by its query, in the present belief.
    """
    return _candidates(designator.query if isinstance(designator, Late) else designator, belief, context)


def _candidates(wanted: Object, belief: Belief, context: Context) -> Iterator[Answer]:
    answers = [_grounded(entity, wanted, belief, context) for entity in _entities(wanted, belief, context)]
    yield from (a for a in answers if isinstance(a, Refused))
    yield from sorted((a for a in answers if isinstance(a, Grounding)), key=lambda a: (a.cost, str(a.value)))


def _entities(wanted: Object, belief: Belief, context: Context) -> list[str]:
    """Names of candidates for an object designator: the entity that it names, else the features of the thing
    of which it asks for a part, else all things."""
    if wanted.entity:
        return [wanted.entity]
    if wanted.part_of:
        whole = str(context.bindings[wanted.part_of])
        return [str(EntityName(whole, f.name)) for f in belief.thing(whole).features]
    return [t.name for t in belief.world.things]


def _grounded(entity: str, wanted: Object, belief: Belief, context: Context) -> Answer:
    """Ground an object designator by an entity; or refuse the entity by the first check that it fails.

    The later that check comes, the nearer a miss the refusal is.
    """
    there = [t.name for t in belief.world.things]
    if thing_of(entity) not in there:  # it was taken away since the task was given
        reason = f"no thing of this name is in the believed world, which has {', '.join(there) or 'nothing'}"
        return Refused(entity, reason, blocking=())
    fit = _fit(entity, wanted, belief, context)
    if isinstance(fit, Refused):
        return fit
    gap, robot = _gap(belief.thing(entity), belief), context.robot
    reach = robot.reach + math.hypot(*robot.gripper.tcp.position)
    if gap <= reach:
        return fit
    reason = f"nearest point at {gap:.2f} m > {reach:.2f} m reach of arm '{robot.type}' with gripper"
    numbers, remedy = {"gap_m": gap, "limit_m": reach}, too_far(entity, gap - reach, robot)
    return Refused(entity, reason, 4, numbers=numbers, blocking=(), remedy=remedy)


def _fit(entity: str, wanted: Object, belief: Belief, context: Context) -> Answer:
    """Grounding of an object designator by an entity of the wanted class, or with the wanted features and
    affordances; else the refusal with what the entity lacks."""
    classes, feature, thing = context.taxonomy, belief.feature(entity), belief.thing(entity)
    own = feature.type if feature else thing.type
    taken = next((k for k, v in context.bindings.items() if k != wanted.name and v == entity), None)
    if taken is not None:
        few = _too_few(wanted, belief, context)
        remedy = Remedy(f"few {wanted.name}", f"'{wanted.name}' has nothing left{few}") if few else None
        reason = f"the entity has another role already: {taken}{few}"
        return Refused(entity, reason, because=(taken,), remedy=remedy)
    has = [own] if feature else [f.type for f in belief.world.features_of(thing.name)]
    for need in wanted.features:
        if not any(classes.is_a(f, need) for f in has):
            reason = f"{own} without the {need} that the tasks need; it has {', '.join(has) or 'no features'}"
            return Refused(entity, reason, 1)
    for need in wanted.affords:
        if not classes.affords(own, need):
            return Refused(entity, f"{own} does not afford {need}", 2)
    fit = _classed(entity, own, wanted, belief, context, part=feature is not None)
    empty = wanted.filled and thing.filling is None and not wanted.entity
    return replace(fit, cost=fit.cost + EMPTY) if empty and isinstance(fit, Grounding) else fit


def _too_few(wanted: Object, belief: Belief, context: Context) -> str:
    """Remark that more things are needed if all things of the wanted kind play other roles; "" if one is
    free, or the world has none."""
    kinds = wanted.types or wanted.like
    taken = _taken(wanted, context)
    fitting = [t.name for t in belief.world.things if _meets(t, kinds, wanted, belief, context)]
    if not fitting or wanted.part_of or any(name not in taken for name in fitting):
        return ""
    needs = ", ".join((*wanted.features, *wanted.affords))
    which = f" of {' or '.join(kinds)}" if kinds else f" with {needs}" if needs else ""
    return f"; the tasks need more things{which} than the {len(fitting)} that the world has: add one"


def _meets(thing: Thing, kinds: tuple[str, ...], wanted: Object, belief: Belief, context: Context) -> bool:
    """Whether a thing has the wanted features and affordances, and one of the wanted classes if there are
    any."""
    classes, has = context.taxonomy, [f.type for f in belief.world.features_of(thing.name)]
    if kinds and not any(classes.is_a(thing.type, k) for k in kinds):
        return False
    lacks = any(not any(classes.is_a(f, need) for f in has) for need in wanted.features)
    return not lacks and all(classes.affords(thing.type, need) for need in wanted.affords)


def _classed(
    entity: str, own: str, wanted: Object, belief: Belief, context: Context, *, part: bool
) -> Answer:
    """Grounding of a designator by an entity: asked for by name, of a wanted class, or a substitute with the
    needed features and affordances; else a refusal."""
    if wanted.entity:
        return Grounding(entity, f"'{entity}' is asked for by name")
    types = _classes(wanted, belief, context)
    fitting = next((t for t in types if context.taxonomy.is_a(own, t)), None)
    if fitting or not types:
        reason = f"{own} is a {fitting}" if fitting else f"'{entity}' has what is needed"
        return Grounding(entity, reason, cost=float(types.index(fitting)) if fitting else 0.0)
    if not (wanted.features or wanted.affords) or part:
        kinds = " or ".join(types)
        say = (
            f"nothing in the world is a {kinds} for '{wanted.name}': add one, name another thing, or "
            "correct its class ('type')"
        )
        return Refused(entity, f"{own} is no {kinds}", 3, remedy=Remedy(f"kind {wanted.name}", say))
    needs = ", ".join((*wanted.features, *wanted.affords))
    reason = f"substitute: {own} is no {types[0]}, but has the {needs} that the tasks need"
    return Grounding(entity, reason, SUBSTITUTE)


def _classes(wanted: Object, belief: Belief, context: Context) -> tuple[str, ...]:
    """Classes of things that an object designator asks for.

    A class that only the designator's name suggests counts if the world has a thing of that class which plays
    no other role.
    """
    taken = _taken(wanted, context)
    free = [t.type for t in belief.world.things if t.name not in taken]
    there = any(context.taxonomy.is_a(t, like) for t in free for like in wanted.like)
    return wanted.types or (wanted.like if there else ())


def _taken(wanted: Object, context: Context) -> set[str]:
    """Names of the entities that play other roles."""
    others = (v for k, v in context.bindings.items() if k != wanted.name)
    return {v for v in others if isinstance(v, str)}  # the rest are places and looks


def _gap(thing: Thing, belief: Belief) -> float:
    """Distance from the arm's base to the nearest point of a thing [m]; 0 for the payload, and for every
    thing if the robot can drive."""
    if belief.at is not None or (belief.held and belief.held.thing == thing.name):
        return 0.0
    radii = (math.dist((0, 0, 0), g.pose.position) + g.bounding_radius for g in thing.geoms)
    return math.hypot(*belief.pose(thing.name).position) - max(radii, default=0.0)

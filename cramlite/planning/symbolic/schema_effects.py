"""Effects of action schemas: which facts and things each changes, and which schemas a goal needs."""

from __future__ import annotations

from collections.abc import Sequence

from ...interpretation.fluents import Fact, Fluents
from .action_schema import ActionSchema
from .goal_planner import GoalFacts
from .handling import handled


def may_make(schema: ActionSchema, added: Fact, fact: Fact) -> bool:
    """Check whether an effect of an action schema is a given fact, for some choice of things for its
    parameters."""
    return added[0] == fact[0] and not misfits(schema, added, fact)


def misfits(schema: ActionSchema, added: Fact, fact: Fact) -> dict[str, str]:
    """Return the terms of an effect that cannot take the values in a given fact, each with its value."""
    fits = fillers(schema)
    pairs = zip(added[1:], fact[1:], strict=True)
    return {t: e for t, e in pairs if t != e and not (t.startswith("?") and e in fits.get(t, {e}))}


def fillers(schema: ActionSchema) -> dict[str, frozenset[str]]:
    """Return the entities that each term of an action schema may stand for, by the conditions on that term alone."""
    return {t.terms[0]: frozenset(e for (e,) in t.rows) for t in schema.tables if len(t.terms) == 1 and not t.denied}


def relevant_schemas(goal: GoalFacts, schemas: Sequence[ActionSchema], fluents: Fluents, blocked: bool) -> list[ActionSchema]:
    """Return the action schemas that change facts which the goal or another relevant schema asks for.

    If tasks are blocked, also those that move things on joints, such as a drawer with its content.
    """
    asked = {p[0] for p in (*goal.needs, *goal.without)}
    changing = [s for s in schemas if _changes(s, fluents)]
    moving = [s for s in changing if blocked and _moves_joint(s, fluents)]
    while True:
        found = [s for s in changing if asked & _changed(s) or any(s is m for m in moving)]
        more = asked | {n for s in found for n in _asked(s)}
        if more == asked:
            return found
        asked = more


def _changes(schema: ActionSchema, fluents: Fluents) -> bool:
    """Check whether an action schema changes any fact: its effects may already follow from its preconditions."""
    change = schema.change
    ends = [p for p in change.removes if p not in change.without]
    return bool(ends or schema.after or change.adds - fluents.implied(change.needs, schema.in_hand))


def _moves_joint(schema: ActionSchema, fluents: Fluents) -> bool:
    change = schema.change
    return any(h.displaces and not h.holds for h in handled(change.needs, change.adds, change.removes, fluents).values())


def pushed_terms(schema: ActionSchema, fluents: Fluents) -> frozenset[str]:
    """Return the terms of things that an action schema pushes: moved, but neither held nor on a joint."""
    change = schema.change
    told = handled(change.needs, change.adds, change.removes, fluents)
    return frozenset(t for t in change.moves if t not in told or not told[t].displaces)


def may_push(schema: ActionSchema, things: frozenset[str], fluents: Fluents) -> bool:
    """Check whether an action schema pushes one of the given things, for some choice of things for its
    parameters."""
    pushed = pushed_terms(schema, fluents)
    tables = [t.rows for t in schema.tables if not t.denied and len(t.terms) == 1 and t.terms[0] in pushed]
    return bool(pushed) and any(all((thing,) in rows for rows in tables) for thing in things)


def _changed(schema: ActionSchema) -> set[str]:
    change = schema.change
    return {str(p[0]) for p in (*change.adds, *change.removes, *(u.given for u in schema.after))}


def _asked(schema: ActionSchema) -> set[str]:
    change, pairs = schema.change, [f for pair in schema.change.never for f in pair]
    return {str(p[0]) for p in (*change.needs, *change.without, *pairs, *(u.given for u in schema.before))}

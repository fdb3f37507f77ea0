"""Endings: all facts that a task makes false, directly or as a consequence, by the predicates' declarations
(``Fluent``).

``Fluents.after`` says the same of one state; here it is said of all states, as the conditional effects of an action schema.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from ...base.value import Value
from ...interpretation.fluents import EFFECTOR, Fact, Fluents
from ...model.entity_name import BETWEEN, thing_of
from .action_schema import ActionSchema, Table, kind_of

PART_OF = "part_of"
"""Static relation of a part and its whole."""

DEEPEST = 4
"""Largest number of steps from what a task makes false to further facts that become false as a consequence. Supporting, touching, and
touching of parts takes three."""

Kinds = Mapping[tuple[str, int], frozenset[str]]
"""Kinds of entities ("hand", "body", "component") that occur as an argument of a predicate, by predicate and number of the argument, from
1."""


class Ending(Value):
    """Fact that a task makes false under certain conditions, for all entities that can stand for its free variables.

    Args:
        fact: with terms; free variables are "?other" and "?any1", "?any2", ...
        when: facts that must have held.
        tables: static conditions.
    """

    fact: Fact
    when: frozenset[Fact] = frozenset()
    tables: frozenset[Table] = frozenset()

    @property
    def free(self) -> list[str]:
        """Free variables, which stand for any entity; the other variables are parameters of the task."""
        facts = [self.fact, *sorted(self.when), *sorted((PART_OF, *t.terms) for t in self.tables)]
        return list(dict.fromkeys(t for f in facts for t in f[1:] if is_free(t)))


def is_free(term: str) -> bool:
    """Check whether a term is a free variable rather than a parameter."""
    return term.startswith(("?any", "?other"))


def kinds_of(schemas: Iterable[ActionSchema], facts: Iterable[Fact]) -> Kinds:
    """Return the kinds of entities that each argument of a relation can have, from the facts at the start
    and the effects of tasks."""
    found: dict[tuple[str, int], set[str]] = {}
    added = ((f[0], map(kind_of, f[1:])) for s in schemas for f in s.change.adds)
    known = ((f[0], map(kind_of, f[1:])) for f in facts)
    for name, kinds in (*added, *known):
        for k, kind in enumerate(kinds, 1):
            found.setdefault((name, k), set()).add(kind)
    return {place: frozenset(kinds) for place, kinds in found.items()}


def kinds_of_free(term: str, facts: Iterable[Fact], tables: Iterable[Table], kinds: Kinds) -> frozenset[str]:
    """Return the kinds of entity ("hand", "body", "component") that a variable may stand for, by the facts
    and static conditions that contain it."""
    here = [(f[0], k) for f in facts for k, t in enumerate(f[1:], 1) if t == term]
    places = [kinds[place] for place in here if place in kinds]
    for table in tables:
        for k in (k for k, t in enumerate(table.terms) if t == term and not table.denied):
            parts = frozenset({("component", "body")[k]}) if table.name == PART_OF else frozenset()
            places.append(parts or frozenset(kind_of(row[k]) for row in table.rows))
    return frozenset({"hand", "body", "component"}).intersection(*places)


def endings(schema: ActionSchema, fluents: Fluents, kinds: Kinds) -> tuple[Ending, ...]:
    """Return the facts that a task ends, without impossible facts and without endings that a more general one
    covers."""
    found: list[Ending] = []
    todo = [_tidy(e) for e in _denied(schema, fluents)]
    for _ in range(DEEPEST):
        new = [e for e in dict.fromkeys(todo) if _possible(e, kinds) and not any(_covers(other, e) for other in found)]
        found += new
        todo = [_tidy(after) for e in new for after in _following(e, fluents)]
    return tuple(e for e in found if e.fact not in schema.change.adds)


def _denied(schema: ActionSchema, fluents: Fluents) -> Iterator[Ending]:
    """Generate the facts that a rule makes false, and the facts that cannot hold together with one that the
    rule adds."""
    for pattern in sorted(schema.change.removes, key=str):
        yield Ending((str(pattern[0]), *(p if p is not None else f"?any{k}" for k, p in enumerate(pattern[1:]))))
    for every in schema.after:
        opposite = Table(every.then.name, every.then.terms, every.then.rows, not every.then.denied)
        for fact in sorted(fluents.both_ways(every.given)):
            yield Ending(tuple(map(str, fact)), tables=frozenset({opposite}))
    for fact in sorted(schema.change.adds):
        yield from (Ending((other, *map(thing_of, fact[1:]))) for other in fluents[fact[0]].excludes)


def _following(ending: Ending, fluents: Fluents) -> Iterator[Ending]:
    """Generate further facts that become false with a fact that a task makes false.

    They are the fact with swapped arguments if it is symmetric, facts that it undoes, the same about wholes
    of parts, and facts that imply it.
    """
    name, *terms = ending.fact
    fluent, when = fluents[name], ending.when | {ending.fact}
    if fluent.symmetric:
        yield Ending((name, *terms[::-1]), ending.when, ending.tables)
    for other in fluent.undoes:
        whole = Ending((other, *map(thing_of, terms)), when, ending.tables)
        yield whole
        if fluents[other].of_wholes:
            yield from (_of_part(whole, k) for k, t in enumerate(terms) if t != EFFECTOR and BETWEEN not in t)
    if fluent.of_wholes:
        yield from (_of_whole(ending, k) for k, t in enumerate(terms) if is_free(t) or BETWEEN in t)
    for other in (n for n, f in fluents.of.items() if name in f.implies):
        implying = (other, *map(thing_of, terms))
        yield Ending(implying, ending.when | {implying}, ending.tables)


def _of_part(ending: Ending, k: int) -> Ending:
    parts = Table(PART_OF, ("?any_part", ending.fact[k + 1]), frozenset())
    return Ending(_with(ending.fact, k, "?any_part"), ending.when, ending.tables | {parts})


def _of_whole(ending: Ending, k: int) -> Ending:
    term, when = ending.fact[k + 1], ending.when | {ending.fact}
    if not is_free(term):
        return Ending(_with(ending.fact, k, thing_of(term)), when, ending.tables)
    return Ending(_with(ending.fact, k, "?any_whole"), when, ending.tables | {Table(PART_OF, (term, "?any_whole"), frozenset())})


def _with(fact: Fact, k: int, term: str) -> Fact:
    return (*fact[: k + 1], term, *fact[k + 2 :])


def _tidy(ending: Ending) -> Ending:
    """Return a fact that a task makes false, its free variables numbered in the order in which they appear."""
    names = {v: v if v == "?other" else f"?any{k}" for k, v in enumerate(ending.free, 1)}

    def renamed(fact: Fact) -> Fact:
        return tuple(names.get(t, t) for t in fact)

    tables = (Table(t.name, renamed(t.terms), t.rows, t.denied) for t in ending.tables)
    fact = renamed(ending.fact)
    return Ending(fact, frozenset(map(renamed, ending.when)) - {fact}, frozenset(tables))


def _possible(ending: Ending, kinds: Kinds) -> bool:
    """Check whether a task can ever make a fact false, judged by the kinds of entities that occur as arguments of the predicates."""
    facts = [ending.fact, *ending.when]
    terms = {t for f in facts for t in f[1:]} - set(ending.free)
    fits = all(kind_of(t) in kinds.get((f[0], k), ()) for f in facts for k, t in enumerate(f[1:], 1) if t in terms)
    ever = all((f[0], k) in kinds for f in facts for k in range(1, len(f)))
    return fits and ever and all(kinds_of_free(t, facts, ending.tables, kinds) for t in ending.free)


def _covers(one: Ending, other: Ending) -> bool:
    return one.fact == other.fact and one.when <= other.when and one.tables <= other.tables

"""Coherence of task sequences: those that agree with themselves and with how the demonstration ended.

Every action may be read in several ways, and the product of all readings holds many that no programmer would write: a hand
that only reached for a box, and then carries it. A sequence is a candidate if, by what the rules themselves say begins
and ends (no reach, path or physics is asked):

1. What a task presupposes was not left to a reading that was not chosen: a relation that some reading of an earlier action
   begins (or ends) holds (or does not hold) for the sequence only if the chosen reading of that action says so too.
2. What began and lasted to the end of the demonstration is explained: the chosen reading says that it begins.
3. What the sequence itself begins it also ends, where the demonstration saw it end.
4. A reading by which something happens explains every end that another reading of the same action explains. A
   reading by which nothing happens need not: an end that shows just behind a pause is the doing of what follows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import islice

from ..base.value import Value
from ..model.entity_name import thing_of
from ..ontology.taxonomy import Taxonomy
from .conditions import Atom, Every, Not, Variable, atoms
from .matching import Match
from .ranking import DEFAULT_CAP, TaskSequence, best_first
from .rules import Rule
from .timeline import PhaseName

Fact = tuple[str, ...]
"""A predicate and its arguments; "_" stands for anything that is no role of the task."""


class Claims(Value):
    """Preconditions and effects that one reading of an action claims, on the relations that rules change.

    Args:
        needs, denies: relations that must hold, or must not, just before it.
        begins, ends: relations that it makes hold, or makes no longer hold.
        passive: whether it says that nothing happens.
    """

    needs: frozenset[Fact]
    denies: frozenset[Fact]
    begins: frozenset[Fact]
    ends: frozenset[Fact]
    passive: bool


NOTHING = Claims(frozenset(), frozenset(), frozenset(), frozenset(), passive=False)
"""What is said of a task that no rule speaks about."""

LOOKED_AT = 5000
"""Readings that are looked at, most of which contradict themselves."""


def claims(rule: Rule, match: Match) -> Claims:
    """Return the preconditions and effects that a rule claims of the entities that fill its roles."""
    said = partial(_facts, rule, match)
    needs, denies, after, gone = said("pre", False), said("pre", True), said("post", False), said("post", True)
    begins = frozenset(f for f in after if any(d[0] == f[0] for d in denies))
    ends = frozenset(f for f in needs if any(g[0] == f[0] for g in gone))
    return Claims(needs, denies, begins, ends, _passive(rule))


def _facts(rule: Rule, match: Match, phase: PhaseName, denied: bool) -> frozenset[Fact]:
    found: set[Fact] = set()
    for clause in rule.clauses:
        if clause.phase == phase and isinstance(clause.condition, Not | Every) == denied:
            asked = clause.condition.given if isinstance(clause.condition, Every) else clause.condition
            found |= {_fact(atom, match) for atom in atoms(asked)}
    return frozenset(found)


def _fact(atom: Atom, match: Match) -> Fact:
    terms = [match.roles.get(t.name, "_") if isinstance(t, Variable) else str(t) for t in atom.terms]
    return (atom.predicate.name, *terms)


def _passive(rule: Rule) -> bool:
    """Whether the rule denies, while the action lasts, that something happens, and asserts of nothing that it does.

    What happens is said by predicates without arguments: that the arm moves, that the gripper does.
    """
    happens = {False: 0, True: 0}
    for clause in rule.clauses:
        for atom in atoms(clause.condition) if clause.phase == "run" else ():
            happens[isinstance(clause.condition, Not)] += not atom.terms
    return happens[True] > 0 and happens[False] == 0


def same(a: Fact, b: Fact) -> bool:
    """Check whether two facts unify: equal where both name something; a part counts as its whole."""
    pairs = zip(a[1:], b[1:], strict=False)
    return a[0] == b[0] and all("_" in (x, y) or thing_of(x) == thing_of(y) for x, y in pairs)


def candidates(
    actions: Sequence[Sequence[Match]], rules: Iterable[Rule], taxonomy: Taxonomy, cap: int = DEFAULT_CAP
) -> Iterator[TaskSequence]:
    """Yield the coherent task sequences of some actions, best first: those among the first ``LOOKED_AT`` by ``best_first``.

    Args:
        actions: the matches of each action, none of them empty.
        rules: that matched.
        cap: unfinished sequences kept.
    """
    by_task = {rule.task: rule for rule in rules}
    readings = [[_said(by_task, m) for m in matches] for matches in actions]
    numbers = [{id(m): r for r, m in enumerate(matches)} for matches in actions]
    honest = [
        [m for m, claim in zip(matches, said, strict=True) if explains_ends(claim, said)]
        for matches, said in zip(actions, readings, strict=True)
    ]
    asked = demands(readings)
    for sequence in islice(best_first(honest, taxonomy, cap), LOOKED_AT) if all(honest) else ():
        if coherent([n[id(m)] for n, m in zip(numbers, sequence.matches, strict=True)], asked):
            yield sequence


def _said(rules: Mapping[str, Rule], match: Match) -> Claims:
    return claims(rules[match.task], match) if match.task in rules else NOTHING


def explains_ends(claim: Claims, readings: Iterable[Claims]) -> bool:
    """Check condition 4 for one reading of an action among all of them."""
    return claim.passive or all(_among(f, claim.ends) for c in readings for f in c.ends)


def coherent(chosen: Sequence[int], asked: Iterable[Demand]) -> bool:
    """Check whether a choice, the number of a reading for each action, fulfils conditions 1 to 3."""
    made = set(enumerate(chosen))
    return all(not made.isdisjoint(d.any_of) for d in asked if d.of is None or d.of in made)


Choice = tuple[int, int]
"""An action and one of its readings, both counted from 0."""


class Demand(Value):
    """Constraint on the choice of readings: one choice requires one of others.

    Args:
        of: the choice that demands it; None if every choice does.
        any_of: choices of which one must be made.
    """

    of: Choice | None
    any_of: frozenset[Choice]


Sayers = Callable[[Fact], Sequence[Choice]]
"""The readings that say of a fact that it begins (or ends), in order of the actions."""


def demands(readings: Sequence[Sequence[Claims]]) -> tuple[Demand, ...]:
    """Return conditions 1 to 3 as constraints on a choice among the readings of each action."""
    begins, ends = _sayers(readings, lambda c: c.begins), _sayers(readings, lambda c: c.ends)
    found: list[Demand] = []
    for k, said in enumerate(readings):
        found += _lasting(k, said, begins, ends)
        for r, claim in enumerate(said):
            found += _presupposed((k, r), claim, begins, ends)
            found += _closed((k, r), claim, ends)
    return tuple(found)


def _sayers(readings: Sequence[Sequence[Claims]], side: Callable[[Claims], frozenset[Fact]]) -> Sayers:
    @cache
    def of(fact: Fact) -> Sequence[Choice]:
        return [(k, r) for k, said in enumerate(readings) for r, c in enumerate(said) if _among(fact, side(c))]

    return of


def _among(fact: Fact, facts: Iterable[Fact]) -> bool:
    return any(same(fact, f) for f in facts)


def _presupposed(at: Choice, claim: Claims, begins: Sayers, ends: Sayers) -> Iterator[Demand]:
    """Condition 1: it is settled by the last action before that may have begun (or ended) the relation."""
    for facts, sayers in ((claim.needs, begins), (claim.denies, ends)):
        for fact in facts:
            before = [c for c in sayers(fact) if c[0] < at[0]]
            if before:
                yield Demand(at, frozenset(c for c in before if c[0] == before[-1][0]))


def _lasting(k: int, said: Iterable[Claims], begins: Sayers, ends: Sayers) -> Iterator[Demand]:
    """Condition 2, of what may have begun in one action and nothing may have ended later."""
    for fact in {f for c in said for f in c.begins}:
        if not any(c[0] > k for c in ends(fact)):
            yield Demand(None, frozenset(c for c in begins(fact) if c[0] >= k))


def _closed(at: Choice, claim: Claims, ends: Sayers) -> Iterator[Demand]:
    """Condition 3, of what a reading begins."""
    for fact in claim.begins:
        if later := frozenset(c for c in ends(fact) if c[0] > at[0]):
            yield Demand(at, later)

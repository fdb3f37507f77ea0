"""Coherence of task sequences: a sequence may contradict neither itself nor how the demonstration ended.

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

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import islice
from typing import Protocol

from ..base.value import Value, replace
from ..model.entity_name import thing_of
from ..ontology.taxonomy import Taxonomy
from .conditions import Atom, Condition, Every, Not, Or, Variable, atoms
from .fluents import PLAIN, Fluent
from .matching import Match
from .ranking import (
    CHANGE,
    DEFAULT_CAP,
    GENERIC,
    LABEL,
    MOVED,
    DescriptionLength,
    Option,
    TaskSequence,
    naming_length,
    shortest_first,
)
from .rules import Rule
from .timeline import PhaseName

Fact = tuple[str, ...]
"""Relation of entities: a predicate and its arguments, where "_" stands for any entity that has no role in the task."""


class Claims(Value):
    """Claims of one reading of an action: the preconditions and effects that its rule states about relations.

    Args:
        needs, denies: relations that must hold, or must not, just before it.
        begins, ends: relations that it makes hold, or makes no longer hold.
        passive: whether it says that nothing happens.
        changes: all relations that begin or end by it, those also that do by what ``Fluent`` declares of others.
    """

    needs: frozenset[Fact]
    denies: frozenset[Fact]
    begins: frozenset[Fact]
    ends: frozenset[Fact]
    passive: bool
    changes: frozenset[Fact] = frozenset()


NOTHING = Claims(frozenset(), frozenset(), frozenset(), frozenset(), passive=False)
"""Empty claims: those of a reading whose task has no rule, and of an action without a reading."""

OFFERED = 256
"""Largest number of candidate task sequences that are yielded. A person reads a few, and a search that fails with so many would fail
with the others."""
LOOKED_AT = 20_000
"""Largest number of partial task sequences that are examined, including those that turn out to be incoherent."""


class Read(Protocol):
    """Interface of an action and its readings, each a task that the action may have been."""

    @property
    def matches(self) -> tuple[Match, ...]:
        """Matches of the action: each is a task that it may be."""

    @property
    def label(self) -> str | None:
        """Task that the recording names; None where it names none."""

    @property
    def moved(self) -> tuple[str, ...]:
        """Things whose position at the end of the action differs from that at its start."""


def claims(rule: Rule, match: Match) -> Claims:
    """Return the preconditions and effects that a rule states about the entities that fill its roles."""
    of = partial(_facts, rule, match)
    needs, denies, after, gone = of("pre", False), of("pre", True), of("post", False), of("post", True)
    fluents = {a.predicate.name: a.predicate.fluent for c in rule.clauses for a in atoms(c.condition)}
    begins = frozenset(f for f in after if any(d[0] == f[0] for d in denies))
    ends = frozenset(f for f in needs if any(g[0] == f[0] for g in gone))
    changes = begins | ends | _implied(needs, denies, after, gone, fluents)
    return Claims(needs, denies, begins, ends, passive(rule), changes)


def _implied(
    needs: frozenset[Fact], denies: frozenset[Fact], after: frozenset[Fact], gone: frozenset[Fact], fluents: Mapping[str, Fluent]
) -> frozenset[Fact]:
    """Return the facts that begin or end because another fact of the reading implies, denies or excludes
    them."""
    meant = {str(p[0]) for f in gone for p in fluents.get(f[0], PLAIN).denial}
    denied = {f[0] for f in denies}
    of = {f: fluents.get(f[0], PLAIN) for f in after}
    follows = {(p, *f[1:]) for f, fluent in of.items() for p in (*fluent.implies, *fluent.implies_when_carried)}
    over = {(f, (p, *f[1:])) for f, fluent in of.items() for p in fluent.excludes}
    turned = {t for t in over if t[1] in needs or t[0][0] in denied}
    return frozenset({f for f in needs if f[0] in meant} | {f for f in follows if f[0] in denied} | {f for t in turned for f in t})


def _facts(rule: Rule, match: Match, phase: PhaseName, denied: bool) -> frozenset[Fact]:
    """Return the relations that a rule's conditions on a phase (before, during or after the action) ask for or, if
    ``denied``, deny."""
    found: set[Fact] = set()
    for clause in rule.clauses:
        for part in _alternatives(clause.condition) if clause.phase == phase else ():
            if isinstance(part, Not | Every) == denied:
                found |= {_fact(atom, match) for atom in atoms(part.given if isinstance(part, Every) else part)}
    return frozenset(found)


def _alternatives(condition: Condition) -> tuple[Condition, ...]:
    return condition.options if isinstance(condition, Or) else (condition,)


def _fact(atom: Atom, match: Match) -> Fact:
    terms = [match.roles.get(t.name, "_") if isinstance(t, Variable) else str(t) for t in atom.terms]
    return (atom.predicate.name, *terms)


def passive(rule: Rule) -> bool:
    """Check whether a rule forbids events during the action, such as motion of the arm, and requires none.

    What happens is said by predicates without arguments: that the arm moves, that the gripper does.
    """
    happens = {False: 0, True: 0}
    for clause in rule.clauses:
        for atom in atoms(clause.condition) if clause.phase == "run" else ():
            happens[isinstance(clause.condition, Not)] += not atom.terms
    return happens[True] > 0 and happens[False] == 0


def same(a: Fact, b: Fact) -> bool:
    """Check whether two facts unify: named entities are equal; a part counts as its whole."""
    pairs = zip(a[1:], b[1:], strict=False)
    return a[0] == b[0] and all("_" in (x, y) or thing_of(x) == thing_of(y) for x, y in pairs)


def candidates(
    actions: Sequence[Read], rules: Sequence[Rule], taxonomy: Taxonomy, cap: int = DEFAULT_CAP
) -> Iterator[TaskSequence]:
    """Yield the coherent task sequences of some actions, the shortest description first, ``OFFERED`` at most.

    Args:
        actions: with at least one match each.
        rules: that matched.
        cap: unfinished sequences kept.
    """
    by_task = {rule.task: rule for rule in rules}
    readings = [_undecided(action.matches, [_claims_of(by_task, m) for m in action.matches]) for action in actions]
    general = [generic(action.matches, said_, by_task, taxonomy) for action, said_ in zip(actions, readings, strict=True)]
    options = _options(actions, readings, general, taxonomy, math.log2(max(len(rules), 2)))
    if not all(options):
        return
    settled: dict[int, list[Demand]] = defaultdict(list)
    for demand in demands(readings):
        settled[max(k for k, _ in (*demand.any_of, *([demand.of] if demand.of else ())))].append(demand)

    def allowed(chosen: Sequence[int]) -> bool:
        asked = settled.get(len(chosen) - 1)
        return not asked or coherent(chosen, asked)

    yield from islice(shortest_first(options, allowed, cap, LOOKED_AT), OFFERED)


def _undecided(matches: Sequence[Match], claimed: Sequence[Claims]) -> list[Claims]:
    """Return the relations that each reading of an action requires or changes, with "_" in place of a thing
    where several could fill its role.

    Of several unknown fillers of a role only one can be right, so a claim about one of them is left open.
    """
    found = list(claimed)
    for task in {m.task for m in matches if m.unknown}:
        alike = [k for k, m in enumerate(matches) if m.task == task and m.unknown]
        fillers: dict[str, set[str]] = defaultdict(set)
        for role, filler in ((r, f) for k in alike for r, f in matches[k].roles.items()):
            fillers[role].add(filler)
        open_ = {f for several in fillers.values() if len(several) > 1 for f in several}
        for k in alike if open_ else []:
            found[k] = _left_open(claimed[k], open_)
    return found


def _left_open(claim: Claims, names: set[str]) -> Claims:
    def of(facts: Iterable[Fact]) -> frozenset[Fact]:
        return frozenset((f[0], *("_" if a in names else a for a in f[1:])) for f in facts)

    return replace(claim, begins=of(claim.begins), ends=of(claim.ends), changes=of(claim.changes))


def _options(
    actions: Sequence[Read], readings: Sequence[Sequence[Claims]], general: Sequence[frozenset[int]], taxonomy: Taxonomy, name: float
) -> list[list[Option]]:
    """Return the options of each action: its readings or, for an action that changes nothing, no reading.

    If anything changes in the demonstration, readings without roles of an action that changes nothing are
    left out.

    If anything changes in the demonstration, an action without changes needs no reading.
    """
    something = any(c.changes for said_ in readings for c in said_) or any(a.label or set(a.moved) & _spoken_of(a) for a in actions)
    found = []
    for action, claimed, wide in zip(actions, readings, general, strict=True):
        idle = something and not any(c.begins or c.ends for c in claimed)
        honest = [
            Option(m, naming_length(m, action.matches, taxonomy, name) + _untold(action, claimed, m, claim, taxonomy, name, k in wide), k)
            for k, (m, claim) in enumerate(zip(action.matches, claimed, strict=True))
            if explains_ends(claim, claimed) and not (idle and not m.roles and not _is_label(m, action, taxonomy))
        ]
        nothing = [Option(None, _untold(action, claimed, None, NOTHING, taxonomy, name))] if idle else []
        found.append([*nothing, *honest])
    return found


def _untold(
    action: Read, claimed: Sequence[Claims], match: Match | None, claim: Claims, taxonomy: Taxonomy, name: float, wide: bool = False
) -> DescriptionLength:
    """Return the description length [bits] of what the chosen reading leaves unexplained in an action:
    changes, moved things, its label."""
    changes = _distinct(f for c in claimed for f in c.changes)
    left = sum(not _among(f, claim.changes) for f in changes)
    mine = {thing_of(f) for f in match.roles.values()} if match is not None else set()
    moved = len((set(action.moved) & _spoken_of(action)) - mine)
    unnamed = action.label is not None and not (match is not None and _is_label(match, action, taxonomy))
    return DescriptionLength(unexplained=name * (CHANGE * left + MOVED * moved + LABEL * unnamed + GENERIC * wide))


def generic(matches: Sequence[Match], said_: Sequence[Claims], rules: Mapping[str, Rule], taxonomy: Taxonomy) -> frozenset[int]:
    """Return the indices of the readings by shipped rules that are replaced by a more specific reading by a user's own
    rule.

    A reading by a rule that does not come with cramlite is more specific than one by a rule that does if it explains all the
    changes that the other explains, and its task is a kind of the other's, or its rule says of what class a thing must be of
    which the other's says nothing.
    """
    own = [k for k, m in enumerate(matches) if m.task in rules and not rules[m.task].shipped]
    return frozenset(
        b for b, other in enumerate(matches) for a in own
        if other.task in rules and rules[other.task].shipped
        and all(_among(f, said_[a].changes) for f in said_[b].changes)
        and (taxonomy.is_a(matches[a].task, other.task) or classed(matches[a], rules) - classed(other, rules))
    )  # fmt: skip


def classed(match: Match, rules: Mapping[str, Rule]) -> frozenset[tuple[str, str]]:
    """Return pairs of a thing and a class: the classes that a reading's rule requires of the things in its
    roles."""
    asked = (a for c in rules[match.task].clauses for a in atoms(c.condition) if a.predicate.timeless and not isinstance(c.condition, Not))
    pairs = ((t.name, str(k)) for a in asked for t in a.terms if isinstance(t, Variable) for k in a.terms if isinstance(k, str))
    return frozenset((thing_of(match.roles[role]), class_) for role, class_ in pairs if role in match.roles)


def _spoken_of(action: Read) -> set[str]:
    """Return the things that some reading of an action mentions."""
    return {thing_of(f) for m in action.matches for f in m.roles.values()}


def _is_label(match: Match, action: Read, taxonomy: Taxonomy) -> bool:
    """Check whether a reading's task is the task that the recording names for the action, or a subclass of
    it."""
    return action.label is not None and taxonomy.is_a(match.task, action.label)


def _distinct(facts: Iterable[Fact]) -> list[Fact]:
    found: list[Fact] = []
    for fact in facts:
        if not _among(fact, found):
            found.append(fact)
    return found


def _claims_of(rules: Mapping[str, Rule], match: Match) -> Claims:
    return claims(rules[match.task], match) if match.task in rules else NOTHING


def explains_ends(claim: Claims, readings: Iterable[Claims]) -> bool:
    """Check that a reading of an action ends every relation that another reading of the action ends.

    A reading by which nothing happens need not. This is condition 4 of coherence.
    """
    return claim.passive or all(_among(f, claim.ends) for c in readings for f in c.ends)


def coherent(chosen: Sequence[int], asked: Iterable[Demand]) -> bool:
    """Check whether the chosen readings, one number for each action, fulfil all given constraints between readings.

    The constraints are conditions 1 to 3 of coherence.
    """
    made = set(enumerate(chosen))
    return all(not made.isdisjoint(d.any_of) for d in asked if d.of is None or d.of in made)


Choice = tuple[int, int]
"""An action and one of its readings, both counted from 0."""


class Demand(Value):
    """Constraint between readings of actions: choosing one reading requires that one of several others is
    chosen too.

    Args:
        of: the choice that demands it; None if every choice does.
        any_of: choices of which one must be made.
    """

    of: Choice | None
    any_of: frozenset[Choice]


Sayers = Callable[[Fact], Sequence[Choice]]
"""Function that returns, in the order of the actions, the readings by which a given fact begins (or ends)."""


def demands(readings: Sequence[Sequence[Claims]]) -> tuple[Demand, ...]:
    """Return the constraints that keep the readings chosen for the actions from contradicting each other or
    the end of the demonstration.

    They are conditions 1 to 3 of coherence.
    """
    begins, ends = _sayers(readings, lambda c: c.begins), _sayers(readings, lambda c: c.ends)
    found: list[Demand] = []
    for k, claimed in enumerate(readings):
        found += _lasting(k, claimed, begins, ends)
        for r, claim in enumerate(claimed):
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
    """Yield constraints: the last earlier action that can begin a relation presupposed by a reading must begin it.

    For a relation that must not hold, it is the last earlier action that can end it. This is condition 1 of coherence.
    """
    for facts, sayers in ((claim.needs, begins), (claim.denies, ends)):
        for fact in facts:
            before = [c for c in sayers(fact) if c[0] < at[0]]
            if before:
                yield Demand(at, frozenset(c for c in before if c[0] == before[-1][0]))


def _lasting(k: int, said: Iterable[Claims], begins: Sayers, ends: Sayers) -> Iterator[Demand]:
    """Yield a constraint for each relation that lasts to the end of the demonstration: one of the readings
    that begin it must be chosen.

    They are those that action ``k`` may have begun and no later action may end. This is condition 2 of
    coherence.
    """
    for fact in {f for c in said for f in c.begins}:
        if not any(c[0] > k for c in ends(fact)):
            yield Demand(None, frozenset(c for c in begins(fact) if c[0] >= k))


def _closed(at: Choice, claim: Claims, ends: Sayers) -> Iterator[Demand]:
    """Yield constraints: where later actions may end a relation that a reading begins, a reading that ends
    it must be chosen, too.

    This is condition 3 of coherence.
    """
    for fact in claim.begins:
        if later := frozenset(c for c in ends(fact) if c[0] > at[0]):
            yield Demand(at, later)

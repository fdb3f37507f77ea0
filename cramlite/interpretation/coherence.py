"""Candidates: the task sequences that agree with themselves and with how the demonstration ended.

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

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import islice

from ..base.value import Value
from .conditions import Atom, Every, Not, Variable, atoms
from .interpretation import Interpretation
from .matching import Match
from .ranking import TaskSequence, best_first
from .rules import Rule
from .timeline import PhaseName

Fact = tuple[str, ...]
"""A predicate and its arguments; "_" stands for anything that is no role of the task."""


class Claims(Value):
    """What one reading of an action says about the relations that rules change.

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


def claims(rule: Rule, match: Match) -> Claims:
    """What a rule says of the entities that fill its roles."""
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
    """Whether two facts may be about the same: equal where both name something; a part counts as its whole."""
    pairs = zip(a[1:], b[1:], strict=False)
    return a[0] == b[0] and all("_" in (x, y) or x.split("/")[0] == y.split("/")[0] for x, y in pairs)


def candidates(found: Interpretation, rules: Iterable[Rule], limit: int = 5000) -> Iterator[TaskSequence]:
    """The coherent sequences of an interpretation, best first.

    Args:
        limit: of sequences looked at.
    """
    by_task = {rule.task: rule for rule in rules}
    actions = [a.matches for a in found.actions if not a.hole]
    readings = [[claims(by_task[m.task], m) for m in matches] for matches in actions]
    honest = [
        [m for m, c in zip(matches, said, strict=True) if _ended(c, said)]
        for matches, said in zip(actions, readings, strict=True)
    ]
    for sequence in islice(best_first(honest, found.taxonomy), limit) if all(honest) else ():
        if coherent([claims(by_task[m.task], m) for m in sequence.matches], readings):
            yield sequence


def coherent(chosen: Sequence[Claims], readings: Sequence[Sequence[Claims]]) -> bool:
    """Whether a choice among the readings of each action fulfils the four conditions above."""
    return all(
        _presupposed(k, chosen, readings) and _lasting(k, chosen, readings) and _closed(k, chosen, readings)
        and _ended(chosen[k], readings[k])
        for k in range(len(chosen))
    )  # fmt: skip


Side = Callable[[Claims], frozenset[Fact]]


def _begins(claim: Claims) -> frozenset[Fact]:
    return claim.begins


def _ends(claim: Claims) -> frozenset[Fact]:
    return claim.ends


def _last(facts: Fact, side: Side, readings: Sequence[Sequence[Claims]]) -> int | None:
    """The last action of which some reading says that the fact begins (or ends)."""
    return next((k for k in reversed(range(len(readings))) if any(_says(c, side, facts) for c in readings[k])), None)


def _says(claim: Claims, side: Side, fact: Fact) -> bool:
    return any(same(fact, f) for f in side(claim))


def _presupposed(k: int, chosen: Sequence[Claims], readings: Sequence[Sequence[Claims]]) -> bool:
    """Condition 1."""
    for facts, side in ((chosen[k].needs, _begins), (chosen[k].denies, _ends)):
        for fact in facts:
            at = _last(fact, side, readings[:k])
            if at is not None and not any(_says(c, side, fact) for c in chosen[at:k]):
                return False
    return True


def _lasting(k: int, chosen: Sequence[Claims], readings: Sequence[Sequence[Claims]]) -> bool:
    """Condition 2, of what may have begun in one action."""
    begun = {f for c in readings[k] for f in c.begins}
    lasting = [f for f in begun if not any(_says(c, _ends, f) for later in readings[k + 1 :] for c in later)]
    return all(any(_says(c, _begins, f) for c in chosen[k:]) for f in lasting)


def _closed(k: int, chosen: Sequence[Claims], readings: Sequence[Sequence[Claims]]) -> bool:
    """Condition 3, of what the chosen reading of one action begins."""
    for fact in chosen[k].begins:
        at = next((j for j in range(k + 1, len(readings)) if any(_says(c, _ends, fact) for c in readings[j])), None)
        if at is not None and not any(_says(c, _ends, fact) for c in chosen[k + 1 :]):
            return False
    return True


def _ended(chosen: Claims, readings: Sequence[Claims]) -> bool:
    """Condition 4."""
    return chosen.passive or all(_says(chosen, _ends, f) for c in readings for f in c.ends)

"""Literal of a goal: a condition that should hold when a program has run, and that can be checked on a recorded run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..base.value import Value
from .conditions import Atom, Compare, Condition, Not, Variable
from .fluents import Bound, GoalCondition, Pattern, pattern_text
from .rules import Clause
from .timeline import Predicate


class GoalLiteral(Value):
    """Literal of a goal: a condition that should hold when a program has run.

    Args:
        says: in words, e.g. "coffee in basket".
        things: that it is about, the one that is to be brought there first; names in the robot's world.
        clauses: conditions of the language of rules; all of them must hold.
        binding: their variables -> entities as planning names them (``EFFECTOR``, "hook/peg", ``contents("jug")``).
        side, other: where in the place it should be, as a key of a task's ``where``, and beside which thing; "" for none.
        task: of the plan that it comes from; "" where it was asked for as such.
    """

    says: str
    things: tuple[str, ...]
    clauses: tuple[Clause, ...]
    binding: Mapping[str, str]
    side: str = ""
    other: str = ""
    task: str = ""


def clauses_of(meaning: GoalCondition, predicates: Mapping[str, Predicate]) -> tuple[Clause, ...]:
    """Return the conditions of a goal as clauses of a rule: required facts, and negations of forbidden
    patterns.

    Entities are written as variables of the same name, since a recording may name them otherwise.
    """
    found = [_clause(f, predicates, denied=False) for f in sorted(meaning.needs | meaning.shown)]
    found += [clause for b in meaning.bounds for clause in _bounds(b, predicates)]
    return (*found, *(_clause(p, predicates, denied=True) for p in sorted(meaning.without, key=str)))


def _bounds(bound: Bound, predicates: Mapping[str, Predicate]) -> Iterable[Clause]:
    value = _atom(bound.of, predicates)
    for symbol, limit in ((">=", bound.low), ("<=", bound.high)):
        yield Clause("post", Compare(value, symbol, limit), f"{pattern_text(bound.of)} {symbol} {limit:.3g}", 0)


def entities_of(meaning: GoalCondition) -> dict[str, str]:
    """Return every entity that a goal's conditions name, by the variable that stands for it."""
    patterns: Iterable[Pattern] = (*meaning.needs, *meaning.shown, *meaning.without, *(b.of for b in meaning.bounds))
    return {e: e for p in patterns for e in p[1:] if e is not None}


def _clause(pattern: Pattern, predicates: Mapping[str, Predicate], *, denied: bool) -> Clause:
    atom: Condition = _atom(pattern, predicates)
    return Clause("post", Not(atom) if denied else atom, ("not " if denied else "") + pattern_text(pattern), 0)


def _atom(pattern: Pattern, predicates: Mapping[str, Predicate]) -> Atom:
    return Atom(predicates[str(pattern[0])], tuple(Variable(e or "_") for e in pattern[1:]))

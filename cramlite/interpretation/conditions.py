"""Conditions of rules: first-order formulas, and the variable bindings that solve them before, during or after an
action.

A binding maps variables to entities. ``solve`` yields every extension of a binding
under which the condition holds.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator
from typing import Union

from ..base.value import Value
from .timeline import Phase, Predicate, Row

Binding = dict[str, str | float]


class Variable(Value):
    """Logic variable: a capitalised name; ``_`` stands for a new variable each time."""

    name: str


Term = Variable | str | float

OPERATORS = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "==": operator.eq,
    "!=": operator.ne,
}


class Atom(Value):
    """Atomic formula: a ``predicate`` of ``terms``, each a variable or a value."""

    predicate: Predicate
    terms: tuple[Term, ...]

    def arguments(self, binding: Binding) -> tuple[str | float | None, ...]:
        """Return the values of the terms under a binding; None for unbound variables."""
        return tuple(binding.get(t.name) if isinstance(t, Variable) else t for t in self.terms)

    def solve(self, phase: Phase, binding: Binding) -> Iterator[Binding]:
        """Yield the extensions of a binding under which the predicate holds."""
        for row in phase.rows(self.predicate, self.arguments(binding)):
            extended = self.bind(row, binding)
            if extended is not None:
                yield extended

    def bind(self, row: Row, binding: Binding) -> Binding | None:
        """Return the binding extended by the arguments for which the predicate holds, or None if a variable would have
        two values."""
        extended = binding
        for term, value in zip(self.terms, row, strict=False):
            if isinstance(term, Variable) and term.name != "_":
                if term.name not in extended:
                    extended = {**extended, term.name: value}
                elif extended[term.name] != value:
                    return None
        return extended

    def binds(self) -> frozenset[str]:
        """Return the names of the variables to which a solution of the atom gives values."""
        return frozenset(t.name for t in self.terms if isinstance(t, Variable) and t.name != "_")


class Not(Value):
    """Negation as failure: it holds when the inner condition has no solution."""

    inner: Condition

    def solve(self, phase: Phase, binding: Binding) -> Iterator[Binding]:
        """Yield the binding if the inner condition has no solution under it."""
        if next(self.inner.solve(phase, binding), None) is None:
            yield binding


class Every(Value):
    """Universal condition: every solution of the first condition makes the second hold."""

    given: Condition
    then: Condition

    def solve(self, phase: Phase, binding: Binding) -> Iterator[Binding]:
        """Yield the binding if every solution of the first condition makes the second hold."""
        if all(next(self.then.solve(phase, case), None) is not None for case in self.given.solve(phase, binding)):
            yield binding


class Compare(Value):
    """Comparison of a predicate's value, or a variable, with a number or a variable.

    Args:
        left: value predicate or variable.
        symbol: one of ``OPERATORS``.
        right: number or variable.
    """

    left: Atom | Variable
    symbol: str
    right: Term

    def solve(self, phase: Phase, binding: Binding) -> Iterator[Binding]:
        """Yield the binding if some value of the comparison's left side fulfils the comparison."""
        right = binding[self.right.name] if isinstance(self.right, Variable) else self.right
        for left in self.values(phase, binding):
            if OPERATORS[self.symbol](left, right):
                yield binding
                return

    def values(self, phase: Phase, binding: Binding) -> list[str | float]:
        """Return the values of the comparison's left side under a binding."""
        if isinstance(self.left, Variable):
            return [binding[self.left.name]]
        return [row[-1] for row in phase.rows(self.left.predicate, self.left.arguments(binding))]


class Or(Value):
    """Disjunction of conditions."""

    options: tuple[Condition, ...]

    def solve(self, phase: Phase, binding: Binding) -> Iterator[Binding]:
        """Yield the bindings that solve at least one option of the disjunction, each binding once."""
        seen: list[Binding] = []
        for option in self.options:
            for found in option.solve(phase, binding):
                if found not in seen:
                    seen.append(found)
                    yield found


class And(Value):
    """Conjunction of conditions; each condition gets the variable values that the conditions to its left have found."""

    parts: tuple[Condition, ...]

    def solve(self, phase: Phase, binding: Binding) -> Iterator[Binding]:
        """Yield the bindings that solve all parts of the conjunction."""
        first, *rest = self.parts
        for found in first.solve(phase, binding):
            if rest:
                yield from And(tuple(rest)).solve(phase, found)
            else:
                yield found


Condition = Union[Atom, Not, Every, Compare, Or, And]  # noqa: UP007 - a forward reference between the classes


def atoms(condition: Condition) -> Iterator[Atom]:
    """Yield every atom of a condition."""
    match condition:
        case Atom():
            yield condition
        case Not(inner):
            yield from atoms(inner)
        case Every(given, then):
            yield from atoms(given)
            yield from atoms(then)
        case Compare(left):
            if isinstance(left, Atom):
                yield left
        case Or(parts) | And(parts):
            for part in parts:
                yield from atoms(part)


def binds(condition: Condition) -> frozenset[str]:
    """Return the variables that have a value in every solution of the condition."""
    match condition:
        case Atom():
            return condition.binds()
        case And(parts):
            return frozenset().union(*map(binds, parts))
        case Or(options):
            return frozenset.intersection(*map(binds, options))
        case _:
            return frozenset()


def mentions(condition: Condition) -> frozenset[str]:
    """Return every variable that occurs in the condition."""
    found: frozenset[str] = frozenset().union(*(a.binds() for a in atoms(condition)))
    for part in comparisons(condition):
        found |= {t.name for t in (part.left, part.right) if isinstance(t, Variable)}
    return found


def tests(condition: Condition) -> frozenset[str]:
    """Return the variables that a condition tests but does not bind; other conditions must bind them
    first."""
    match condition:
        case And(parts) | Or(parts):
            return frozenset().union(*map(tests, parts)) | (mentions(condition) - binds(condition))
        case Atom():
            return frozenset()
        case _:
            return mentions(condition)


def comparisons(condition: Condition) -> Iterator[Compare]:
    """Yield every comparison in a condition."""
    match condition:
        case Compare():
            yield condition
        case Not(inner):
            yield from comparisons(inner)
        case Every(given, then):
            yield from comparisons(given)
            yield from comparisons(then)
        case Or(parts) | And(parts):
            for part in parts:
                yield from comparisons(part)

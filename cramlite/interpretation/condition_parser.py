"""Parser of the conditions of rule files.

condition := "every" simple ("and" simple)* "->" condition | simple ("or" simple)*
simple    := "not" simple | atom [comparison] | Variable comparison | "(" condition ")"
atom      := predicate "(" [term ("," term)*] ")"
term      := Variable | _ | prefix:Class | number | "text"
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..base.errors import nearest
from ..ontology.taxonomy import Taxonomy
from .conditions import OPERATORS, And, Atom, Compare, Condition, Every, Not, Or, Term, Variable
from .timeline import PhaseName, Predicate

_TOKEN = re.compile(r"\s*(?:(->|<=|>=|!=|==|[<>=(),])|(-?\d+(?:\.\d+)?)|\"([^\"]*)\"|([A-Za-z_][\w-]*(?::[\w-]+)?))")
_DEEPEST = 30
"""Largest nesting depth of brackets and negations in a condition. No rule needs three; the limit keeps bad input from exhausting the
stack."""


class ConditionError(ValueError):
    """Syntax or name error in a condition; the caller adds file and line to its message."""


def parse_condition(text: str, phase: PhaseName, predicates: Mapping[str, Predicate], taxonomy: Taxonomy) -> Condition:
    """Parse a condition, and look up its predicates and classes.

    Raises:
        ConditionError: syntax, an unknown predicate or class, a wrong number of arguments, or a
            predicate that means nothing in this phase.
    """
    return _Parser(_tokens(text), phase, predicates, taxonomy).whole()


def _tokens(text: str) -> list[tuple[str, str]]:
    found, at = [], 0
    kinds = ("symbol", "number", "text", "name")
    while at < len(text.rstrip()):
        match = _TOKEN.match(text, at)
        if match is None:
            raise ConditionError(f"'{text[at:].strip()[:20]}' is not part of a condition")
        kind = next(k for k, group in zip(kinds, match.groups(), strict=True) if group is not None)
        found.append((kind, match[kinds.index(kind) + 1]))
        at = match.end()
    return found


class _Parser:
    """Recursive-descent parser of a condition's tokens, with a method for each line of the grammar."""

    def __init__(
        self, tokens: list[tuple[str, str]], phase: PhaseName, predicates: Mapping[str, Predicate], taxonomy: Taxonomy
    ) -> None:
        self.tokens, self.at, self.depth = tokens, 0, 0
        self.phase, self.predicates, self.taxonomy = phase, predicates, taxonomy

    def whole(self) -> Condition:
        found = self.condition()
        if self.at < len(self.tokens):
            raise ConditionError(f"'{self.tokens[self.at][1]}' is not expected here")
        return found

    def peek(self, *values: str) -> bool:
        return (
            self.at < len(self.tokens)
            and self.tokens[self.at][0] in ("symbol", "name")
            and self.tokens[self.at][1] in values
        )

    def take(self, *values: str) -> bool:
        if self.peek(*values):
            self.at += 1
            return True
        return False

    def next(self) -> tuple[str, str]:
        if self.at >= len(self.tokens):
            raise ConditionError("the condition is incomplete: a predicate, variable or value is missing at its end")
        self.at += 1
        return self.tokens[self.at - 1]

    def need(self, value: str) -> None:
        if not self.take(value):
            found = f"'{self.tokens[self.at][1]}'" if self.at < len(self.tokens) else "nothing"
            raise ConditionError(f"expected '{value}', found {found}")

    def condition(self) -> Condition:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise ConditionError(f"more than {_DEEPEST} brackets or negations inside each other")
        if self.take("every"):
            given = [self.simple()]
            while self.take("and"):
                given.append(self.simple())
            self.need("->")
            found: Condition = Every(given[0] if len(given) == 1 else And(tuple(given)), self.condition())
        else:
            options = [self.conjunction()]
            while self.take("or"):
                options.append(self.conjunction())
            found = options[0] if len(options) == 1 else Or(tuple(options))
        self.depth -= 1
        return found

    def conjunction(self) -> Condition:
        parts = [self.simple()]
        while self.take("and"):
            parts.append(self.simple())
        return parts[0] if len(parts) == 1 else And(tuple(parts))

    def simple(self) -> Condition:
        if self.take("("):
            inner = self.condition()
            self.need(")")
            return inner
        if self.take("not"):
            self.depth += 1
            if self.depth > _DEEPEST:
                raise ConditionError(f"more than {_DEEPEST} brackets or negations inside each other")
            inner = self.simple()
            self.depth -= 1
            return Not(inner)
        kind, name = self.next()
        if kind != "name":
            raise ConditionError(f"expected a predicate or a variable, found '{name}'")
        if self.peek("("):
            atom = self.atom(name)
            if not self.peek(*OPERATORS):
                if atom.predicate.value:
                    raise ConditionError(f"'{name}' gives a number: compare it, as in '{name}(...) < 2'")
                return atom
            if not atom.predicate.value:
                raise ConditionError(f"the predicate '{name}' is true or false, so it cannot be compared with a number")
            return Compare(atom, self.next()[1], self.term())
        if not name[0].isupper() or not self.peek(*OPERATORS):
            raise ConditionError(f"expected '(' after '{name}', or a comparison after a variable")
        return Compare(Variable(name), self.next()[1], self.term())

    def atom(self, name: str) -> Atom:
        predicate = self.predicates.get(name)
        if predicate is None:
            raise ConditionError(f"unknown predicate '{name}'; {nearest(name, self.predicates)}")
        if self.phase not in predicate.phases:
            raise ConditionError(
                f"the predicate '{name}' is not defined under '{self.phase}'; write it under {', '.join(sorted(predicate.phases))}"
            )
        self.need("(")
        terms: list[Term] = []
        while not self.take(")"):
            if terms:
                self.need(",")
            terms.append(self.term())
        if len(terms) != predicate.arity:
            raise ConditionError(f"'{name}' takes {predicate.arity} arguments, not {len(terms)}")
        return Atom(predicate, tuple(terms))

    def term(self) -> Term:
        kind, value = self.next()
        if kind == "number":
            return float(value)
        if kind == "text":
            return value
        if kind == "name" and ":" in value:
            found = self.taxonomy.resolve(value)
            if found is None or self.taxonomy.curie(value) not in self.taxonomy.classes:
                raise ConditionError(f"unknown class '{value}'; {nearest(value, self.taxonomy.classes)}")
            return found
        if kind == "name" and (value[0].isupper() or value == "_"):
            return Variable(value)
        raise ConditionError(f"'{value}' is no argument: write a Variable, _, a class such as vrps:Peg, or \"text\"")

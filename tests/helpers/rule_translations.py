"""Our rules as programs of clingo and of SWI-Prolog: the oracle of a test, and what a benchmark compares with."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from cramlite.interpretation.conditions import And, Atom, Condition, Every, Not, Or, Term, Variable, binds, mentions
from cramlite.interpretation.matching import Phases
from cramlite.plugin import Compare, PhaseName, Predicate, Row, Rule, atoms

Fact = tuple[PhaseName, str, Row]


def facts_of(
    rules: Sequence[Rule], phases: Phases, names: list[str], wanted: Callable[[Predicate], bool] = lambda _: True
) -> list[Fact]:
    """Return the facts of every wanted predicate that the rules mention, evaluated for every combination of things."""
    asked = {
        (c.phase, a.predicate.name, tuple(None if isinstance(t, Variable) else t for t in a.terms)): a.predicate
        for r in rules
        for c in r.clauses
        for a in atoms(c.condition)
        if wanted(a.predicate)
    }
    found: dict[Fact, None] = {}
    for (phase, name, terms), predicate in asked.items():
        for arguments in itertools.product(*[names if t is None else [t] for t in terms]):
            found |= {(phase, name, row): None for row in phases[phase].rows(predicate, arguments)}
    return list(found)


def clingo_program(rules: Iterable[Rule], scope: tuple[str, ...] = ()) -> list[str]:
    """Return the rules as a clingo program; with a scope ("A",) each fact begins with its action, for many actions at once."""
    program = _Clingo(scope)
    for rule in rules:
        program.add(rule)
    return program.lines


def clingo_facts(facts: Iterable[Fact], names: Iterable[str], action: str = "") -> Iterator[str]:
    yield from (f"thing({quoted(name)})." for name in names)
    for phase, name, row in facts:
        yield f"fact({action}{', '.join([phase, quoted(name), *map(term, row)])})."


def prolog_program(rules: Iterable[Rule]) -> list[str]:
    """Return the rules as Prolog clauses match(Action, Task, [Role, ...])."""
    lines = []
    for rule in rules:
        body = ", ".join(prolog_goal(c.condition, "A", f"{c.phase}_") for c in rule.quick_order)
        lines.append(f"match(A, '{rule.task}', [{', '.join(rule.roles)}]) :- act(A), {body}.")
    asked = {(c.phase, a.predicate) for r in rules for c in r.clauses for a in atoms(c.condition)}
    arities = [f"{phase}_{p.name}/{p.arity + 1 + p.value}" for phase, p in asked]
    return [f":- dynamic {', '.join(sorted(set(arities)))}.", *lines]


def prolog_facts(facts: Iterable[Fact], action: int) -> Iterator[str]:
    for phase, name, row in facts:
        yield f"{phase}_{name}({', '.join([str(action), *map(_constant, row)])})."


def _constant(value: Term) -> str:
    if isinstance(value, Variable):
        return value.name
    return f"'{value}'" if isinstance(value, str) else repr(float(value))


def prolog_goal(condition: Condition, scope: str, prefix: str) -> str:
    """Return a condition as a Prolog goal; each predicate is called by prefix and name, and its first argument is the scope."""
    match condition:
        case Atom(predicate, terms):
            return f"{prefix}{predicate.name}({', '.join([scope, *map(_constant, terms)])})"
        case Compare(left, symbol, right):
            sign = {"==": "=:=", "=": "=:=", "!=": "=\\=", "<=": "=<"}.get(symbol, symbol)
            if isinstance(left, Variable):
                words = {"=:=": "==", "=\\=": "\\=="}.get(sign, sign)
                return f"{left.name} {words} {_constant(right)}"
            inner = ", ".join([scope, *map(_constant, left.terms), "V"])
            return f"\\+ \\+ ({prefix}{left.predicate.name}({inner}), V {sign} {_constant(right)})"
        case Not(inner_condition):
            return f"\\+ ({prolog_goal(inner_condition, scope, prefix)})"
        case Every(given, then):
            return f"forall(({prolog_goal(given, scope, prefix)}), ({prolog_goal(then, scope, prefix)}))"
        case And(parts):
            return ", ".join(prolog_goal(p, scope, prefix) for p in parts)
        case Or(options):
            return "(" + " ; ".join(f"({prolog_goal(o, scope, prefix)})" for o in options) + ")"


SCALE = 1000  # clingo counts in integers


@dataclass
class _Clingo:
    """Writer of a clingo program: each rule of cramlite becomes one clingo rule and some helper rules."""

    scope: tuple[str, ...] = ()
    lines: list[str] = field(default_factory=list)
    helpers: Iterator[int] = field(default_factory=itertools.count)

    def add(self, rule: Rule) -> None:
        bound = frozenset().union(*(binds(c.condition) for c in rule.clauses))
        body = ", ".join(self.literal(c.condition, c.phase, bound) for c in rule.clauses)
        roles = ", ".join([quoted(rule.task), *rule.roles])
        scope = "".join(f"{name}, " for name in self.scope)
        self.lines.append(f"match{len(rule.roles)}({scope}{roles}) :- {self.domain(())}{body}.")

    def literal(self, condition: Condition, phase: PhaseName, outer: frozenset[str]) -> str:
        """Return a body literal that is true where the condition holds."""
        match condition:
            case Atom(predicate, terms):
                return f"fact({', '.join([*self.scope, phase, quoted(predicate.name), *map(term, terms)])})"
            case Compare(left, symbol, right):
                sign = {"==": "="}.get(symbol, symbol)
                if isinstance(left, Variable):
                    return f"{left.name} {sign} {term(right)}"
                value = f"Value{next(self.helpers)}"
                inner = [*self.scope, phase, quoted(left.predicate.name), *map(term, left.terms), value]
                return f"fact({', '.join(inner)}), {value} {sign} {term(right)}"
            case Not(inner):
                return f"not {self.helper([inner], phase, mentions(inner) & outer, outer)}"
            case Every(given, then):
                inside = outer | binds(given)
                kept = self.helper([then], phase, mentions(then) & inside, inside)
                broken = self.named(mentions(condition) & outer)
                domain = self.domain((mentions(condition) & outer) | (mentions(then) & inside))
                self.lines.append(f"{broken} :- {domain}{self.literal(given, phase, outer)}, not {kept}.")
                return f"not {broken}"
            case And(parts):
                return ", ".join(self.literal(p, phase, outer) for p in parts)
            case Or(options):
                return self.helper(options, phase, (mentions(condition) & outer) | binds(condition), outer)

    def named(self, variables: Iterable[str]) -> str:
        return f"helper{next(self.helpers)}({', '.join([*self.scope, *sorted(variables)]) or '0'})"

    def domain(self, variables: Iterable[str]) -> str:
        return "".join([*(f"act({a}), " for a in self.scope), *(f"thing({v}), " for v in sorted(variables))])

    def helper(
        self, options: Iterable[Condition], phase: PhaseName, variables: frozenset[str], outer: frozenset[str]
    ) -> str:
        """Define a helper predicate that holds if at least one of some conditions does, and return its literal."""
        name = self.named(variables)
        for option in options:
            self.lines.append(f"{name} :- {self.domain(variables)}{self.literal(option, phase, outer)}.")
        return name


def quoted(text: str) -> str:
    return '"' + text + '"'


def term(value: Term) -> str:
    if isinstance(value, Variable):
        return value.name
    return quoted(value) if isinstance(value, str) else str(round(value * SCALE))

"""All rules as one decision tree, so that what many rules ask is asked once for an action.

Rules are sorted cheapest condition first; rules that begin with the same conditions (whatever
their variables are called) share a path, and a condition that fails ends all rules below it.
``matching.match`` is the definition; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from operator import itemgetter

from .conditions import And, Atom, Binding, Compare, Condition, Every, Not, Or, Term, Variable, binds
from .phases import Phase, PhaseName
from .rules import Clause, Rule

Values = tuple[str | float, ...]
"""A binding: the values of the variables, in the order in which a path of the tree binds them."""

Step = Callable[[Phase, list[Values]], list[Values]]
Key = tuple[PhaseName, object]


@dataclass
class _Node:
    """One condition on the way to some rules."""

    phase: PhaseName
    step: Step
    below: dict[Key, _Node] = field(default_factory=dict)
    rules: list[tuple[Rule, dict[str, int]]] = field(default_factory=list)


class DecisionTree:
    """Finds all bindings of all rules for an action.

    Args:
        rules: from ``load_rules``.
    """

    def __init__(self, rules: Iterable[Rule]) -> None:
        self._root = _Node("pre", lambda _phase, bindings: bindings)
        for rule in rules:
            self._add(rule)

    def solve(self, phases: Mapping[PhaseName, Phase]) -> dict[str, list[Binding]]:
        """Task -> the bindings under which all its conditions hold, for each rule that has any."""
        found: dict[str, list[Binding]] = {}
        todo: list[tuple[_Node, list[Values]]] = [(self._root, [()])]
        while todo:
            node, bindings = todo.pop()
            for rule, slots in node.rules:
                found[rule.task] = [{name: b[k] for name, k in slots.items()} for b in bindings]
            for child in node.below.values():
                left = child.step(phases[child.phase], bindings)
                if left:
                    todo.append((child, left))
        return found

    def _add(self, rule: Rule) -> None:
        node, slots = self._root, dict[str, int]()
        for clause in rule.quick_order:
            seen = dict(slots)
            key = (clause.phase, _canonical(clause.condition, seen))
            new = _new_variables(clause, slots, seen)
            child = node.below.get(key)
            if child is None:
                child = node.below[key] = _Node(clause.phase, _step(clause.condition, dict(slots), new))
            slots |= {name: len(slots) + k for k, name in enumerate(new)}
            node = child
        node.rules.append((rule, slots))


def _new_variables(clause: Clause, slots: Mapping[str, int], seen: Mapping[str, int]) -> list[str]:
    """The variables that a condition binds for the first time, as they appear; ``seen`` is in that order."""
    names = binds(clause.condition) - set(slots)
    return [n for n in seen if n in names] + sorted(names - set(seen))


def _canonical(condition: Condition, slots: dict[str, int]) -> object:
    """The condition without names of variables; ``slots`` grows by each new one."""

    def term(t: Term) -> object:
        if not isinstance(t, Variable):
            return ("constant", t)
        return "_" if t.name == "_" else slots.setdefault(t.name, len(slots))

    match condition:
        case Atom(predicate, terms):
            return (predicate.name, *map(term, terms))
        case Compare(left, symbol, right):
            shown = term(left) if isinstance(left, Variable) else _canonical(left, slots)
            return ("compare", shown, symbol, term(right))
        case Not(inner):
            return ("not", _canonical(inner, slots))
        case Every(given, then):
            return ("every", _canonical(given, slots), _canonical(then, slots))
        case And(parts):
            return ("and", *(_canonical(p, slots) for p in parts))
        case Or(options):  # its branches bind by name: rules share it only under equal names
            return ("or", tuple(sorted(slots.items())), options)


def _step(condition: Condition, slots: dict[str, int], new: list[str]) -> Step:
    if isinstance(condition, Atom):
        return _atom_step(condition, slots)
    if isinstance(condition, Not) and isinstance(condition.inner, Atom) and _plain(condition.inner, slots):
        arguments, predicate = _arguments(condition.inner, slots), condition.inner.predicate
        return lambda phase, bindings: [b for b in bindings if not phase.rows(predicate, arguments(b))]

    def general(phase: Phase, bindings: list[Values]) -> list[Values]:
        return list(_general(condition, phase, bindings, slots, new))

    return general


def _general(
    condition: Condition, phase: Phase, bindings: list[Values], slots: dict[str, int], new: list[str]
) -> Iterator[Values]:
    for b in bindings:
        named: Binding = {name: b[k] for name, k in slots.items()}
        for found in condition.solve(phase, named):
            yield b + tuple(found[name] for name in new)


def _plain(atom: Atom, slots: dict[str, int]) -> bool:
    """No unbound variable is written twice: then any row will do."""
    local = [t.name for t in atom.terms if isinstance(t, Variable) and t.name != "_" and t.name not in slots]
    return len(local) == len(set(local))


def _arguments(atom: Atom, slots: dict[str, int]) -> Callable[[Values], tuple[str | float | None, ...]]:
    """What the predicate is asked with: constants, bound values, and None for the rest."""
    places = [slots.get(t.name) if isinstance(t, Variable) else None for t in atom.terms]
    fixed = tuple(None if isinstance(t, Variable) else t for t in atom.terms)
    if all(place is None for place in places):
        return lambda _values: fixed
    plan = list(zip(places, fixed, strict=True))
    return lambda values: tuple([value if place is None else values[place] for place, value in plan])


def _atom_step(atom: Atom, slots: dict[str, int]) -> Step:
    predicate, arguments = atom.predicate, _arguments(atom, slots)
    names = [t.name if isinstance(t, Variable) and t.name != "_" and t.name not in slots else None for t in atom.terms]
    first = [k for k, name in enumerate(names) if name is not None and names.index(name) == k]
    equal = [(names.index(name), k) for k, name in enumerate(names) if name is not None and names.index(name) != k]
    if not first:
        return lambda phase, bindings: [b for b in bindings if phase.rows(predicate, arguments(b))]
    pick = itemgetter(*first) if len(first) > 1 else itemgetter(slice(first[0], first[0] + 1))

    def step(phase: Phase, bindings: list[Values]) -> list[Values]:
        return [
            b + pick(row)
            for b in bindings
            for row in phase.rows(predicate, arguments(b))
            if not equal or all(row[i] == row[k] for i, k in equal)
        ]

    return step

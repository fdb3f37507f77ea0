"""Rule conditions compiled to joins: one step extends the variable bindings of all actions at once.

A binding is a tuple: the number of its action, then the values of its variables in the order in which they
were bound. A step only ever appends to it, so a binding is known again by the beginning of what became of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from typing import Any

from .conditions import And, Atom, Binding, Condition, Every, Not, Or, Variable, binds
from .timeline import Phase, Row

Values = tuple[Any, ...]
"""Variable bindings of one action, as a tuple: the action's number, then the values of the variables."""

Step = Callable[[Sequence[Phase], list[Values]], list[Values]]
Slots = Mapping[str, int]
"""Variable -> its place in a binding; places begin at 1."""
Rows = Callable[[Sequence[Phase], list[Values]], list[tuple[Values, tuple[Row, ...]]]]


def compile_step(condition: Condition, slots: Slots, new: list[str]) -> Step:
    """Compile a condition to a function that extends bindings by values of ``new`` variables with which the condition holds."""
    match condition:
        case Atom():
            return _atom(condition, slots, new)
        case Not(inner):
            return _not(inner, slots)
        case Every(given, then):
            return _every(given, then, slots)
        case And(parts):
            return _and(parts, slots, new)
        case Or(options) if all(set(_unbound(o, slots)) == set(new) for o in options):
            return _or(options, slots, new)
        case _:
            return _plain(condition, slots, new)


def _unbound(condition: Condition, slots: Slots) -> list[str]:
    return sorted(binds(condition) - set(slots))


def _extended(slots: Slots, names: list[str]) -> dict[str, int]:
    return {**slots, **{name: len(slots) + 1 + k for k, name in enumerate(names)}}


def _plain(condition: Condition, slots: Slots, new: list[str]) -> Step:
    """Compile a comparison, or an 'or' whose options bind different variables, to a step that evaluates it
    one binding at a time."""

    def step(phases: Sequence[Phase], bindings: list[Values]) -> list[Values]:
        extended = []
        for b in bindings:
            named: Binding = {name: b[k] for name, k in slots.items()}
            found = condition.solve(phases[b[0]], named)
            extended += [(*b, *(f[name] for name in new)) for f in found]
        return extended

    return step


def _not(inner: Condition, slots: Slots) -> Step:
    holds, size = compile_step(inner, slots, _unbound(inner, slots)), len(slots) + 1

    def step(phases: Sequence[Phase], bindings: list[Values]) -> list[Values]:
        refuted = {f[:size] for f in holds(phases, bindings)}
        return [b for b in bindings if b not in refuted] if refuted else bindings

    return step


def _every(given: Condition, then: Condition, slots: Slots) -> Step:
    local, size = _unbound(given, slots), len(slots) + 1
    inside = _extended(slots, local)
    cases, holds = compile_step(given, slots, local), compile_step(then, inside, _unbound(then, inside))

    def step(phases: Sequence[Phase], bindings: list[Values]) -> list[Values]:
        asked = cases(phases, bindings)
        kept = {f[: len(inside) + 1] for f in holds(phases, asked)}
        refuted = {case[:size] for case in asked if case not in kept}
        return [b for b in bindings if b not in refuted]

    return step


def _and(parts: tuple[Condition, ...], slots: Slots, new: list[str]) -> Step:
    steps: list[Step] = []
    inside = dict(slots)
    for part in parts:
        local = _unbound(part, inside)
        steps.append(compile_step(part, inside, local))
        inside = _extended(inside, local)
    kept = [*range(len(slots) + 1), *(inside[name] for name in new)]

    def step(phases: Sequence[Phase], bindings: list[Values]) -> list[Values]:
        for one in steps:
            bindings = one(phases, bindings) if bindings else bindings
        return [tuple([b[k] for k in kept]) for b in bindings]

    return step


def _or(options: tuple[Condition, ...], slots: Slots, new: list[str]) -> Step:
    steps, size = [compile_step(o, slots, new) for o in options], len(slots) + 1

    def step(phases: Sequence[Phase], bindings: list[Values]) -> list[Values]:
        groups: dict[Values, dict[Values, None]] = {b: {} for b in bindings}
        for one in steps:
            for found in one(phases, bindings):
                groups[found[:size]][found] = None
        return [found for group in groups.values() for found in group]

    return step


def _atom(atom: Atom, slots: Slots, new: list[str]) -> Step:
    names = [t.name if isinstance(t, Variable) and t.name != "_" and t.name not in slots else None for t in atom.terms]
    equal = [(names.index(name), k) for k, name in enumerate(names) if name is not None and names.index(name) != k]
    first = [names.index(name) for name in new]
    rows = _indexed(atom, slots) if atom.predicate.complete else _asked(atom, slots)
    if equal:
        return lambda phases, bindings: [
            b + tuple([row[k] for k in first])
            for b, found in rows(phases, bindings)
            for row in found
            if all(row[i] == row[k] for i, k in equal)
        ]
    if not first:
        return lambda phases, bindings: [b for b, _ in rows(phases, bindings)]
    pick = _picker(first)
    return lambda phases, bindings: [b + pick(row) for b, found in rows(phases, bindings) for row in found]


def _picker(places: list[int]) -> Callable[[Values], Values]:
    """Return a function that picks the values at some indices of a tuple, as a tuple."""
    if not places:
        return lambda _values: ()
    return itemgetter(*places) if len(places) > 1 else itemgetter(slice(places[0], places[0] + 1))


def _arguments(atom: Atom, slots: Slots, places: Sequence[int]) -> Callable[[Values], tuple[Any, ...]]:
    """Return a function from a binding's values to some of an atom's arguments: constants, bound values, None for
    unbound variables."""
    terms = [atom.terms[k] for k in places]
    sources = [slots.get(t.name) if isinstance(t, Variable) else None for t in terms]
    fixed = tuple([None if isinstance(t, Variable) else t for t in terms])
    if all(source is None for source in sources):
        return lambda _values: fixed
    bound = [source for source in sources if source is not None]
    if len(bound) == len(sources):
        return _picker(bound)
    plan = list(zip(sources, fixed, strict=True))
    return lambda values: tuple([value if source is None else values[source] for source, value in plan])


def _asked(atom: Atom, slots: Slots) -> Rows:
    """Return a function that evaluates a predicate: for each binding of variables, it returns the argument values for which the
    predicate holds.

    It pairs each binding with its rows, and drops bindings without any.
    """
    predicate, arguments = atom.predicate, _arguments(atom, slots, range(len(atom.terms)))

    def rows(phases: Sequence[Phase], bindings: list[Values]) -> list[tuple[Values, tuple[Row, ...]]]:
        found = [(b, phases[b[0]].rows(predicate, arguments(b))) for b in bindings]
        return [pair for pair in found if pair[1]]

    return rows


def _indexed(atom: Atom, slots: Slots) -> Rows:
    """Return a function that finds, in an index, the argument tuples for which a predicate holds and that agree with
    each binding.

    It pairs each binding with its rows, and drops bindings without any.
    """
    predicate = atom.predicate
    places = tuple(k for k, t in enumerate(atom.terms) if not isinstance(t, Variable) or t.name in slots)
    key = _arguments(atom, slots, places)

    def rows(phases: Sequence[Phase], bindings: list[Values]) -> list[tuple[Values, tuple[Row, ...]]]:
        extended = []
        for b in bindings:
            index = phases[b[0]].index(predicate, places)
            found = index.get(key(b)) if index else None
            if found:
                extended.append((b, found))
        return extended

    return rows

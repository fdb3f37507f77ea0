"""All rules as one decision tree, so that what many rules ask is asked once for an action.

Rules are sorted cheapest condition first; rules that begin with the same conditions (whatever
their variables are called) share a path, and a condition that fails ends all rules below it.
``matching.match`` is the definition; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from .conditions import And, Atom, Binding, Compare, Condition, Every, Not, Or, Term, Variable, binds
from .phases import Phase, PhaseName, Timeline
from .rules import Clause, Rule
from .steps import Step, Values, compile_step

_PHASES: tuple[PhaseName, ...] = ("pre", "run", "post")
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
        timeline: the episode; rules that nothing in it can fulfil are left out.
    """

    def __init__(self, rules: Iterable[Rule], timeline: Timeline | None = None) -> None:
        self._root = _Node("pre", lambda _phase, bindings: bindings)
        for rule in rules:
            if timeline is None or all(_possible(c.condition, timeline) for c in rule.clauses):
                self._add(rule)

    def solve(self, phases: Mapping[PhaseName, Phase]) -> dict[str, list[Binding]]:
        """Task -> the bindings under which all its conditions hold, for each rule that has any."""
        return self.solve_all([phases])[0]

    def solve_all(self, phases: Sequence[Mapping[PhaseName, Phase]]) -> list[dict[str, list[Binding]]]:
        """The same for many actions: each condition is asked of all those that are left at once."""
        found: list[dict[str, list[Binding]]] = [{} for _ in phases]
        columns: dict[PhaseName, list[Phase]] = {name: [p[name] for p in phases] for name in _PHASES}
        todo: list[tuple[_Node, list[Values]]] = [(self._root, [(k,) for k in range(len(phases))])]
        while todo:
            node, bindings = todo.pop()
            for rule, slots in node.rules:
                for b in bindings:
                    found[b[0]].setdefault(rule.task, []).append({name: b[k] for name, k in slots.items()})
            for child in node.below.values():
                left = child.step(columns[child.phase], bindings)
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
                child = node.below[key] = _Node(clause.phase, compile_step(clause.condition, dict(slots), new))
            slots |= {name: len(slots) + 1 + k for k, name in enumerate(new)}
            node = child
        node.rules.append((rule, slots))


def _possible(condition: Condition, timeline: Timeline) -> bool:
    """Whether a condition can hold at some time of the episode; cautious: True unless it surely cannot."""
    match condition:
        case Atom(predicate, terms):
            if predicate.timeless:
                fixed = tuple(None if isinstance(t, Variable) else t for t in terms)
                return bool(timeline.instant(timeline.cuts[0]).rows(predicate, fixed))
            return predicate.possible is None or predicate.possible(timeline)
        case And(parts):
            return all(_possible(p, timeline) for p in parts)
        case Or(options):
            return any(_possible(o, timeline) for o in options)
        case _:
            return True


def _new_variables(clause: Clause, slots: Mapping[str, int], seen: Mapping[str, int]) -> list[str]:
    """The variables that a condition binds for the first time, as they appear; ``seen`` is in that order."""
    names = binds(clause.condition) - set(slots)
    return [n for n in seen if n in names] + sorted(names - set(seen))


def _canonical(condition: Condition, slots: dict[str, int]) -> object:
    """The condition without names of variables; ``slots`` grows by each new one."""

    def term(t: Term) -> object:
        if not isinstance(t, Variable):
            return ("constant", t)
        return "_" if t.name == "_" else slots.setdefault(t.name, len(slots) + 1)

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

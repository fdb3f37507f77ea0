"""Decision tree of all rules: a condition that several rules share is checked once for an action.

Rules ask first what the states of an episode decide, cheapest condition first, and then what must be measured.
Rules that begin with the same conditions (whatever their variables are called) share a path, and a condition that
fails ends all rules below it. What states decide is asked once for all actions before, during and after which the
same states hold. What a rule alone gives is the definition
(tests/helpers/plain_matcher.py); a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from itertools import groupby
from operator import itemgetter

from msgspec import Struct, field
from msgspec.structs import replace

from .compiled_conditions import Step, Values, compile_step
from .conditions import And, Atom, Binding, Compare, Condition, Every, Not, Or, Term, Variable, binds
from .rules import Clause, Rule
from .timeline import Phase, PhaseName, Timeline

_PHASES: tuple[PhaseName, ...] = ("pre", "run", "post")
Key = tuple[PhaseName, object]


class _Node(Struct):
    """Node of the decision tree: a condition, the rules that end with it, and the nodes of the conditions
    after it."""

    phase: PhaseName
    step: Step
    lasting: bool
    below: dict[Key, _Node] = field(default_factory=dict)
    rules: list[tuple[Rule, dict[str, int]]] = field(default_factory=list)


BindingsByTask = dict[str, list[Binding]]
"""Task -> the bindings under which all its conditions hold, for each rule that has any."""


class _Settled(Struct):
    """Result for an action after its conditions on states: the tasks found, and the nodes of the decision
    tree that are still to be checked, with their bindings."""

    found: BindingsByTask = field(default_factory=dict)
    left: list[tuple[_Node, list[Values]]] = field(default_factory=list)


class DecisionTree:
    """Decision tree that matches all rules at once with the actions of one episode.

    Args:
        rules: from ``load_rules``.
        timeline: the episode; rules that nothing in it can fulfil are left out.
    """

    def __init__(self, rules: Iterable[Rule], timeline: Timeline) -> None:
        self._root = _Node("pre", lambda _phase, bindings: bindings, lasting=True)
        self._settled: dict[Hashable, _Settled] = {}
        for rule in rules:
            if all(_possible(c.condition, timeline) for c in rule.clauses):
                self._add(rule, timeline)

    def solve(self, phases: Mapping[PhaseName, Phase]) -> BindingsByTask:
        """Return the tasks of an action, each with the bindings under which all its conditions hold."""
        return self.solve_all([phases])[0]

    def solve_all(self, phases: Sequence[Mapping[PhaseName, Phase]]) -> list[BindingsByTask]:
        """Return for each of many actions the tasks that it may be; each condition is checked in one step
        for all actions that need it."""
        settled = self._settle_all(phases)
        found = [dict(s.found) for s in settled]
        waiting: dict[int, tuple[_Node, list[Values]]] = {}
        for k, one in enumerate(settled):
            for node, bindings in one.left:
                waiting.setdefault(id(node), (node, []))[1].extend([(k, *b[1:]) for b in bindings])
        columns = _columns(phases)
        todo = [(node, node.step(columns[node.phase], bindings)) for node, bindings in waiting.values()]
        while todo:
            node, bindings = todo.pop()
            _report(node, bindings, found)
            for child in node.below.values():
                left = child.step(columns[child.phase], bindings)
                if left:
                    todo.append((child, left))
        return found

    def _settle_all(self, phases: Sequence[Mapping[PhaseName, Phase]]) -> list[_Settled]:
        """Return for each action what conditions on states decide: tasks that match, and nodes of the
        decision tree that are still to be checked."""
        known = self._settled
        keys = [(p["pre"].holds, p["run"].holds, p["post"].holds) for p in phases]
        new = {key: p for key, p in zip(keys, phases, strict=True) if key not in known}
        for key, settled in zip(new, self._settle(list(new.values())), strict=True):
            known[key] = settled
        return [known[key] for key in keys]

    def _settle(self, phases: Sequence[Mapping[PhaseName, Phase]]) -> list[_Settled]:
        settled = [_Settled() for _ in phases]
        found = [s.found for s in settled]
        columns = _columns(phases)
        todo: list[tuple[_Node, list[Values]]] = [(self._root, [(k,) for k in range(len(phases))])]
        while todo:
            node, bindings = todo.pop()
            _report(node, bindings, found)
            for child in node.below.values():
                if child.lasting:
                    left = child.step(columns[child.phase], bindings)
                    if left:
                        todo.append((child, left))
                else:
                    for k, own in groupby(bindings, itemgetter(0)):
                        settled[k].left.append((child, list(own)))
        return settled

    def _add(self, rule: Rule, timeline: Timeline) -> None:
        node, slots = self._root, dict[str, int]()
        for clause in (replace(c, condition=_pruned(c.condition, timeline)) for c in rule.quick_order):
            seen = dict(slots)
            key = (clause.phase, _canonical(clause.condition, seen))
            new = _new_variables(clause, slots, seen)
            child = node.below.get(key)
            if child is None:
                child = node.below[key] = self._node(clause, slots, new)
            slots |= {name: len(slots) + 1 + k for k, name in enumerate(new)}
            node = child
        node.rules.append((rule, slots))

    @staticmethod
    def _node(clause: Clause, slots: Mapping[str, int], new: list[str]) -> _Node:
        return _Node(clause.phase, compile_step(clause.condition, dict(slots), new), clause.lasting)


def _columns(phases: Sequence[Mapping[PhaseName, Phase]]) -> dict[PhaseName, list[Phase]]:
    return {name: [p[name] for p in phases] for name in _PHASES}


def _report(node: _Node, bindings: list[Values], found: list[BindingsByTask]) -> None:
    """Add to the result of each action the bindings of all rules that are fulfilled at a node of the decision tree."""
    for rule, slots in node.rules:
        for b in bindings:
            found[b[0]].setdefault(rule.task, []).append({name: b[k] for name, k in slots.items()})


def _possible(condition: Condition, timeline: Timeline) -> bool:
    """Check whether a condition may hold at some time of the episode; False only if it certainly cannot."""
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


def _pruned(condition: Condition, timeline: Timeline) -> Condition:
    """Return the condition without those options of an 'or' that cannot hold, if all options bind the same
    variables."""
    if not isinstance(condition, Or) or any(binds(o) != binds(condition) for o in condition.options):
        return condition
    left = tuple(o for o in condition.options if _possible(o, timeline))
    return left[0] if len(left) == 1 else Or(left)


def _new_variables(clause: Clause, slots: Mapping[str, int], seen: Mapping[str, int]) -> list[str]:
    """Return the variables that a condition binds and that were not numbered yet, in a fixed order.

    Those of ``seen`` come first, in its order, then the others by name.
    """
    names = binds(clause.condition) - set(slots)
    return [n for n in seen if n in names] + sorted(names - set(seen))


def _canonical(condition: Condition, slots: dict[str, int]) -> object:
    """Return the condition with its variables replaced by numbers, so that renamed copies are equal;
    ``slots`` gets each new variable."""

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

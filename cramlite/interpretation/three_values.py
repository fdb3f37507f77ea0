"""Three-valued conditions: true, false or unknown, by Kleene's strong logic.

Closed world is right where a recorder would have seen what it did not record. Where it could not (no pose, no shape, no
finger) a condition is not known. What a recording itself names an action is then believed, and what is not known is said.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..base.value import Value
from .conditions import And, Atom, Binding, Compare, Condition, Every, Not, Or, tests
from .matching import Match, Phases, match_of
from .rules import Clause, Rule
from .timeline import Phase


class Truth(Value):
    """Assignment of entities to the variables of a condition, under which the condition is true or unknown.

    Args:
        binding: variable -> entity.
        unknown: why it is not known to be true; empty where it is.
    """

    binding: Binding
    unknown: tuple[str, ...] = ()


def evaluate(condition: Condition, phase: Phase, binding: Binding) -> Iterator[Truth]:
    """Yield the bindings under which a condition is true; if there are none, those under which it is
    unknown."""
    match condition:
        case Atom():
            yield from _or_unknown(condition, phase, binding, [Truth(b) for b in condition.solve(phase, binding)])
        case Compare(left):
            found = [Truth(b) for b in condition.solve(phase, binding)]
            told = isinstance(left, Atom) and not found and not condition.values(phase, binding)
            yield from _or_unknown(left, phase, binding, found) if told and isinstance(left, Atom) else iter(found)
        case Not(inner):
            yield from _negated(list(evaluate(inner, phase, binding)), binding)
        case Every(given, then):
            yield from _every([(j, list(evaluate(then, phase, j.binding))) for j in evaluate(given, phase, binding)], binding)
        case Or(options):
            found = [j for option in options for j in evaluate(option, phase, binding)]
            yield from [j for j in found if not j.unknown] or _by_binding(found)
        case And(parts):
            yield from _all(parts, phase, binding)


def _or_unknown(atom: Atom, phase: Phase, binding: Binding, found: list[Truth]) -> Iterator[Truth]:
    if found or atom.predicate.unknown is None:
        yield from found
        return
    reason = atom.predicate.unknown(phase, *atom.arguments(binding))
    if reason is not None:
        yield Truth(binding, (reason,))


def _by_binding(found: list[Truth]) -> list[Truth]:
    """Merge the truth values of a condition that have equal variable bindings into one, which lists the unknown
    conditions of all."""
    groups: dict[str, list[Truth]] = {}
    for one in found:
        groups.setdefault(str(sorted(one.binding.items())), []).append(one)
    return [Truth(group[0].binding, _together(group)) for group in groups.values()]


def _negated(found: list[Truth], binding: Binding) -> Iterator[Truth]:
    if all(j.unknown for j in found):
        yield Truth(binding, _together(found))


def _every(cases: list[tuple[Truth, list[Truth]]], binding: Binding) -> Iterator[Truth]:
    if all(then or given.unknown for given, then in cases):
        open_ = [j for given, then in cases for j in (given, *then) if not any(not t.unknown for t in then)]
        yield Truth(binding, _together(open_))


def _all(parts: tuple[Condition, ...], phase: Phase, binding: Binding) -> Iterator[Truth]:
    first, *rest = parts
    for one in evaluate(first, phase, binding):
        if not rest:
            yield one
            continue
        for other in _all(tuple(rest), phase, one.binding):
            yield Truth(other.binding, _together([one, other]))


def _together(found: Iterable[Truth]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(u for j in found for u in j.unknown))


def _binding_first(rule: Rule) -> list[Clause]:
    """Sort a rule's conditions for evaluation: those that bind variables first, and of each group those on states before those on motion.

    A condition whose truth is unknown binds no variable.
    """
    return sorted(rule.clauses, key=lambda c: (bool(tests(c.condition)), not c.lasting, c.cost))


def possible_matches(rule: Rule, phases: Phases, said: Iterable[Binding]) -> tuple[Match, ...]:
    """Return the matches of a rule that no condition refutes and that have the fewest unknown conditions.

    Args:
        said: what the recording itself says of the roles, the most said first; the first that is not refuted counts.
    """
    for start in said:
        judged = [Truth(start)]
        for clause in _binding_first(rule):
            judged = [
                Truth(found.binding, _together([one, found]))
                for one in judged
                for found in evaluate(clause.condition, phases[clause.phase], one.binding)
            ]
        judged = [j for j in judged if not j.unknown or _holds(rule, phases, j.binding)]
        if judged:
            least = min(len(j.unknown) for j in judged)
            kept = {str([j.binding.get(r) for r in rule.roles]): j for j in reversed(judged) if len(j.unknown) == least}
            return tuple(match_of(rule, kept[k].binding, kept[k].unknown) for k in sorted(kept))
    return ()


def _holds(rule: Rule, phases: Phases, binding: Binding) -> bool:
    """Check whether no condition of a rule is false under a complete binding of its roles."""
    return all(any(True for _ in evaluate(c.condition, phases[c.phase], binding)) for c in rule.clauses)

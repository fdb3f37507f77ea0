"""Matches and rejections of a rule for an action: the fillers of its roles, or the condition that failed."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from ..base.value import Value
from .conditions import Atom, Binding, Compare, Not, atoms, comparisons
from .rules import Clause, Rule
from .timeline import Phase, PhaseName

Phases = Mapping[PhaseName, Phase]

LISTED = 8
"""Largest number of facts and of candidate entities that a rejection lists."""

_WHEN: dict[PhaseName, str] = {"pre": "just before it", "run": "while it lasts", "post": "just after it"}


class Match(Value):
    """Recognition of an action as a task.

    Args:
        task: class of the task.
        roles: role -> entity; without those that nobody knows the filler of.
        explanation: one sentence.
        conditions: how many conditions held.
        changes: how many relations began or ended by it, as its rule says.
        unknown: why conditions could not be judged, e.g. "no pose of 'cup'"; the recording itself says that it was this task.
        counted: of how many conditions a number was measured while the action lasted, such as swings.
    """

    task: str
    roles: dict[str, str]
    explanation: str
    conditions: int = 0
    changes: int = 0
    unknown: tuple[str, ...] = ()
    counted: int = 0


class Rejection(Value):
    """Explanation of why an action is not a task.

    Args:
        task: class of the task.
        phase: where the condition is asked.
        condition: the first one, in the order written, that no binding survived.
        binding: the fullest binding that got so far.
        candidates: all bindings that got so far (the first few).
        facts: what was known instead, e.g. "supports(table, box)" (the first few).
        sentence: all this for people.
        where: file and line of the condition.
    """

    task: str
    phase: PhaseName
    condition: str
    binding: dict[str, str | float]
    candidates: tuple[dict[str, str | float], ...]
    facts: tuple[str, ...]
    sentence: str
    where: str


def matches_of(rule: Rule, bindings: list[Binding]) -> tuple[Match, ...]:
    """Return the matches of a rule: one for each distinct assignment of things to its roles."""
    first: dict[tuple[str | float, ...], Binding] = {}
    for binding in bindings:
        first.setdefault(tuple([binding[role] for role in rule.roles]), binding)
    return tuple(match_of(rule, first[fillers]) for fillers in sorted(first, key=str))


def match_of(rule: Rule, binding: Binding, unknown: tuple[str, ...] = ()) -> Match:
    """Return the match of a rule under a binding of its variables; a role without a value has no known
    filler."""
    roles = {role: str(binding[role]) for role in rule.roles if role in binding}
    shown = defaultdict(lambda: "something", {k: _shown(v) for k, v in binding.items()})
    explanation = rule.explain.format_map(shown)
    return Match(rule.task, roles, explanation, rule.conditions - len(unknown), rule.changes, unknown, rule.counted)


def measured(rule: Rule, roles: Mapping[str, str], phases: Phases) -> dict[str, float]:
    """Return the largest measured value of each predicate that a rule compares with a number, for given role fillers.

    Units are those of the predicate's sentence.
    """
    found: dict[str, float] = {}
    for clause in rule.clauses:
        for compare in comparisons(clause.condition):
            if isinstance(compare.left, Atom):
                values = [v for v in compare.values(phases[clause.phase], dict(roles)) if not isinstance(v, str)]
                found |= {compare.left.predicate.name: max(values)} if values else {}
    return found


def reject(rule: Rule, phases: Phases) -> Rejection | None:
    """Return why an action is not the rule's task: the first condition that failed; None if the action is the
    task."""
    bindings: list[Binding] = [{}]
    for clause in rule.written_order:
        phase = phases[clause.phase]
        found = [f for binding in bindings for f in clause.condition.solve(phase, binding)]
        if not found:
            return _rejection(rule, clause, phase, bindings)
        bindings = found
    return None


def _rejection(rule: Rule, clause: Clause, phase: Phase, bindings: list[Binding]) -> Rejection:
    fullest = max(bindings, key=len)
    facts = _facts(clause, phase, bindings)
    when = f"{_WHEN[clause.phase]} ({_time(phase)})"
    known = ", ".join(f"{k} = {_shown(v)}" for k, v in sorted(fullest.items()))
    others = f" (nor for {len(bindings) - 1} other choices of these things)" if len(bindings) > 1 else ""
    with_ = f" for {known}{others}" if known else ""
    seen = f"; known is: {', '.join(facts)}" if facts else "; nothing of the kind is known"
    sentence = f"not {rule.task}: {when}, '{clause.text}' does not hold{with_}{seen}."
    distinct: dict[str, Binding] = {str(sorted(b.items())): b for b in bindings}
    return Rejection(
        rule.task,
        clause.phase,
        clause.text,
        dict(fullest),
        tuple(distinct.values())[:LISTED],
        facts,
        sentence,
        f"{rule.path}:{clause.line}",
    )


def _facts(clause: Clause, phase: Phase, bindings: list[Binding]) -> tuple[str, ...]:
    """Return known facts that show why a condition failed.

    For a denial these are the facts that it denies, for a comparison the values that it compares, else all
    facts of its predicates, unless too costly to list.
    """
    found: dict[str, None] = {}
    for atom in atoms(clause.condition):
        narrow = isinstance(clause.condition, (Not, Compare)) or _wide(atom)
        for binding in bindings[:LISTED] if narrow else [{}]:
            for row in phase.rows(atom.predicate, atom.arguments(binding)):
                found[_fact(atom, row)] = None
            if len(found) >= LISTED:
                break
    return tuple(list(found)[:LISTED])


def _wide(atom: Atom) -> bool:
    """Check whether a predicate is so costly that an explanation should not list all facts with it."""
    return atom.predicate.cost > 1


def _fact(atom: Atom, row: tuple[str | float, ...]) -> str:
    shown = [_shown(v) for v in row]
    if atom.predicate.value:
        return f"{atom.predicate.name}({', '.join(shown[:-1])}) = {shown[-1]}"
    return f"{atom.predicate.name}({', '.join(shown)})"


def _shown(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _time(phase: Phase) -> str:
    return f"{phase.start:.2f} s" if phase.start == phase.end else f"{phase.start:.2f} to {phase.end:.2f} s"

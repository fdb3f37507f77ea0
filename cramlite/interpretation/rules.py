"""Rules: conditions under which an action is interpreted as a task. Loaded from ``task_rules/*.yaml``.

A file holds one task type. A variable named like a role IS that role's filler::

    task: soma:PickingUp
    roles: {Locatum: soma:LocatumRole, Relatum: soma:RelatumRole}
    source: where the conditions come from
    pre: [...]   run: [...]   post: [...]     what holds just before, all through, just after the action
    needs: [...]   leaves: [...]              what a robot's program asks for before, and leaves, beyond what is seen
    explain: "{Locatum} is lifted off {Relatum}"
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any

from ..base.errors import UserError, nearest
from ..base.resources import data_folder
from ..base.value import Value
from ..base.yaml_file import line_of, load_yaml
from ..ontology.foundation import ROLE, TASK
from ..ontology.taxonomy import Taxonomy
from .condition_parser import ConditionError, parse_condition
from .conditions import Atom, Condition, Every, Not, atoms, binds, comparisons, mentions, tests
from .timeline import Phase, PhaseName, Predicate

__all__ = ["PHASES", "Clause", "Phase", "Predicate", "Rule", "RuleBook", "load_rules"]

PHASES: tuple[PhaseName, ...] = ("pre", "run", "post")
_KEYS = ("task", "roles", "source", "pre", "run", "post", "needs", "leaves", "explain")
_OF_PROGRAMS: dict[str, PhaseName] = {"needs": "pre", "leaves": "post"}
"""Keys of the conditions that apply to programs but not to demonstrations -> the phase in which they hold."""


class Clause(Value, dict=True):
    """Condition of a rule, with the phase in which it is checked, its text, and its line in the rule file.

    Args:
        phase: in which it is asked: "pre", "run" or "post".
        condition: parsed.
        text: as it was written.
        line: of the rule file, from 1.
    """

    phase: PhaseName
    condition: Condition
    text: str
    line: int

    @cached_property
    def cost(self) -> int:
        """Rough cost of checking the clause: the sum of its predicates' costs."""
        return sum(a.predicate.cost for a in atoms(self.condition))

    @cached_property
    def lasting(self) -> bool:
        """Whether the clause asks about states and classes only, so that equal states give equal
        solutions."""
        return all(a.predicate.steady or a.predicate.timeless for a in atoms(self.condition))


class Rule(Value, dict=True):
    """Rule by which an action is recognised as a task.

    Args:
        task: class of the task.
        roles: role and variable name -> class of the role.
        clauses: in the order written.
        explain: sentence with ``{Variable}`` placeholders.
        source: where the conditions come from.
        path: the file.
        planned: conditions that only planning asks: what the program of a task needs before and leaves behind, beyond what
            a demonstration shows.
    """

    task: str
    roles: dict[str, str]
    clauses: tuple[Clause, ...]
    explain: str
    source: str
    path: Path
    planned: tuple[Clause, ...] = ()

    @cached_property
    def written_order(self) -> tuple[Clause, ...]:
        """Clauses as near to the written order as possible, with variables bound before they are tested: for
        reports."""
        return _ordered(self.clauses, cheapest=False)

    @cached_property
    def quick_order(self) -> tuple[Clause, ...]:
        """Clauses in the order of evaluation: variables are bound before they are tested, conditions on
        states come first, cheap ones first."""
        return _ordered(self.clauses, cheapest=True)

    @cached_property
    def changes(self) -> int:
        """Number of relations that the rule requires to begin or end: true before the action and false after
        it, or the reverse."""
        said = {(phase, denied): _asserted(self.clauses, phase, denied) for phase in ("pre", "post") for denied in (True, False)}
        return len((said["pre", True] & said["post", False]) | (said["pre", False] & said["post", True]))

    @property
    def shipped(self) -> bool:
        """Whether the rule came with cramlite, rather than with a plugin of a user's own."""
        return self.path.is_relative_to(data_folder("task_rules"))

    @property
    def conditions(self) -> int:
        """Number of the rule's conditions; more conditions make a rule more specific."""
        return len(self.clauses)

    @cached_property
    def counted(self) -> int:
        """Number of conditions that compare a number that is measured during the action."""
        return sum(c.phase == "run" and any(comparisons(c.condition)) for c in self.clauses)


def _asserted(clauses: Iterable[Clause], phase: str, denied: bool) -> set[str]:
    """Return the predicates that a rule's conditions of one phase require or, if ``denied``, those that they negate
    or restrict by ``every``."""
    found: set[str] = set()
    for clause in clauses:
        if clause.phase == phase and isinstance(clause.condition, Not | Every) == denied:
            asked = clause.condition.given if isinstance(clause.condition, Every) else clause.condition
            found |= {a.predicate.name for a in atoms(asked)}
    return found


ALIKE = 0.8
"""Smallest similarity (difflib's ratio, 1 for equal names) at which one name counts as a misspelling of the other."""
RuleBook = tuple[Rule, ...]
"""The rules of all task types, sorted by task."""


def load_rules(paths: Iterable[Path | str], predicates: Iterable[Predicate], taxonomy: Taxonomy) -> RuleBook:
    """Load the rules of some files (a folder stands for the .yaml files in it), sorted by task.

    Raises:
        UserError: names file and line of: YAML errors, unknown keys, predicates, classes, roles or
            variables, a role that nothing but a negation mentions, and a task that two files define.
    """
    known: dict[str, Predicate] = {}
    for predicate in predicates:
        if predicate.name in known:
            raise UserError(f"Two plugins define the predicate '{predicate.name}'; rename one of them.")
        known[predicate.name] = predicate
    rules: dict[str, Rule] = {}
    for path in _files(paths):
        rule = _load(path, known, taxonomy)
        if rule.task in rules:
            raise UserError(
                f"{path}:1: the task '{rule.task}' has a rule already in {rules[rule.task].path}; "
                "join them with 'or', or remove one."
            )
        rules[rule.task] = rule
    return tuple(rules[task] for task in sorted(rules))


def _files(paths: Iterable[Path | str]) -> list[Path]:
    found: list[Path] = []
    for path in map(Path, paths):
        found += sorted(path.glob("*.yaml")) if path.is_dir() else [path]
    return found


def _load(path: Path, predicates: dict[str, Predicate], taxonomy: Taxonomy) -> Rule:
    data = load_yaml(path)
    if not isinstance(data, dict):
        raise UserError(f"{path}:1: a rule file is a mapping with the keys {', '.join(_KEYS)}.")
    for key in data:
        if key not in _KEYS:
            raise UserError(f"{path}:{line_of(data, [key])}: unknown key '{key}'; {nearest(str(key), _KEYS)}")
    task = _class(path, data, ["task"], data.get("task"), TASK, taxonomy)
    roles = _mapping(path, data)
    roles = {n: _class(path, data, ["roles", n], r, ROLE, taxonomy) for n, r in roles.items()}
    clauses = tuple(c for phase in PHASES for c in _clauses(path, data, phase, phase, predicates, taxonomy))
    keys = _OF_PROGRAMS.items()
    planned = tuple(c for key, phase in keys for c in _clauses(path, data, key, phase, predicates, taxonomy))
    rule = Rule(task, roles, clauses, _text(path, data, "explain"), _text(path, data, "source"), path, planned)
    _check(rule, path, data)
    return rule


def _mapping(path: Path, data: Any) -> dict[str, Any]:
    roles = data.get("roles") or {}
    if not isinstance(roles, dict):
        raise UserError(f"{path}:{line_of(data, ['roles'])}: 'roles' is a mapping such as 'Patient: soma:Patient'.")
    for name in roles:
        if not re.fullmatch(r"[A-Z]\w*", str(name)):
            raise UserError(
                f"{path}:{line_of(data, ['roles', name])}: a role is also a variable, so '{name}' must be "
                "a capitalised word."
            )
    return dict(roles)


def _class(path: Path, data: Any, location: list[str], name: Any, above: str, taxonomy: Taxonomy) -> str:
    where = f"{path}:{line_of(data, location)}"
    if not isinstance(name, str):
        raise UserError(f"{where}: '{location[0]}' is missing or is not text; write a class such as soma:Grasping.")
    found = taxonomy.resolve(name)
    if found is None or not taxonomy.is_a(found, above):
        raise UserError(f"{where}: unknown class '{name}'; {nearest(name, taxonomy.subclasses(above))}")
    return found


def _text(path: Path, data: Any, key: str) -> str:
    text = data.get(key)
    if not isinstance(text, str) or not text.strip():
        raise UserError(f"{path}:{line_of(data, [key])}: '{key}' is missing; write a sentence.")
    return " ".join(text.split())


def _clauses(
    path: Path, data: Any, key: str, phase: PhaseName, predicates: dict[str, Predicate], taxonomy: Taxonomy
) -> Iterable[Clause]:
    conditions = data.get(key) or []
    if not isinstance(conditions, list):
        raise UserError(f"{path}:{line_of(data, [key])}: '{key}' is a list of conditions, one a line after '- '.")
    for k, text in enumerate(conditions):
        line = line_of(data, [key, k])
        if not isinstance(text, str):
            raise UserError(f"{path}:{line}: a condition is text such as 'grasps(Gripper, Patient)', not {text!r}.")
        try:
            yield Clause(phase, parse_condition(text, phase, predicates, taxonomy), " ".join(text.split()), line)
        except ConditionError as error:
            raise UserError(f"{path}:{line}: in '{text}': {error}.") from None


def _check(rule: Rule, path: Path, data: Any) -> None:
    bound = frozenset().union(*(binds(c.condition) for c in rule.clauses))
    for role in rule.roles:
        if role not in bound:
            used = any(role in mentions(c.condition) for c in rule.clauses)
            why = "is tested only, under 'not', 'every' or a comparison" if used else "is in no condition"
            raise UserError(
                f"{path}:{line_of(data, ['roles', role])}: the role '{role}' {why}, so nothing says what "
                f"fills it; add a condition that does, such as 'grasps(Gripper, {role})'."
            )
    for name in re.findall(r"\{(\w+)\}", rule.explain):
        if name not in bound:
            raise UserError(
                f"{path}:{line_of(data, ['explain'])}: 'explain' uses the variable '{name}', which no "
                f"condition binds; {nearest(name, bound)}"
            )
    _check_comparisons(rule, path, bound)
    _check_spelling(rule, path)


def _check_spelling(rule: Rule, path: Path) -> None:
    """Refuse a variable that occurs once and is nearly called like a role that its condition does not name."""
    clauses = (*rule.clauses, *rule.planned)
    words = Counter(word for c in clauses for word in re.findall(r"\w+", c.text))
    for clause in clauses:
        named = mentions(clause.condition)
        for name in sorted(n for n in named - rule.roles.keys() if words[n] == 1):
            if close := get_close_matches(name, sorted(rule.roles.keys() - named), n=1, cutoff=ALIKE):
                raise UserError(
                    f"{path}:{clause.line}: in '{clause.text}': the variable '{name}' occurs nowhere else; did you mean the role "
                    f"'{close[0]}'? Where any thing will do, write '_'."
                )


def _check_comparisons(rule: Rule, path: Path, bound: frozenset[str]) -> None:
    for clause in rule.clauses:
        free = _free_in_comparisons(clause.condition, bound)
        if free:
            raise UserError(
                f"{path}:{clause.line}: in '{clause.text}': nothing binds the variable "
                f"'{min(free)}' that is compared; {nearest(min(free), bound)}"
            )


def _free_in_comparisons(condition: Condition, bound: frozenset[str]) -> frozenset[str]:
    from .conditions import And, Compare, Every, Not, Or, Variable

    match condition:
        case Compare(left, _, right):
            terms = [t for t in (left, right) if isinstance(t, Variable)]
            inner = left.binds() if isinstance(left, Atom) else frozenset()
            return (frozenset(t.name for t in terms) | inner) - bound
        case Not(inner_condition):
            return _free_in_comparisons(inner_condition, bound)
        case Every(given, then):
            return _free_in_comparisons(given, bound) | _free_in_comparisons(then, bound | binds(given))
        case And(parts):
            found: frozenset[str] = frozenset()
            for part in parts:
                found |= _free_in_comparisons(part, bound)
                bound |= binds(part)
            return found
        case Or(options):
            return frozenset().union(*(_free_in_comparisons(o, bound) for o in options))
        case _:
            return frozenset()


def _ordered(clauses: tuple[Clause, ...], cheapest: bool) -> tuple[Clause, ...]:
    """Order conditions so that each follows those that bind its variables; the order in a rule file then
    never changes the meaning."""
    bound_somewhere = frozenset().union(*(binds(c.condition) for c in clauses))
    left, found = list(clauses), []
    bound: frozenset[str] = frozenset()
    while left:
        ready = [c for c in left if not ((tests(c.condition) & bound_somewhere) - binds(c.condition)) - bound] or left
        clause = min(ready, key=lambda c: (not c.lasting, c.cost, left.index(c))) if cheapest else ready[0]
        left.remove(clause)
        found.append(clause)
        bound |= binds(clause.condition)
    return tuple(found)

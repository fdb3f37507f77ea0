"""Action schemas: task rules over parameters in the place of things, as planning languages write actions.

A rule's relations become facts about its own variables; its conditions on classes and parts become tables of the entities of
a world for which they hold.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product

from msgspec.structs import replace

from ...base.value import Value
from ...interpretation.conditions import OPERATORS, Atom, Compare, Condition, Not
from ...interpretation.fluents import EFFECTOR, SymbolicWorld
from ...interpretation.rules import Rule
from ...model.entity_name import BETWEEN, thing_of
from ...plugin.task_type import TaskType
from ..operators import Change, Grounder, conditions_of, decided, doing, held_in, is_static, universal, variables
from .handling import moved_by

WHOLE = "_whole"
"""Suffix for the name of the thing to which the part in a parameter belongs: "?Relatum_whole/?Relatum"."""

SYMBOLS = dict(zip(OPERATORS, ("lt", "le", "gt", "ge", "eq", "eq", "ne"), strict=True))
"""Words for comparison operators in PDDL names, which cannot contain the signs."""

LENGTH = 1000
"""Cost of a task: a plan of fewer tasks is cheaper than any longer one, and of equal ones the one with tasks of
earlier rules."""

TableRow = tuple[str, ...]


class Table(Value):
    """Entities of a world for which a static condition (one that no task changes) holds, as a table.

    Args:
        name: of the relation, made of the condition's words.
        terms: what it is asked about, in the order of the columns.
        rows: entities.
        denied: whether the condition is that no row has its entities.
    """

    name: str
    terms: tuple[str, ...]
    rows: frozenset[TableRow]
    denied: bool = False


class Universal(Value):
    """Condition ``every given -> then`` of a rule: each entity (``OTHER``) for which ``given`` holds must
    satisfy ``then``.

    Args:
        given: the fact, one entity of it ``OTHER``.
        then: of which entities it may hold.
    """

    given: tuple[str, ...]
    then: Table


class ActionSchema(Value):
    """Action schema of a rule. Its terms are parameters such as "?Locatum", or "?Relatum_whole/?Relatum" for a part.

    Args:
        task: class of the task.
        terms: variable -> its term, or the effector.
        tables: that the terms must satisfy.
        change: what is needed, and what begins and ends.
        before, after: further conditions: what must hold of everything before, and what ends.
        rule: that it comes from.
        cost: ``LENGTH``, and more for later rules.
        elsewhere: whether it puts down elsewhere what the goal asks for at some place.
    """

    task: str
    terms: Mapping[str, str]
    tables: tuple[Table, ...]
    change: Change
    before: tuple[Universal, ...]
    after: tuple[Universal, ...]
    rule: Rule
    cost: int
    elsewhere: bool = False

    @property
    def doing(self) -> str:
        """Class of the action schema's task, followed by "elsewhere" if the task puts a thing down elsewhere
        than the goal asks."""
        return doing(self.task, self.elsewhere)

    @property
    def parameters(self) -> dict[str, str]:
        """Map each variable of the rule to the name of its parameter in the action schema; the effector is
        left out."""
        return {v: t.rpartition(BETWEEN)[2] for v, t in self.terms.items() if t != EFFECTOR}

    @property
    def in_hand(self) -> frozenset[str]:
        """Parameters of the action schema whose things are in the hand at some time of the task."""
        return held_in(conditions_of(self.rule), self.terms)

    @property
    def wholes(self) -> list[str]:
        """Variables of the rule that stand for a part, such as a hole; the thing with that part becomes a
        further parameter, after all others."""
        return [v for v, t in self.terms.items() if BETWEEN in t]


def action_schemas(grounder: Grounder, rules: Iterable[Rule], tasks: Mapping[str, TaskType]) -> Iterator[ActionSchema]:
    """Generate the action schemas of rules whose tasks a plugin offers: one for each choice of a thing or a part in each role."""
    for rank, rule in enumerate(rules):
        if rule.task in tasks:
            found = grounder.candidates(rule, tasks[rule.task])
            kinds = [sorted({kind_of(e) for e in entities}) for entities in found.values()]
            for choice in product(*kinds):
                chosen = zip(found.items(), choice, strict=True)
                fillers = {v: [e for e in entities if kind_of(e) == kind] for (v, entities), kind in chosen}
                if schema := _schema(grounder, rule, tasks[rule.task], fillers):
                    yield replace(schema, cost=LENGTH + rank)


def kind_of(entity: str) -> str:
    """Return "hand", "component" or "body": the kind of entity of a name."""
    return "hand" if entity == EFFECTOR else "component" if BETWEEN in entity else "body"


def _schema(grounder: Grounder, rule: Rule, task: TaskType, fillers: Mapping[str, Sequence[str]]) -> ActionSchema | None:
    terms = {v: _term(v, kind_of(entities[0])) for v, entities in fillers.items()}
    clauses = conditions_of(rule)
    in_hand = held_in(clauses, {v: v for v in fillers})
    fillers = {v: [e for e in found if v not in in_hand or grounder.can_be_held(e)] for v, found in fillers.items()}
    asked = [(p, given, then) for p, given, then in universal(clauses) if is_static(then)]
    change = grounder.change(rule, task, terms, any(p == "post" for p, _, _ in asked))
    if change is None:
        return None
    moved, kept = moved_by(change, grounder.fluents), grounder.scene.kept
    fillers = {v: [e for e in found if terms[v] not in moved or thing_of(e) not in kept] for v, found in fillers.items()}
    if not all(fillers.values()):
        return None
    ask = _Tabulation(grounder.scene, fillers, terms, in_hand)
    tables = [ask.table(c) for _, c in clauses if is_static(c)]
    tables += [Table(f"{v} of {rule.task}", (terms[v],), frozenset((e,) for e in fillers[v])) for v in ask.open]
    if any(not t.terms and bool(t.rows) == t.denied for t in tables):
        return None
    every = {phase: tuple(ask.every(g, t) for p, g, t in asked if p == phase) for phase in ("pre", "post")}
    unlike = tuple({t.name: t for t in tables if t.terms}.values())
    return ActionSchema(rule.task, terms, unlike, change, every["pre"], every["post"], rule, LENGTH)


def _term(variable: str, kind: str) -> str:
    return EFFECTOR if kind == "hand" else f"?{variable}{WHOLE}{BETWEEN}?{variable}" if kind == "component" else f"?{variable}"


class _Tabulation:
    """Evaluator of the static conditions of one action schema, which are those that no task changes.

    Args:
        scene: whose entities are asked about.
        fillers: variable -> entities.
        terms: variable -> term.
        in_hand: variables of which the entity is in the hand.
    """

    def __init__(
        self, scene: SymbolicWorld, fillers: Mapping[str, Sequence[str]], terms: Mapping[str, str], in_hand: Iterable[str]
    ) -> None:
        self.scene, self.fillers, self.terms, self.in_hand = scene, fillers, terms, sorted(in_hand)

    @property
    def open(self) -> list[str]:
        """Variables that things or their parts can fill: all but the effector."""
        return [v for v, t in self.terms.items() if t != EFFECTOR]

    def table(self, condition: Condition, other: str = "") -> Table:
        """Return the entities for which a static condition holds (one that no task changes), as a table.

        Columns that do not matter are left out.

        Args:
            other: a variable that stands for every entity of the scene.
        """
        denied = isinstance(condition, Not)
        inner = condition.inner if isinstance(condition, Not) else condition
        asked = dict.fromkeys((*variables(inner), *self.in_hand))
        columns = [v for v in asked if v == other or self.terms[v] != EFFECTOR]
        entities = {v: self.scene.entities if v == other else self.fillers[v] for v in columns}
        rows = {row for row in product(*entities.values()) if self._holds(inner, dict(zip(columns, row, strict=True)))}
        kept = [k for k, v in enumerate(columns) if v == other or _matters(rows, k, len(entities[v]))]
        if not rows:  # it holds of none
            kept = [] if denied else list(range(len(columns)))
        left = frozenset(tuple(row[k] for k in kept) for row in rows)
        names = tuple("?other" if columns[k] == other else self.terms[columns[k]] for k in kept)
        reduced = " ".join(str(k + 1) for k in kept) if len(kept) < len(columns) else ""
        return Table(f"{_name(inner)} {reduced}", names, left, denied)

    def every(self, given: Atom, then: Condition) -> Universal:
        """Return the condition ``every given -> then``, with a table of the entities for which ``then``
        holds."""
        (other,) = [v for v in variables(given) if v not in self.terms]
        binding = {**self.terms, other: "?other"}
        fact = (given.predicate.name, *(str(a) for a in given.arguments(dict(binding))))
        return Universal(fact, self.table(then, other))

    def _holds(self, condition: Condition, row: Mapping[str, str]) -> bool:
        held = frozenset(row[v] for v in self.in_hand if v in row)
        binding = {**{v: EFFECTOR for v, t in self.terms.items() if t == EFFECTOR}, **row}
        return decided(condition, binding, replace(self.scene, held=held))


def _matters(rows: set[TableRow], column: int, choices: int) -> bool:
    """Check whether the rows of a table of entities depend on the entity in one column.

    They do not if every entity occurs there with the same other columns.
    """
    left = {(*row[:column], *row[column + 1 :]) for row in rows}
    return len(left) * choices != len(rows)


def _name(condition: Condition) -> str:
    """Return a name for a static condition, such as "isa_vrps:Peg" for isa(Relatum, vrps:Peg),
    "constrained_dof_lt_2" for a comparison."""
    match condition:
        case Atom(predicate, terms):
            return "_".join([predicate.name, *(str(t) for t in terms if isinstance(t, str | float))])
        case Compare(Atom() as left, symbol, right):
            return f"{_name(left)}_{SYMBOLS[symbol]}_{right:g}" if isinstance(right, float | int) else _name(left)
    raise AssertionError(f"{condition} is not static")

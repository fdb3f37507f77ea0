"""PDDL: planning problems as the domain and problem texts that planners read, and the plans that they write.

Typed, with negative preconditions, quantifiers, conditional effects and action costs (Haslum et al. 2019, "An introduction to
the Planning Domain Definition Language"). What follows from a change is compiled into effects; only what geometry refuses
(``blocking``), and plans that were tried, become derived predicates.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from ...base.value import Value
from ...interpretation.fluents import EFFECTOR, Fact, Fluents, Pattern
from ...model.entity_name import BETWEEN, thing_of
from ..operators import OTHER
from .action_schema import WHOLE, ActionSchema, Table, Universal
from .blocking import Blocking
from .blocking_text import ENTITY, BlockingText
from .endings import PART_OF, Ending, endings, is_free, kinds_of, kinds_of_free

HAND, THING, PART = "hand", "body", "component"


class PddlText(Value):
    """PDDL domain and problem of a planning problem, with the meaning of their names.

    Args:
        domain, problem: texts.
        actions: name of an action -> its schema.
        entities: name of an object -> the entity.
    """

    domain: str
    problem: str
    actions: Mapping[str, ActionSchema]
    entities: Mapping[str, str]


class Names:
    """Names in PDDL, which has no capitals and few special characters: each text gets a name of its own."""

    def __init__(self) -> None:
        self._of: dict[str, str] = {}

    def __call__(self, text: str) -> str:
        """Return the PDDL name of a text, which stays the same for the same text."""
        if text not in self._of:
            plain = re.sub(r"[^a-z0-9_]+", "_", text.lower()).strip("_")
            plain = plain if plain[:1].isalpha() else f"x{plain}"
            taken, name, number = set(self._of.values()), plain, 2
            while name in taken:
                name, number = f"{plain}_{number}", number + 1
            self._of[text] = name
        return self._of[text]


class PlanStep(Value):
    """Step of a plan.

    Args:
        schema: of the action.
        binding: variable of the schema's rule -> entity.
    """

    schema: ActionSchema
    binding: Mapping[str, str]

    @property
    def key(self) -> tuple[str, ...]:
        """Class of the step's task and the things in its roles, in the order of the schema's parameters."""
        return (self.schema.task, *(self.binding[v] for v in self.schema.parameters))


def write_pddl(
    name: str, schemas: Sequence[ActionSchema], fluents: Fluents, entities: Iterable[str], facts: Iterable[Fact],
    needs: Iterable[Fact], without: Iterable[Pattern], *, earlier: Sequence[Sequence[PlanStep]] = (), refused: Sequence[PlanStep] = (),
    blocked: Sequence[Blocking] = (),
) -> PddlText:  # fmt: skip
    """Write a planning problem in PDDL.

    Args:
        entities: of the problem; facts about others are left out.
        facts: that hold at first.
        needs, without: the goal.
        earlier: plans of which none may be carried out whole again.
        refused: steps that no plan may have.
        blocked: steps that no plan may have while some things are as they are; they become derived predicates.
    """
    facts = tuple(facts)
    return _Writer(name, schemas, fluents, tuple(entities), facts, blocked).text(facts, needs, without, earlier, refused)


class _Writer:
    def __init__(
        self, name: str, schemas: Sequence[ActionSchema], fluents: Fluents, entities: tuple[str, ...], facts: tuple[Fact, ...],
        blocked: Sequence[Blocking],
    ) -> None:  # fmt: skip
        self.name, self.schemas, self.fluents = name, schemas, fluents
        self.entities = tuple(dict.fromkeys((EFFECTOR, *entities)))
        self.names, self.of_entities = Names(), Names()
        self.actions = {self.names(_label(s)): s for s in schemas}
        self.objects = {self.of_entities(e): e for e in self.entities}
        self.kinds = kinds_of(schemas, facts)
        self.ends = {action: endings(s, fluents, self.kinds) for action, s in self.actions.items()}
        self.used: dict[str, tuple[str, int]] = {}
        self.done = frozenset[str]()
        self.blocked = BlockingText(blocked, self._atom, self.of_entities, frozenset(self.entities))

    def text(
        self, facts: Sequence[Fact], needs: Iterable[Fact], without: Iterable[Pattern],
        earlier: Sequence[Sequence[PlanStep]], refused: Sequence[PlanStep],
    ) -> PddlText:  # fmt: skip
        """Return the PDDL domain and problem; the problem is made first, since the domain declares the names in
        both."""
        self.done = frozenset(e for steps in earlier for s in steps for e in s.key[1:])
        marks = {s.key[0] for steps in earlier for s in steps}, {s.key[0] for s in refused}
        attainable = _attainable(self.schemas, facts)
        actions = [self._action(name, schema, *marks) for name, schema in self.actions.items() if schema in attainable]
        goal = [self._fact(f) for f in sorted(needs)] + [self._forbidden(p) for p in sorted(without, key=str)]
        again = [(self._atom(f"again {k}", []), self._whole(steps)) for k, steps in enumerate(earlier)]
        goal += [f"(not {atom})" for atom, _ in again]
        init = ["(= (total-cost) 0)", *self._initial(facts), *(self._mark("refused", s) for s in refused), *self.blocked.initial()]
        problem = [
            f"(define (problem {self.of_entities(self.name)})", f"  (:domain {self._domain_name()})",
            "  (:objects", *(f"    {self.of_entities(e)} - {_type(e)}" for e in self.entities if e not in self._constants()), "  )",
            "  (:init", *(f"    {line}" for line in dict.fromkeys(init)), "  )",
            "  (:goal (and", *(f"    {line}" for line in goal), "  ))", "  (:metric minimize (total-cost))", ")",
        ]  # fmt: skip
        derived = [*(f"(:derived {atom} {whole})" for atom, whole in again), *self.blocked.derived()]
        return PddlText(self._domain(actions, derived), "\n".join(problem) + "\n", self.actions, self.objects)

    def _constants(self) -> list[str]:
        """Return the entities that actions name directly, which PDDL declares as constants."""
        return [e for e in self.entities if e == EFFECTOR or e in self.blocked.named | self.done]

    def _domain_name(self) -> str:
        return "cramlite"

    def _domain(self, actions: Iterable[str], lines: Iterable[str]) -> str:
        derived = [f"  {line}" for line in lines]
        constants = " ".join(f"{self.of_entities(e)} - {_type(e)}" for e in self._constants())
        declared = [
            f"    ({' '.join([plain, *(f'?{k} - {self._type_at(name, k)}' for k in range(1, arity + 1))])})".replace("?", "?e")
            for plain, (name, arity) in sorted(self.used.items())
        ]
        lines = [
            f"(define (domain {self._domain_name()})",
            f"  (:requirements :adl :typing :action-costs{' :derived-predicates' if derived else ''})",
            f"  (:types {HAND} {THING} {PART} - {ENTITY})", f"  (:constants {constants})",
            "  (:predicates", *declared, "  )", "  (:functions (total-cost) - number)", *derived, *actions, ")",
        ]  # fmt: skip
        return "\n".join(lines) + "\n"

    def _action(self, name: str, schema: ActionSchema, marked: set[str], refusable: set[str]) -> str:
        done = [self._of_action("done", schema)] if schema.task in marked else []
        refused = [f"(not {self._of_action('refused', schema)})"] if schema.task in refusable else []
        effects = [*map(self._ending, self.ends[name]), *(self._fact(f) for f in sorted(schema.change.adds)), *done]
        effects += self.blocked.effects(schema, self.fluents)
        conditions = [*self._conditions(schema), *refused, *self.blocked.conditions(schema)]
        lines = [
            "", f"  (:action {name}", f"   :parameters ({_parameters(schema)})",
            "   :precondition (and", *(f"     {c}" for c in dict.fromkeys(conditions)), "   )",
            "   :effect (and", *(f"     {e}" for e in dict.fromkeys(effects)), f"     (increase (total-cost) {schema.cost})", "   ))",
        ]  # fmt: skip
        return "\n".join(lines)

    def _conditions(self, schema: ActionSchema) -> Iterator[str]:
        yield from (self._table(t) for t in schema.tables)
        terms = [t for t in schema.terms.values() if t != EFFECTOR]
        for variable in (t for t in terms if BETWEEN in t):
            yield self._atom(PART_OF, variable.split(BETWEEN)[::-1])
        for k, one in enumerate(terms):
            same = (t for t in terms[k + 1 :] if (BETWEEN in t) == (BETWEEN in one))
            yield from (f"(not (= {_term(one)} {_term(two)}))" for two in same)
        yield from (self._fact(f) for f in sorted(schema.change.needs))
        yield from (self._forbidden(p) for p in sorted(schema.change.without, key=str))
        yield from (self._universal(u) for u in schema.before)
        for pair in sorted(schema.change.never):
            one, two = (f"(not {self._fact(f)})" for f in pair)
            yield self._all([OTHER], pair, f"(or {one} {two})")

    def _ending(self, ending: Ending) -> str:
        conditions = sorted(self._table(t) for t in ending.tables if t.terms) + [self._fact(f) for f in sorted(ending.when)]
        effect = f"(not {self._fact(ending.fact)})"
        whole = f"(and {' '.join(conditions)})" if len(conditions) > 1 else "".join(conditions)
        effect = f"(when {whole} {effect})" if conditions else effect
        return self._all(ending.free, [ending.fact, *ending.when], effect, ending.tables)

    def _all(self, free: Sequence[str], facts: Sequence[Fact], said: str, tables: Iterable[Table] = ()) -> str:
        """Wrap a PDDL formula so that it holds for all values of its free variables.

        The facts in which a variable occurs give its type.
        """
        typed = [f"{v} - {_widest(kinds_of_free(v, facts, tables, self.kinds))}" for v in free]
        return f"(forall ({' '.join(typed)}) {said})" if typed else said

    def _universal(self, every: Universal) -> str:
        allowed = self._table(every.then) if every.then.terms else ""
        return self._all([OTHER], [every.given], f"(or {allowed} (not {self._fact(every.given)}))")

    def _forbidden(self, pattern: Pattern) -> str:
        terms = [p if p is not None else f"?any{k}" for k, p in enumerate(pattern[1:], 1)]
        free = [t for t in terms if is_free(t)]
        denied: Fact = (str(pattern[0]), *terms)
        return self._all(free, [denied], f"(not {self._fact(denied)})")

    def _table(self, table: Table) -> str:
        said = self._atom(table.name, list(table.terms))
        return f"(not {said})" if table.denied else said

    def _type_at(self, predicate: str, k: int) -> str:
        if predicate == PART_OF:
            return (PART, THING)[k - 1]
        return _widest(self.kinds.get((predicate, k), frozenset()))

    def _fact(self, fact: Fact) -> str:
        return self._atom(fact[0], list(fact[1:]))

    def _atom(self, name: str, terms: Sequence[str]) -> str:
        plain = self.names(name)
        self.used[plain] = (name, len(terms))
        shown = [_term(t) if t.startswith("?") else self.of_entities(t) for t in terms]
        return f"({' '.join([plain, *shown])})"

    def _of_action(self, mark: str, schema: ActionSchema) -> str:
        return self._atom(f"{mark} {schema.task}", list(schema.parameters.values()))

    def _mark(self, mark: str, step: PlanStep) -> str:
        return self._atom(f"{mark} {step.schema.task}", step.key[1:])

    def _whole(self, steps: Sequence[PlanStep]) -> str:
        """Format the PDDL condition that all steps of an earlier plan were done, which keeps planners from
        finding that plan again.

        In the goal itself, planners would multiply the ways to leave one step out of each plan.
        """
        return "(and " + " ".join(sorted({self._mark("done", s) for s in steps})) + ")"

    def _initial(self, facts: Iterable[Fact]) -> Iterator[str]:
        here = set(self.entities)
        tables = [t for s in self.schemas for t in (*s.tables, *(u.then for u in (*s.before, *s.after)))]
        for table in tables:
            yield from (
                self._atom(table.name, row) for row in sorted(table.rows) if table.terms and here.issuperset(row)
            )
        yield from (self._atom(PART_OF, [e, thing_of(e)]) for e in self.entities if BETWEEN in e and thing_of(e) in here)
        yield from (self._fact(f) for f in sorted(facts) if here.issuperset(f[1:]) and self.names(f[0]) in self.used)


def _attainable(schemas: Sequence[ActionSchema], facts: Iterable[Fact]) -> list[ActionSchema]:
    """Return the action schemas that may become applicable: what they need holds at the start, or a schema adds it.

    Planners ground a problem faster without the others.
    """
    known = {f[0] for f in (*facts, *(f for s in schemas for f in s.change.adds))}
    kept = [s for s in schemas if known.issuperset(f[0] for f in s.change.needs)]
    return kept if len(kept) == len(schemas) else _attainable(kept, facts)


def _label(schema: ActionSchema) -> str:
    parts = [v for v, t in schema.terms.items() if BETWEEN in t]
    return " ".join([schema.doing.split(":")[-1], *(f"with part {v}" for v in parts)])


def _type(entity: str) -> str:
    return HAND if entity == EFFECTOR else PART if BETWEEN in entity else THING


def _term(term: str) -> str:
    return term.rpartition(BETWEEN)[2]


def _widest(kinds: frozenset[str]) -> str:
    return next(iter(kinds)) if len(kinds) == 1 else ENTITY


def _parameters(schema: ActionSchema) -> str:
    found: list[str] = []
    for term in (t for t in schema.terms.values() if t != EFFECTOR):
        whole, _, part = term.partition(BETWEEN)
        found.append(f"{part} - {PART}" if part else f"{whole} - {THING}")
    wholes = [f"{t.partition(BETWEEN)[0]} - {THING}" for t in schema.terms.values() if WHOLE in t]
    return " ".join([*found, *wholes])

"""Planning actions (operators): task rules grounded over the things of one world, with preconditions and
effects.

The rules that interpret demonstrations say both (``pre`` and ``post``). They are grounded here: conditions on classes and
parts choose the fillers of roles, relations become facts that are needed, forbidden, added or removed. What is measured
(motion, distances) is left to the search and to the run. Everything that no postcondition denies stays as it is.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cached_property
from itertools import product

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..interpretation.conditions import OPERATORS, And, Atom, Compare, Condition, Every, Not, Or, Variable
from ..interpretation.fluents import (
    EFFECTOR,
    Fact,
    Fluents,
    Pattern,
    SymbolicWorld,
    by_predicate,
    contents,
    fluents_of,
    matches,
    matching,
    pattern_text,
)
from ..interpretation.rules import Rule
from ..interpretation.timeline import Predicate
from ..model.entity_name import thing_of
from ..plugin.task_type import TaskType

OTHER = "?other"
"""Free variable in the pattern of a fact: it stands for any entity, the same one at each of its places."""


def doing(task: str, elsewhere: bool) -> str:
    """Return a task's class, with "elsewhere" added if the task puts a thing down elsewhere than the goal asks for."""
    return f"{task} elsewhere" if elsewhere else task


class Operator(Value):
    """Grounded planning action: a task with things in its roles, its preconditions and its effects.

    Args:
        task: class.
        roles: role -> entity; the effector is ``EFFECTOR``.
        needs: facts that must hold.
        without: patterns that nothing may match.
        adds: facts that hold afterwards.
        removes: patterns; what matches does not hold afterwards.
        fluents: what follows from a change.
        never: pairs of facts that may not both hold of one entity, which stands in both as ``OTHER``.
        moves: entities that it moves without holding them.
        elsewhere: whether it puts a thing down elsewhere than the goal asks for, to make room.
    """

    task: str
    roles: Mapping[str, str]
    needs: frozenset[Fact]
    without: frozenset[Pattern]
    adds: frozenset[Fact]
    removes: frozenset[Pattern]
    fluents: Fluents
    never: frozenset[tuple[Fact, Fact]] = frozenset()
    moves: frozenset[str] = frozenset()
    elsewhere: bool = False

    @property
    def doing(self) -> str:
        """Class of the planning action's task, followed by "elsewhere" if the task puts a thing down
        elsewhere than the goal asks."""
        return doing(self.task, self.elsewhere)

    def __str__(self) -> str:
        return f"{self.doing.split(':')[-1]}({', '.join(f'{r}={e}' for r, e in self.roles.items() if e != EFFECTOR)})"

    def barred_by(self, fact: Fact, facts: frozenset[Fact]) -> bool:
        """Check whether a fact would violate a precondition if it were added to ``facts``, which hold."""
        if any(matches(fact, p) for p in self.without):
            return True
        about = [pair for pair in self.never if fact[0] in (pair[0][0], pair[1][0])]
        pairs = [(_with(one, e), _with(two, e)) for one, two in about for f in facts for e in _others(f, one)]
        return any(fact in pair and pair[1] in facts for pair in pairs)

    def applies(self, facts: frozenset[Fact]) -> bool:
        """Check whether all preconditions of this task hold in a set of facts."""
        return not self.unmet(facts)

    def unmet(self, facts: frozenset[Fact]) -> str:
        """Return the first precondition that does not hold, as rules write it; "" where all do."""
        missing = [pattern_text(f) for f in sorted(self.needs - facts)]
        if matching(facts, self.without):
            missing += ["not " + pattern_text(f) for p in sorted(self.without, key=str) for f in sorted(matching(facts, [p]))]
        for one, two in sorted(self.never):
            alike = sorted(by_predicate(facts).get(one[0], ()))
            found = (e for f in alike for e in _others(f, one) if _with(two, e) in facts)
            missing += [f"not {pattern_text(_with(two, e))} as {pattern_text(_with(one, e))}" for e in found]
        return next(iter(missing), "")

    def apply(self, facts: frozenset[Fact]) -> frozenset[Fact]:
        """Return the facts after the task, with all that follows from its effects by the predicates'
        declarations."""
        return self.fluents.after(facts, self.adds, self.removes)


def _others(fact: Fact, pattern: Fact) -> list[str]:
    """Return the entities at the places of ``OTHER`` in a fact that matches a pattern; empty if the fact does not match."""
    bare = tuple(None if p == OTHER else p for p in pattern)
    return [e for e, p in zip(fact, pattern, strict=True) if p == OTHER] if matches(fact, bare) else []


def _with(pattern: Fact, entity: str) -> Fact:
    return tuple(entity if p == OTHER else p for p in pattern)


class Change(Value):
    """Preconditions and effects of a task as facts, and the things that it moves; see ``Operator`` for the
    fields.

    Args:
        needs, without, adds, removes, never, moves: as ``Operator`` has them.
    """

    needs: frozenset[Fact]
    without: frozenset[Pattern]
    adds: frozenset[Fact]
    removes: frozenset[Pattern]
    never: frozenset[tuple[Fact, Fact]]
    moves: frozenset[str] = frozenset()


class Grounder:
    """Grounder of task rules: it makes planning actions by filling roles with the things of one world.

    Args:
        scene: whose things and features fill roles.
        predicates: of the rules; they say what follows from what.

    Raises:
        PluginError: predicates do not agree with each other.
    """

    def __init__(self, scene: SymbolicWorld, predicates: Iterable[Predicate]) -> None:
        self.predicates = tuple(predicates)
        self.scene, self.fluents = scene, fluents_of({p.name: p.fluent for p in self.predicates})
        self.things = {t.name: t for t in scene.world.things}
        self.contents = [contents(t.name) for t in scene.filled()]

    @cached_property
    def initial(self) -> frozenset[Fact]:
        """Facts that hold at the start, as predicates declare them."""
        return self.fluents.initial(self.scene)

    def among(self, names: Collection[str]) -> Grounder:
        """Return a grounder of task rules over only some of the world's things."""
        world = replace(self.scene.world, things=tuple(t for t in self.scene.world.things if t.name in names))
        types = {e: c for e, c in self.scene.types.items() if thing_of(e) in names}
        return Grounder(replace(self.scene, world=world, types=types), self.predicates)

    def ground(self, rules: Iterable[Rule], tasks: Mapping[str, TaskType]) -> tuple[Operator, ...]:
        """Return the planning actions of rules whose tasks a plugin offers, grounded over the things of the
        world."""
        return tuple(o for rule in rules if rule.task in tasks for o in self._ground(rule, tasks[rule.task]))

    def _ground(self, rule: Rule, task: TaskType) -> Iterator[Operator]:
        candidates = self.candidates(rule, task)
        for fillers in product(*candidates.values()):
            if found := self.operator(rule, task, dict(zip(candidates, fillers, strict=True))):
                yield found

    def candidates(self, rule: Rule, task: TaskType) -> dict[str, list[str]]:
        """Return the entities that may fill each variable of a rule, by those conditions that are about one
        variable alone."""
        clauses = conditions_of(rule)
        atoms = [c for _, c in clauses if isinstance(c, Atom)]
        asked = [a for a in atoms if a.predicate.static]
        last = [a.terms[-1] for a in atoms if a.predicate.fluent.of_contents]
        inside = {t.name for t in last if isinstance(t, Variable)}
        names = dict.fromkeys((*rule.roles, *(v for _, c in clauses for v in variables(c))))
        return {n: self.contents if n in inside else self._candidates(n, asked, task) for n in names}

    def _candidates(self, name: str, asked: Iterable[Atom], task: TaskType) -> list[str]:
        """Entities that may fill a variable: they meet the conditions on it alone, and have the features that
        its role needs."""
        role = task.role(name)
        if role is not None and role.effector:
            return [EFFECTOR]
        alone, anyone = [a for a in asked if variables(a) == [name]], replace(self.scene, held=frozenset(self.things))
        found = [e for e in anyone.entities if all(_static(a, {name: e}, anyone) for a in alone)]
        if found == [EFFECTOR]:  # only where nothing else will do: conditions that name no class are about things
            return found
        features = role.features if role is not None else ()
        return [e for e in found if e != EFFECTOR and all(self.scene.has(e, f) for f in features)]

    def operator(self, rule: Rule, task: TaskType, binding: Mapping[str, str]) -> Operator | None:
        """Return the planning action for one assignment of things to roles; None if a thing is of a wrong
        class, or nothing would change."""
        clauses = conditions_of(rule)
        held = held_in(clauses, binding)
        if len(set(binding.values())) < len(binding) or not all(self.can_be_held(name) for name in held):
            return None
        scene = replace(self.scene, held=held)
        if not all(decided(c, binding, scene) for _, c in clauses if is_static(c)):
            return None
        every = {phase: self._every(clauses, phase, binding, scene) for phase in ("pre", "post")}
        change = self.change(rule, task, binding, {phase: bool(found) for phase, found in every.items()}["post"])
        if change is None:
            return None
        without, removes = change.without | every["pre"], change.removes | every["post"]
        roles = {r: binding[r] for r in rule.roles}
        return Operator(rule.task, roles, change.needs, without, change.adds, removes, self.fluents, change.never, change.moves)

    def can_be_held(self, name: str) -> bool:
        """Check whether a thing can be held in the hand: it must be movable."""
        return name in self.things and self.things[name].movable

    def change(self, rule: Rule, task: TaskType, binding: Mapping[str, str], ends: bool = False) -> Change | None:
        """Return preconditions and effects of a task with given things, or parameters, in its roles.

        Conditions on classes are not checked.

        Args:
            ends: whether it ends something beside what it denies by itself.

        Returns:
            None where nothing changes.
        """
        clauses = conditions_of(rule)
        needs, without = self._facts(clauses, "pre", binding)
        adds, removes = self._facts(clauses, "post", binding)
        if type(task).effects is TaskType.effects:  # it brings nothing anywhere
            needs |= {f for f in adds if self.fluents[f[0]].by_moving}
        adds = self.fluents.implied(adds, held_in(clauses, binding))
        never = frozenset(_pair(given, then, binding) for p, given, then in universal(clauses) if p == "pre" and not is_static(then))
        moves = frozenset(binding[r] for r in task.moves if r in binding)
        return Change(needs, without, adds, removes, never, moves) if adds - needs or removes or ends else None

    def _facts(
        self, clauses: Iterable[tuple[str, Condition]], phase: str, binding: Mapping[str, str]
    ) -> tuple[frozenset[Fact], frozenset[Pattern]]:
        """Return the facts that must hold in a phase of a task, and the patterns of facts that must not,
        without static conditions.

        An effect on a thing that the rule leaves open is left out.
        """
        yes: set[Fact] = set()
        no: set[Pattern] = set()
        for condition in (c for p, c in clauses if p == phase and not is_static(c)):
            match condition:
                case Atom():
                    facts = self.fluents.both_ways(_pattern(condition, binding))
                    yes |= {f for f in facts if phase == "pre" or None not in f}
                case Not(Atom() as inner):
                    no |= self.fluents.denied(_pattern(inner, binding))
        return frozenset(yes), frozenset(no)

    def _every(
        self, clauses: Iterable[tuple[str, Condition]], phase: str, binding: Mapping[str, str], scene: SymbolicWorld
    ) -> frozenset[Pattern]:
        asked = ((given, then) for p, given, then in universal(clauses) if p == phase and is_static(then))
        found = (self._others(given, then, binding, scene) for given, then in asked)
        return frozenset().union(*found)

    def _others(self, given: Atom, then: Condition, binding: Mapping[str, str], scene: SymbolicWorld) -> set[Pattern]:
        """Return the facts that a condition ``every given -> then`` forbids: ``given`` with each entity for which ``then`` is false."""
        (free,) = [v for v in variables(given) if v not in binding] or [""]
        if not free:
            return set()
        wrong = [e for e in scene.entities if not decided(then, {**binding, free: e}, scene)]
        return {p for e in wrong for p in self.fluents.both_ways(_pattern(given, {**binding, free: e}))}


def conditions_of(rule: Rule) -> list[tuple[str, Condition]]:
    """Return all conditions of a rule that must hold before or after its task, each with its phase."""
    return [(c.phase, part) for c in (*rule.clauses, *rule.planned) if c.phase != "run" for part in _parts(c.condition)]


def held_in(clauses: Iterable[tuple[str, Condition]], binding: Mapping[str, str]) -> frozenset[str]:
    """Return the things that are in the hand at some time of a task."""
    atoms = (c for _, c in clauses if isinstance(c, Atom) and c.predicate.fluent.in_hand)
    return frozenset(str(a.arguments(dict(binding))[-1]) for a in atoms)


def universal(clauses: Iterable[tuple[str, Condition]]) -> Iterator[tuple[str, Atom, Condition]]:
    """Generate phase, premise and conclusion of each condition of the form ``every premise -> conclusion``."""
    for phase, condition in clauses:
        match condition:
            case Every(Atom() as given, then):
                yield phase, given, then


def is_static(condition: Condition) -> bool:
    """Check whether a condition (an atom, its negation or its comparison) is static: tasks do not change its
    truth."""
    match condition:
        case Atom(predicate) | Not(Atom(predicate)):
            return predicate.static is not None
        case Compare(Atom(predicate), _, right):
            return predicate.static is not None and not isinstance(right, Variable)
    return False


def decided(condition: Condition, binding: Mapping[str, str], scene: SymbolicWorld) -> bool:
    """Evaluate a static condition: one whose truth no task changes."""
    match condition:
        case Not(Atom() as inner):
            return not _static(inner, binding, scene)
        case Compare(Atom() as left, symbol, right):
            return bool(OPERATORS[symbol](_static(left, binding, scene), float(str(right))))
        case Atom():
            return bool(_static(condition, binding, scene))
    raise AssertionError(f"{condition} is not static")


def _static(atom: Atom, binding: Mapping[str, str], scene: SymbolicWorld) -> bool | float:
    assert atom.predicate.static is not None
    return atom.predicate.static(scene, *map(str, atom.arguments(dict(binding))))


def _parts(condition: Condition) -> Iterator[Condition]:
    """Yield the conditions that must all hold; of alternatives ("or") only the first is taken.

    Rules write the alternative about a joint first, and the one about a lid later.
    """
    match condition:
        case And(parts):
            for part in parts:
                yield from _parts(part)
        case Or(options):
            yield from _parts(options[0])
        case _:
            yield condition


def variables(condition: Condition) -> list[str]:
    """Return the variables in an atom or a compared atom; none for 'not' and 'every', which bind no
    variables."""
    atom = condition.left if isinstance(condition, Compare) else condition
    return [t.name for t in atom.terms if isinstance(t, Variable) and t.name != "_"] if isinstance(atom, Atom) else []


def _pattern(atom: Atom, binding: Mapping[str, str]) -> Pattern:
    return (atom.predicate.name, *(None if a is None else str(a) for a in atom.arguments(dict(binding))))


def _pair(given: Atom, then: Condition, binding: Mapping[str, str]) -> tuple[Fact, Fact]:
    """Return the two facts that ``every given -> not then`` forbids to hold together."""
    if not isinstance(then, Not) or not isinstance(then.inner, Atom):
        raise UserError("In rules for planning, 'every' ends in a class, or in 'not' and a relation: every in(X, Y) -> not shut(Y).")
    free = {**dict.fromkeys(variables(given), OTHER), **binding}
    one, two = (tuple(p or OTHER for p in _pattern(a, free)) for a in (given, then.inner))
    return one, two

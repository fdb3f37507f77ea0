"""Planning operators: task rules grounded over the things of one world, with preconditions and effects.

The rules that interpret demonstrations say both (``pre`` and ``post``). They are grounded here: conditions on classes and
parts choose the fillers of roles, relations become facts that are needed, forbidden, added or removed. What is measured
(motion, distances) is left to the search and to the run. Everything that no postcondition denies stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from msgspec.structs import replace

from ..base.value import Value
from ..interpretation.conditions import OPERATORS, And, Atom, Compare, Condition, Every, Not, Or, Variable
from ..interpretation.fluents import EFFECTOR, Fact, Fluents, Pattern, SymbolicWorld, contents, fluents_of, matches
from ..interpretation.rules import Rule
from ..interpretation.timeline import Predicate
from ..plugin.task_type import TaskType


class Operator(Value):
    """Ground planning operator: a task with fillers, its preconditions and its effects.

    Args:
        task: class.
        roles: role -> entity; the effector is ``EFFECTOR``.
        needs: facts that must hold.
        without: patterns that nothing may match.
        adds: facts that hold afterwards.
        removes: patterns; what matches does not hold afterwards.
        fluents: what follows from a change.
    """

    task: str
    roles: Mapping[str, str]
    needs: frozenset[Fact]
    without: frozenset[Pattern]
    adds: frozenset[Fact]
    removes: frozenset[Pattern]
    fluents: Fluents

    def __str__(self) -> str:
        return f"{self.task.split(':')[-1]}({', '.join(f'{r}={e}' for r, e in self.roles.items() if e != EFFECTOR)})"

    def applies(self, facts: frozenset[Fact]) -> bool:
        """Check whether the preconditions hold."""
        return self.needs <= facts and not any(matches(f, p) for p in self.without for f in facts)

    def apply(self, facts: frozenset[Fact]) -> frozenset[Fact]:
        """Return the facts afterwards, with all that follows from the change as predicates declare it."""
        return self.fluents.after(facts, self.adds, self.removes)


class Grounder:
    """Grounding of task rules over the things of one world into planning operators.

    Args:
        scene: whose things and features fill roles.
        predicates: of the rules; they say what follows from what.

    Raises:
        PluginError: predicates do not agree with each other.
    """

    def __init__(self, scene: SymbolicWorld, predicates: Iterable[Predicate]) -> None:
        self.scene, self.fluents = scene, fluents_of({p.name: p.fluent for p in predicates})
        self.things = {t.name: t for t in scene.world.things}
        self.contents = [contents(t.name) for t in scene.filled()]

    def initial(self) -> frozenset[Fact]:
        """Return the facts that hold at the start, as predicates declare them; the hand is empty."""
        return self.fluents.initial(self.scene)

    def ground(self, rules: Iterable[Rule], tasks: Mapping[str, TaskType]) -> tuple[Operator, ...]:
        """Return the ground operators of those rules whose tasks a plugin offers."""
        return tuple(o for rule in rules if rule.task in tasks for o in self._ground(rule, tasks[rule.task]))

    def _ground(self, rule: Rule, task: TaskType) -> Iterator[Operator]:
        clauses = [(c.phase, part) for c in rule.clauses if c.phase != "run" for part in _parts(c.condition)]
        names = list(dict.fromkeys((*rule.roles, *(v for _, c in clauses for v in _variables(c)))))
        atoms = [c for _, c in clauses if isinstance(c, Atom)]
        asked = [a for a in atoms if a.predicate.static]
        last = [a.terms[-1] for a in atoms if a.predicate.fluent.of_contents]
        inside = {t.name for t in last if isinstance(t, Variable)}
        for fillers in product(*(self.contents if n in inside else self._candidates(n, asked, task) for n in names)):
            binding = dict(zip(names, fillers, strict=True))
            if len(set(fillers)) == len(fillers) and (found := self._bound(rule, task, clauses, binding)):
                yield found

    def _candidates(self, name: str, asked: Iterable[Atom], task: TaskType) -> list[str]:
        """Entities that conditions on classes, and what the task type's role asks for, leave for a variable."""
        role = task.role(name)
        if role is not None and role.effector:
            return [EFFECTOR]
        alone, anyone = [a for a in asked if _variables(a) == [name]], replace(self.scene, held=frozenset(self.things))
        found = [e for e in anyone.entities if all(_static(a, {name: e}, anyone) for a in alone)]
        if found == [EFFECTOR]:  # only where nothing else will do: conditions that name no class are about things
            return found
        features = role.features if role is not None else ()
        return [e for e in found if e != EFFECTOR and all(self.scene.has(e, f) for f in features)]

    def _bound(
        self, rule: Rule, task: TaskType, clauses: Iterable[tuple[str, Condition]], binding: dict[str, str]
    ) -> Operator | None:
        """The operator for one choice of fillers; None where a condition on classes does not hold."""
        atoms = (c for _, c in clauses if isinstance(c, Atom) and c.predicate.fluent.in_hand)
        held = frozenset(str(a.arguments(dict(binding))[-1]) for a in atoms)
        if not all(name in self.things and self.things[name].movable for name in held):
            return None  # only what can move can be in the hand
        scene = replace(self.scene, held=held)
        before, after = (self._facts([c for p, c in clauses if p == phase], binding, scene) for phase in ("pre", "post"))
        if before is None or after is None:
            return None
        needs, adds = before[0], after[0]
        if type(task).effects is TaskType.effects:  # it brings nothing anywhere
            needs |= {f for f in adds if self.fluents[f[0]].by_moving}
        adds = self.fluents.implied(adds, held)
        if not (adds - needs) and not after[1]:
            return None
        roles = {r: binding[r] for r in rule.roles}
        return Operator(rule.task, roles, needs, before[1], adds, after[1], self.fluents)

    def _facts(
        self, conditions: Iterable[Condition], binding: dict[str, str], scene: SymbolicWorld
    ) -> tuple[frozenset[Fact], frozenset[Pattern]] | None:
        """What must hold and what may not; None where it cannot be."""
        yes: set[Fact] = set()
        no: set[Pattern] = set()
        for condition in conditions:
            match condition:
                case Atom() | Not(Atom()) | Compare(Atom()) if _is_static(condition):
                    if not _decided(condition, binding, scene):
                        return None
                case Atom():
                    yes |= self.fluents.both_ways(_pattern(condition, binding))
                case Not(Atom() as inner):
                    no |= self.fluents.denied(_pattern(inner, binding))
                case Every(Atom() as given, then):
                    no |= self._others(given, then, binding, scene)
        return frozenset(yes), frozenset(no)

    def _others(self, given: Atom, then: Condition, binding: dict[str, str], scene: SymbolicWorld) -> set[Pattern]:
        """Facts that ``every given -> then`` forbids: those of entities of which ``then`` does not hold."""
        (free,) = [v for v in _variables(given) if v not in binding] or [""]
        if not free or not _is_static(then):
            return set()
        wrong = [e for e in scene.entities if not _decided(then, {**binding, free: e}, scene)]
        return {p for e in wrong for p in self.fluents.both_ways(_pattern(given, {**binding, free: e}))}


def _is_static(condition: Condition) -> bool:
    """Whether a condition, denied or compared or as it is, is decided before anything is done."""
    match condition:
        case Atom(predicate) | Not(Atom(predicate)):
            return predicate.static is not None
        case Compare(Atom(predicate), _, right):
            return predicate.static is not None and not isinstance(right, Variable)
    return False


def _decided(condition: Condition, binding: Mapping[str, str], scene: SymbolicWorld) -> bool:
    """Whether a static condition holds."""
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
    """The conditions that must all hold; of alternatives the first, which is about joints rather than lids."""
    match condition:
        case And(parts):
            for part in parts:
                yield from _parts(part)
        case Or(options):
            yield from _parts(options[0])
        case _:
            yield condition


def _variables(condition: Condition) -> list[str]:
    """Variables that an atom, or the atom that is compared, names; those under 'not' and 'every' bind nothing."""
    atom = condition.left if isinstance(condition, Compare) else condition
    return [t.name for t in atom.terms if isinstance(t, Variable) and t.name != "_"] if isinstance(atom, Atom) else []


def _pattern(atom: Atom, binding: Mapping[str, str]) -> Pattern:
    return (atom.predicate.name, *(None if a is None else str(a) for a in atom.arguments(dict(binding))))

"""Task rules as planning operators: what a task needs before, and what it changes, over the things of one world.

The rules that interpret demonstrations say both (``pre`` and ``post``). They are grounded here: conditions on classes and
parts choose the fillers of roles, relations become facts that are needed, forbidden, added or removed. What is measured
(motion, distances) is left to the search and to the run. Everything that no postcondition denies stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from ..base.value import Value
from ..interpretation.conditions import OPERATORS, And, Atom, Compare, Condition, Every, Not, Or, Variable
from ..interpretation.rules import Rule
from ..model.world import Thing, World
from ..ontology.taxonomy import Taxonomy
from ..plugin.task_type import TaskType

GRIPPER = "gripper"
"""The effector, as facts name it."""

Fact = tuple[str, ...]
"""A relation that holds: its predicate and the entities, e.g. ("touches", "tea", "hook/peg")."""

Pattern = tuple[str | None, ...]
"""A fact with None where anything may stand."""

STATIC = ("effector", "isa", "has", "thing", "part")
"""Predicates about classes and parts: they choose fillers and never change."""

GUIDED_DOF = 4.0
"""Degrees of freedom that a peg takes from a thing with a hole; all else that supports takes one (rule of PickingUp)."""


class Operator(Value):
    """One task with fillers: what must hold, what may not, and what changes.

    Args:
        task: class.
        roles: role -> entity; the effector is ``GRIPPER``.
        needs: facts that must hold.
        without: patterns that nothing may match.
        adds: facts that hold afterwards.
        removes: patterns; what matches does not hold afterwards.
    """

    task: str
    roles: Mapping[str, str]
    needs: frozenset[Fact]
    without: frozenset[Pattern]
    adds: frozenset[Fact]
    removes: frozenset[Pattern]

    def __str__(self) -> str:
        return f"{self.task.split(':')[-1]}({', '.join(f'{r}={e}' for r, e in self.roles.items() if e != GRIPPER)})"

    def applies(self, facts: frozenset[Fact]) -> bool:
        return self.needs <= facts and not any(matches(f, p) for p in self.without for f in facts)

    def apply(self, facts: frozenset[Fact]) -> frozenset[Fact]:
        """The facts afterwards; what no longer touches does not support, and the reverse."""
        gone = {f for f in facts if any(matches(f, p) for p in self.removes)} - self.adds
        lifted = {(f[1], f[2]) for f in gone if f[0] == "supports"}
        gone |= {f for f in facts if f[0] == "touches" and {(whole(f[1]), f[2]), (whole(f[2]), f[1])} & lifted}
        gone |= {("touches", f[2], f[1]) for f in gone if f[0] == "touches"}
        left = (facts - gone) | self.adds
        parted = {(f[1], whole(f[2])) for f in gone if f[0] == "touches"}
        parted -= {(f[1], whole(f[2])) for f in left if f[0] == "touches" and "/" in f[2]}
        left -= {(p, *pair) for a, b in parted for p in ("touches",) for pair in ((a, b), (b, a))} - self.adds
        touching = {(whole(f[1]), f[2]) for f in left if f[0] == "touches"}
        return frozenset(f for f in left if f[0] != "supports" or (f[1], f[2]) in touching)


def matches(fact: Fact, pattern: Pattern) -> bool:
    return len(fact) == len(pattern) and all(p is None or p == f for f, p in zip(fact, pattern, strict=True))


def whole(entity: str) -> str:
    """The thing that an entity belongs to."""
    return entity.split("/")[0]


def contents(vessel: str) -> str:
    """What a vessel was filled with, as an entity."""
    return f"{vessel}/contents"


class Grounder:
    """Rules over the things of one world become operators.

    Args:
        world: whose things and features fill roles.
        taxonomy: says what they are.
    """

    def __init__(self, world: World, taxonomy: Taxonomy) -> None:
        self.world, self.taxonomy = world, taxonomy
        self.things = {t.name: t for t in world.things}
        self.contents = [contents(t.name) for t in world.things if t.filling is not None]
        self.types = {GRIPPER: "soma:Gripper", **{t.name: t.type for t in world.things}}
        self.types |= {f"{t.name}/{f.name}": f.type for t in world.things for f in t.features}

    def ground(self, rules: Iterable[Rule], tasks: Mapping[str, TaskType]) -> tuple[Operator, ...]:
        """The operators of those rules whose tasks a plugin offers."""
        return tuple(o for rule in rules if rule.task in tasks for o in self._ground(rule, tasks[rule.task]))

    def _ground(self, rule: Rule, task: TaskType) -> Iterator[Operator]:
        clauses = [(c.phase, part) for c in rule.clauses if c.phase != "run" for part in _parts(c.condition)]
        names = list(dict.fromkeys((*rule.roles, *(v for _, c in clauses for v in _variables(c)))))
        asked = [c for _, c in clauses if isinstance(c, Atom) and c.predicate.name in STATIC]
        atoms = [c for _, c in clauses if isinstance(c, Atom) and c.predicate.name == "contains"]
        inside = {v[1] for v in map(_variables, atoms) if len(v) == 2}
        for fillers in product(*(self.contents if n in inside else self._candidates(n, asked, task) for n in names)):
            binding = dict(zip(names, fillers, strict=True))
            if len(set(fillers)) == len(fillers) and (found := self._bound(rule, task, clauses, binding)):
                yield found

    def _candidates(self, name: str, asked: Iterable[Atom], task: TaskType) -> list[str]:
        """Entities that conditions on classes, and what the task type's role asks for, leave for a variable."""
        alone = [a for a in asked if _variables(a) == [name]]
        role = task.role(name)
        if any(a.predicate.name == "effector" for a in alone) or (role is not None and role.effector):
            return [GRIPPER]
        found = [e for e in self.types if e != GRIPPER and all(self.holds(a, {name: e}) for a in alone)]
        return [e for e in found if role is None or all(self.has(e, f) for f in role.features)]

    def _bound(
        self, rule: Rule, task: TaskType, clauses: Iterable[tuple[str, Condition]], binding: dict[str, str]
    ) -> Operator | None:
        """The operator for one choice of fillers; None where a condition on classes does not hold."""
        grasped = [
            c.arguments(dict(binding)) for _, c in clauses if isinstance(c, Atom) and c.predicate.name == "grasps"
        ]
        held = {str(thing) for _, thing in grasped}
        if not all(name in self.things and self.things[name].movable for name in held):
            return None  # only what can move can be in the hand
        chain = {GRIPPER, *held}
        before, after = (
            self._facts([c for p, c in clauses if p == phase], binding, chain) for phase in ("pre", "post")
        )
        if before is None or after is None:
            return None
        needs, adds = before[0], after[0]
        if (
            type(task).effects is TaskType.effects
        ):  # it brings nothing anywhere: what it ends in contact with, it touches before
            needs |= {f for f in adds if f[0] == "touches"}
        adds = _consequences(adds, held)
        if not (adds - needs) and not after[1]:
            return None
        return Operator(rule.task, {r: binding[r] for r in rule.roles}, needs, before[1], adds, after[1])

    def _facts(
        self, conditions: Iterable[Condition], binding: dict[str, str], chain: set[str]
    ) -> tuple[frozenset[Fact], frozenset[Pattern]] | None:
        """What must hold and what may not; None where it cannot be."""
        yes: set[Fact] = set()
        no: set[Pattern] = set()
        for condition in conditions:
            match condition:
                case Atom() if condition.predicate.name in (*STATIC, "chain"):
                    if not self.holds(condition, binding, chain):
                        return None
                case Atom():
                    yes |= _both(_pattern(condition, binding))
                case Not(Atom() as inner) if inner.predicate.name in (*STATIC, "chain"):
                    if self.holds(inner, binding, chain):
                        return None
                case Not(Atom() as inner):
                    no |= _untouched(_pattern(inner, binding))
                case Every(Atom() as given, then):
                    no |= self._others(given, then, binding, chain)
                case Compare(Atom() as left) if left.predicate.name == "constrained_dof":
                    dof = GUIDED_DOF if self.has(str(left.arguments(dict(binding))[0]), "vrps:Peg") else 1.0
                    if not OPERATORS[condition.symbol](dof, float(str(condition.right))):
                        return None
        return frozenset(yes), frozenset(no)

    def _others(self, given: Atom, then: Condition, binding: dict[str, str], chain: set[str]) -> set[Pattern]:
        """Facts that ``every given -> then`` forbids: those of entities of which ``then`` does not hold."""
        (free,) = [v for v in _variables(given) if v not in binding] or [""]
        inner, wanted = (then.inner, False) if isinstance(then, Not) else (then, True)
        if not free or not isinstance(inner, Atom) or inner.predicate.name not in (*STATIC, "chain"):
            return set()
        wrong = [e for e in self.types if self.holds(inner, {**binding, free: e}, chain) != wanted]
        return {p for e in wrong for p in _both(_pattern(given, {**binding, free: e}))}

    def holds(self, atom: Atom, binding: Mapping[str, str], chain: Iterable[str] = ()) -> bool:
        """A condition on classes and parts."""
        first, *rest = (str(a) for a in atom.arguments(dict(binding)))
        match atom.predicate.name:
            case "effector":
                return first == GRIPPER
            case "isa":
                return self._isa(first, rest[0])
            case "has":
                return self.has(first, rest[0])
            case "thing":
                return first in self.things
            case "part":
                return whole(rest[0]) == first != rest[0]
            case _:
                return whole(first) in chain

    def _isa(self, entity: str, class_: str) -> bool:
        return self.taxonomy.is_a(self.types.get(entity, ""), class_)

    def has(self, entity: str, class_: str) -> bool:
        """An entity is of a class, or a part of it is."""
        parts = [n for n in self.types if n == entity or ("/" not in entity and whole(n) == entity)]
        return any(self._isa(p, class_) for p in parts)


def _consequences(facts: frozenset[Fact], held: set[str]) -> frozenset[Fact]:
    """What is grasped is touched; what a held thing is brought to touch supports it, and is touched as a whole."""
    found = set(facts)
    for fact in facts:
        if fact[0] == "grasps":
            found |= _both(("touches", fact[1], fact[2]))
        if fact[0] == "touches" and fact[1] in held and fact[2] != GRIPPER:
            found |= {("supports", whole(fact[2]), fact[1])} | _both(("touches", fact[1], whole(fact[2])))
    return frozenset(found)


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


def _both(pattern: Pattern) -> set[Fact]:
    """Contact goes both ways."""
    return {pattern, ("touches", *pattern[:0:-1])} if pattern[0] == "touches" else {pattern}  # type: ignore[arg-type]


def _untouched(pattern: Pattern) -> set[Pattern]:
    """What a denial forbids; that nothing collides means that the gripper touches nothing."""
    if pattern[0] == "collides":
        return {("touches", GRIPPER, None), ("touches", None, GRIPPER)}
    return {pattern, ("touches", *pattern[:0:-1])} if pattern[0] == "touches" else {pattern}


def facts_of(world: World, relations: Iterable[tuple[str, str, str]]) -> frozenset[Fact]:
    """What holds at the start: what hangs, what stands on what, what is open, what is filled; the gripper is empty."""
    facts: set[Fact] = set()
    hanging = {s: o for p, s, o in relations if p == "hangs_on"}
    for thing in world.things:
        if thing.filling is not None:
            facts.add(("contains", thing.name, contents(thing.name)))
        hanger = hanging.get(thing.name)
        if hanger is not None:
            peg = world.thing(whole(hanger)).feature("vrps:Peg")
            for place in {whole(hanger), f"{whole(hanger)}/{peg.name}" if peg else hanger}:
                facts |= _both(("touches", thing.name, place))
            facts.add(("supports", whole(hanger), thing.name))
        elif thing.joint is not None:
            closed = thing.joint.value - thing.joint.lower < 0.1 * (thing.joint.upper - thing.joint.lower)
            facts.add(("joint_closed" if closed else "joint_open", thing.name))
        elif thing.movable and (below := _below(thing, world)):
            facts |= _both(("touches", thing.name, below)) | {("supports", below, thing.name)}
    return frozenset(facts)


def _below(thing: Thing, world: World) -> str | None:
    """The fixed thing with the highest surface under a thing; None where there is none."""
    x, y, z = thing.pose.position
    found = []
    for other in world.things:
        for feature in other.features:
            if other.movable or other.joint is not None or feature.type != "vrps:SurfaceFeature":
                continue
            across = (other.pose * feature.pose).inverse().apply((x, y, z))
            inside = all(
                abs(a) <= feature.size.get(k, 0.0) / 2 for a, k in zip(across, ("width", "depth"), strict=False)
            )
            if inside and across[2] >= 0.0:
                found.append((float(across[2]), other.name))
    return min(found)[1] if found else None

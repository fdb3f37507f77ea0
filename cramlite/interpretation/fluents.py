"""Fluents: relations that tasks change, with their initial state, implications and effects, for planning.

A predicate declares how its own behaves (``Predicate.fluent``). What never changes, classes and parts, a predicate
declares as ``Predicate.static``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import lru_cache
from itertools import product

from msgspec import field

from ..base.errors import PluginError, nearest
from ..base.value import Value
from ..model.entity_name import EntityName, thing_of
from ..model.world.thing import Thing
from ..model.world.world import World
from ..ontology.taxonomy import Taxonomy

EFFECTOR = "gripper"
"""Name of the acting hand in facts."""

Fact = tuple[str, ...]
"""A relation that holds: its predicate and the entities, e.g. ("touches", "tea", "hook/peg")."""

Pattern = tuple[str | None, ...]
"""Pattern of facts: a fact in which None stands for any argument."""


def matches(fact: Fact, pattern: Pattern) -> bool:
    """Check whether a fact matches a pattern."""
    if len(fact) != len(pattern):
        return False
    for said, asked in zip(fact, pattern, strict=True):  # noqa: SIM110  # `all` takes twice as long, which counts among 100 things
        if asked is not None and asked != said:
            return False
    return True


def matching(facts: frozenset[Fact], patterns: Iterable[Pattern]) -> set[Fact]:
    """Return the facts that match at least one of some patterns."""
    found, some = set[Fact](), dict[str | None, list[Pattern]]()
    for p in patterns:
        if None in p:
            some.setdefault(p[0], []).append(p)
        elif p in facts:
            found.add(p)  # type: ignore[arg-type]
    if anywhere := some.pop(None, []):
        found |= {f for f in facts if any(matches(f, p) for p in anywhere)}
    alike = by_predicate(facts) if some else {}
    return found | {f for name, asked in some.items() for f in alike.get(name or "", ()) if any(matches(f, p) for p in asked)}


@lru_cache(maxsize=64)
def by_predicate(facts: frozenset[Fact]) -> Mapping[str, tuple[Fact, ...]]:
    """Group facts by predicate.

    Results are cached, because a state is asked several times before the next one is reached.
    """
    found = dict[str, list[Fact]]()
    for f in facts:
        found.setdefault(f[0], []).append(f)
    return {name: tuple(rows) for name, rows in found.items()}


def pattern_text(pattern: Pattern) -> str:
    """Format a fact or pattern as rules write it: "grasps(_, tea)"."""
    return f"{pattern[0]}({', '.join(a or '_' for a in pattern[1:])})"


def contents(vessel: str) -> str:
    """Return the entity name of a vessel's content."""
    return str(EntityName(vessel, "contents"))


class SymbolicWorld(Value):
    """Symbolic state of a world before anything is done: the things and relations that predicates are evaluated on.

    Args:
        world: with its things and features.
        taxonomy: says what they are.
        relations: believed facts beside the world's poses, e.g. ("hangs_on", "tea", "hook").
        types: thing, or "thing/feature" -> class.
        held: things that are in the hand at some time of the task in question.
        in_hand: what is held at the start; "" for nothing.
        kept: things that no task may move.
    """

    world: World
    taxonomy: Taxonomy
    relations: tuple[tuple[str, str, str], ...]
    types: Mapping[str, str]
    held: frozenset[str] = frozenset()
    in_hand: str = ""
    kept: frozenset[str] = frozenset()

    @property
    def entities(self) -> tuple[str, ...]:
        """Names of the hand, the things and their features."""
        return (EFFECTOR, *self.types)

    def is_a(self, entity: str, class_: str) -> bool:
        """Check whether a thing or feature is of a class, or of a subclass of it."""
        return self.taxonomy.is_a(self.types.get(entity, ""), class_)

    def has(self, entity: str, class_: str) -> bool:
        """Check whether an entity is of a class, or has a feature of the class; features of things mounted on the
        entity count, too."""
        if self.is_a(entity, class_):
            return True
        whole = entity in self.types and entity == thing_of(entity)
        return whole and any(self.taxonomy.is_a(f.type, class_) for f in self.world.features_of(entity))

    def filled(self) -> tuple[Thing, ...]:
        """Return the vessels with something in them."""
        return tuple(t for t in self.world.things if t.filling is not None)


def symbolic_world(world: World, taxonomy: Taxonomy, relations: Iterable[tuple[str, str, str]] = ()) -> SymbolicWorld:
    """Return the symbolic state of a world."""
    types = {t.name: t.type for t in world.things}
    types |= {str(EntityName(t.name, f.name)): f.type for t in world.things for f in t.features}
    return SymbolicWorld(world, taxonomy, tuple(relations), types)


class Bound(Value):
    """Bounds of a measured value that must lie within them at the end of a run.

    Args:
        of: value predicate and the entities that it is asked about, e.g. ("joint_share", "drawer").
        low, high: both allowed.
    """

    of: Fact
    low: float
    high: float


class Manner(Value):
    """Manner of a goal: what the task that brings the goal about must have under ``where`` and as
    parameters.

    Args:
        where: keys of ``where`` for the task that puts the goal's first thing down, e.g. {"attitude": "upright"}.
        parameters: of the task that brings the goal's facts about, e.g. {"share": 0.6}.
        holds: whether it is so at the start, so that no task need bring it about.
    """

    where: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    holds: bool = False


class GoalCondition(Value):
    """Condition that a goal states: facts that must hold and patterns that no fact may match.

    Args:
        needs: facts that must hold in the end.
        without: patterns that nothing may match then.
        spot: whether it is reached by choosing a spot, so that the goal may say what the spot is beside.
        shown: further facts that a run must show in the end, which planning has no use for.
        bounds: values that a run must show in the end.
        manner: of the tasks that bring it about; None where any will do.
        instead: lists of goals; those of one list together fulfil the condition as well. Goals of a list that are not
            about its own thing are asked for anyway, or hold: they are not brought about for this.
    """

    needs: frozenset[Fact] = frozenset()
    without: frozenset[Pattern] = frozenset()
    spot: bool = False
    shown: frozenset[Fact] = frozenset()
    bounds: tuple[Bound, ...] = ()
    manner: Manner | None = None
    instead: tuple[tuple[str, ...], ...] = ()

    @property
    def denied(self) -> GoalCondition | None:
        """Return the opposite of the condition: a single required fact is forbidden, a single forbidden
        pattern is required; None for any other condition."""
        facts, (pattern, *others) = self.needs or self.shown, (*self.without, ())
        if len(facts) == 1 and not self.bounds:
            return GoalCondition(without=facts | self.shown)
        known = not facts and len(others) == 1 and None not in pattern
        return GoalCondition(needs=frozenset({tuple(map(str, pattern))})) if known else None


def _any_thing(_thing: Thing) -> bool:
    return True


def _any_things(_scene: SymbolicWorld, *_things: str) -> bool:
    return True


class GoalPhrase(Value):
    """Phrase by which goals may be written, e.g. "THING on PLACE".

    Args:
        form: words in capitals stand for things, the first word for the one that the goal is about; the others are
            written as they are. The last may be AMOUNT: a number with its unit, such as "120 mm". PLACE may also be a feature of a
            thing, such as "table/left".
        meaning: ``meaning(scene, *things)`` says what is asked for; it raises UserError where that makes no sense of these
            things. An amount follows the things, as it was written.
        verbs: words that may stand after the first one and change nothing.
        asked: how a person asks for it: a verb, then the words of the form, e.g. "put|place THING on|on_top_of PLACE". Bars are between
            words of which any will do, an underscore stands for a space; a verb's last word may also follow the thing
            ("turn_on THING").
        about: of which things it can be asked.
        suits: ``suits(scene, *things)``: whether people mean it of these things where their words leave open how: "take the tin to the
            box".
    """

    form: str
    meaning: Callable[..., GoalCondition]
    verbs: tuple[str, ...] = ("is",)
    asked: tuple[str, ...] = ()
    about: Callable[[Thing], bool] = _any_thing
    suits: Callable[..., bool] = _any_things


class Fluent(Value):
    """Declaration of how a relation that tasks change depends on others, such as which ones begin and end with it.

    Below, "the same arguments" means the same things, or parts of them.

    Args:
        symmetric: it holds both ways round.
        of_wholes: what holds of a part holds of the whole thing, as long as it holds of some part.
        implies: predicates that hold of the same arguments whenever it does: with them it begins, without them it ends.
        implies_when_carried: predicates that begin with it where the last argument is in the hand and no other is the hand.
        undoes: predicates that end with it, of the same arguments.
        excludes: predicates that cannot hold of the same arguments while it does: they end when it begins.
        contrary: ``contrary(scene, fact, other)``: whether a fact of it and another fact of any predicate cannot hold at one
            time in a world, beyond what ``excludes`` says, e.g. a thing on two tables that stand apart.
        in_hand: its last argument is in the hand; it must be something that can be moved.
        by_moving: only bringing something somewhere makes it so: of a task that changes nothing in the belief it is needed
            before as well.
        of_contents: its last argument is what a vessel was filled with (``contents``), not a thing.
        denial: patterns that its denial means, if not its own.
        initial: ``initial(scene)`` gives the rows of arguments that hold at the start.
        phrases: goals that ask for it.
        carrier: place of the carrier among its two arguments, counted from 0, where it says that one thing carries or encloses the
            other: nothing comes, over any number of such facts, to carry itself. None where it says no such thing.
    """

    symmetric: bool = False
    of_wholes: bool = False
    implies: tuple[str, ...] = ()
    implies_when_carried: tuple[str, ...] = ()
    undoes: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()
    contrary: Callable[[SymbolicWorld, Fact, Fact], bool] | None = None
    in_hand: bool = False
    by_moving: bool = False
    of_contents: bool = False
    denial: tuple[Pattern, ...] = ()
    initial: Callable[[SymbolicWorld], Iterable[tuple[str, ...]]] | None = None
    phrases: tuple[GoalPhrase, ...] = ()
    carrier: int | None = None


PLAIN = Fluent()
"""Relation without declarations, which begins and ends independently of all other relations."""


class Fluents(Value):
    """Fluents of all predicates: what a fact implies or excludes, and what a task's effects do to a set of
    facts.

    Args:
        of: predicate -> its fluent.
    """

    of: Mapping[str, Fluent] = field(default_factory=dict)

    def __getitem__(self, predicate: str | None) -> Fluent:
        return self.of.get(predicate or "", PLAIN)

    @property
    def phrases(self) -> tuple[GoalPhrase, ...]:
        """Phrases by which goals may be written."""
        return tuple(p for fluent in self.of.values() for p in fluent.phrases)

    def initial(self, scene: SymbolicWorld) -> frozenset[Fact]:
        """Return the facts that hold in a world before any task is done, those about the thing in the hand included."""
        asked = ((name, fluent.initial(scene)) for name, fluent in self.of.items() if fluent.initial is not None)
        found = frozenset(f for name, rows in asked for row in rows for f in self.both_ways((name, *row)))
        if not scene.in_hand:
            return found
        return found | self.implied({(name, EFFECTOR, scene.in_hand) for name, f in self.of.items() if f.in_hand}, {scene.in_hand})

    def about(self, facts: frozenset[Fact], names: Collection[str | None]) -> frozenset[Fact]:
        """Return the facts of some predicates, and of all that these imply; None stands for every predicate."""
        wider = {*names, *(p for name in names for p in self[name].implies)}
        if len(wider) > len(names):
            return self.about(facts, wider)
        return facts if None in wider else frozenset(f for f in facts if f[0] in wider)

    def both_ways(self, pattern: Pattern) -> set[Fact]:
        """Return the fact, or pattern, and its mirror image where the fluent is symmetric."""
        return {pattern, (pattern[0], *pattern[:0:-1])} if self[pattern[0]].symmetric else {pattern}  # type: ignore[arg-type]

    def denied(self, pattern: Pattern) -> set[Pattern]:
        """Return the patterns of all those facts that must be untrue where a fact of a given pattern is denied."""
        return {p for meant in self[pattern[0]].denial or (pattern,) for p in self.both_ways(meant)}

    def implied(self, facts: Iterable[Fact], held: Iterable[str]) -> frozenset[Fact]:
        """Return the given facts, which begin to hold, and all that they imply; ``held`` are the things in
        the hand."""
        found, carried = set(facts), frozenset(held)
        todo = list(found)
        while todo:
            new = self._follow(todo.pop(), found, carried) - found
            found |= new
            todo += new
        return frozenset(found)

    def _follow(self, fact: Fact, facts: set[Fact], held: frozenset[str]) -> set[Fact]:
        fluent, (_, *things) = self[fact[0]], _of_wholes(fact)
        known = {_of_wholes(f) for f in facts}
        names = [p for p in fluent.implies if (p, *things) not in known]
        if things[-1:] and things[-1] in held and EFFECTOR not in things:
            names += fluent.implies_when_carried
        found = {f for p in names for f in self.both_ways((p, *things))} | self.both_ways(fact)
        return found | (self.both_ways((fact[0], *things)) if fluent.of_wholes and _distinct(things) else set())

    def after(self, facts: frozenset[Fact], adds: frozenset[Fact], removes: Iterable[Pattern]) -> frozenset[Fact]:
        """Return the facts after a task that adds some and removes those that match patterns, with all
        that follows from it."""
        patterns = tuple(removes)
        ended = matching(facts, patterns) - adds
        excluded = {(p, *_of_wholes(new)[1:]) for new in adds for p in self[new[0]].excludes}
        ended |= _as_wholes(facts, excluded) - adds
        lost = {(p, *_of_wholes(f)[1:]) for f in ended for p in self[f[0]].undoes}
        ended |= _as_wholes(facts, lost)
        ended = {m for f in ended for m in self.both_ways(f)}
        left = (facts - ended) | adds
        if not ended:
            return left
        left -= self._parted(ended, left) - adds
        named = {name for name, fluent in self.of.items() if fluent.implies}
        implying = [f for f in left if f[0] in named]
        meant = {p for name in named for p in self[name].implies}
        known = {_of_wholes(f) for f in left if f[0] in meant}
        return left - {f for f in implying if not all((p, *_of_wholes(f)[1:]) in known for p in self[f[0]].implies)}

    def clash(self, scene: SymbolicWorld, one: GoalCondition, other: GoalCondition) -> str:
        """Explain why two conditions cannot both hold in a world, by the predicates' declarations; "" if
        they can."""
        mine, its = (self.implied(c.needs | c.shown, ()) for c in (one, other))
        for facts, patterns in ((mine, other.without), (its, one.without)):
            denied = {p for pattern in patterns for p in self.both_ways(pattern)}
            for fact in sorted(facts):
                if any(matches(fact, p) for p in denied):
                    return f"one condition requires {pattern_text(fact)}, the other forbids it"
        for a, b in product(sorted(mine), sorted(its)):
            if self._contrary(scene, a, b):
                return f"{pattern_text(a)} and {pattern_text(b)} cannot hold at the same time"
        for first, second in product(one.bounds, other.bounds):
            if first.of == second.of and (first.high < second.low or second.high < first.low):
                between = (f"{b.low:.2f} to {b.high:.2f}" for b in (first, second))
                return f"{pattern_text(first.of)} is required to be {' and '.join(between)}"
        return ""

    def ring(self, facts: Iterable[Fact]) -> tuple[Fact, ...]:
        """Return a cycle of facts by which a thing would carry itself; empty if there is none."""
        carried = [(f, *self.carries(f)) for f in sorted(facts) if self[f[0]].carrier is not None]

        def follow(way: tuple[Fact, ...], first: str, last: str) -> tuple[Fact, ...]:
            if way and first == last:
                return way
            further = (follow((*way, f), first, below) for f, above, below in carried if above == last and f not in way)
            return next((found for found in further if found), ())

        return next((found for above in dict.fromkeys(a for _, a, _ in carried) if (found := follow((), above, above))), ())

    def carries(self, fact: Fact) -> tuple[str, str]:
        """Return the carrier and the carried thing of a fact whose fluent declares a ``carrier``."""
        things = [thing_of(name) for name in fact[1:]]
        return (things[0], things[1]) if self[fact[0]].carrier == 0 else (things[1], things[0])

    def _excluded(self, fact: Fact, by: Fact) -> bool:
        return fact[0] in self[by[0]].excludes and _of_wholes(fact)[1:] == _of_wholes(by)[1:]

    def _contrary(self, scene: SymbolicWorld, one: Fact, other: Fact) -> bool:
        pairs = ((one, other), (other, one))
        contraries = ((self[a[0]].contrary, a, b) for a, b in pairs)
        return any(self._excluded(a, b) for a, b in pairs) or any(j is not None and j(scene, a, b) for j, a, b in contraries)

    def _parted(self, ended: Iterable[Fact], left: Iterable[Fact]) -> set[Fact]:
        """Return the relations between whole things that end because the last such relation between their parts ends."""
        gone = {_of_wholes(f) for f in ended if self[f[0]].of_wholes}
        names = {f[0] for f in gone}
        return gone - {_of_wholes(f) for f in left if f[0] in names and f not in gone} if gone else gone


def _as_wholes(facts: frozenset[Fact], wholes: set[Fact]) -> set[Fact]:
    """Return the facts that become one of the facts ``wholes`` when each feature in them is replaced by its thing."""
    return {f for p in {w[0] for w in wholes} for f in by_predicate(facts).get(p, ()) if _of_wholes(f) in wholes}


@lru_cache(maxsize=100_000)
def _of_wholes(fact: Fact) -> Fact:
    return (fact[0], *map(thing_of, fact[1:]))


def _distinct(things: list[str]) -> bool:
    """Check whether all things of a fact differ, since no thing is related to itself or to its own parts."""
    return len(set(things)) == len(things)


def fluents_of(found: Mapping[str, Fluent]) -> Fluents:
    """Collect the fluents that predicates declare, by the predicates' names.

    Raises:
        PluginError: one names a predicate that there is not, or two declare one phrase.
    """
    for name, fluent in found.items():
        denied = tuple(str(p[0]) for p in fluent.denial)
        for other in (*fluent.implies, *fluent.implies_when_carried, *fluent.undoes, *fluent.excludes, *denied):
            if other not in found:
                raise PluginError(
                    f"The predicate '{name}' refers to a predicate '{other}', which no plugin declares; {nearest(other, found)}."
                )
    _check_phrases(found)
    return Fluents(found)


def _check_phrases(fluents: Mapping[str, Fluent]) -> None:
    first: dict[str, str] = {}
    for name, fluent in fluents.items():
        for phrase in fluent.phrases:
            said = " ".join("_" if w.isupper() else w for w in phrase.form.split())
            if first.setdefault(said, name) != name:
                raise PluginError(
                    f"The predicates '{first[said]}' and '{name}' both declare the goal phrase '{phrase.form}'; change one of them."
                )

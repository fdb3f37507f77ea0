"""The matcher against clingo, an answer-set solver: from the same rule files, on the same facts, the same matches.

Also the decision tree against the plain matcher, which defines it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from interpretation_samples import action, episode, state, track

from cramlite.conditions import And, Atom, Compare, Condition, Every, Not, Or, Term, Variable, atoms, binds, mentions
from cramlite.decision import DecisionTree
from cramlite.episode import Entity, Episode, Event
from cramlite.geometry import Pose
from cramlite.matching import Phases, match, reject
from cramlite.ontology import load_taxonomy
from cramlite.phases import PhaseName, Timeline
from cramlite.resources import data_folder
from cramlite.rules import Rule, load_rules
from cramlite_plugins.experts.predicates import all_predicates

clingo = pytest.importorskip("clingo")

TAXONOMY = load_taxonomy([data_folder("ontologies")])
RULES = load_rules([data_folder("task_rules")], all_predicates(), TAXONOMY)
SCALE = 1000  # clingo counts in integers


@dataclass
class Program:
    """A logic program in the making: one rule of ours becomes one rule of its and some helpers."""

    lines: list[str] = field(default_factory=list)
    helpers: Iterator[int] = field(default_factory=itertools.count)

    def add(self, rule: Rule) -> None:
        bound = frozenset().union(*(binds(c.condition) for c in rule.clauses))
        body = ", ".join(self.literal(c.condition, c.phase, bound) for c in rule.clauses)
        roles = ", ".join([quoted(rule.task), *rule.roles])
        self.lines.append(f"match{len(rule.roles)}({roles}) :- {body}.")

    def literal(self, condition: Condition, phase: PhaseName, outer: frozenset[str]) -> str:
        """A body literal that is true where the condition is."""
        match condition:
            case Atom(predicate, terms):
                return f"fact({', '.join([phase, quoted(predicate.name), *map(term, terms)])})"
            case Compare(left, symbol, right):
                sign = {"==": "="}.get(symbol, symbol)
                if isinstance(left, Variable):
                    return f"{left.name} {sign} {term(right)}"
                value = f"Value{next(self.helpers)}"
                inner = [phase, quoted(left.predicate.name), *map(term, left.terms), value]
                return f"fact({', '.join(inner)}), {value} {sign} {term(right)}"
            case Not(inner):
                return f"not {self.helper([inner], phase, mentions(inner) & outer, outer)}"
            case Every(given, then):
                inside = outer | binds(given)
                kept = self.helper([then], phase, mentions(then) & inside, inside)
                broken = self.named(mentions(condition) & outer)
                domain = self.domain((mentions(condition) & outer) | (mentions(then) & inside))
                self.lines.append(f"{broken} :- {domain}{self.literal(given, phase, outer)}, not {kept}.")
                return f"not {broken}"
            case And(parts):
                return ", ".join(self.literal(p, phase, outer) for p in parts)
            case Or(options):
                return self.helper(options, phase, (mentions(condition) & outer) | binds(condition), outer)

    def named(self, variables: Iterable[str]) -> str:
        return f"helper{next(self.helpers)}({', '.join(sorted(variables)) or '0'})"

    def domain(self, variables: Iterable[str]) -> str:
        return "".join(f"thing({v}), " for v in sorted(variables))

    def helper(
        self, options: Iterable[Condition], phase: PhaseName, variables: frozenset[str], outer: frozenset[str]
    ) -> str:
        """A helper predicate that holds where one of the options does."""
        name = self.named(variables)
        for option in options:
            self.lines.append(f"{name} :- {self.domain(variables)}{self.literal(option, phase, outer)}.")
        return name


def quoted(text: str) -> str:
    return '"' + text + '"'


def term(value: Term) -> str:
    if isinstance(value, Variable):
        return value.name
    return quoted(value) if isinstance(value, str) else str(round(value * SCALE))


PROGRAM = Program()
for one in RULES:
    PROGRAM.add(one)


def facts(phases: Phases, names: list[str]) -> Iterator[str]:
    """Every row of every predicate that the rules mention, asked for every combination of things."""
    asked = {(c.phase, a.predicate, a.terms) for r in RULES for c in r.clauses for a in atoms(c.condition)}
    for name in names:
        yield f"thing({quoted(name)})."
    for phase, predicate, terms in asked:
        choices = [[t] if not isinstance(t, Variable) else names for t in terms]
        for arguments in itertools.product(*choices):
            for row in phases[phase].rows(predicate, arguments):
                shown = ", ".join([phase, quoted(predicate.name), *map(term, row)])
                yield f"fact({shown})."


def solved_by_clingo(phases: Phases, names: list[str]) -> set[tuple[str, ...]]:
    control = clingo.Control(["--warn=none"])
    control.add("base", [], "\n".join([*PROGRAM.lines, *facts(phases, names)]))
    control.ground([("base", [])])
    found: set[tuple[str, ...]] = set()
    with control.solve(yield_=True) as handle:
        for model in handle:
            found = {
                tuple(a.string for a in s.arguments) for s in model.symbols(atoms=True) if s.name.startswith("match")
            }
    return found


THINGS = (
    Entity("box", ("cram:BoxedProduct",), pose=Pose((0.5, 0, 0.1)), size=(0.1, 0.1, 0.1)),
    Entity("jar", ("soma:Jar",), pose=Pose((0.5, 0, 0)), size=(0.2, 0.2, 0.2)),
    Entity("lid", ("soma:Lid",), pose=Pose((0.4, 0, 0))),
    Entity("rack", ("cram:Hanger",), pose=Pose((0, 1, 0))),
    Entity("rack/peg", ("vrps:Peg",), part_of="rack", pose=Pose()),
)
NAMES = ["hand", *(t.name for t in THINGS)]


@st.composite
def episodes(draw: st.DrawFn) -> Episode:
    events: list[Event] = [action("soma:PhysicalAction", 2, 4, object=draw(st.sampled_from(NAMES[1:4])))]
    for k in range(draw(st.integers(0, 10))):
        kind = draw(st.sampled_from(["contact", "support", "grasp", "contain"]))
        first = "hand" if kind == "grasp" else draw(st.sampled_from(NAMES))
        second = draw(st.sampled_from([n for n in NAMES if n != first]))
        start = draw(st.integers(0, 4))
        made = state(kind, first, second, start, start + draw(st.integers(1, 6)))
        events.append(Event(f"{k}", made.type, "state", made.start, made.end, made.roles))
    goal = draw(st.sampled_from([0.0, 0.0004, 0.2]))
    last = draw(st.sampled_from([0.0, 0.05, 0.1]))
    hand = track((0, 0.2, 0, 0.1), (2, 0.2, 0, 0.1), (4, 0.2 + goal, 0, 0.1), (10, 0.2, 0, 0.1))
    lid = track((0, 0.4, 0, 0), (2, 0.4, 0, 0), (4, 0.4 + draw(st.sampled_from([0.0, 0.1])), 0, 0), (10, 0.4, 0, 0))
    opening = np.array([(0, 0.0), (2, 0.05), (4, last), (10, 0.0)])
    return episode(THINGS, events, {"hand": hand, "lid": lid}, opening)


@settings(max_examples=40, deadline=None)
@given(episodes())
def test_clingo_finds_the_same_matches(sample: Episode) -> None:
    timeline = Timeline(sample, TAXONOMY)
    names = [e.name for e in sample.entities]
    for segment in timeline.segments():
        phases = timeline.phases(segment)
        ours = {(m.task, *m.roles.values()) for rule in RULES for m in match(rule, phases)}
        assert ours == solved_by_clingo(phases, names)


@settings(max_examples=80, deadline=None)
@given(episodes())
def test_the_tree_and_the_rejections_agree_with_the_matcher(sample: Episode) -> None:
    timeline, tree = Timeline(sample, TAXONOMY), DecisionTree(RULES)
    for segment in timeline.segments():
        phases = timeline.phases(segment)
        solved = tree.solve(phases)
        for rule in RULES:
            matches = match(rule, phases)
            fillings = {tuple(b[r] for r in rule.roles) for b in solved.get(rule.task, ())}
            assert fillings == {tuple(m.roles.values()) for m in matches}
            assert (reject(rule, phases) is None) == bool(matches)


def test_the_oracle_can_disagree() -> None:
    """A matcher that forgot a condition would be found: without its facts clingo finds nothing."""
    events = [state("grasp", "hand", "box", 1, 3), action("soma:PhysicalAction", 0, 2)]
    sample = episode(THINGS, events, {"hand": track((0, 0, 0, 0), (5, 0, 0, 0))})
    timeline = Timeline(sample, TAXONOMY)
    phases = timeline.phases(timeline.segments()[0])
    assert ("soma:Grasping", "box") in solved_by_clingo(phases, [e.name for e in sample.entities])
    assert ("soma:Grasping", "box") not in solved_by_clingo({**phases, "post": timeline.instant(3.0)}, NAMES)

"""The matcher against clingo, an answer-set solver: from the same rule files, on the same facts, the same matches.

Also the decision tree against the plain matcher, which defines it.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers.interpretation_samples import action, episode, state, track
from helpers.plain_matcher import match
from helpers.properties import examples
from helpers.rule_translations import clingo_facts, clingo_program, facts_of
from hypothesis import given
from hypothesis import strategies as st

from cramlite import data_folder
from cramlite.interpretation.decision_tree import DecisionTree
from cramlite.interpretation.matching import Phases, reject
from cramlite.interpretation.rules import load_rules
from cramlite.model import Entity, Episode, Event, Pose
from cramlite.ontology.taxonomy import load_taxonomy
from cramlite.plugin import Timeline
from cramlite_plugins.predicates.relations import all_predicates

clingo = pytest.importorskip("clingo")

TAXONOMY = load_taxonomy([data_folder("ontologies")])
RULES = load_rules([data_folder("task_rules")], all_predicates(), TAXONOMY)
PROGRAM = clingo_program(RULES)


def solved_by_clingo(phases: Phases, names: list[str]) -> set[tuple[str, ...]]:
    control = clingo.Control(["--warn=none"])
    control.add("base", [], "\n".join([*PROGRAM, *clingo_facts(facts_of(RULES, phases, names), names)]))
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


@pytest.mark.heavy
@examples(40)
@given(episodes())
def test_clingo_finds_the_same_matches(sample: Episode) -> None:
    timeline = Timeline(sample, TAXONOMY)
    names = [e.name for e in sample.entities]
    for segment in timeline.segments():
        phases = timeline.phases(segment)
        ours = {(m.task, *m.roles.values()) for rule in RULES for m in match(rule, phases)}
        assert ours == solved_by_clingo(phases, names)


@examples(80)
@given(episodes())
def test_the_tree_and_the_rejections_agree_with_the_matcher(sample: Episode) -> None:
    timeline = Timeline(sample, TAXONOMY)
    tree = DecisionTree(RULES, timeline)
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

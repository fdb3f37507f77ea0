"""Phases and predicates against clingo and SWI-Prolog, which are given an episode's states, classes and measurements
and derive the rest by rules of their own: the same matches."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from helpers.interpretation_samples import action, episode, hanger_episode, state, track
from helpers.properties import examples
from helpers.timeline_translation import (
    VARIANTS,
    absent,
    by_clingo,
    by_prolog,
    clingo_timeline,
    timeline_facts,
    timeline_program,
)
from hypothesis import given
from test_rules_oracle import RULES, TAXONOMY, THINGS, episodes

from cramlite.interpretation.decision_tree import DecisionTree
from cramlite.model import Episode
from cramlite.plugin import Timeline


def ours(timeline: Timeline) -> set[tuple[object, ...]]:
    segments = timeline.segments()
    solved = DecisionTree(RULES, timeline).solve_all([timeline.phases(s) for s in segments])
    roles = {r.task: tuple(r.roles) for r in RULES}
    return {(k, t, *(str(b[r]) for r in roles[t])) for k, f in enumerate(solved) for t, bs in f.items() for b in bs}


@examples(40)
@given(episodes())
def test_clingo_derives_phases_and_relations(sample: Episode) -> None:
    timeline = Timeline(sample, TAXONOMY)
    assert by_clingo(clingo_timeline(RULES, timeline, timeline.segments()))[1] == ours(timeline)


@pytest.mark.skipif(absent(), reason="SWI-Prolog is not installed")
@examples(8)
@given(episodes())
def test_prolog_derives_everything_but_extremes(sample: Episode) -> None:
    timeline = Timeline(sample, TAXONOMY)
    facts = timeline_facts(timeline, timeline.segments())
    assert by_prolog(timeline_program(RULES, "tabled"), facts)[1] == ours(timeline)


@pytest.mark.skipif(absent(), reason="SWI-Prolog is not installed")
@pytest.mark.parametrize("variant", VARIANTS)
def test_prolog_on_a_whole_demonstration(variant: str) -> None:
    timeline = Timeline(hanger_episode(), TAXONOMY)
    found = by_prolog(timeline_program(RULES, variant), timeline_facts(timeline, timeline.segments()))[1]
    assert found == ours(timeline)
    assert ("artm:ExtractHoleFromPeg", "product", "hanger/peg") in {m[1:] for m in found}


def shifted(line: str) -> str:
    return line.replace("state('cram:GraspState', 0, 1", "state('cram:GraspState', 0, 0")


@pytest.mark.skipif(absent(), reason="SWI-Prolog is not installed")
@pytest.mark.parametrize(("change", "same"), [(str, True), (shifted, False)])
def test_the_oracle_can_disagree(change: Callable[[str], str], same: bool) -> None:
    """A grasp that began before the action, told to Prolog only, would be found."""
    events = [state("grasp", "hand", "box", 1, 3), action("soma:PhysicalAction", 0, 2)]
    timeline = Timeline(episode(THINGS, events, {"hand": track((0, 0, 0, 0), (5, 0, 0, 0))}), TAXONOMY)
    facts = [change(f) for f in timeline_facts(timeline, timeline.segments())]
    assert (by_prolog(timeline_program(RULES, "as stated"), facts)[1] == ours(timeline)) is same

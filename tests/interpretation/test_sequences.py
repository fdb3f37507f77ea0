"""Task sequences: counted, complete, lazy, best first."""

from __future__ import annotations

import itertools
import math

import pytest
from helpers.interpretation_reading import TAXONOMY
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Interpretation
from cramlite.interpretation.coherence import OFFERED
from cramlite.interpretation.ranking import DescriptionLength, naming_length
from cramlite.plugin import Interpreted, Match

CHOICES = st.lists(
    st.lists(
        st.builds(
            Match,
            st.sampled_from(["soma:Grasping", "soma:Reaching", "artm:NoOp"]),
            st.dictionaries(st.sampled_from(["Patient", "Goal"]), st.sampled_from("ab"), max_size=2),
            st.just(""),
            st.integers(0, 8),
        ),
        max_size=3,
    ),
    max_size=5,
)


@examples(60)
@given(CHOICES)
def test_sequences_are_complete_and_shortest_first(choices: list[list[Match]]) -> None:
    """Where no rule says that anything begins or ends, every reading may be chosen, and nothing is left out."""
    found = Interpretation("x", tuple(Interpreted(k, k + 1, tuple(m)) for k, m in enumerate(choices)), TAXONOMY)
    listed = list(found.sequences())
    explained = [c for c in choices if c]
    assert found.count() == (math.prod(len(c) for c in explained) if explained else 0)
    assert len(listed) == min(found.count(), OFFERED)
    scores = [s.score for s in listed]
    assert all(a >= b - 1e-9 for a, b in itertools.pairwise(scores))
    for one in listed:
        assert one.actions == tuple(range(len(explained)))
        total = sum((naming_length(m, explained[k], TAXONOMY, 1.0) for k, m in enumerate(one.matches)), DescriptionLength())
        assert one.score == pytest.approx(-total.bits)


def test_sequences_are_lazy_and_bounded_in_number_and_memory() -> None:
    choices = tuple(Match("soma:Grasping", {"Patient": p}, "") for p in "abc")
    found = Interpretation("x", tuple(Interpreted(k, k + 1, choices) for k in range(300)), TAXONOMY)
    assert found.count() == 3**300
    listed = list(found.sequences(cap=2000))
    assert 5 < len(listed) <= OFFERED
    assert listed[0].score == max(s.score for s in listed)


GRASP, REACH = Match("soma:Grasping", {"Patient": "cup"}, "", 3), Match("soma:Reaching", {"Goal": "cup"}, "", 5)
CARRY = [Match("soma:Transporting", {"Patient": "cup", "Destination": d}, "", 7) for d in ("bowl", "plate", "box")]


@pytest.mark.parametrize("count", [1, 3])
def test_a_free_choice_costs_and_what_is_known_does_not(count: int) -> None:
    length = naming_length(CARRY[0], CARRY[:count], TAXONOMY, 4.0)
    assert length.choices == pytest.approx(math.log2(count))


def test_what_is_not_known_costs() -> None:
    sure, unsure = (Match("soma:Pouring", {}, "", 5, 0, unknown) for unknown in ((), ("no shape of 'bowl'",)))
    assert naming_length(unsure, [unsure], TAXONOMY, 4.0).bits > naming_length(sure, [sure], TAXONOMY, 4.0).bits


def test_what_the_recording_names_is_not_left_out_for_nothing() -> None:
    shaken = Match("cram:Shaking", {"Patient": "cup"}, "", 3)
    named = Interpretation("x", (Interpreted(0, 1, (shaken,), label="cram:Shaking"),), TAXONOMY)
    best, other = named.sequences(), 0
    assert [m.task for m in next(best).matches] == ["cram:Shaking"]
    assert other == len(list(best))  # the empty sequence is none


def test_what_moved_and_a_task_speaks_of_is_explained_or_told() -> None:
    """A cup that is elsewhere in the end was carried; who only reached for it leaves that to be told."""
    readings = (CARRY[0], Match("artm:NoOp", {}, "", 2))
    here, away = (Interpreted(0, 1, readings, label=None, _moved=lambda m=m: m) for m in ((), ("cup",)))  # type: ignore[misc]
    grasped = Interpreted(1, 2, (Match("cram:Shaking", {"Patient": "cup"}, "", 3),), label="cram:Shaking")
    for action, carried in ((here, False), (away, True)):
        best = next(Interpretation("x", (action, grasped), TAXONOMY).sequences())
        assert ("soma:Transporting" in [m.task for m in best.matches]) == carried

"""Task sequences: counted, complete, lazy, best first."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from interpretation_reading import TAXONOMY
from properties import examples

from cramlite import Interpretation
from cramlite.interpretation.ranking import affinity, specificity
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
def test_sequences_are_counted_complete_and_best_first(choices: list[list[Match]]) -> None:
    found = Interpretation("x", tuple(Interpreted(k, k + 1, tuple(m)) for k, m in enumerate(choices)), TAXONOMY)
    listed = list(found.sequences())
    explained = [c for c in choices if c]
    assert found.count() == len(listed) == (math.prod(len(c) for c in explained) if explained else 0)
    scores = [s.score for s in listed]
    assert all(a >= b - 1e-9 for a, b in itertools.pairwise(scores))
    for one in listed:
        total = sum(specificity(m, TAXONOMY) for m in one.matches) + sum(
            affinity(a, b) for a, b in itertools.pairwise(one.matches)
        )
        assert one.score == pytest.approx(total)


def test_sequences_are_lazy_and_bounded_in_memory() -> None:
    choices = tuple(Match("soma:Grasping", {"Patient": p}, "") for p in "abc")
    found = Interpretation("x", tuple(Interpreted(k, k + 1, choices) for k in range(300)), TAXONOMY)
    assert found.count() == 3**300
    listed = list(itertools.islice(found.sequences(cap=2000), 5))
    assert len(listed) == 5
    assert listed[0].score == max(s.score for s in listed)

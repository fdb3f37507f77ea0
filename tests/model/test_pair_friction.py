"""Friction of a pair: of two alike that of one, as slippery as the smoother one asks for, and the same both ways."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import pair_friction

COEFFICIENTS = st.just(0.0) | st.floats(1e-6, 100.0)


@given(COEFFICIENTS, COEFFICIENTS)
def test_it_lies_between_the_smaller_one_and_twice_that(a: float, b: float) -> None:
    both, least = pair_friction(a, b), min(a, b)
    assert both == pair_friction(b, a)
    assert least * (1 - 1e-12) <= both <= min(2 * least, max(a, b)) * (1 + 1e-12)


@given(COEFFICIENTS)
def test_two_alike_keep_their_own_and_one_without_makes_both_slide(a: float) -> None:
    assert pair_friction(a, a) == pytest.approx(a)
    assert pair_friction(a, 0.0) == 0.0


@given(st.floats(0.01, 10.0), st.floats(0.01, 10.0), st.floats(1.01, 3.0))
def test_each_of_the_two_counts(a: float, b: float, rougher: float) -> None:
    assert pair_friction(a * rougher, b) > pair_friction(a, b) < pair_friction(a, b * rougher)

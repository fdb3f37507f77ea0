"""What held in some demonstrations of known tasks and not in others is no safe condition."""

from __future__ import annotations

import pytest

from cramlite.learning.learner import lapsed


def test_what_always_held_is_safe() -> None:
    assert lapsed([[True] * 4, [True] * 3, [False] * 3], 3) == 0.0
    assert lapsed([], 3) == lapsed([[True]], 3) == 0.0, "one demonstration says nothing"


def test_what_held_in_some_only_is_not() -> None:
    assert lapsed([[True, True, False]], 2) == pytest.approx(0.25)
    assert lapsed([[True, True, False]] * 9, 2) == pytest.approx(0.75)
    mixed = [[True, True, False], *[[True] * 3] * 8]
    assert 0.0 < lapsed(mixed, 2) < 0.05


def test_more_examples_make_it_safer() -> None:
    held = [[True] * 9 + [False]] * 3
    assert lapsed(held, 5) < 0.5 and lapsed([[True, False, False, False]], 3) == 0.0

"""What lasts for a time: the least over it, from each sample on."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite_plugins.validators.lasting import lasting

VALUES = np.array([3.0, 5.0, 4.0, 9.0, 1.0])
TIMES = 10.0 + 0.25 * np.arange(5)


@pytest.mark.parametrize(
    ("seconds", "least"),
    [(0.0, [3, 5, 4, 9, 1]), (0.25, [3, 4, 4, 1]), (0.5, [3, 4, 1]), (1.0, [1]), (1.25, [0])],
)
def test_the_least_of_each_stretch_of_so_long(seconds: float, least: list[float]) -> None:
    assert lasting(VALUES, TIMES, seconds).tolist() == least


@pytest.mark.parametrize(("count", "seconds", "least"), [(0, 0.0, [0]), (1, 0.0, [0]), (2, 0.25, [3]), (2, 0.5, [0])])
def test_a_run_that_is_shorter_has_nothing_that_lasts(count: int, seconds: float, least: list[float]) -> None:
    assert lasting(VALUES[:count], TIMES[:count], seconds).tolist() == least

"""Ways from above and aside."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite_plugins.locations.from_aside import slants


@given(st.floats(0.01, 0.5))
def test_each_way_leads_up_by_the_rise_and_as_far_aside(rise: float) -> None:
    for _, way in slants(rise):
        assert way[2] == pytest.approx(rise)
        assert math.hypot(way[0], way[1]) == pytest.approx(rise)


def test_four_sides_the_robots_own_first() -> None:
    ways = [tuple(way.round(9)[:2]) for _, way in slants(0.1)]
    assert ways[0] == (-0.1, 0.0)
    assert set(ways) == {(-0.1, 0.0), (0.1, 0.0), (0.0, 0.1), (0.0, -0.1)}
    assert next(said for said, _ in slants(0.1)) == "aside at 180 deg"

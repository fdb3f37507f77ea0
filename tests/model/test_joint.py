"""How far a thing on a joint is open: from the lower end on, or either way from where a spring draws it to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Joint, Pose, opened

SHARES = st.floats(0.0, 1.0)


@given(SHARES, st.sampled_from([0.0, 0.5]), st.sampled_from([-2.0, -0.5]))
def test_without_a_spring_or_with_its_rest_at_the_lower_end_it_is_closed_there(share: float, spring: float, rest: float) -> None:
    joint = Joint("hinge", Pose(), -0.5, 1.5, spring=spring, rest=rest)
    assert joint.closed == -0.5 and joint.opening(-0.5 + 2.0 * share) == pytest.approx(share)


@given(SHARES)
def test_a_lever_that_turns_both_ways_opens_both_ways(share: float) -> None:
    lever = Joint("hinge", Pose(), -1.5, 1.5, spring=0.5)
    assert lever.opening(0.0) == 0.0 and lever.opening(1.5 * share) == lever.opening(-1.5 * share) == pytest.approx(share)


def test_the_farther_end_is_all_the_way_and_values_may_be_many() -> None:
    assert opened(np.array([-0.5, 0.0, 1.0]), -0.5, 1.0, 0.0).tolist() == [0.5, 0.0, 1.0]
    assert Joint("slide", Pose(), 0.0, 0.2, spring=9.0, rest=0.5).opening(0.2) == 0.0, "pressed against its stop it is closed"

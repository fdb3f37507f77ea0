"""Where things ended is measured against where what holds them is by then."""

from __future__ import annotations

import numpy as np
import pytest
from edited import proven
from msgspec.structs import replace

from cramlite.model import Rollout, Touch
from cramlite_plugins.validators.postconditions import EndState, _not_on, at_the_end


def shifted(rollout: Rollout, by: float, *things: str) -> Rollout:
    """The rollout with some things elsewhere in its second half, as if they had been moved [m]."""
    poses = dict(rollout.poses)
    for thing in things:
        poses[thing] = poses[thing].copy()
        poses[thing][len(rollout.times) // 2 :, 0] += by
    return replace(rollout, poses=poses)


@pytest.mark.parametrize(("moved", "passes"), [((), True), (("basket",), False), (("basket", "block"), True)])
def test_in_a_container_is_in_it_where_it_is_then(moved: tuple[str, ...], passes: bool) -> None:
    good = proven("ungrasping")
    assert good.rollout is not None
    judged = replace(good, rollout=shifted(good.rollout, 0.3, *moved))
    assert all(f.passed for f in EndState().check(judged)) == passes


@pytest.mark.parametrize(("share", "passes"), [(0.51, True), (0.49, False)])
def test_on_a_support_is_what_it_bears(share: float, passes: bool) -> None:
    good = proven("placing").rollout
    assert good is not None
    weight = 9.81 * (good.world.thing("block").mass or 0.0)
    leaning = replace(good, touches=(*good.touches[:-1], (Touch("block", "shelf", 5.0, -share * weight),)))
    said = _not_on(leaning, "block", at_the_end(good, "shelf"))
    assert (said == "") == passes
    assert passes or ("of the" in said and "weighs at the end" in said)


def test_a_thing_is_where_the_run_left_it() -> None:
    good = proven("placing").rollout
    assert good is not None
    assert np.allclose(at_the_end(good, "block").pose.position, good.poses["block"][-1][:3])

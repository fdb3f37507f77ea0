"""What a run that ended says of a hand from a file that closed in vain."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_runs import COUNT, HANDOVERS, ORIGINS, good
from msgspec.structs import replace

from cramlite.model import Fallback, Linkage, SetGripper, Wait
from cramlite.plugin import Candidate
from cramlite_plugins.validators.empty_hand import KEYS, closed_on_nothing
from cramlite_plugins.validators.grips import OPENED

LINKAGE = Linkage((0.085, 0.0), (), ((), ()), (), (), ((), ()), ((), ()))
CLOSE = SetGripper(0.04, 0.1, 50.0, expect="object", origin=ORIGINS[1])
CLOSING = 15  # a sample at which that runs


def ended(wide: float, *steps: SetGripper | Fallback | Wait, linkage: Linkage | None = LINKAGE) -> Candidate:
    """The candidate, whose hand is from a file, closes in its first step and is so wide at the end."""
    base = good(opening=np.full(COUNT, wide))
    robot = replace(base.robot, gripper=replace(base.robot.gripper, linkage=linkage))
    return replace(base, robot=robot, program=replace(base.program, steps=steps or (CLOSE,)))


@pytest.mark.parametrize(("over", "empty"), [(-0.001, True), (0.0, True), (OPENED - 0.0001, True), (OPENED + 0.0001, False)])
def test_a_hand_that_closed_as_far_as_it_was_told_holds_nothing(over: float, empty: bool) -> None:
    assert (closed_on_nothing(ended(0.04 + over), CLOSING) != "") is empty


def test_it_says_how_far_and_without_what_and_which_keys_may_be_wrong() -> None:
    assert closed_on_nothing(ended(0.04), CLOSING) == f"the hand closed to 40 mm without 'block'; {KEYS}"
    for handovers in (None, (), HANDOVERS[1:], (replace(HANDOVERS[0], by="9.Other"),)):
        said = closed_on_nothing(replace(ended(0.04), handovers=handovers), CLOSING)
        assert said == f"the hand closed to 40 mm on nothing; {KEYS}"
    task = (replace(HANDOVERS[1], thing="cup", by="1.Grasping"), replace(HANDOVERS[0], by="1.Grasping"))
    assert "without 'block'" in closed_on_nothing(replace(ended(0.04), handovers=task), CLOSING)


def test_hands_of_other_kinds_and_steps_that_take_nothing_are_left_out() -> None:
    assert closed_on_nothing(ended(0.04, linkage=None), CLOSING) == ""
    assert closed_on_nothing(ended(0.04, replace(CLOSE, expect="none")), CLOSING) == ""
    assert closed_on_nothing(ended(0.04, Wait(0.1, origin=ORIGINS[1])), CLOSING) == ""
    assert closed_on_nothing(ended(0.04), 30) == ""  # it lifts then
    assert closed_on_nothing(ended(0.04, Fallback(((CLOSE,), ()))), CLOSING) != ""


def test_of_several_orders_under_one_origin_the_last_counts() -> None:
    wider = replace(CLOSE, opening=0.06)
    assert closed_on_nothing(ended(0.05, CLOSE, CLOSE, wider), CLOSING) != ""
    assert closed_on_nothing(ended(0.05, wider, wider, CLOSE), CLOSING) == ""
    assert closed_on_nothing(ended(0.05, wider, CLOSE, wider), CLOSING) != ""

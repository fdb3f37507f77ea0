"""The reach combinator: a candidate passes where the arm has all of its legs; a refusal says where and why."""

from __future__ import annotations

import pytest
from helpers.placing import taxonomy

from cramlite.model import Pose, RobotMount, Stage, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused
from cramlite_plugins.locations.reached import IN_ORDER, Arm, Candidate, Leg, reached
from cramlite_plugins.motion_planning.reach import shift
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.ur5e import UR5E

DOWN = Pose.from_axes((0.45, -0.3, 0.4), (0, 0, -1), (1, 0, 0))
MOUNT = RobotMount("arm", "ur5e")


@pytest.fixture
def arm() -> Arm:
    world = World((block("it", Pose((0.45, -0.3, 0.37)), (0.12, 0.04, 0.03)),), (MOUNT,))
    return Arm(initial_belief(world, "arm", UR5E.home, 0.085), Context(UR5E, MOUNT, {}, taxonomy()))


def one(name: str, *legs: Leg, group: str = "") -> Candidate:
    return Candidate(name, name, legs, group=group)


def test_what_may_be_touched_is_reached_and_what_may_not_be_is_refused_with_its_stage(arm: Arm) -> None:
    low = shift(DOWN, (0.0, 0.0, -0.02))
    above = Leg(shift(DOWN, (0.0, 0.0, 0.1)), said="above it", where=Stage.BEFORE)
    good, bad = (one(n, above, Leg(low, touch, 0.0, said="at it", where=Stage.POSE)) for n, touch in (("good", ("it",)), ("bad", ())))
    refused, found = reached((bad, good), arm)
    assert isinstance(refused, Refused) and refused.value == "bad" and refused.where is Stage.POSE
    assert refused.reason.startswith("at it: ") and "'it'" in refused.reason and refused.blocking is not None
    assert isinstance(found, Grounding) and found.key == "good" and found.cost == IN_ORDER


def test_of_a_group_one_is_enough(arm: Arm) -> None:
    far = Leg(shift(DOWN, (2.0, 0.0, 0.0)))
    near = Leg(shift(DOWN, (0.0, 0.0, 0.1)))
    answers = reached((one("a", far, group="g"), one("b", near, group="g"), one("c", near, group="g"), one("d", near)), arm)
    assert [(a.value, isinstance(a, Grounding)) for a in answers] == [("a", False), ("b", True), ("d", True)]


def test_a_line_has_to_be_free_all_along(arm: Arm) -> None:
    start, end = (shift(DOWN, (x, 0.0, -0.02)) for x in (-0.15, 0.15))
    through, over = (Leg(s, opening=0.0, along=(e,)) for s, e in ((start, end), (shift(start, (0, 0, 0.1)), shift(end, (0, 0, 0.1)))))
    blocked, free = reached((one("through", through), one("over", over)), arm)
    assert isinstance(blocked, Refused) and "'it'" in blocked.reason
    assert isinstance(free, Grounding)


def test_a_check_objects_last(arm: Arm) -> None:
    leg = Leg(shift(DOWN, (0.0, 0.0, 0.1)))
    candidate = Candidate("x", 1, (leg, leg), check=lambda led: Refused("", f"{len(led)} legs", check="mine"))
    assert list(reached((candidate,), arm)) == [Refused("x", "2 legs", check="mine")]

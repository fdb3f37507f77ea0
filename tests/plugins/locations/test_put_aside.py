"""What is put aside before other things are handled: beside where it stood; elsewhere where the task says more or it was not there."""

from __future__ import annotations

import math

import pytest
from helpers.placing import HELD, believed, context_of, on
from msgspec.structs import replace

from cramlite.model import Action, Belief, Location, Object, Pose, Thing
from cramlite.plugin import Grounding
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing.positions import AWAY
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.ur5e import UR5E

BOX = table("box", Pose((0.45, 0.35, 0.15)), (0.6, 0.6, 0.02))
STOOD = (0.5, 0.2)


def taken(*things: Thing, over: float = 0.0, at: tuple[float, float] = STOOD) -> Belief:
    """The belief with a block in the hand that stood on the box, or so far over it [m]."""
    lower = Pose.from_axes((*at, 0.15 + 0.05 + over - HELD.tcp_to_thing.position[2]), (0, 0, 1), (0, 1, 0))
    down = Pose.from_axes((*at, lower.position[2] + 2 * HELD.tcp_to_thing.position[2]), (0, 0, -1), (0, 1, 0))
    belief = believed(BOX, *things)
    return replace(belief, held=replace(belief.held, joints=inverse(UR5E, down)[0]))


def first(location: Location, belief: Belief, *tasks: str) -> Grounding:
    """The first place, before tasks that are about the block, or about a drawer."""
    about = [(t, "it" if t.endswith("Retracting") else "drawer") for t in tasks]
    agenda = tuple(Action(f"{k}.{t}", t, {"Patient": Object(f"o{k}", entity=e)}) for k, (t, e) in enumerate(about, 2))
    found = ground(location, belief, replace(context_of(belief), agenda=agenda))
    return next(a for a in found if isinstance(a, Grounding))


SHUT = ("soma:Retracting", "soma:Closing")


def moved(belief: Belief, tasks: tuple[str, ...] = SHUT, **where: object) -> float:
    place = first(on("box", **where), belief, *tasks).value
    x, y, _ = (place.pose * HELD.tcp_to_thing).position
    return math.dist((x, y), STOOD)


def test_it_goes_to_the_side_of_the_robot_a_hand_away() -> None:
    place = first(on("box"), taken(), *SHUT).value
    x, y, _ = (place.pose * HELD.tcp_to_thing).position
    assert math.dist((x, y), STOOD) == pytest.approx(2 * 0.02 + AWAY, abs=0.002)
    assert math.hypot(x, y) < math.hypot(*STOOD) - 0.13


def test_where_something_stands_there_it_goes_to_another_side() -> None:
    x, y = (STOOD[k] * (1 - 0.14 / math.hypot(*STOOD)) for k in range(2))
    place = first(on("box"), taken(block("tin", Pose((x, y, 0.2)), (0.05, 0.05, 0.08))), *SHUT).value
    there = (place.pose * HELD.tcp_to_thing).position
    assert math.dist(there[:2], STOOD) == pytest.approx(0.14, abs=0.002) and math.dist(there[:2], (x, y)) > 0.08


@pytest.mark.parametrize("over", [0.0, 0.02])
def test_it_goes_there_too_before_another_thing_is_taken_and_from_the_top_of_one(over: float) -> None:
    assert moved(taken(over=over), ("soma:Retracting", "soma:Grasping")) == pytest.approx(0.14, abs=0.002)


def test_what_came_from_elsewhere_and_what_is_told_more_goes_where_it_did() -> None:
    assert moved(taken()) == pytest.approx(0.14, abs=0.002)
    assert moved(taken(at=(0.3, -0.3))) == pytest.approx(math.dist(STOOD, (0.45, 0.35)), abs=0.002)
    for tasks in ((), ("soma:Retracting",), ("soma:Opening",), ("soma:Opening", "soma:Closing")):
        assert moved(taken(), tasks) == pytest.approx(math.dist(STOOD, (0.45, 0.35)), abs=0.002), tasks
    tin = block("tin", Pose((0.3, 0.45, 0.2)), (0.05, 0.05, 0.08))
    assert moved(taken(tin), near="tin") > 0.2

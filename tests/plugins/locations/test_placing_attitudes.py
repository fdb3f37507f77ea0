"""Attitudes of placed things: turned as asked for, by the shortest way, and what forbids a turn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.placing import HELD, TIN, believed, context_of, first, on, query_on, turns
from msgspec.structs import replace

from cramlite.model import Belief, Filling, GripFacts, Place, Pose
from cramlite.plugin import Unresolvable
from cramlite_plugins.locations.parameters import Where
from cramlite_plugins.locations.placing.stable_poses import as_asked, check_turn, standing_at
from cramlite_plugins.locations.reached import Arm


def angle(a: Any, b: Any) -> float:
    return math.acos(float(np.clip(np.dot(a, b), -1.0, 1.0)))


@pytest.mark.parametrize(("attitude", "z"), [("upright", 1.0), ("upside down", -1.0)])
def test_it_is_turned_the_shortest_way(attitude: str, z: float) -> None:
    for leaning in ((0.3, -0.5, 1.1), (2.0, 0.2, -0.4), (1.2, 1.4, 0.0), (0.0, 0.0, 0.7)):
        now = Pose.from_rotvec((0.4, 0.3, 0.5), leaning)
        asked = as_asked(now, Where(attitude=attitude))  # type: ignore[arg-type]
        assert asked.rotate((0.0, 0.0, 1.0)) == pytest.approx((0.0, 0.0, z), abs=1e-9) and asked.position == now.position
        assert now.distance(asked)[1] == pytest.approx(angle(now.rotate((0.0, 0.0, 1.0)), (0.0, 0.0, z)), abs=1e-6)
        assert as_asked(now, Where()) is now


@pytest.mark.parametrize(("attitude", "over"), [("upright", math.pi), ("upside down", 0.0)])
def test_half_a_turn_is_about_its_own_side(attitude: str, over: float) -> None:
    """The x axis stays where it is: upside down it need not turn at all."""
    turned = Pose.from_rotvec((0.4, 0.3, 0.5), (0.0, 0.0, 0.7)) * Pose.from_rotvec((0, 0, 0), (math.pi, 0, 0))
    asked = as_asked(turned, Where(attitude=attitude))  # type: ignore[arg-type]
    assert turned.distance(asked)[1] == pytest.approx(over, abs=1e-9)
    assert asked.rotate((1.0, 0.0, 0.0)) == pytest.approx(turned.rotate((1.0, 0.0, 0.0)))


def palm(degrees: float) -> Belief:
    """The block held upside down, so that upright the hand's approach goes up by an angle."""
    lean = Pose.from_axes((0.0, 0.0, 0.0), (0.0, math.cos(math.radians(degrees)), math.sin(math.radians(degrees))), (1, 0, 0))
    return believed().grasped(replace(HELD, tcp_to_thing=(lean * Pose((0.0, 0.0, -0.03))).inverse()))


@pytest.mark.parametrize(("degrees", "passes"), [(19.9, True), (20.1, False), (60.0, False)])
def test_the_hand_does_not_come_under_what_it_holds(degrees: float, passes: bool) -> None:
    belief = palm(degrees)
    grasp = Place(Pose(), Pose(), thing="it", grip=GripFacts(0.04))
    known = {"grasp": grasp, "other": replace(grasp, thing="tin"), "place": replace(grasp, grip=None), "name": "it"}
    context = replace(context_of(belief), bindings={**context_of(belief).bindings, **known})
    wanted = replace(query_on(belief), arm=Arm(belief, context))
    check_turn(wanted, wanted.now)  # it is as asked for already
    if passes:
        return check_turn(wanted, Pose())
    with pytest.raises(Unresolvable) as none:
        check_turn(wanted, Pose())
    assert none.value.because == ("grasp",)
    assert none.value.reason == f"turned so, the hand would be under 'it' and reach up by {degrees:.0f} deg"


def test_what_is_full_is_not_turned() -> None:
    belief = believed()
    full = replace(query_on(belief), thing=replace(belief.world.thing("it"), filling=Filling(3, 0.005, 0.001)))
    check_turn(full, full.now * Pose.from_rotvec((0, 0, 0), (5e-7, 0, 0)))
    with pytest.raises(Unresolvable, match="'it' holds something that would be spilled") as none:
        check_turn(full, full.now * Pose.from_rotvec((0, 0, 0), (1e-5, 0, 0)))
    assert none.value.because == ("shelf",)


@pytest.mark.parametrize("yaw", [0.0, 6.0, -6.0])
def test_its_front_looks_to_what_it_shall_face(yaw: float) -> None:
    belief = believed(TIN)
    wanted = query_on(belief, where={"facing": "tin"})
    spot = standing_at(wanted, Pose.from_rotvec((0.4, 0.3, 0.5), (0, 0, 0.4)), (0.05, 0.02), yaw)
    ahead = spot.thing.rotate((1.0, 0.0, 0.0))
    to = np.subtract((0.45, -0.45), (0.50, -0.33))
    off = math.remainder(math.atan2(ahead[1], ahead[0]) - math.atan2(to[1], to[0]), 2 * math.pi)
    assert math.degrees(off) == pytest.approx(yaw, abs=1e-6)


def test_only_turns_that_still_face_it_are_tried() -> None:
    found = turns(first(4, on("shelf", facing="tin"), believed(replace(TIN, pose=Pose((0.45, -0.9, 0.19))))))
    assert [t for _, t in found] == [0, 6, -6, 0]

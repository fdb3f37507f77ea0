"""What is over a container: places under it come first nowhere, and where nothing leads out of it no hand is tried."""

from __future__ import annotations

from itertools import islice

import pytest
from helpers.placing import query_on
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Held, Location, Place, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing.access import covered, goes_in_upright
from cramlite_plugins.objects.products_and_fixtures import basket, block, table
from cramlite_plugins.robots.ur5e import UR5E

MOUNT = RobotMount("arm", "ur5e")
INTO = Location("in(box)", "in", "box", {})


def asked(*things: Thing) -> tuple[Belief, Context]:
    it = block("it", Pose((0.4, 0.3, 0.5)), (0.04, 0.04, 0.06))
    belief = initial_belief(World((*things, it), (MOUNT,)), "arm", UR5E.home, 0.085).grasped(Held("it", Pose((0.0, 0.0, 0.02)), 0.04))
    return belief, Context(UR5E, MOUNT, {"box": "box"}, Engine().knowledge.taxonomy)


def box_under(x: float, over: float) -> tuple[Thing, Thing]:
    """A box whose middle is at 0.4, and a board that begins at ``x`` and is so far over its rim [m]."""
    box = basket("box", Pose((0.4, -0.4, 0.0)), (0.24, 0.24, 0.1))
    return box, table("board", Pose((x + 0.3, -0.4, 0.1 + over + 0.02)), (0.6, 0.6, 0.02))


def found(*things: Thing) -> list[Grounding | Refused]:
    return list(islice(ground(INTO, *asked(*things)), 40))


@pytest.mark.parametrize("x", [0.38, 0.42])
def test_beside_what_covers_a_part_is_tried_first(x: float) -> None:
    best = next(a for a in found(*box_under(x, 0.06)) if isinstance(a, Grounding))
    assert isinstance(best.value, Place)
    assert best.value.pose.position[0] + 0.02 < x


def test_nothing_is_let_go_of_over_what_covers_it() -> None:
    """The middle is under the board: however high the hand is, it refuses; without the board the middle is the best."""
    refused = [a for a in found(*box_under(0.38, 0.06)) if isinstance(a, Refused) and a.reason.startswith("not free to fall")]
    assert refused and all("'board' is between" in a.reason and a.blocking == ("board",) for a in refused)
    (bare, _) = box_under(0.38, 0.06)
    assert not any(isinstance(a, Refused) and "free to fall" in a.reason for a in found(bare))


def test_where_nothing_leads_out_no_hand_is_tried() -> None:
    with pytest.raises(Unresolvable, match="no hand comes into 'box': 'board' and 'box' are on all sides of its opening") as ended:
        found(*box_under(0.1, 0.01))
    assert set(ended.value.blocking or ()) == {"board", "box"} and ended.value.because == ("box",)


def test_where_there_is_room_under_it_a_hand_is_tried() -> None:
    assert len(found(*box_under(0.1, 0.2))) > 10


def test_a_short_way_back_depends_on_the_place_that_the_hand_was_led_to() -> None:
    """And on the grasp of what was put there; not on what was done with other things before."""
    belief, context = asked(*box_under(0.1, 0.2))
    here = Pose((0.4, 0.0, 0.3))
    put = {"handle": Place(here, here, thing="drawer"), "grasp": Place(here, here, thing="it"), "spot": Place(here, here, thing="it")}
    low = Pose((0.4, -0.4, 0.13))
    there = replace(belief, joints=inverse(UR5E, Pose(low.position, (1.0, 0.0, 0.0, 0.0)), seed=UR5E.home)[0])
    context = replace(context, bindings={**context.bindings, **put})
    answers = list(ground(Location("away", "retreat"), there, context))
    refused = [a for a in answers if isinstance(a, Refused)]
    assert refused and all(a.because == ("grasp", "spot") for a in refused)


def test_into_what_is_narrower_no_way_is_an_answer_and_no_fault() -> None:
    it = block("it", Pose((0.4, -0.1, 0.5)), (0.16, 0.16, 0.06))
    box = basket("box", Pose((0.4, -0.4, 0.0)), (0.1, 0.1, 0.1))
    board = table("board", Pose((0.4, -0.4, 0.2)), (0.6, 0.6, 0.02))
    belief = initial_belief(World((box, board, it), (MOUNT,)), "arm", UR5E.home, 0.085).grasped(Held("it", Pose((0.0, 0.0, 0.02)), 0.04))
    query = covered(query_on(belief, "box"))
    assert query.target.area.buffer(-0.08).is_empty
    assert goes_in_upright(query, it.pose) is False

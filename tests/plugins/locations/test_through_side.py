"""Placements under a roof: through which side, by which hands, and what is said of a room that is too low, shut or without a roof."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import (
    Action,
    Belief,
    Estimate,
    GripFacts,
    Held,
    Location,
    Object,
    Place,
    Pose,
    RobotMount,
    Thing,
    World,
    initial_belief,
)
from cramlite.plugin import Context, Grounding, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pinching.antipodal import Hands
from cramlite_plugins.locations.pinching.hand_room import Taken
from cramlite_plugins.locations.placing.for_later import suits_later
from cramlite_plugins.locations.placing.query import queries
from cramlite_plugins.locations.placing.ways_out import WAYS
from cramlite_plugins.objects.furniture import cabinet, door
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.roofs import open_sides, roofed

MOUNT = RobotMount("arm", "ur5e")
AT = Pose.from_rotvec((0.70, -0.1, 0.30), (0, 0, np.pi))  # its front looks to the robot
LEVEL, DOWN = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)
INSIDE = Location("on(cabinet)", "on", "cabinet", {"region": "inside"})


def _asked(approach: tuple[float, float, float], *things: Thing) -> tuple[Belief, Context]:
    """A block of 130 mm in the hand, whose approach is so."""
    it = block("it", Pose((0.4, 0.3, 0.4)), (0.04, 0.04, 0.13))
    hand = Pose.from_axes((0.4, 0.3, 0.4), approach, np.cross((0.0, 1.0, 0.0), approach))
    start = initial_belief(World((*things, it), (MOUNT,)), "arm", UR5E.home, 0.04)
    belief = start.grasped(Held("it", hand.inverse() * it.pose, 0.04)).moved(inverse(UR5E, hand, seed=UR5E.home)[0])
    bindings = {"cabinet": "cabinet", "it": "it", "grasp(it)": Place(hand, hand, thing="it", grip=GripFacts(0.04))}
    return belief, Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy)


def _refused(approach: tuple[float, float, float], *things: Thing) -> Unresolvable:
    with pytest.raises(Unresolvable) as no:
        list(ground(INSIDE, *_asked(approach, *things)))
    return no.value


def test_it_is_carried_in_level_through_the_front_and_let_down_there() -> None:
    found = ground(INSIDE, *_asked(LEVEL, cabinet("cabinet", AT)))
    place = next(a for a in found if isinstance(a, Grounding)).value
    way = np.subtract(place.via[0].position, place.before.position)
    assert way == pytest.approx((way[0], 0.0, 0.0), abs=1e-6) and way[0] > 0.15
    assert place.before.position[0] < 0.70 - 0.02 - 0.019  # all of it is before the front
    assert place.approach == pytest.approx(LEVEL, abs=1e-6)
    assert np.subtract(place.via[0].position, place.pose.position) == pytest.approx((0.0, 0.0, 0.01))


def test_positions_come_from_the_middle_outwards() -> None:
    found = ground(INSIDE, *_asked(LEVEL, cabinet("cabinet", AT)))
    names = [a.key for a in itertools.islice((a for a in found if isinstance(a, Grounding)), 20)]
    gone = [int(name.split()[0]) for name in names]
    assert gone == sorted(gone) and gone[0] < 100


def test_a_hand_that_points_down_turns_inwards_and_lays_it_down() -> None:
    belief, context = _asked(DOWN, cabinet("cabinet", AT))
    place = next(a for a in ground(INSIDE, belief, context) if isinstance(a, Grounding)).value
    assert place.approach == pytest.approx(LEVEL, abs=1e-6) and place.reorients
    lies = place.pose * belief.held.tcp_to_thing  # type: ignore[union-attr]
    assert abs(lies.rotate((0.0, 0.0, 1.0))[2]) == pytest.approx(0.0, abs=1e-6)


def test_what_leans_is_let_go_of_where_it_comes_to_lie_within() -> None:
    belief, context = _asked(DOWN, cabinet("cabinet", AT))
    (query,) = queries(INSIDE, belief, context)
    found = [a for a in ground(INSIDE, belief, context) if isinstance(a, Grounding) and "points down by 20 deg" in a.key]
    release = found[0].value.release
    rests = found[0].value.pose * belief.held.tcp_to_thing * release.settles  # type: ignore[union-attr]
    assert abs(rests.rotate((0.0, 0.0, 1.0))[2]) == pytest.approx(0.0, abs=0.02)
    assert query.target.area.covers(shapely.Point(*query.target.pose.inverse().apply(rests.position)[:2]))


@pytest.mark.parametrize(("high", "lies"), [(0.17, True), (0.08, False)])
def test_what_is_too_high_may_be_brought_in_lying_by_another_grasp(high: float, lies: bool) -> None:
    no = _refused(LEVEL, cabinet("cabinet", AT, (0.3, 0.3, high)))
    more = 1000 * (high - 0.03 - 0.13)
    assert no.reason == f"the room under the roof of 'cabinet' is {more:.0f} mm higher than 'it', 20 mm is needed"
    assert no.because == (("cabinet", "grasp(it)") if lies else ("cabinet",))


def test_a_shut_door_is_in_the_way_of_every_hand() -> None:
    no = _refused(LEVEL, cabinet("cabinet", AT), door("door", AT, "cabinet"))
    assert no.reason.startswith("no hand comes into 'cabinet': 'cabinet' and 'door' are on all sides of it")
    assert no.because == ("cabinet",) and no.blocking == ("cabinet", "door")


def test_what_stands_before_an_open_side_is_in_the_way_of_every_hand() -> None:
    wall = block("wall", Pose((0.6, -0.1, 0.3)), (0.02, 0.6, 0.4))
    no = _refused(LEVEL, cabinet("cabinet", AT), wall)
    assert no.reason.startswith("through its sides: not ") and "'wall'" in no.reason
    assert "cabinet" in no.because and ("wall",) in (no.blocking or ())


def test_what_is_open_above_is_none_of_it() -> None:
    asked = queries(Location("on(cabinet)", "on", "cabinet"), *_asked(LEVEL, table("cabinet", AT, (0.3, 0.3, 0.02))))
    assert [way.name for way in WAYS["on"] if way.rank(asked) is not None] == ["from above"]


def test_roofs_and_open_sides() -> None:
    thing = cabinet("cabinet", AT)
    (surface, room), = roofed(thing, AT, "inside")
    assert room == pytest.approx(0.17) and surface.pose.position == pytest.approx((0.8425, -0.1, 0.215))
    assert not list(roofed(thing, AT, "top"))
    (out,) = open_sides(thing, AT, surface, 0.05)
    assert out == pytest.approx((-1.0, 0.0, 0.0), abs=1e-9)


FAR = Pose((1.6, 0.0, 0.0)) * AT


@pytest.mark.parametrize(("region", "at", "under"), [("inside", AT, True), ("top", AT, False), ("inside", FAR, False)])
def test_grasps_know_what_comes_later_where_the_arm_reaches(region: str, at: Pose, under: bool) -> None:
    belief, context = _asked(LEVEL, cabinet("cabinet", at))
    roles = {"Locatum": Object("it", entity="it"), "Relatum": Object("cabinet", entity="cabinet")}
    placing = Action("3.Placing", "soma:Placing", roles, parameters={"where": {"region": region}})
    later = Context(UR5E, MOUNT, context.bindings, context.taxonomy, (placing,))
    assert _comes_in(belief, later) == [True, not under]
    assert _comes_in(belief, context) == [True, True]


def _comes_in(belief: Belief, context: Context) -> list[bool]:
    """Of hands that hold a block at its end, level and from above."""
    it, at = belief.world.thing("it"), belief.world.thing("it").pose
    level, down = (Pose.from_axes(at.apply(tip), way, (0, 1, 0)) for tip, way in (((-0.03, 0, 0), LEVEL), ((0, 0, 0.04), DOWN)))
    there = replace(belief, held=None, poses={**belief.poses, "it": Estimate(at, 0.0, "seen")})
    all_of = np.ones(2, bool)
    found: list[bool] = suits_later(it, there, context, Taken(Hands.at([level, down]), np.full(2, 0.05), all_of, ~all_of)).tolist()
    return found


def test_picked_up_off_a_table_with_a_board_below_it_goes_under_no_roof() -> None:
    """Else hands would take everything that stands on it from the side."""
    top, board = (table("cabinet", Pose((0.5, 0.0, z)), (0.8, 0.8, 0.02)) for z in (0.4, 0.05))
    low = tuple(replace(g, pose=Pose((0.0, 0.0, -0.35)) * g.pose) for g in board.geoms)
    desk = replace(top, geoms=(*top.geoms, *low), features=())
    belief, context = _asked(DOWN, desk)
    assert any(roofed(desk, belief.pose("cabinet"), ""))
    roles = {"Locatum": Object("it", entity="it"), "Relatum": Object("cabinet", entity="cabinet")}
    picking = Action("1.PickingUp", "soma:PickingUp", roles)
    assert _comes_in(belief, Context(UR5E, MOUNT, context.bindings, context.taxonomy, (picking,))) == [True, True]


def test_nothing_is_put_from_above_under_a_roof_that_is_shut_in_all_around() -> None:
    """No grasp would help."""
    belief, context = _asked(DOWN, cabinet("cabinet", AT), door("door", AT, "cabinet"))
    with pytest.raises(Unresolvable, match="no hand comes into 'cabinet': 'cabinet' and 'door' are on all sides of it") as no:
        list(ground(Location("on(cabinet)", "on", "cabinet", {"region": "inside"}), belief, context))
    assert no.value.because == ("cabinet",) and no.value.blocking == ("cabinet", "door")


def test_where_the_door_is_open_a_hand_comes_in_that_points_inwards_alone() -> None:
    belief, context = _asked(DOWN, cabinet("cabinet", AT), door("door", AT, "cabinet", opened=1.2))
    on = Location("on(cabinet)", "on", "cabinet", {"region": "inside"})
    found = list(itertools.islice(ground(on, belief, context), 20))
    approaches = [a.value.approach for a in found if isinstance(a, Grounding)]
    assert not isinstance(found[0], Grounding) and approaches
    assert all(abs(z) < 0.5 for _, _, z in approaches)


def _stacked(approach: tuple[float, float, float], at: Pose, thick: float = 0.005) -> tuple[Belief, Context, Location]:
    """A block in the hand, and a flat one at a pose, to be put upon."""
    belief, context = _asked(approach, cabinet("cabinet", AT), block("flat", at, (0.06, 0.06, thick)))
    bound = Context(UR5E, MOUNT, {**context.bindings, "flat": "flat"}, context.taxonomy)
    return belief, bound, Location("on(flat)", "on", "flat")


def test_onto_what_stands_under_a_roof_it_is_brought_in_through_the_open_side() -> None:
    belief, context, onto = _stacked(LEVEL, Pose((0.8425, -0.1, 0.2175)))
    place = next(a for a in ground(onto, belief, context) if isinstance(a, Grounding)).value
    assert place.approach == pytest.approx(LEVEL, abs=1e-6) and place.before.position[0] < 0.70
    lies = place.pose * belief.held.tcp_to_thing  # type: ignore[union-attr]
    assert lies.position == pytest.approx((0.8425, -0.1, 0.22 + 0.065), abs=0.012)


@pytest.mark.parametrize(("at", "under"), [((0.8425, -0.1, 0.2175), True), ((0.45, -0.3, 0.0025), False)])
def test_only_what_stands_under_a_roof_is_put_upon_through_a_side(at: tuple[float, float, float], under: bool) -> None:
    belief, context, onto = _stacked(LEVEL, Pose(at))
    asked = queries(onto, belief, context)
    assert [q.roof for q in asked] == ["cabinet" if under else ""]
    assert [way.name for way in WAYS["on"] if way.rank(asked) is not None] == ["through its sides" if under else "from above"]


def test_upon_what_leaves_too_little_room_under_its_roof_nothing_is_put() -> None:
    belief, context, onto = _stacked(LEVEL, Pose((0.8425, -0.1, 0.2325)), 0.035)
    with pytest.raises(Unresolvable, match="the room under the roof of 'flat' is -5 mm higher than 'it', 20 mm is needed"):
        list(ground(onto, belief, context))

"""Placements one by one: how many are looked at, in which order, from which height and stand-off, and what is said of none."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
import shapely
from helpers.placing import HELD, Answer, answers, believed, context_of, first, into, on, placed, query_on
from msgspec.structs import replace

from cramlite.model import Belief, Feature, Filling, Geom, GripFacts, Location, Place, Pose, Release, Thing
from cramlite.plugin import Grounding, Refused, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.parameters import Where
from cramlite_plugins.locations.placing.checks import clear, inside
from cramlite_plugins.locations.placing.driver import ARM, OUTLINE
from cramlite_plugins.locations.placing.positions import INSET, anchor, free_for, positions_on, radius
from cramlite_plugins.locations.placing.query import GAP, Placement, Query, openings, queries, standing_on
from cramlite_plugins.locations.placing.stable_poses import YAWS, as_asked, check_turn, heights, standing_at
from cramlite_plugins.locations.placing.ways_out import _from_above, beside_content, prepared
from cramlite_plugins.locations.reached import Arm
from cramlite_plugins.motion_planning.reach import held_pose, tcp, uncertainty_margins
from cramlite_plugins.objects.products_and_fixtures import basket, block, table
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.bounds import centre_of_mass
from cramlite_plugins.shapes.surfaces import FLAT, surfaces

LARGE = table("box", Pose((0.45, 0.35, 0.15)), (1.2, 1.2, 0.02))
TIN = block("tin", Pose((0.45, -0.45, 0.19)), (0.05, 0.05, 0.08))
SIDES = (((0.05, 0.0), (0.005, 0.05)), ((-0.05, 0.0), (0.005, 0.05)), ((0.0, 0.05), (0.055, 0.005)), ((0.0, -0.05), (0.055, 0.005)))
RING = tuple(Geom("box", (*half, 0.02), Pose((*at, 0.0))) for at, half in SIDES)
"""Walls around a square of 90 mm."""


# How many


def spent(found: list[Answer]) -> int:
    """What looks cost: 5 samples at shapes alone, 20 at the arm."""
    return sum(5 if isinstance(a, Refused) and a.passed < 3 else 20 for a in found)


def test_what_a_look_takes() -> None:
    assert (OUTLINE, ARM) == (5, 20)


@pytest.mark.parametrize(("samples", "count"), [(1, 1), (20, 1), (21, 2), (100, 5), (101, 6)])
def test_as_many_are_looked_at_as_the_samples_allow(samples: int, count: int) -> None:
    found, ended = answers(on("shelf"), believed(), samples)
    assert len(found) == count and ended is not None and ended.because == ("shelf",)
    assert ended.reason == f"{count} placements were looked at, as many as the {samples} samples of a query allow"


@pytest.mark.parametrize("samples", range(490, 540, 7))
def test_looks_at_shapes_are_cheap(samples: int) -> None:
    """Over an opening of 55 mm those turns along its walls come first, some others stick out."""
    narrow = basket("box", Pose((0.4, 0.35, 0.0)), (0.075, 0.3, 0.1))
    found, ended = answers(into("box"), believed(narrow), samples)
    assert {isinstance(f, Refused) and f.passed == 0 for f in found} == {True, False}
    assert spent(found[:-1]) < samples <= spent(found) and ended is not None


BAR = block("tin", Pose((0.45, -0.35, 0.17)), (0.05, 0.3, 0.02))
"""Across the middle: of the best position no turn fits, and every one of the second does."""


def test_what_shapes_refuse_is_told_once_one_gets_past_them_and_in_order() -> None:
    found, ended = answers(on("shelf", behind="tin"), believed(BAR), 51)
    assert [f.passed if isinstance(f, Refused) else None for f in found] == [1] * 10 + [None] and ended is not None
    assert [f.value.split(", ")[1] for f in found if isinstance(f, Refused)] == [f"turned {yaw:+.0f} deg" for yaw in YAWS]
    assert ended.reason == "11 placements were looked at, as many as the 51 samples of a query allow"


def test_what_none_gets_past_is_told_in_one() -> None:
    found, ended = answers(on("shelf", behind="tin"), believed(BAR), 50)
    assert found == [] and ended is not None
    assert ended.reason.startswith("none of 10 placements fits; (+51 +0) mm from its middle, turned +0 deg")
    nowhere, ended = answers(on("shelf", near="tin", within=0.0), believed(BAR))
    assert nowhere == [] and ended is not None and ended.reason.startswith("none of 1 placements fits; ")


# In which order


def turns(found: list[Grounding]) -> list[tuple[str, int]]:
    """Position and turn [deg] of placements."""
    names = [("middle, " if not g.key.startswith("(") else "") + g.key for g in found]
    return [(n.split(", turned ")[0].split(" mm")[0], int(n.split("turned ")[1].split(" deg")[0])) for n in names]


def test_at_the_best_position_every_turn_is_tried_at_others_a_few_and_one_of_their_own() -> None:
    found = turns(first(19, on("shelf"), believed()))
    best, second, third = [[t for p, t in found if p == q] for q in dict.fromkeys(p for p, _ in found)][:3]
    assert best == [0, 30, -30, 60, -60, 90, -90, 135, -135, 180] == list(YAWS)
    assert second == [0, 90, -45, 138] and third == [0, 90, -45, -85]
    assert len(found) == 19 and found[0][0] == "middle"


@pytest.mark.parametrize(("geom", "along"), [(Geom("box", (0.02, 0.03, 0.05)), True), (Geom("cylinder", (0.02, 0.05)), False)])
def test_straight_sides_are_put_along_straight_walls_however_much_room_there_is(geom: Geom, along: bool) -> None:
    belief = believed(basket("box", Pose((0.4, 0.35, 0.0)), (0.3, 0.4, 0.1)))
    things = tuple(replace(t, geoms=(geom,)) if t.name == "it" else t for t in belief.world.things)
    belief = replace(belief, world=replace(belief.world, things=things))
    x, y, _ = placed(first(1, into("box"), belief)[0]).rotate((1.0, 0.0, 0.0))
    assert (abs(math.sin(2 * math.atan2(y, x))) < 1e-3) == along


def test_a_position_later_costs_more_than_any_turn_and_a_turn_by_its_angle() -> None:
    found = first(16, on("shelf"), believed())
    angles = [0, 30, 30, 60, 60, 90, 90, 135, 135, 180, 0, 90, 45, 137.5077640500378, 0, 90]
    places = [0] * 10 + [1] * 4 + [2] * 2
    expected = [0.5 * k + 0.1 * math.radians(a) for k, a in zip(places, angles, strict=True)]
    assert [g.cost for g in found] == pytest.approx(expected)


def test_two_surfaces_take_turns() -> None:
    boards = tuple(Geom("box", (0.15, 0.15, 0.01), Pose((0.0, y, z))) for y, z in ((0.2, 0.1), (-0.2, 0.0)))
    steps = Thing("box", "soma:Shelf", Pose((0.45, -0.2, 0.15)), boards)
    found = first(30, on("box"), believed(steps))
    heights = [round(g.value.pose.position[2], 2) for g in found]
    low, high = min(heights), max(heights)
    assert (low, high) == pytest.approx((0.26, 0.36)) and heights[:20] == [high] * 10 + [low] * 10 and {low, high} == set(heights[20:])
    assert all("from its middle" not in g.key for g in found[:20]) and [g.cost for g in found[:11:10]] == [0.0, 0.5]


# Where


def test_its_centre_of_mass_is_over_the_position_and_its_lowest_point_above_it() -> None:
    belief = believed()
    for answer in first(14, on("shelf"), belief):
        offset = (0.0, 0.0)
        if answer.key.startswith("("):
            x, y = answer.key[1:].split(")")[0].split()
            offset = float(x) / 1000, float(y) / 1000
        x, y, z = placed(answer).position
        assert (x - 0.45, y + 0.35) == pytest.approx(offset, abs=0.0006)
        assert z - 0.05 - 0.15 == pytest.approx(answer.value.release.height_m, abs=1e-6)  # half the block, the shelf's top
        assert "lowest point +20 mm from it" in answer.key and answer.value.release.height_m == 0.02
        before = np.subtract(answer.value.before.position, answer.value.pose.position)
        assert before == pytest.approx((0.0, 0.0, 0.06), abs=1e-9) and answer.value.approach == (0, 0, -1)
        assert answer.value.thing == "it" and answer.reason == f"'shelf', {answer.key}"


def test_it_faces_the_robot_as_it_did() -> None:
    """Without a turn the bearing of the hand, seen from the base, is what the thing turns by."""
    belief = believed()
    context = context_of(belief)
    now, hand = held_pose(belief, context), tcp(belief, context)
    bearing = math.atan2(-0.35, 0.45) - math.atan2(hand.position[1], hand.position[0])
    for answer, turn in zip(first(2, on("shelf"), belief), (0.0, math.radians(30)), strict=True):
        about = Pose.from_rotvec((0, 0, 0), (0, 0, bearing + turn)) * Pose((0, 0, 0), now.quaternion)
        assert Pose((0, 0, 0), placed(answer).quaternion).distance(about)[1] < 1e-5


def test_off_its_middle_the_centre_of_mass_counts() -> None:
    belief = believed()
    heavy = Geom("box", (0.02, 0.02, 0.02), Pose((0.05, 0.0, -0.03)))
    things = tuple(replace(t, geoms=(*t.geoms, heavy)) if t.name == "it" else t for t in belief.world.things)
    lopsided = replace(belief, world=replace(belief.world, things=things))
    thing = lopsided.world.thing("it")
    (answer,) = first(1, on("shelf"), lopsided)
    centre = placed(answer).apply(centre_of_mass(thing))
    assert centre[:2] == pytest.approx((0.45, -0.35), abs=1e-6) and thing.inertia is None


@pytest.mark.parametrize(
    ("geoms", "wide"),
    [
        ((Geom("box", (0.02, 0.03, 0.05)),), 0.02),
        ((Geom("cylinder", (0.03, 0.05)),), 0.03),
        ((Geom("box", (0.05, 0.005, 0.05), Pose((0, 0.05, 0))), Geom("box", (0.005, 0.05, 0.05), Pose((0.05, 0, 0)))), 0.0),
        ((Geom("box", (0.02, 0.02, 0.002)), *RING), 0.055),
    ],
)
def test_the_largest_disc_in_its_outline(geoms: tuple[Geom, ...], wide: float) -> None:
    """Of an angle the centre of mass is outside; a bowl of boxes is as wide as its rim, though there are gaps between them."""
    wanted = replace(query_on(believed()), thing=Thing("it", "cram:Product", Pose(), geoms, mass=0.1))
    assert radius(wanted, Pose()) == pytest.approx(wide, rel=0.01)


def test_the_best_position_is_the_middle_near_what_is_asked_for_or_near_the_robot() -> None:
    belief = believed(TIN, replace(LARGE, name="box"))
    shelf, box = query_on(belief), query_on(belief, "box")
    assert anchor(shelf, Pose()) == (0.0, 0.0)
    assert anchor(query_on(belief, where={"near": "tin"}), Pose()) == pytest.approx((0.0, -0.1))
    drove = replace(belief, at=Pose())
    for wanted, half in ((shelf, 0.15), (box, 0.6)):
        away = wanted.target.pose.inverse().apply((0.0, 0.0, 0.0))[:2]
        there = anchor(replace(wanted, arm=Arm(drove, context_of(drove))), Pose())
        edge = half - INSET
        assert there == pytest.approx(np.clip(away, -edge, edge))
    small = replace(shelf, arm=Arm(drove, context_of(drove)), target=replace(shelf.target, area=shapely.box(-0.05, -0.1, 0.05, 0.1)))
    assert anchor(small, Pose()) == (0.0, 0.0)  # narrower than twice the inset


def test_heights_over_a_surface_are_two() -> None:
    assert heights(query_on(believed()), Pose()) == [(0.02, 0.06), (0.01, 0.015)]


@pytest.mark.parametrize(("depth", "hand_above"), [(0.09, 0.03), (0.05, 0.3), (0.2, -0.1)])
def test_heights_over_a_container_go_from_its_floor_up_to_where_the_hand_is_over_the_rim(depth: float, hand_above: float) -> None:
    belief = believed().grasped(replace(HELD, tcp_to_thing=Pose((0.0, 0.0, hand_above))))
    wanted = replace(query_on(belief), depth=depth)
    now, hand = held_pose(belief, wanted.context), tcp(belief, wanted.context)
    found = heights(wanted, now)
    highs, aboves = [h for h, _ in found], [a for _, a in found]
    assert highs[0] == pytest.approx(0.01 - depth) and np.diff(highs) == pytest.approx([0.03] * (len(highs) - 1))
    ball = math.hypot(*UR5E.gripper.tcp.position) + UR5E.gripper.pad[1]
    lowest = now.position[2] - min(abs(now.rotation[2]) @ np.array(s) for s in [(0.02, 0.02, 0.05)])
    least = max(0.0, ball - (hand.position[2] - lowest))
    assert least <= highs[-1] < least + 0.03 + 1e-9
    assert aboves == pytest.approx([max(0.06 - h, 0.06) for h in highs])


# Between what stands there


def targets(location: Location, belief: Belief) -> list[Query]:
    """What a query from above is about."""
    return prepared(queries(location, belief, context_of(belief)))


def outlines(*things: Thing) -> dict[str, Any]:
    belief = believed(*things)
    return {o.name: o.area for o in targets(on("shelf"), belief)[0].obstacles}


def test_what_stands_there_is_kept_clear_of_by_a_gap() -> None:
    found = outlines(TIN)
    assert list(found) == ["tin"]
    assert found["tin"].bounds == pytest.approx((-0.025 - GAP, -0.125 - GAP, 0.025 + GAP, -0.075 + GAP))


@pytest.mark.parametrize(("height", "there"), [(0.0999, True), (0.1001, False)])
def test_what_hangs_over_it_counts_as_high_as_the_thing_is(height: float, there: bool) -> None:
    """The block is 100 mm high as it is held."""
    over = block("tin", Pose((0.45, -0.35, 0.15 + height + 0.01)), (0.05, 0.05, 0.02))
    belief = believed(over)
    up = held_pose(belief, context_of(belief)).rotation[2]
    tall = 2 * float(np.abs(up) @ np.array((0.02, 0.02, 0.05)))
    lower = replace(over, pose=Pose((0.45, -0.35, 0.15 + height * tall / 0.1 + 0.01)))
    assert bool(outlines(lower)) is there


@pytest.mark.parametrize(("high", "there"), [(2 * FLAT - 1e-4, False), (2 * FLAT + 1e-4, True)])
def test_what_is_as_flat_as_the_surface_is_nothing_that_stands_there(high: float, there: bool) -> None:
    sheet = block("tin", Pose((0.45, -0.35, 0.15 + high - 0.005)), (0.05, 0.05, 0.01))
    assert bool(outlines(sheet)) is there


@pytest.mark.parametrize(("away", "there"), [(-0.001, True), (0.001, False)])
def test_what_is_further_beside_it_than_it_is_high_is_left_out(away: float, there: bool) -> None:
    belief = believed()
    up = held_pose(belief, context_of(belief)).rotation[2]
    tall = 2 * float(np.abs(up) @ np.array((0.02, 0.02, 0.05)))
    beside = block("tin", Pose((0.45 + 0.15 + 2 * GAP + tall + away + 0.025, -0.35, 0.2)), (0.05, 0.05, 0.08))
    assert bool(outlines(beside)) is there


def bounds(belief: Belief, location: Location) -> tuple[float, ...]:
    (wanted,) = targets(location, belief)
    return tuple(free_for(wanted, wanted.now).bounds)


def test_free_is_where_it_is_supported() -> None:
    least = 0.005 + 0.0002
    assert bounds(believed(), on("shelf")) == pytest.approx((-0.15 + least, -0.15 + least, 0.15 - least, 0.15 - least), abs=1e-6)


def test_free_in_a_container_is_where_its_disc_keeps_off_the_walls() -> None:
    box = basket("box", Pose((0.4, 0.35, 0.0)), (0.2, 0.3, 0.1))
    cavity = box.feature("cram:Cavity")
    assert cavity is not None
    belief = believed(box)
    disc = radius(query_on(belief, "box"), held_pose(belief, context_of(belief)))
    x, y = cavity.size["width"] / 2 - disc - 0.009, cavity.size["depth"] / 2 - disc - 0.009
    assert bounds(belief, into("box")) == pytest.approx((-x, -y, x, y))


def test_free_in_a_narrow_container_is_where_its_disc_is_inside() -> None:
    belief = believed(narrow := basket("box", Pose((0.4, 0.35, 0.0)), (0.075, 0.3, 0.1)))
    cavity = narrow.feature("cram:Cavity")
    assert cavity is not None
    disc = radius(query_on(belief, "box"), held_pose(belief, context_of(belief)))
    (_, y, _, _), x = bounds(belief, into("box")), cavity.size["width"] / 2 - disc
    assert 0 < x < 0.009 and y == pytest.approx(disc - cavity.size["depth"] / 2)


@pytest.mark.parametrize(("inner", "there"), [(0.1, True), (0.09, False)])
def test_where_content_leaves_little_room_the_next_goes_close_to_it(inner: float, there: bool) -> None:
    """Beside a block of 40 mm from wall to wall, there are 51 mm or 41 mm for another one and a gap of 6 mm."""
    box, aside = basket("box", Pose((0.4, 0.35, 0.0)), (inner + 0.02, inner + 0.02, 0.1)), inner / 2 - 0.029
    belief = believed(box, block("tin", Pose((0.4 - aside, 0.35, 0.05)), (0.04, inner - 0.018, 0.08)))
    belief = replace(belief, poses={**belief.poses, "tin": replace(belief.poses["tin"], sigma=0.1)})
    bare = queries(into("box"), belief, context_of(belief))[0]
    query = beside_content(bare)
    assert free_for(query, query.now).is_empty is not there
    if there:
        x, y = next(positions_on(query, query.now))
        placement = Placement("there", Pose((0.4 + x, 0.35 + y, 0.06)), Pose(), Pose(), 0.0)
        assert not inside(placement, query) and "8 mm is needed" in str(inside(placement, bare))


@pytest.mark.parametrize(("x", "y", "beside"), [(0.4, 0.35, True), (0.4, 0.55, False)])
def test_beside_what_lies_in_a_container_is_tried_before_over_it(x: float, y: float, beside: bool) -> None:
    box = basket("box", Pose((0.4, 0.35, 0.0)), (0.4, 0.3, 0.1))
    belief = believed(box, block("tin", Pose((x, y, 0.05)), (0.05, 0.05, 0.08)))
    assert [[o.name for o in w.obstacles] for w in targets(into("box"), belief)] == ([["tin"], []] if beside else [[]])


@pytest.mark.parametrize(
    ("side", "index", "value"), [("left_of", 1, 0.0 + 0.02), ("right_of", 3, -0.02), ("behind", 0, 0.02), ("in_front_of", 2, -0.02)]
)
def test_free_beside_a_thing_is_on_its_side(side: str, index: int, value: float) -> None:
    flat = block("tin", Pose((0.45, -0.35, 0.15)), (0.02, 0.02, 0.002))
    assert bounds(believed(flat), on("shelf", **{side: "tin"}))[index] == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize(("where", "within"), [({}, 0.2), ({"within": 0.05}, 0.05)])
def test_free_near_a_thing_is_within_a_distance(where: dict[str, float], within: float) -> None:
    flat = block("tin", Pose((0.45 + 0.14, -0.35, 0.15)), (0.002, 0.002, 0.002))
    assert bounds(believed(flat), on("shelf", near="tin", **where))[0] == pytest.approx(0.14 - within, abs=1e-3)


# Containers


def vessel(**size: float) -> Thing:
    box = basket("box", Pose((0.4, 0.35, 0.0)), (0.3, 0.3, 0.1))
    return replace(box, features=tuple(replace(f, size=size) if f.type == "cram:Cavity" else f for f in box.features))


@pytest.mark.parametrize(
    ("size", "area"),
    [
        ({"width": 0.2, "depth": 0.1, "height": 0.05}, (-0.1, -0.05, 0.1, 0.05)),
        ({"radius": 0.1, "height": 0.05}, (-0.1, -0.1, 0.1, 0.1)),
    ],
)
def test_an_opening_is_round_or_has_a_width_and_a_depth(size: dict[str, float], area: tuple[float, ...]) -> None:
    thing = vessel(**size)
    ((surface, depth),) = openings(thing, thing.pose)
    assert surface.area.bounds == pytest.approx(area) and depth == 0.05
    assert openings(TIN, TIN.pose) == []


# What is said of none


def test_what_has_no_place_is_said_so() -> None:
    ball = Thing("box", "cram:Product", Pose((0.4, 0.3, 0.1)), (Geom("sphere", (0.05,)),), mass=1.0)
    level = "no level face that looks upwards, to put anything on"
    for location, said in ((on("box"), level), (into("box"), "no cavity to put anything in")):
        found, ended = answers(location, believed(ball))
        assert found == [] and ended is not None and ended.reason == f"'box' has {said}" and ended.because == ("box",)
    _, ended = answers(on("box"), believed(replace(ball, mass=None)))  # it stays where it is, so that it might be a rack
    assert ended is not None and "not at rest: it would slide or fall off 'box'" in ended.reason
    empty = replace(believed(), held=None)
    with pytest.raises(Unresolvable, match="the hand holds no payload"):
        list(ground(on("shelf"), empty, context_of(empty)))


def test_what_stands_there_and_was_put_there_is_to_blame() -> None:
    whole = block("tin", Pose((0.45, -0.35, 0.2)), (0.3, 0.3, 0.08))
    belief = believed(whole)
    put = Place(Pose(), Pose(), thing="tin", release=Release(0.02))
    slid, other = replace(put, release=None), replace(put, thing="it")
    known = {"what": "tin", "by task": put, "slide": slid, "other": other, "held": "it", "else": "basket"}
    context = replace(context_of(belief), bindings={**context_of(belief).bindings, **known})
    with pytest.raises(Unresolvable) as none:
        list(ground(on("shelf"), belief, context))
    assert set(none.value.because) == {"shelf", "by task", "what", "held"}
    assert none.value.reason.startswith("none of 1 placements fits; turned +0 deg, lowest point +20 mm from it: not clear: ")
    assert "cm2" in none.value.reason or "has no free position" in none.value.reason


def test_what_is_too_large_for_an_opening_is_told_with_its_best_position() -> None:
    found, ended = answers(into("box"), believed(vessel(width=0.03, depth=0.03, height=0.05)))
    assert found == [] and ended is not None and set(ended.because) == {"box"}
    assert ended.reason.startswith("none of 1 placements fits; turned +0 deg, lowest point -40 mm from it: not inside: ")


def test_where_no_disc_is_free_it_is_said_how_large() -> None:
    """The centre of mass would be supported on a post of 10.3 mm, but not where positions are rounded."""
    post = Thing("box", "cram:Product", Pose((0.45, 0.35, 0.15)), (Geom("box", (0.00515, 0.00515, 0.1)),))
    found, ended = answers(on("box"), believed(post))
    assert found == [] and ended is not None
    assert ended.reason.endswith("from it: not clear: the largest disc in its outline, of 40 mm, has no free position")


def test_a_feature_may_say_how_large_the_place_is() -> None:
    spot = Feature("spot", "vrps:SurfaceFeature", Pose((0.1, 0.0, 0.01)), {"width": 0.06, "depth": 0.06})
    shelf = table("box", Pose((0.45, 0.35, 0.15)), (0.4, 0.4, 0.02))
    belief = believed(replace(shelf, features=(*shelf.features, spot)))
    context = replace(context_of(belief), bindings={"box": "box/spot"})
    (answer,) = itertools.islice(ground(on("box"), belief, context), 1)
    assert isinstance(answer, Grounding) and placed(answer).position[:2] == pytest.approx((0.55, 0.35), abs=1e-6)


# Attitudes that are asked for


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


# Doubts, and heights


def doubted(belief: Belief, sigma: float) -> Belief:
    return replace(belief, poses={n: replace(e, sigma=sigma) if n == "tin" else e for n, e in belief.poses.items()})


def test_more_is_kept_from_what_is_not_known_well() -> None:
    lying, box = block("tin", Pose((0.4, -0.4, 0.05)), (0.05, 0.05, 0.08)), basket("box", Pose((0.4, -0.4, 0.0)), (0.4, 0.3, 0.1))
    for belief, place in ((believed(TIN), on("shelf")), (believed(box, lying), into("box"))):
        unsure = doubted(belief, 0.002)
        more = uncertainty_margins(unsure)["tin"]
        obstacles = [o for b in (belief, unsure) for o in targets(place, b)[0].obstacles]
        areas = [o.area.bounds for o in obstacles if o.name == "tin"]
        assert more > 0.001 and np.subtract(*areas) == pytest.approx((more, more, -more, -more))


def test_each_height_above_the_lowest_costs_a_little() -> None:
    """Beside what lies in the opening the hand comes lower than over it; a position later costs 0.5."""
    box = basket("box", Pose((0.4, 0.35, 0.0)), (0.2, 0.3, 0.1))
    found = first(20, into("box"), believed(box, block("tin", Pose((0.4, 0.35, 0.05)), (0.05, 0.05, 0.08))))
    lowest = min(h for h, _ in heights(replace(query_on(believed(box), "box"), depth=_depth(box)), _held(box)))
    steps = [round((g.value.release.height_m - lowest) / 0.03) for g in found]
    angles = [abs(math.radians(math.remainder(t, 360))) for _, t in turns(found)]
    assert max(steps) > 0
    rest = [g.cost - 0.1 * a - 0.02 * s for g, s, a in zip(found, steps, angles, strict=True)]
    assert {round(r, 2) for r in rest} == {0.0, 0.5} and all(abs(r - round(r, 2)) < 1e-3 for r in rest)


def _depth(box: Thing) -> float:
    cavity = box.feature("cram:Cavity")
    assert cavity is not None
    return cavity.size["height"]


def _held(box: Thing) -> Pose:
    return held_pose(believed(box), context_of(believed(box)))


def test_what_is_put_on_a_plate_may_stick_out_over_its_rim() -> None:
    """A cup whose foot fits on a plate's flat middle, and whose mouth is wider than that; not so one that is as wide all the way down."""
    along, across = (0.01, 0.05, 0.012), (0.05, 0.01, 0.012)
    rim = [Geom("box", half, Pose(at)) for s in (0.04, -0.04) for half, at in ((along, (s, 0.0, 0.0)), (across, (0.0, s, 0.0)))]
    plate = Thing("plate", "soma:Plate", Pose((0.45, -0.35, 0.2)), (Geom("box", (0.05, 0.05, 0.002)), *rim))
    foot, mouth = Geom("cylinder", (0.018, 0.02), Pose((0.0, 0.0, -0.02))), Geom("cylinder", (0.045, 0.02), Pose((0.0, 0.0, 0.02)))
    belief = believed(plate)
    for geoms, fits in (((foot, mouth), True), ((replace(foot, size=(0.045, 0.02)), mouth), False)):
        held = replace(belief.world.thing(HELD.thing), geoms=geoms)
        middle = next(s for s in surfaces(plate, plate.pose) if s.pose.position[2] == pytest.approx(0.202))
        wanted = replace(query_on(belief, "plate"), thing=held, target=middle)
        above = Placement("it", Pose((0.45, -0.35, 0.202 + 0.04)), Pose(), Pose(), 0.0)
        wanted = replace(wanted, obstacles=standing_on(wanted))
        assert any(o.name == "plate" for o in wanted.obstacles)
        assert (clear(above, wanted) == "") == fits


# On what is not level, and in regions

DISH = Thing(
    "box", "soma:Plate", Pose((0.45, -0.35, 0.165)), (
        Geom("box", (0.028, 0.028, 0.004)), *(Geom("box", (0.004, 0.032, 0.01), Pose((s * 0.032, 0, 0.006))) for s in (-1, 1)),
        *(Geom("box", (0.032, 0.004, 0.01), Pose((0, s * 0.032, 0.006))) for s in (-1, 1)),
    ), mass=0.3,
)  # fmt: skip
"""A floor of 56 mm within a rim: the foot of a block of 40 mm, turned by 30 deg, comes within 1 mm of it."""


def test_what_can_be_moved_carries_things_within_its_rim() -> None:
    (middle,) = first(1, on("box"), believed(DISH))
    assert isinstance(middle.value, Place) and "mm from its middle" not in middle.key


def test_beside_its_middle_too_the_payload_alone_touches_a_support_with_a_rim() -> None:
    """A hand that came down onto the wall of a tray stopped there, and kept the bowl."""
    walls = (Geom("box", (0.1, 0.004, 0.01), Pose((0.0, s * 0.034, 0.014))) for s in (-1, 1))
    tray = Thing("box", "soma:Plate", Pose((0.45, -0.35, 0.165)), (Geom("box", (0.1, 0.03, 0.004)), *walls), mass=0.3)
    desk = table("box", Pose((0.45, -0.35, 0.25)), (0.3, 0.35, 0.02))
    amid, beside = prepared([query_on(believed(tray), "box")])
    (level,) = prepared([query_on(believed(desk), "box")])
    assert amid.under is not None and beside.under is None
    assert [q.let_down(q.now).hand for q in (amid, beside, level)] == [False, False, True]
    assert len(beside.openings) == 3 and len(level.openings) == 1  # beside a rim fingers may have to open less


def test_not_where_something_else_stands_within_the_rim() -> None:
    pin = block("pin", Pose((0.45, -0.35, 0.199)), (0.02, 0.02, 0.06))
    found, ended = answers(on("box"), believed(DISH, pin))
    assert not any(isinstance(a, Grounding) for a in found) and ended is not None and "'pin'" in ended.reason


def lopsided(higher: float) -> Thing:
    """A tray that can be moved, 40 mm by 40 mm inside, with one side higher than the other."""
    floor = Geom("box", (0.03, 0.022, 0.002), Pose((0.0, 0.0, -0.038)))
    walls = ((0.02, 0.0), (0.02 + higher / 2, higher / 2))
    sides = [Geom("box", (0.03, 0.004, high), Pose((0.0, y, z - 0.02))) for (high, z), y in zip(walls, (-0.018, 0.018), strict=True)]
    return Thing("box", "cram:Product", Pose((0.45, -0.35, 0.2)), (floor, *sides), mass=1.0)


@pytest.mark.heavy
@pytest.mark.parametrize(("higher", "leans"), [(0.006, True), (0.0, False)])
def test_what_nothing_level_carries_is_put_as_it_comes_to_rest(higher: float, leans: bool) -> None:
    """A block of 40 mm leans on two edges, one of them 6 mm higher, and stands where they are as high."""
    found, _ = answers(on("box"), believed(lopsided(higher)), 2000)
    places = [a for a in found if isinstance(a, Grounding) and "at rest" in a.key]
    assert bool(places) is leans and any("not supported: its centre of mass" in a.reason for a in found) is leans


@pytest.mark.parametrize(("region", "least", "most"), [("left", 0.05, 0.15), ("right", -0.15, -0.05)])
def test_an_area_narrows_where_things_are_put(region: str, least: float, most: float) -> None:
    sides = (("left", 0.1), ("right", -0.1))
    areas = [Feature(n, "vrps:SurfaceFeature", Pose((0, y, 0.01)), {"width": 0.1, "depth": 0.1}) for n, y in sides]
    desk = table("box", Pose((0.45, -0.35, 0.25)), (0.3, 0.35, 0.02))
    belief = believed(replace(desk, features=(*desk.features, *areas)))
    for found in first(5, on("box", region=region), belief):
        assert isinstance(found.value, Place)
        y = float((found.value.pose * HELD.tcp_to_thing).position[1]) + 0.35
        assert least < y < most


@pytest.mark.parametrize(("geom", "along"), [(Geom("box", (0.02, 0.03, 0.05)), True), (Geom("cylinder", (0.02, 0.05)), False)])
def test_straight_sides_are_put_along_those_of_a_region(geom: Geom, along: bool) -> None:
    desk = table("box", Pose((0.45, -0.35, 0.25)), (0.3, 0.35, 0.02))
    mark = Feature("mark", "vrps:SurfaceFeature", Pose((0.05, 0.04, 0.01)), {"width": 0.02, "depth": 0.02})
    belief = believed(replace(desk, features=(*desk.features, mark)))
    things = tuple(replace(t, geoms=(geom,)) if t.name == "it" else t for t in belief.world.things)
    belief = replace(belief, world=replace(belief.world, things=things))
    x, y, _ = placed(first(1, on("box", region="mark"), belief)[0]).rotate((1.0, 0.0, 0.0))
    assert (abs(math.sin(2 * math.atan2(y, x))) < 1e-3) == along


def test_a_region_that_is_too_small_is_refused() -> None:
    desk = table("box", Pose((0.45, -0.35, 0.25)), (0.3, 0.35, 0.02))
    strip = Feature("strip", "vrps:SurfaceFeature", Pose((0, 0, 0.01)), {"width": 0.1, "depth": 0.012})
    found, ended = answers(on("box", region="strip"), believed(replace(desk, features=(*desk.features, strip))))
    assert not any(isinstance(a, Grounding) for a in found) and ended is not None
    assert "not in its region" in ended.reason and "8 mm inside is needed" in ended.reason


@pytest.mark.parametrize(("reaches", "fits"), [(0.06, True), (0.02, False)])
def test_an_origin_that_would_be_over_the_end_of_its_region_is_refused(reaches: float, fits: bool) -> None:
    """A validator of goals asks for the origin in the region: a site of 20 mm on a shelf's board does not reach up to that of a product."""
    desk = table("box", Pose((0.45, -0.35, 0.25)), (0.3, 0.35, 0.02))
    level = Feature("level", "vrps:SurfaceFeature", Pose((0, 0, 0.0)), {"width": 0.05, "depth": 0.05, "height": reaches})
    belief = believed(replace(desk, features=(*desk.features, level)))
    if fits:
        assert len(first(1, on("box", region="level"), belief)) == 1
        return
    found, ended = answers(on("box", region="level"), belief)
    assert not any(isinstance(a, Grounding) for a in found) and ended is not None
    assert "mm too high for 'box/level', which reaches 20 mm above the surface under it" in ended.reason
    assert "mm too little for the origin of" in str(ended.remedy)


@pytest.mark.heavy
@pytest.mark.parametrize(("lowest", "fits"), [(0.02, True), (0.2, False)])
def test_an_origin_that_would_be_below_its_region_in_every_attitude_is_refused(lowest: float, fits: bool) -> None:
    """A validator asks for the origin in the region: that of a mug, in its foot, is below a site 12 mm over a microwave."""
    desk = table("box", Pose((0.45, -0.35, 0.25)), (0.3, 0.35, 0.02))
    level = Feature("level", "vrps:SurfaceFeature", Pose((0, 0, 0.01)), {"width": 0.1, "depth": 0.1, "lowest": lowest})
    belief = believed(replace(desk, features=(*desk.features, level)))
    if fits:
        assert "at rest" not in first(1, on("box", region="level"), belief)[0].reason  # as it stands
        return
    found, ended = answers(on("box", region="level"), belief)
    assert not any(isinstance(a, Grounding) for a in found)
    said = [ended.reason if ended else "", *(a.reason for a in found)]
    assert any("too low for 'level'" in s or "below 'level' of 'box'" in s for s in said), said


@pytest.mark.parametrize(("x", "asked"), [(0.45, True), (1.5, False)])
def test_what_is_out_of_reach_is_not_come_at_from_aside(x: float, asked: bool) -> None:
    box = basket("box", Pose((x, -0.3, 0.0)), (0.3, 0.3, 0.1))
    query = replace(query_on(believed(box), "box"), depth=_depth(box))
    asides = [one for _, one in _from_above(standing_at(query, query.now, (0.0, 0.0))) if one.aside]
    assert bool(asides) == asked

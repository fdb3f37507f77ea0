"""Placements one by one: how many are looked at, in which order, from which height and stand-off, and what is said of none."""

from __future__ import annotations

import math
from itertools import islice

import numpy as np
import pytest
import shapely
from helpers.placing import (
    HELD,
    TIN,
    Answer,
    answers,
    believed,
    context_of,
    depth_of,
    first,
    into,
    on,
    placed,
    query_on,
    targets,
    turns,
)
from msgspec.structs import replace

from cramlite.model import Belief, Geom, Pose, Thing
from cramlite.plugin import Refused
from cramlite_plugins.locations.placing.checks.shapes import clear, inside
from cramlite_plugins.locations.placing.driver import ARM, OUTLINE
from cramlite_plugins.locations.placing.positions import INSET, anchor, radius
from cramlite_plugins.locations.placing.query import Placement, standing_on
from cramlite_plugins.locations.placing.stable_poses import RISE, YAWS, Rest, heights, stable_poses
from cramlite_plugins.locations.reached import Arm
from cramlite_plugins.motion_planning.reach import held_pose, tcp, uncertainty_margins
from cramlite_plugins.objects.products_and_fixtures import basket, block, table
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.bounds import centre_of_mass
from cramlite_plugins.shapes.surfaces import surfaces

LARGE = table("box", Pose((0.45, 0.35, 0.15)), (1.2, 1.2, 0.02))
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


@pytest.mark.parametrize(("long", "askew"), [(0.12, True), (0.08, False), (0.2, False)])
@pytest.mark.parametrize("turned", [0.0, 17.0, 45.0])
def test_what_fits_askew_alone_is_turned_so_whatever_holds_it(long: float, askew: bool, turned: float) -> None:
    box = basket("box", Pose((0.4, 0.35, 0.0)), (0.12, 0.12, 0.1))
    query = replace(query_on(believed(box), "box"), thing=block("it", Pose(), (long, 0.01, 0.05)), depth=depth_of(box))
    found = list(islice(stable_poses([query], Pose.from_rotvec((0.4, 0.3, 0.5), (0.0, 0.0, math.radians(turned)))), 20))
    named = [rest for rest in found if isinstance(rest, Rest) and "in the middle of its room" in rest.name]
    assert bool(named) == askew
    assert not any(inside(Placement(r.name, r.thing, r.thing, r.thing, 0.0), query) for r in named)


BAR = block("tin", Pose((0.45, -0.35, 0.17)), (0.05, 0.3, 0.02))
"""Across the middle: of the best position no turn fits, and every one of the second does."""


def test_what_shapes_refuse_is_told_once_one_gets_past_them_and_in_order() -> None:
    found, ended = answers(on("shelf", near="tin"), believed(BAR), 51)
    assert [f.passed if isinstance(f, Refused) else None for f in found] == [1] * 10 + [None] and ended is not None
    assert [f.value.split(", ")[1] for f in found if isinstance(f, Refused)] == [f"turned {yaw:+.0f} deg" for yaw in YAWS]
    assert ended.reason == "11 placements were looked at, as many as the 51 samples of a query allow"


def test_what_none_gets_past_is_told_in_one() -> None:
    found, ended = answers(on("shelf", near="tin"), believed(BAR), 50)
    assert found == [] and ended is not None
    assert ended.reason.startswith("none of 10 placements fits; (-51 +0) mm from its middle, turned +0 deg")
    nowhere, ended = answers(on("shelf", near="tin", within=0.0), believed(BAR))
    assert nowhere == [] and ended is not None and ended.reason.startswith("none of 1 placements fits; ")


# In which order


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
    assert highs[0] == pytest.approx(0.01 - depth) and np.diff(highs) == pytest.approx([RISE] * (len(highs) - 1))
    ball = math.hypot(*UR5E.gripper.tcp.position) + UR5E.gripper.pad[1]
    lowest = now.position[2] - min(abs(now.rotation[2]) @ np.array(s) for s in [(0.02, 0.02, 0.05)])
    least = max(0.0, ball - (hand.position[2] - lowest))
    assert least <= highs[-1] < least + RISE + 1e-9
    assert aboves == pytest.approx([max(0.06 - h, 0.06) for h in highs])


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
    lowest = min(h for h, _ in heights(replace(query_on(believed(box), "box"), depth=depth_of(box)), _held(box)))
    steps = [round((g.value.release.height_m - lowest) / RISE) for g in found]
    angles = [abs(math.radians(math.remainder(t, 360))) for _, t in turns(found)]
    assert max(steps) > 0
    rest = [g.cost - 0.1 * a - 0.01 * s for g, s, a in zip(found, steps, angles, strict=True)]
    assert {round(r, 2) for r in rest} == {0.0, 0.5} and all(abs(r - round(r, 2)) < 1e-3 for r in rest)


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

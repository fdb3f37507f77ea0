"""Surfaces from geometry: what is level, flat and looks upwards; what stands on what, and what moves along."""

from __future__ import annotations

import math

import pytest
import shapely
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Belief, Geom, Pose, Thing, World, initial_belief
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.products_and_fixtures import basket, block, hanger, hung, product, table
from cramlite_plugins.objects.vessels import bottle, bowl, can, lid, mug
from cramlite_plugins.shapes.bounds import corners
from cramlite_plugins.shapes.carried_along import carried_along
from cramlite_plugins.shapes.surfaces import footprint, inset, resting_height, standing, surfaces

UPSIDE_DOWN = Pose((0, 0, 0), (0, 1, 0, 0))


def _leaning(degrees: float) -> Pose:
    return Pose.from_rotvec((0, 0, 0), (math.radians(degrees), 0, 0))


@pytest.mark.parametrize(
    ("thing", "pose", "heights", "areas"),
    [
        (block("it", Pose(), (0.06, 0.04, 0.1)), Pose(), [0.05], [0.06 * 0.04]),
        (block("it", Pose(), (0.06, 0.04, 0.1)), _leaning(90), [0.02], [0.06 * 0.1]),
        (block("it", Pose(), (0.06, 0.04, 0.1)), _leaning(5.5), [0.05 * math.cos(math.radians(5.5))], [0.06 * 0.04]),
        (block("it", Pose(), (0.06, 0.04, 0.1)), _leaning(6), [], []),
        (mug("it", Pose(), 0.042, 0.095), UPSIDE_DOWN, [0.0475], [math.pi * 0.042**2]),
        (table("it", Pose((0, 0, 0.15)), (0.3, 0.2, 0.02)), Pose((0, 0, 0.15)), [0.15], [0.06]),
    ],
)
def test_the_largest_is_what_is_level_on_top(thing: Thing, pose: Pose, heights: list[float], areas: list[float]) -> None:
    found = surfaces(thing, pose)[: len(heights) or 1]
    assert [s.pose.position[2] for s in found] == pytest.approx(heights, abs=1e-6)
    assert [s.area.area for s in found] == pytest.approx(areas, rel=0.12)


def test_balls_and_lying_cans_have_none() -> None:
    ball = Thing("ball", "cram:Product", Pose(), (Geom("sphere", (0.05,)),))
    assert not surfaces(ball, Pose())
    assert not surfaces(can("it", Pose()), _leaning(90))
    assert surfaces(can("it", Pose()), _leaning(2))


def test_faces_in_one_plane_within_2_mm_are_one_surface() -> None:
    def two(step: float) -> Thing:
        parts = (Geom("box", (0.05, 0.05, 0.01)), Geom("box", (0.05, 0.05, 0.01), Pose((0.1, 0, step))))
        return Thing("it", "cram:Product", Pose(), parts)

    assert len(surfaces(two(0.0015), Pose())) == 1
    assert len(surfaces(two(0.0025), Pose())) == 2


def test_a_hull_has_the_faces_of_the_box_that_it_is() -> None:
    corners = tuple((x, y, z) for x in (-0.03, 0.03) for y in (-0.02, 0.02) for z in (-0.05, 0.05))
    hull = Thing("it", "cram:Product", Pose(), (Geom("convex", (0.03, 0.02, 0.05), corners=corners),))
    (top,) = surfaces(hull, Pose())
    assert top.area.area == pytest.approx(0.06 * 0.04) and top.pose.position[2] == pytest.approx(0.05)


def test_a_part_that_is_named_is_as_large_as_it_says_and_must_look_upwards() -> None:
    box = basket("box", Pose(), (0.4, 0.3, 0.15))
    (floor,) = surfaces(box, Pose(), "floor")
    assert floor.area.area == pytest.approx(0.38 * 0.28) and floor.pose.position[2] == pytest.approx(0.01)
    it = block("it", Pose())
    assert not surfaces(it, Pose(), "bottom")
    assert surfaces(it, UPSIDE_DOWN, "bottom")


@examples(50)
@given(st.floats(-0.06, 0.06), st.floats(-0.06, 0.06), st.floats(0, 360))
def test_a_block_stands_on_another_where_its_middle_is_5_mm_inside(x: float, y: float, yaw: float) -> None:
    upper, lower = block("upper", Pose(), (0.05, 0.05, 0.05)), block("lower", Pose(), (0.08, 0.08, 0.05))
    turned = Pose.from_rotvec((x, y, 0.2), (0, 0, math.radians(yaw)))
    (top,) = surfaces(lower, Pose())
    inside, least = inset(standing(upper, top.pose.inverse() * turned), top.area)
    edge = 0.04 - max(abs(x), abs(y))
    assert least == pytest.approx(0.005)
    assert inside <= edge + 1e-6 and (inside > 0) == (edge > 0)
    height, whose = resting_height(upper, turned, [(lower, Pose())])
    assert (whose == "lower" and height == pytest.approx(0.025)) if edge > 1e-6 else math.isinf(height) or edge > -1e-6


def test_a_lid_stands_on_a_rim_and_a_narrower_one_does_not() -> None:
    pot = bowl("pot", Pose(), 0.08, 0.09)
    for radius, height in ((0.085, 0.045), (0.05, -0.039)):
        found, whose = resting_height(lid("lid", Pose(), radius), Pose((0, 0, 0.2)), [(pot, Pose())])
        assert (found, whose) == (pytest.approx(height, abs=1e-3), "pot")


def test_the_outline_is_that_of_what_reaches_into_a_range_of_heights() -> None:
    it = bottle("it", Pose(), radius=0.034, height=0.15, neck=0.014, neck_height=0.06)
    assert footprint(it, Pose()).area == pytest.approx(math.pi * 0.034**2, rel=0.02)
    assert footprint(it, Pose(), 0.08).area == pytest.approx(math.pi * 0.014**2, rel=0.02)
    assert footprint(it, Pose(), 0.2).is_empty
    assert shapely.box(-0.034, -0.034, 0.034, 0.034).buffer(1e-6).covers(footprint(it, Pose()))


def _kitchen(*things: Thing) -> Belief:
    return initial_belief(World((table("floor", Pose(), (2, 2, 0.02)), *things)), "arm", (), 0.08)


def test_what_is_in_or_on_a_thing_moves_along_through_others_too() -> None:
    at = Pose((0.5, 0.0, 0.35))
    pulled = drawer("drawer", at, opened=0.15)
    inside = (
        bowl("bowl", pulled.pose * Pose((-0.12, 0, -0.042))),
        block("tin", pulled.pose * Pose((-0.12, 0, -0.036)), (0.04, 0.04, 0.04)),
        block("beside", Pose((0.9, 0.6, 0.03))),
        block("above", at * Pose((-0.2, 0, 0.13))),
    )
    belief = _kitchen(cabinet("cabinet", at), pulled, *inside)
    assert set(carried_along(belief, "drawer")) == {"bowl", "tin"}
    assert set(carried_along(belief, "bowl")) == {"tin"}
    assert set(carried_along(belief, "cabinet")) == {"above"}
    pose = carried_along(belief, "drawer")["tin"].pose
    assert pose.position == pytest.approx((-0.12, 0, -0.036))


def test_a_stack_moves_with_its_lowest_and_what_hangs_with_its_hanger() -> None:
    low, middle, top = (block(n, Pose((0.4, 0, z))) for n, z in (("low", 0.03), ("middle", 0.091), ("top", 0.152)))
    hook = hanger("hook", Pose((0.8, 0, 0.5)))
    tea = product("tea", Pose())
    belief = _kitchen(low, middle, top, hook, tea)
    placed = belief.poses["tea"].pose
    assert set(carried_along(belief, "low")) == {"middle", "top"}
    assert set(carried_along(belief, "middle")) == {"top"}
    assert "tea" not in carried_along(belief, "hook")
    assert set(carried_along(belief.related(("hangs_on", "tea", "hook/peg")), "hook")) == {"tea"}
    assert placed == belief.poses["tea"].pose and hung(tea, hook, 0.08)


def test_what_is_seen_of_a_tilted_thing_is_what_is_in_the_range_of_heights() -> None:
    table = Thing("table", "soma:Table", Pose(), (Geom("box", (0.5, 0.6, 0.025), Pose((0.0, 0.0, -0.033))),))  # 8 mm under a plate
    tilted = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, -0.02, 0.0))  # its end at +x is 2 mm over the plate's plane
    assert footprint(table, Pose(), 0.004).is_empty
    assert footprint(table, tilted, 0.004).is_empty
    assert not footprint(table, tilted, 0.001).is_empty
    far = footprint(table, tilted, 0.001)
    assert far.bounds[0] == pytest.approx((0.008 + 0.001) / 0.02, abs=0.01) and not far.intersects(shapely.Point(0, 0))


@given(
    st.tuples(*[st.floats(0.01, 0.3)] * 3), st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.floats(-0.4, 0.4), st.floats(0.001, 0.4)
)
def test_slices_of_a_box_make_up_its_outline(half: tuple[float, ...], turn: tuple[float, ...], low: float, thick: float) -> None:
    box = Thing("box", "cram:Product", Pose(), (Geom("box", half),))
    pose = Pose.from_rotvec((0.0, 0.0, 0.0), turn)
    whole, parts = footprint(box, pose), [footprint(box, pose, a, b) for a, b in ((-1, low), (low, low + thick), (low + thick, 1))]
    assert shapely.union_all(parts).area == pytest.approx(whole.area, rel=1e-6)
    assert all(p.is_empty or whole.buffer(1e-9).covers(p) for p in parts)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3), st.floats(-0.05, 0.1))
@examples(40)
def test_an_outline_turns_and_moves_with_its_thing(lean: float, turn: float, further: float, height: float) -> None:
    """Seen from above: what is worked out once for how a thing leans is what it is at each turn and place."""
    thing = Thing("it", "t:it", Pose(), (
        Geom("box", (0.1, 0.05, 0.02)), Geom("box", (0.02, 0.02, 0.1), Pose((0.05, 0.0, 0.1))),
    ))  # fmt: skip
    leaning = Pose.from_rotvec((0, 0, 0), (0, 0, turn)) * Pose.from_rotvec((0, 0, 0), (lean, 0, 0))
    there = Pose.from_rotvec((0.3, -0.2, 0.5), (0, 0, further))
    one = footprint(thing, leaning, high=height)
    other = footprint(thing, there * leaning, high=0.5 + height)
    by = there.rotation[:2, :2]
    moved = shapely.transform(one, lambda points: points @ by.T + (0.3, -0.2))
    assert moved.symmetric_difference(other).area < 1e-5
    direct = shapely.MultiPoint(_points(thing, leaning)).convex_hull
    assert footprint(thing, leaning).convex_hull.symmetric_difference(direct).area < 1e-5


def _points(thing: Thing, pose: Pose) -> list[tuple[float, float]]:
    """Corners from above."""
    return [tuple(p[:2]) for p in corners(thing, pose).tolist()]

"""Placements on supports that are not level or have a rim, and in regions of a surface."""

from __future__ import annotations

import itertools
import math

import pytest
from helpers.placing import HELD, answers, believed, depth_of, first, on, placed, query_on
from msgspec.structs import replace

from cramlite.model import Feature, Geom, Place, Pose, Thing
from cramlite.plugin import Grounding, Refused
from cramlite_plugins.locations.placing.at_rest import _over
from cramlite_plugins.locations.placing.stable_poses import _stands, _upright, put_down, stable_poses, standing_at
from cramlite_plugins.locations.placing.ways_out import _from_above, prepared
from cramlite_plugins.objects.products_and_fixtures import basket, block, table

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


def test_near_something_the_origins_come_over_one_another() -> None:
    """A mug's handle moves its middle aside: middle over middle its origin was 31 mm from that of the mug below, and 25 mm are near."""
    aside = tuple(replace(g, pose=Pose((0.02, 0.0, 0.0)) * g.pose) for g in DISH.geoms)
    belief = believed(replace(DISH, geoms=aside))
    amid = prepared([query_on(belief, "box", {"near": "box", "within": 0.01})])[0]
    rests = [r for r in itertools.islice(stable_poses([amid], put_down(amid)), 4) if not isinstance(r, Refused)]
    away = [math.dist(r.thing.position[:2], belief.pose("box").position[:2]) for r in rests]
    assert min(away) < 1e-6 and max(away) > 0.015
    dropped = [math.dist(p, belief.pose("box").position[:2]) for p in _over(amid)]
    assert dropped[0] < 1e-3 and max(dropped) < 0.0101  # where it is let go of in simulation, too


@pytest.mark.parametrize(("knob", "stays"), [(Geom("box", (0.01, 0.01, 0.025)), True), (Geom("sphere", (0.025,)), False)])
def test_what_is_let_down_onto_a_knob_stays_there_if_it_would_4_mm_aside(knob: Geom, stays: bool) -> None:
    lid = replace(DISH, geoms=(Geom("box", (0.04, 0.04, 0.01)), knob))
    amid = replace(prepared([query_on(believed(lid), "box")])[0], under=lid)
    assert any(_stands(rest) for rest in _upright([amid], put_down(amid))) is stays


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
    query = replace(query_on(believed(box), "box"), depth=depth_of(box))
    asides = [one for _, one in _from_above(standing_at(query, query.now, (0.0, 0.0))) if one.aside]
    assert bool(asides) == asked

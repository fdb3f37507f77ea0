"""Free areas of placements: between what stands on a surface or lies in a container, and what is said where none is left."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from helpers.placing import TIN, answers, believed, context_of, into, on, placed, query_on, targets
from msgspec.structs import replace

from cramlite.model import Belief, Feature, Geom, Location, Place, Pose, Release, Thing
from cramlite.plugin import Grounding, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing.checks.shapes import inside
from cramlite_plugins.locations.placing.positions import free_for, positions_on, radius
from cramlite_plugins.locations.placing.query import GAP, Placement, openings, queries
from cramlite_plugins.locations.placing.ways_out import beside_content
from cramlite_plugins.motion_planning.reach import held_pose
from cramlite_plugins.objects.products_and_fixtures import basket, block, table
from cramlite_plugins.shapes.surfaces import FLAT


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


@pytest.mark.parametrize(("side", "axis", "sign"), [("left_of", 1, 1), ("right_of", 1, -1), ("behind", 0, 1), ("in_front_of", 0, -1)])
def test_the_first_place_beside_a_thing_is_straight_beside_it(side: str, axis: int, sign: int) -> None:
    belief = believed(block("tin", Pose((0.45, -0.35, 0.175)), (0.05, 0.05, 0.05)))
    query = query_on(belief, where={side: "tin"})
    first = next(positions_on(query, held_pose(belief, context_of(belief))))
    assert first[1 - axis] == pytest.approx(0.0, abs=0.002)
    assert 0.025 + 0.02 < sign * first[axis] < 0.025 + 0.08


def test_beside_a_thing_on_a_large_table_the_next_places_are_near_the_first() -> None:
    at = Pose((0.45, -0.35, 0.15))
    belief = believed(table("wide", at, (1.0, 1.2, 0.02)), block("tin", Pose((0.45, -0.35, 0.175)), (0.05, 0.05, 0.05)))
    query = query_on(belief, "wide", {"left_of": "tin"})
    first, *others = itertools.islice(positions_on(query, held_pose(belief, context_of(belief))), 8)
    assert all(math.dist(first, other) < 0.11 for other in others)


def test_where_straight_beside_it_there_is_no_room_the_next_places_come_from_there_and_none_twice() -> None:
    at = Pose((0.45, -0.35, 0.15))
    tin, can = (block(name, Pose((0.45, y, 0.175)), (0.05, 0.05, 0.05)) for name, y in (("tin", -0.35), ("can", -0.28)))
    query = query_on(believed(table("wide", at, (1.0, 1.2, 0.02)), tin, can), "wide", {"left_of": "tin"})
    found = list(itertools.islice(positions_on(query, held_pose(query.belief, context_of(query.belief))), 60))
    away = [math.dist(found[0], p) for p in found[:4]]
    assert away == sorted(away) and 0 < away[1] < 0.03 and len({*found}) == len(found)


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
def test_an_opening_is_round_or_has_a_width_and_adepth_of(size: dict[str, float], area: tuple[float, ...]) -> None:
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

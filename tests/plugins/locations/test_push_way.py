"""Ways of pushed things: around what stands there, not through it, and what is to blame where there is none."""

from __future__ import annotations

import math

from hypothesis import assume, given
from hypothesis import strategies as st

from cramlite.plugin import Refused
from cramlite_plugins.locations.pushing.around import (
    STEP,
    Met,
    Point,
    on_a_shorter_way,
    way_around,
    way_straight,
    ways_around,
)
from cramlite_plugins.motion_planning.space import refusal

START, END = (0.0, 0.0), (0.3, 0.0)


def _left(spot: Point) -> float:
    return max(math.dist(spot, END) - STEP, 0.0)


def _disc(x: float, y: float, radius: float) -> Met:
    no = refusal("it meets a disc")
    return lambda spot: no if math.dist(spot, (x, y)) < radius else None


def _nothing(_: Point) -> Refused | None:
    return None


@given(st.floats(0.08, 0.22), st.floats(-0.1, 0.1), st.floats(0.01, 0.07))
def test_it_ends_in_the_area_and_meets_nothing(x: float, y: float, radius: float) -> None:
    met = _disc(x, y, radius)
    assume(met(START) is None)
    way = way_around(START, _left, met)
    assert not isinstance(way, Refused)
    assert _left(way[-1]) == 0.0
    legs = zip([START, *way], way, strict=False)
    assert not any(met((a[0] + k / 20 * (b[0] - a[0]), a[1] + k / 20 * (b[1] - a[1]))) for a, b in legs for k in (0, 20))


def test_a_free_way_has_no_corner() -> None:
    assert way_around(START, _left, _nothing) == [(14 * STEP, 0.0)]
    assert way_straight(START, END, _nothing) == [END]


def test_a_straight_way_blames_all_that_is_loose_on_it_and_nothing_where_something_is_fixed() -> None:
    """Else things would be put elsewhere one after the other, or in vain."""
    near, far = (refusal(name, blocking=((name,),)) for name in ("near", "far"))
    loose = way_straight(START, END, lambda spot: near if 0.05 < spot[0] < 0.1 else far if 0.2 < spot[0] < 0.25 else None)
    assert isinstance(loose, Refused) and loose.blocking == (("far", "near"),)
    fixed = way_straight(START, END, lambda spot: near if 0.05 < spot[0] < 0.1 else refusal("wall") if spot[0] > 0.2 else None)
    assert isinstance(fixed, Refused) and fixed.reason == "wall" and not fixed.blocking


def test_a_wider_way_is_further_from_a_disc() -> None:
    met = _disc(0.15, 0.0, 0.05)
    ways = ways_around(START, _left, met, _nothing)
    assert not isinstance(ways, Refused)
    found = {steps: min(math.dist(c, (0.15, 0.0)) for c in corners[:-1]) for steps, corners in ways}
    assert found[2] > found[1] > found[0] >= 0.05


def test_a_short_way_through_what_is_loose_blames_it_and_a_fence_nothing() -> None:
    board = refusal("board", blocking=(("board",),))
    no = way_around(START, _left, lambda spot: board if 0.1 < spot[0] < 0.14 and abs(spot[1]) < 0.3 else None)
    assert isinstance(no, Refused) and no.blocking == (("board",),)
    fenced = way_around(START, _left, lambda spot: refusal("fence") if 0.1 < spot[0] < 0.14 else None)
    assert isinstance(fenced, Refused) and not fenced.blocking


def _wall_with_a_gap(gap: Refused, end: float) -> Met:
    """A wall across the way, whose gap is blocked, that one gets around beyond its end [m]."""
    wall = refusal("wall")
    return lambda spot: None if not 0.05 < spot[0] < 0.19 or abs(spot[1]) > end else gap if abs(spot[1]) < 0.05 else wall


def test_what_blocks_a_much_shorter_way_is_named_though_there_is_a_free_one() -> None:
    block = refusal("block", blocking=(("block",),))
    for end, names in ((0.4, (("block",),)), (0.1, None)):
        met = _wall_with_a_gap(block, end)
        assert not isinstance(way_around(START, _left, met), Refused)
        found = on_a_shorter_way(START, _left, met, _nothing)
        assert (found.blocking if found else None) == names
    assert on_a_shorter_way(START, _left, _wall_with_a_gap(refusal("bolted down"), 0.4), _nothing) is None


def test_each_thing_on_a_shorter_way_counts_once() -> None:
    block, other = (refusal(n, blocking=((n,),)) for n in ("block", "other"))
    met = _wall_with_a_gap(block, math.inf)
    beside = on_a_shorter_way(START, _left, lambda s: other if 0.21 < s[0] < 0.25 and abs(s[1]) < 0.05 else met(s), _nothing)
    assert beside and beside.blocking == (("block",),)  # the other is passed by
    across = on_a_shorter_way(START, _left, lambda s: other if 0.21 < s[0] < 0.25 else met(s), _nothing)
    assert across and across.blocking == (("block", "other"),)

"""How a thing rests on another: lids cover openings, stacked things stand with their centre of mass over what bears them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.short_runs import COUNT, SHELF, good, lying, said, touching
from msgspec.structs import replace

from cramlite.model import Feature, Geom, Pose, Touch
from cramlite.plugin import Candidate
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.objects.vessels import bowl, can, lid
from cramlite_plugins.validators.postconditions import EndState
from cramlite_plugins.validators.stance import borne, near_tip, unbalanced, uncovered

POT = bowl("pot", Pose((0.4, 0.0, 0.045)), radius=0.08, height=0.09)


@pytest.mark.parametrize(("aside", "covers"), [(0.0, True), (0.010, True), (0.012, True), (0.016, False), (0.03, False), (0.06, False)])
def test_a_lid_of_85_mm_covers_an_opening_of_74_mm_within_their_play(aside: float, covers: bool) -> None:
    for x, y in ((aside, 0.0), (0.0, -aside)):
        over = lid("lid", Pose((0.4 + x, y, 0.093)), radius=0.085)
        assert (uncovered(over, POT) == "") is covers
        assert covers or "of the opening of 'pot' uncovered" in uncovered(over, POT)


def test_what_has_no_opening_is_not_to_be_covered() -> None:
    assert uncovered(lid("lid", Pose((0.4, 0.0, 0.1))), block("block", Pose((0.4, 0.0, 0.03)))) == ""


@pytest.mark.parametrize(("aside", "stands"), [(0.0, True), (0.012, True), (0.0245, True), (0.0255, False), (0.031, False)])
def test_a_stacked_block_of_60_mm_has_its_centre_5_mm_inside(aside: float, stands: bool) -> None:
    upper = block("upper", Pose((0.4, aside, 0.09)), size=(0.06, 0.06, 0.06))
    assert (unbalanced(upper, block("lower", Pose((0.4, 0.0, 0.03)), size=(0.06, 0.06, 0.06))) == "") is stands


@pytest.mark.parametrize(("length", "stands"), [(0.2, True), (0.26, True), (0.34, False), (0.4, False)])
def test_what_leans_in_a_pot_also_rests_on_its_rim(length: float, stands: bool) -> None:
    """A bar from the floor, 50 mm beside the middle, over the rim: its middle is over the rim at 305 mm."""
    slope = math.atan2(0.08, 0.125)
    lean = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, -slope, 0.0))
    middle = np.add((0.35, 0.0, 0.012), lean.rotate((length / 2, 0.0, 0.0)))
    bar = block("bar", Pose(tuple(middle.tolist()), lean.quaternion), size=(length, 0.02, 0.01))
    assert (unbalanced(bar, POT) == "") is stands


def test_what_stands_on_little_needs_no_more_than_half_of_that() -> None:
    post = block("post", Pose((0.4, 0.0, 0.03)), size=(0.2, 0.2, 0.06))
    assert unbalanced(can("can", Pose((0.4, 0.0, 0.11)), radius=0.004, height=0.1), post) == ""


@pytest.mark.parametrize(("inside", "stands"), [(0.0022, True), (0.0018, False), (0.0014, False)])
def test_what_stands_on_little_needs_half_of_that(inside: float, stands: bool) -> None:
    """Of a radius of 4 mm, 2 mm."""
    post = block("post", Pose((0.4, 0.0, 0.03)), size=(0.2, 0.2, 0.06))
    at_the_edge = can("can", Pose((0.5 - inside, 0.0, 0.11)), radius=0.004, height=0.1)
    assert (unbalanced(at_the_edge, post) == "") is stands


@pytest.mark.parametrize(("inside", "stands"), [(0.0125, True), (0.0115, False), (0.006, False)])
@pytest.mark.parametrize("turned", [False, True])
def test_the_longer_side_says_how_far_inside(turned: bool, inside: float, stands: bool) -> None:
    """Of a beam of 200 mm, 12 mm."""
    size, at = (0.06, 0.2, 0.06), (0.5 - inside, 0.3, 0.09)
    beam = block("beam", Pose((0.3, 0.5 - inside, 0.09)) if turned else Pose(at), size=(0.2, 0.06, 0.06) if turned else size)
    lower = block("lower", Pose((0.3, 0.3, 0.03)), size=(0.4, 0.4, 0.06))
    assert (unbalanced(beam, lower) == "") is stands


def test_a_thin_plate_bears_what_stands_on_it() -> None:
    plate = block("plate", Pose((0.4, 0.0, 0.0025)), size=(0.1, 0.1, 0.005))
    assert unbalanced(block("upper", Pose((0.4, 0.04, 0.035)), size=(0.06, 0.06, 0.06)), plate) == ""
    assert unbalanced(block("upper", Pose((0.4, 0.047, 0.035)), size=(0.06, 0.06, 0.06)), plate) != ""


def test_an_opening_that_leans_is_where_its_rim_is() -> None:
    leaning = Pose((0.3, 0.2, 0.0), Pose.from_rotvec((0.0, 0.0, 0.0), (0.1, 0.0, 0.0)).quaternion)
    cavity = Feature("cavity", "cram:Cavity", Pose((0.0, 0.0, 0.1)), {"width": 0.06, "depth": 0.08, "height": 0.1})
    chest = replace(block("chest", leaning), features=(cavity,))
    for aside, covers in ((0.0, True), (0.02, False)):
        plate = block("plate", leaning * Pose((0.0, aside, 0.105)), size=(0.1, 0.1, 0.01))
        assert (uncovered(plate, chest) == "") is covers


def stacked_on(movable: bool, aside: float) -> Candidate:
    """The candidate, whose block ends on a block of its own size, or on furniture of that size."""
    base = good().rollout
    assert base is not None
    x, y, z = base.poses["block"][-1, :3]
    under = replace(lying("shelf", (x, y + aside, z - 0.06)), mass=0.2 if movable else None)
    things = tuple(under if t.name == "shelf" else t for t in base.world.things)
    poses = {**base.poses, "shelf": base.poses["shelf"] * 0 + [x, y + aside, z - 0.06, 1, 0, 0, 0]}
    return good(world=replace(base.world, things=things), poses=poses)


def test_a_stack_at_its_edge_is_refused_and_on_furniture_a_thing_stands_as_it_stands() -> None:
    assert SHELF.movable is False
    assert said(EndState(), stacked_on(True, 0.012)) == []
    (why,) = said(EndState(), stacked_on(True, 0.027))
    assert "the centre of mass of 'block' is 3 mm inside of its support on 'shelf', at least 5 mm inside are needed" in why
    assert said(EndState(), stacked_on(False, 0.027)) == []


@pytest.mark.parametrize(("inside", "hangs"), [(0.07, True), (0.0125, True), (0.0115, False), (0.003, False)])
def test_what_hangs_is_farther_from_the_pegs_end_than_it_may_swing(inside: float, hangs: bool) -> None:
    peg = Feature("peg", "vrps:Peg", Pose.from_rotvec((0.0, 0.0, 0.5), (0.0, 1.5707963, 0.0)), {"radius": 0.003, "length": 0.138})
    hook = replace(block("hook", Pose((0.4, 0.0, 0.0))), features=(peg,))
    hole = Feature("hole", "vrps:Hole", Pose((0.0, 0.0, 0.05)), {"diameter": 0.012})
    pack = replace(block("pack", Pose((0.4 + 0.138 - inside, 0.0, 0.45))), features=(hole,))
    assert (near_tip(pack, hook) == "") is hangs
    said = f"'pack' hangs {1000 * inside:.0f} mm from the end of the peg of 'hook', at least 12 mm are needed"
    assert near_tip(pack, hook) == ("" if hangs else said)
    assert near_tip(block("plain", pack.pose), hook) == "" == near_tip(pack, block("bare", hook.pose))


def test_of_a_short_peg_a_quarter_is_enough() -> None:
    peg = Feature("peg", "vrps:Peg", Pose(), {"length": 0.02})
    hook = replace(block("hook", Pose()), features=(peg,))
    hole = Feature("hole", "vrps:Hole", Pose(), {"diameter": 0.012})
    for along, hangs in ((0.0149, True), (0.0151, False)):
        assert (near_tip(replace(block("pack", Pose((0.0, 0.0, along))), features=(hole,)), hook) == "") is hangs


@pytest.mark.parametrize(("x", "y", "covers"), [
    (0.0, 0.0, True), (0.021, 0.0, True), (0.023, 0.0, False), (0.0, 0.011, True), (0.0, -0.013, False), (-0.021, -0.011, True),
    (-0.023, 0.0, False),
])  # fmt: skip
def test_a_plate_covers_a_box_that_is_turned(x: float, y: float, covers: bool) -> None:
    """An opening of 60 x 80 mm under a plate of 100 x 100 mm, both turned; 2 mm may stay open."""
    turned = Pose((0.3, 0.2, 0.1), Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, 0.5)).quaternion)
    cavity = Feature("cavity", "cram:Cavity", Pose((0.0, 0.0, 0.05)), {"width": 0.06, "depth": 0.08, "height": 0.1})
    chest = replace(block("chest", turned), features=(cavity,))
    plate = block("plate", turned * Pose((x, y, 0.06)), size=(0.1, 0.1, 0.01))
    assert (uncovered(plate, chest) == "") is covers
    small = block("small", turned, size=(0.03, 0.08, 0.01))
    assert "leaves 41 % of the opening of 'chest' uncovered" in uncovered(small, chest)


@pytest.mark.parametrize(("lift", "share"), [(1.962, 1.0), (0.981, 0.5), (-1.962, -1.0)])
def test_a_share_of_the_weight_is_borne(lift: float, share: float) -> None:
    pair = Touch("shelf", "block", 2.0, lift)
    for touch in (pair, Touch("block", "shelf", 2.0, -lift)):
        ends = touching(range(COUNT - 1, COUNT), touch, without=lambda t: {t.a, t.b} == {"block", "shelf"}).rollout
        assert ends is not None and borne(ends, "block", "shelf") == pytest.approx(share)
        assert borne(ends, "block", "cup") == borne(ends, "shelf", "block") == 0.0


@pytest.mark.parametrize(("share", "alone"), [(0.91, True), (0.89, False)])
def test_of_what_another_bears_too_no_balance_is_asked(share: float, alone: bool) -> None:
    made = stacked_on(True, 0.027)
    assert made.rollout is not None
    rows = [t for t in made.rollout.touches[-1] if {t.a, t.b} != {"block", "shelf"}]
    held = (*rows, Touch("shelf", "block", 1.962, share * 1.962))
    shared = replace(made, rollout=replace(made.rollout, touches=(*made.rollout.touches[:-1], held)))
    assert (said(EndState(), shared) != []) is alone


def test_what_touches_is_within_a_centimetre_of_where_two_things_meet() -> None:
    """A foot that is wider 20 mm farther down bears nothing."""
    foot = Geom("box", (0.1, 0.1, 0.01), Pose((0.0, 0.0, -0.02)))
    post = replace(block("post", Pose((0.4, 0.0, 0.03)), size=(0.06, 0.06, 0.06)))
    footed = replace(post, geoms=(*post.geoms, foot))
    beside = block("upper", Pose((0.4, 0.027, 0.09)), size=(0.06, 0.06, 0.06))
    assert unbalanced(beside, footed) == unbalanced(beside, post) != ""
    outside = block("upper", Pose((0.4, 0.035, 0.09)), size=(0.06, 0.06, 0.06))
    assert "is 5 mm outside of its support on 'post'" in unbalanced(outside, post)
    narrow = block("narrow", Pose((0.4, 0.0, 0.09)), size=(0.01, 0.2, 0.06))
    assert unbalanced(narrow, post) == ""

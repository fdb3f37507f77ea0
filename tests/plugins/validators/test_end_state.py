"""Where things ended is measured against where what holds them is by then."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.edited import proven
from helpers.short_runs import COUNT, WEIGHT, candidate, good, only, said, shifted, touching
from msgspec.structs import replace

from cramlite.model import Held, Pose, Rollout, Touch
from cramlite.plugin import Candidate
from cramlite_plugins.objects.products_and_fixtures import basket, hanger, hung, product
from cramlite_plugins.validators.postconditions import EndState, _not_in, _not_on, validators
from cramlite_plugins.validators.rest import at_the_end


def moved_later(rollout: Rollout, by: float, *things: str) -> Rollout:
    """The rollout with some things elsewhere in its second half, as if they had been moved [m]."""
    poses = dict(rollout.poses)
    for thing in things:
        poses[thing] = poses[thing].copy()
        poses[thing][len(rollout.times) // 2 :, 0] += by
    return replace(rollout, poses=poses)


@pytest.mark.heavy
@pytest.mark.parametrize(("moved", "passes"), [((), True), (("basket",), False), (("basket", "block"), True)])
def test_in_a_container_is_in_it_where_it_is_then(moved: tuple[str, ...], passes: bool) -> None:
    good = proven("ungrasping")
    assert good.rollout is not None
    judged = replace(good, rollout=moved_later(good.rollout, 0.3, *moved))
    assert all(f.passed for f in EndState().check(judged)) == passes


@pytest.mark.parametrize(("share", "passes"), [(0.51, True), (0.49, False)])
def test_on_a_support_is_what_it_bears(share: float, passes: bool) -> None:
    good = proven("placing").rollout
    assert good is not None
    weight = 9.81 * (good.world.thing("block").mass or 0.0)
    leaning = replace(good, touches=(*good.touches[:-1], (Touch("block", "shelf", 5.0, -share * weight),)))
    said = _not_on(leaning, "block", at_the_end(good, "shelf"))
    assert (said == "") == passes
    assert passes or ("of the" in said and "weighs at the end" in said)


def test_a_thing_is_where_the_run_left_it() -> None:
    good = proven("placing").rollout
    assert good is not None
    assert np.allclose(at_the_end(good, "block").pose.position, good.poses["block"][-1][:3])


# On a run written by hand


def believing(*relations: tuple[str, str, str], of: Candidate | None = None, held: str = "") -> Candidate:
    """The candidate, of which the plan predicts other relations."""
    made = of or good()
    hand = Held(held, Pose(), 0.06) if held else None
    return replace(made, belief=replace(made.belief, relations=frozenset(relations), held=hand))


def judged(*relations: tuple[str, str, str], of: Candidate | None = None, held: str = "") -> list[str]:
    return said(EndState(), believing(*relations, of=of, held=held))


def boxed(x: float = 0.0, y: float = 0.0, z: float = -0.1) -> Candidate:
    """The candidate, in whose world the shelf is a basket of 0.4 x 0.3 x 0.2 m, and the block is in it or not."""
    made = good()
    assert made.rollout is not None
    box = basket("shelf", Pose((0.45, -0.35, 0.15)), size=(0.4, 0.3, 0.2))
    cavity = box.feature("cram:Cavity")
    assert cavity is not None
    things = tuple(box if t.name == "shelf" else t for t in made.world.things)
    poses = {n: p.copy() for n, p in made.rollout.poses.items()}
    poses["shelf"][:, :3] = box.pose.position
    poses["block"][-20:, :3] = (box.pose * cavity.pose).apply((x, y, z))
    world = replace(made.world, things=things)
    return candidate(replace(made.rollout, world=world, poses=poses))


def test_both_are_asked() -> None:
    assert [v.name for v in validators()] == ["end_state", "task_rules"]


def test_what_the_plan_predicts_is_said_where_it_holds() -> None:
    found = only(EndState(), good())
    assert (found.passed, found.reason, found.origin, found.things) == (True, "'block' rests on 'shelf'", "3.Placing", True)


def test_what_plays_no_role_or_is_of_no_known_kind_is_not_asked() -> None:
    assert list(EndState().check(believing(("on", "cup", "floor"), ("near", "block", "floor")))) == []
    assert len(judged(("on", "block", "floor"), ("in", "block", "floor"))) == 2


def test_what_is_still_in_the_hand_is_nowhere_yet() -> None:
    assert list(EndState().check(believing(("on", "block", "shelf"), held="block"))) == []
    assert len(list(EndState().check(believing(("on", "block", "shelf"), held="cup")))) == 1


def test_on_something_else_is_not_on_it() -> None:
    assert judged(("on", "block", "floor")) == ["'block' does not touch 'floor' at the end"]
    assert judged(("on", "block", "cup")) == ["'block' does not touch 'cup' at the end"]


@pytest.mark.parametrize(("share", "passes"), [(0.501, True), (0.5, False), (0.499, False)])
@pytest.mark.parametrize("turned", [False, True])
def test_on_is_borne_by_it_whoever_is_named_first(share: float, passes: bool, turned: bool) -> None:
    lift = share * WEIGHT
    touch = Touch("shelf/top", "block", 5.0, lift) if turned else Touch("block", "shelf/top", 5.0, -lift)
    made = touching([COUNT - 1], touch, without=lambda t: "block" in (t.a, t.b))
    found = judged(("on", "block", "shelf"), of=made)
    assert (found == []) is passes
    if not passes:
        assert found == [f"'shelf' bears {lift:.1f} N of the 2.0 N that 'block' weighs at the end"]


def test_what_several_points_bear_is_added() -> None:
    points = (Touch("block", "shelf", 1.0, -0.3 * WEIGHT), Touch("shelf/edge", "block/foot", 1.0, 0.3 * WEIGHT))
    made = touching([COUNT - 1], *points, without=lambda t: "block" in (t.a, t.b))
    assert judged(("on", "block", "shelf"), of=made) == []
    pressed = touching([COUNT - 1], Touch("cup", "block", 9.0, 9.0), without=lambda t: "block" in (t.a, t.b))
    assert judged(("on", "block", "shelf"), of=pressed) == ["'block' does not touch 'shelf' at the end"]


def test_on_is_asked_of_the_end_alone() -> None:
    assert judged(("on", "block", "shelf"), of=touching([COUNT - 1], without=lambda t: "block" in (t.a, t.b)))
    assert judged(("on", "block", "shelf"), of=touching([COUNT - 2], without=lambda t: "block" in (t.a, t.b))) == []


@pytest.mark.parametrize("touch", [Touch("effector/left", "block", 1.0, 0.0), Touch("block/lid", "effector/body", 1.0, 0.0)])
def test_what_the_gripper_still_touches_was_not_let_go(touch: Touch) -> None:
    assert judged(("on", "block", "shelf"), of=touching([COUNT - 1], touch)) == ["the gripper still touches 'block' at the end"]
    other = replace(touch, a=touch.a.replace("block", "cup"), b=touch.b.replace("block", "cup"))
    assert judged(("on", "block", "shelf"), of=touching([COUNT - 1], other)) == []


def test_what_still_moves_is_not_there_yet() -> None:
    slides = shifted(np.outer(np.arange(10) * 0.002, (1, 0, 0)), "block", COUNT - 10)
    assert "'block' still moves at " in judged(("on", "block", "shelf"), of=slides)[0]


@pytest.mark.parametrize(("axis", "side", "limit"), [
    (0, 1, "width"), (0, -1, "width"), (1, 1, "depth"), (1, -1, "depth"), (2, 1, "rim"), (2, -1, "height"),
])  # fmt: skip
def test_in_is_between_the_walls_over_the_floor_and_hardly_higher_than_the_rim(axis: int, side: int, limit: str) -> None:
    """The middle of a thing that lies in a basket may be up to 50 mm over its rim."""
    cavity = boxed().world.thing("shelf").feature("cram:Cavity")
    assert cavity is not None
    size = cavity.size
    edge = {"width": size["width"] / 2, "depth": size["depth"] / 2, "rim": 0.05, "height": size["height"]}[limit]
    for by, passes in ((-0.001, True), (0.001, False)):
        at = [0.0, 0.0, -0.1]
        at[axis] = side * (edge + by)
        found = judged(("in", "block", "shelf"), of=boxed(*at))
        assert (found == []) is passes
        assert passes or (found[0].startswith("'block' is at ") and "from the middle of the opening of 'shelf'" in found[0])


def test_what_has_no_cavity_holds_nothing() -> None:
    assert judged(("in", "block", "shelf")) == ["'shelf' has no cavity"]


def pegged(there: bool, share: float = 1.0) -> Candidate:
    """The candidate, in whose world the block hangs on the peg of a hook that is its shelf, or is beside it."""
    made = good()
    assert made.rollout is not None
    hook = hanger("shelf", Pose((0.87, 0, 0.45)))
    box = product("block", Pose(), size=(0.06, 0.05, 0.10), hole_diameter=0.009)
    pose = hung(box, hook, depth=0.07)
    world = replace(made.world, things=(hook, replace(box, pose=pose)))
    row = (*(pose.position if there else (0.4, 0.2, 0.06)), *pose.quaternion)
    there = np.tile((*hook.pose.position, *hook.pose.quaternion), (COUNT, 1))
    poses = {**made.rollout.poses, "block": np.tile(row, (COUNT, 1)), "shelf": there}
    lift = share * 9.81 * (box.mass or 0.0)
    return candidate(replace(made.rollout, world=world, poses=poses, touches=((Touch("shelf/peg", "block", 5.0, lift),),) * COUNT))


@pytest.mark.parametrize(
    ("of", "says"),
    [
        (pegged(True), []),
        (pegged(False), ["no peg of 'shelf' passes through a hole of 'block' at the end"]),
        (pegged(True, 0.4), ["'shelf' bears 1.2 N of the 2.9 N that 'block' weighs at the end"]),
    ],
)
def test_hanging_is_a_peg_through_a_hole_that_bears(of: Candidate, says: list[str]) -> None:
    assert judged(("hangs_on", "block", "shelf"), of=of) == says
    assert judged(("hangs_on", "block", "shelf/peg"), of=of) == says


def test_hanging_on_something_else_is_not_hanging_on_it() -> None:
    made = pegged(True)
    assert made.rollout is not None
    beside = replace(hanger("other", Pose((0.87, 0.5, 0.45))), name="other")
    world = replace(made.rollout.world, things=(*made.rollout.world.things, beside))
    poses = {**made.rollout.poses, "other": np.tile((*beside.pose.position, *beside.pose.quaternion), (COUNT, 1))}
    two = candidate(replace(made.rollout, world=world, poses=poses))
    assert judged(("hangs_on", "block", "other"), of=two) == ["no peg of 'other' passes through a hole of 'block' at the end"]


def test_hanging_was_let_go_and_is_asked_of_the_end() -> None:
    made = pegged(True)
    assert made.rollout is not None
    late = made.rollout.poses["block"].copy()
    late[-1, :3] = (0.4, 0.2, 0.06)
    gone = candidate(replace(made.rollout, poses={**made.rollout.poses, "block": late}))
    assert judged(("hangs_on", "block", "shelf"), of=gone)
    swung = made.rollout.poses["block"].copy()
    swung[-9:, 0] += np.arange(9) * 0.002
    moves = candidate(replace(made.rollout, poses={**made.rollout.poses, "block": swung}))
    assert "the hole of 'block' still moves" in judged(("hangs_on", "block", "shelf"), of=moves)[0]


def test_hanging_says_so() -> None:
    (found,) = EndState().check(believing(("hangs_on", "block", "shelf"), of=pegged(True)))
    assert found.reason == "'block' hangs on 'shelf'"


def later(of: Candidate, thing: str, by: tuple[float, float, float]) -> Candidate:
    """The candidate, in whose run a thing is elsewhere at the last sample."""
    assert of.rollout is not None
    poses = of.rollout.poses[thing].copy()
    poses[-1, :3] += by
    return candidate(replace(of.rollout, poses={**of.rollout.poses, thing: poses}))


def test_where_things_are_is_asked_of_the_last_sample() -> None:
    for thing in ("block", "shelf"):
        assert "from the middle of the opening" in judged(("in", "block", "shelf"), of=later(boxed(), thing, (0.5, 0, 0)))[0]
    gone = judged(("hangs_on", "block", "shelf"), of=later(pegged(True), "block", (0.5, 0, 0)))
    assert gone == ["no peg of 'shelf' passes through a hole of 'block' at the end"]
    back = pegged(False)
    assert back.rollout is not None and pegged(True).rollout is not None
    poses = back.rollout.poses["block"].copy()
    poses[0] = pegged(True).rollout.poses["block"][0]  # type: ignore[union-attr]
    at_first = candidate(replace(back.rollout, poses={**back.rollout.poses, "block": poses}))
    assert judged(("hangs_on", "block", "shelf"), of=at_first) == gone


def test_right_at_the_wall_the_rim_and_the_floor_is_in() -> None:
    box = basket("shelf", Pose(), size=(0.4, 0.3, 0.2))
    cavity = box.feature("cram:Cavity")
    assert cavity is not None
    half = replace(cavity, pose=Pose(), size={"width": 0.5, "depth": 0.25, "height": 0.125})
    made = boxed()
    assert made.rollout is not None
    for at in ((0.25, 0.0, 0.0), (0.0, 0.125, 0.0), (0.0, 0.0, -0.125), (0.0, 0.0, 0.05)):
        block, shelf = (np.tile((*p, 1.0, 0, 0, 0), (COUNT, 1)) for p in (at, (0.0, 0.0, 0.0)))
        poses = {**made.rollout.poses, "block": block, "shelf": shelf}
        assert _not_in(replace(made.rollout, poses=poses), "block", replace(box, features=(half,))) == "", at


def test_what_weighs_nothing_is_borne_by_anything() -> None:
    made = good()
    assert made.rollout is not None
    light = tuple(replace(t, mass=None) if t.name == "block" else t for t in made.world.things)
    assert _not_on(replace(made.rollout, world=replace(made.world, things=light)), "block", made.world.thing("shelf")) == ""
    loose = tuple(tuple(t for t in row if {t.a, t.b} != {"block", "shelf"}) for row in made.rollout.touches)
    unsupported = replace(made.rollout, world=replace(made.world, things=light), touches=loose)
    assert "does not touch" in _not_on(unsupported, "block", made.world.thing("shelf"))

"""Goals that cannot hold at one time are told from those that can, by what predicates declare."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite import Engine, Goal, Trace, find_scenario, read_scenario
from cramlite.interpretation.fluents import SymbolicWorld, symbolic_world
from cramlite.model import Pose, World
from cramlite.planning.goal_literals import lasting_of
from cramlite.planning.goal_parser import contradiction
from cramlite.planning.operators import Grounder
from cramlite.plugin import Timeline, UserError
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.products_and_fixtures import basket, block, hanger, product, table

ENGINE = Engine()
THINGS = (
    table("left", Pose((0.5, 0.5, 0)), size=(0.3, 0.3, 0.02)), table("right", Pose((0.5, -0.5, 0)), size=(0.3, 0.3, 0.02)),
    table("near", Pose((0.5, -0.82, 0)), size=(0.3, 0.3, 0.02)), basket("basket", Pose((0.5, 0.5, 0.0)), size=(0.2, 0.2, 0.1)),
    hanger("hook", Pose((0.9, 0.3, 0.4))), hanger("peg", Pose((0.9, -0.6, 0.4))), product("box", Pose((0.5, 0.5, 0.1))),
    block("tin", Pose((0.5, -0.5, 0.031))), cabinet("c", Pose((1.5, 0, 0.3))), drawer("d", Pose((1.5, 0, 0.3)), "c"),
)  # fmt: skip


def scene(*more: object) -> SymbolicWorld:
    return symbolic_world(World((*THINGS, *more), ()), ENGINE.knowledge.taxonomy)  # type: ignore[arg-type]


GROUNDER = Grounder(scene(), ENGINE.knowledge.predicates)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("d open", "d closed"),
        ("tin held", "tin on left"),
        ("tin held", "tin in basket"),
        ("tin held", "box held"),
        ("box on hook", "box off hook"),
        ("box on hook", "box on peg"),
        ("box on hook", "box on left"),
        ("tin on left", "tin on right"),
        ("tin in left", "tin in right"),
        ("tin in basket", "tin on right"),
    ],
)
def test_what_cannot_hold_at_one_time_is_named_both_ways_round(one: str, other: str) -> None:
    for pair in ((one, other), (other, one)):
        said = contradiction(pair, GROUNDER)
        assert f"'{pair[0]}' and '{pair[1]}' contradict each other" in said
        assert contradiction(("box off near", *pair), GROUNDER) == said


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("tin on left", "tin on left"),
        ("tin on left", "box on left"),
        ("tin held", "tin off right"),
        ("tin in basket", "tin on left"),  # the basket stands on it
        ("tin on right", "tin off left"),
        ("d open", "tin held"),
    ],
)
def test_what_can_is_no_contradiction(one: str, other: str) -> None:
    assert contradiction((one, other), GROUNDER) == contradiction((other, one), GROUNDER) == ""


def test_a_plank_may_lie_on_two_tables_that_are_nearer_than_it_is_long() -> None:
    for length, both in ((0.3, True), (0.01, False)):  # 20 mm are between them
        plank = block("plank", Pose((0.5, -0.66, 0.03)), size=(0.01, length, 0.01))
        said = contradiction(("plank on right", "plank on near"), Grounder(scene(plank), ENGINE.knowledge.predicates))
        assert (said == "") is both


def test_a_basket_that_can_be_carried_is_nowhere_apart() -> None:
    crate = replace(basket("crate", Pose((0.5, -0.5, 0.0))), mass=0.5)
    grounder = Grounder(scene(crate), ENGINE.knowledge.predicates)
    assert contradiction(("tin in crate", "tin in basket"), grounder) == ""


def test_the_engine_refuses_them_before_it_plans() -> None:
    setting, trace = ENGINE.setting(read_scenario(find_scenario("tasks/opening"))), Trace()
    with pytest.raises(UserError, match="'drawer open' and 'drawer closed' contradict each other"):
        next(ENGINE.plans(Goal(("drawer open", "drawer closed")), setting, trace))
    assert not trace.entries
    plan, _ = next(ENGINE.plans(Goal(("drawer open",)), setting, trace))
    assert plan.goal == ("drawer open",)


def test_what_a_demonstration_ended_with_goes_to_its_plan_and_nothing_else() -> None:
    reading = ENGINE.read(read_scenario(find_scenario("fetch_from_hanger")))
    plan, sequence = next(ENGINE.plans(reading, ENGINE.setting(reading), Trace()))
    lasting = [(name.partition(".")[2], text) for name, text in plan.lasting]
    assert ("Ungrasping", "in_or_above(Locatum, Relatum)") in lasting
    assert not [text for _, text in lasting if text.startswith("grasps")]  # it was let go
    episode = reading.episode
    assert episode is not None and sequence is not None
    earlier = replace(episode, events=tuple(e for e in episode.events if e.type != "cram:GraspState" or e.end > 0))
    rules = {r.task: r for r in ENGINE.knowledge.rules}
    held = [replace(e, end=episode.span[1]) if e.type == "cram:GraspState" else e for e in earlier.events]
    timeline = Timeline(replace(earlier, events=tuple(held)), ENGINE.knowledge.taxonomy)
    kept = list(lasting_of(sequence.matches, plan.actions, rules, timeline))
    assert [text for _, text in kept if text.startswith("grasps")]  # a hand that never let go ended with it

"""Levers of doors: how far they are turned, and what refuses them."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.model import Action, Belief, Estimate, Location, Motion, Object
from cramlite.plugin import Context, Unresolvable
from cramlite_plugins.locations.jointed.handles import check_way
from cramlite_plugins.locations.jointed.levers import BEYOND, freeing, lever_of
from cramlite_plugins.shapes.carried_along import carried_along

ENGINE = Engine()
TURNED = Location("turned", "opened", "door")


def scene(lever: float = 0.0) -> tuple[Belief, Context]:
    """The door of the scenario with its lever turned."""
    setting = ENGINE.setting(read_scenario(find_scenario("kitchen/lever_door")), twins=0)
    belief = setting.belief()
    thing = belief.world.thing("lever")
    assert thing.joint is not None
    moved = Estimate(thing.joint.moved(thing.pose, lever))
    belief = replace(belief, poses={**belief.poses, "lever": moved})
    return belief, Context(setting.robot, belief.world.robots[0], {"door": "door"}, ENGINE.knowledge.taxonomy)


def test_it_is_turned_a_little_further_than_to_where_the_door_is_free() -> None:
    belief, context = scene()
    lever = lever_of(TURNED, belief.world.thing("door"), belief)
    (value,) = freeing(TURNED, lever, 0.8, belief.poses["lever"].pose, belief, context)
    assert BEYOND + math.radians(20) < value < math.radians(80)


def test_where_the_door_is_free_there_is_nothing_to_turn() -> None:
    belief, context = scene(lever=1.3)
    lever = lever_of(TURNED, belief.world.thing("door"), belief)
    with pytest.raises(Unresolvable, match="'door' can be opened with 'lever' as it is"):
        freeing(TURNED, lever, 0.8, belief.poses["lever"].pose, belief, context)


def test_a_thing_without_a_lever_says_so() -> None:
    belief, _ = scene()
    with pytest.raises(Unresolvable, match="no lever is mounted on 'keeper'"):
        lever_of(TURNED, belief.world.thing("keeper"), belief)


def test_a_door_takes_its_lever_along() -> None:
    belief, _ = scene()
    assert set(carried_along(belief, "door")) == {"lever"}


def test_another_way_is_asked_for_where_the_lever_holds_its_door_shut() -> None:
    belief, context = scene()
    way = Location("1.Opening/handle", "handle", "door", {"least": 0.8})
    context = replace(context, agenda=(Motion("1.Opening/transfer", "transfer", way),))
    with pytest.raises(Unresolvable, match=r"'lever' is .* inside 'keeper'") as held:
        check_way(way, belief.world.thing("door"), belief, context)
    assert "1.Opening" in held.value.because
    bare = replace(belief.world, things=tuple(replace(t, joint=None) if t.name == "lever" else t for t in belief.world.things))
    with pytest.raises(Unresolvable) as met:
        check_way(way, bare.thing("door"), replace(belief, world=bare), context)
    assert "1.Opening" not in met.value.because, "what stands in its way is all that can be moved"


def test_a_lever_is_led_less_far_where_the_arm_does_not_reach_all_the_way() -> None:
    belief, _ = scene()
    opening = ENGINE.knowledge.tasks["soma:Opening"]
    ways = opening.decompose(Action("1.Opening", "soma:Opening", {"Patient": Object("door", entity="door")}), belief)
    by_lever = [way.steps for way in ways if way.reason.startswith("turn the lever")]
    shares = [step.parameters["share"] for steps in by_lever for step in steps if step.name == "opened(door)"]
    assert shares == [0.0, 0.85, 0.8]

"""Levers of doors: how far they are turned, and what refuses them."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.model import Belief, Estimate, Location
from cramlite.plugin import Context, Unresolvable
from cramlite_plugins.locations.levers import BEYOND, freeing, lever_of
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

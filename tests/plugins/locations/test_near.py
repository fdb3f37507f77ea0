"""Near a thing: what is held is brought within what the predicate calls near, or it is said why not."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Held, Location, Object, Pose, RobotMount, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.motion_planning.reach import make_scene
from cramlite_plugins.objects.products_and_fixtures import block, hanger, table
from cramlite_plugins.predicates.places import NEAR
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.bounds import bounds
from cramlite_plugins.task_kit.preconditions import near as near_thing

MOUNT = RobotMount("arm", "ur5e")
HELD = Held("it", Pose((0.0, 0.0, 0.03)), 0.04)
THINGS = (
    table("shelf", Pose((0.45, -0.35, 0.15)), (0.3, 0.3, 0.02)),
    hanger("hook", Pose((0.87, 0.0, 0.45), (0.0, 0.0, 0.0, 1.0))),
    block("it", Pose((0.4, 0.3, 0.5)), (0.04, 0.04, 0.10)),
    table("far", Pose((3.0, 0.0, 0.15)), (0.3, 0.3, 0.02)),
)


def _belief() -> Belief:
    return initial_belief(World(THINGS, (MOUNT,)), "arm", UR5E.home, 0.085)


def _context() -> Context:
    return Context(UR5E, MOUNT, {t.name: t.name for t in THINGS}, Engine().knowledge.taxonomy)


def _at(name: str) -> Location:
    return near_thing(Object(name))


@pytest.mark.parametrize("name", ["shelf", "hook"])
def test_what_is_held_comes_near_without_a_collision(name: str) -> None:
    belief, context = _belief().grasped(HELD), _context()
    found = [a for a in ground(_at(name), belief, context) if isinstance(a, Grounding)]
    assert found
    size = next(t for t in THINGS if t.name == name)
    there = belief.pose(name)
    boxes = [bounds(g) for g in size.geoms]
    low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
    for one in found[:5]:
        at = there.inverse().apply((one.value.pose * HELD.tcp_to_thing).position)
        assert np.linalg.norm(np.maximum(np.maximum(low - at, at - high), 0.0)) < NEAR
    scene = make_scene(belief, context)
    assert scene.free(next(q for q in inverse(UR5E, found[0].value.pose, seed=UR5E.home) if scene.free(q)))
    assert [a.cost for a in found] == sorted(a.cost for a in found)
    assert len(found) <= 5  # one a side


def test_the_empty_hand_comes_near_too() -> None:
    first = next(
        a for a in ground(_at("shelf"), _belief(), _context()) if isinstance(a, Grounding)
    )
    assert first.value.pose.position != forward(UR5E, UR5E.home).position


def test_what_is_out_of_reach_is_refused_with_numbers() -> None:
    answers = list(islice(ground(_at("far"), _belief(), _context()), 100))
    assert answers and all(isinstance(a, Refused) for a in answers)
    assert "m of arm 'ur5e'" in answers[0].reason  # type: ignore[union-attr]


def test_nobody_grasps_or_nears_what_is_in_the_hand_or_lost() -> None:
    held, place = _belief().grasped(HELD), Location("grasp(it)", "grasp", "it")
    with pytest.raises(Unresolvable, match="'it' is in the hand"):
        list(ground(place, held, _context()))
    with pytest.raises(Unresolvable, match="'it' is in the hand"):
        list(ground(_at("it"), held, _context()))
    lost = replace(held, held=None)
    with pytest.raises(Unresolvable, match="where 'it' came to lie is not known"):
        list(ground(place, lost, _context()))

"""Ways on the floor: every leg is free of collision in a world whose robot is not grown; where there is none, why."""

from __future__ import annotations

import itertools
import math

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Geom, Pose, RobotMount, Thing, World
from cramlite_plugins.motion_planning.base_planner import Ground, NoBasePath, ground, level, plan_base_path, unwound
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.robots.ur5e_mobile import UR5E_MOBILE
from cramlite_plugins.simulation.model.compile import compile_world

ROBOTS = {"ur5e_mobile": UR5E_MOBILE, "ur5e": UR5E}
FLOOR = Thing("floor", "cram:Table", Pose((0, 0, -0.01)), (Geom("box", (5, 5, 0.005)),))
CRATE = Thing("crate", "cram:Table", Pose((1.5, 0, 0.25)), (Geom("box", (0.25, 0.25, 0.25)),))
PLATE = Thing("plate", "cram:Table", Pose((1.5, 0, 1.0)), (Geom("box", (0.4, 0.4, 0.02)),))
WALLS = tuple(
    Thing(f"wall{k}", "cram:Table", Pose((x, y, 0.5)), (Geom("box", (a, b, 0.5)),))
    for k, (x, y, a, b) in enumerate([(0.7, 0, 0.01, 0.7), (-0.7, 0, 0.01, 0.7), (0, 0.5, 0.7, 0.01), (0, -0.5, 0.7, 0.01)])
)


def floor_with(*things: Thing, start: Pose = Pose()) -> Ground:  # noqa: B008 - frozen
    world = World((FLOOR, *things), (RobotMount("arm", "ur5e_mobile", start),))
    return ground(world, ROBOTS, "arm", UR5E_MOBILE.home, poses={}, opening=0.08)


def touches(floor: Ground, places: list[tuple[float, float, float]]) -> bool:
    """Whether the robot as it is touches anything on straight legs between places, looked at every 10 mm and 1 deg."""
    compiled = compile_world(floor.compiled.world, ROBOTS, planning=True)
    data, index = compiled.data(), compiled.robots["arm"].platform
    assert index is not None
    for a, b in itertools.pairwise(places):
        for share in np.linspace(0, 1, 2 + int(max(math.dist(a[:2], b[:2]) / 0.005, abs(b[2] - a[2]) / 0.009))):
            index.put(data, floor.start, level(tuple(np.array(a) + share * np.subtract(b, a))))  # type: ignore[arg-type]
            mujoco.mj_kinematics(compiled.model, data)
            mujoco.mj_collision(compiled.model, data)
            if any("crate" in pair for pair in compiled.collisions(data)):
                return True
    return False


def test_an_empty_floor_takes_one_leg() -> None:
    assert plan_base_path(floor_with(), (0, 0, 0), (3, 1, 0.5)) == [(3, 1, 0.5)]


@pytest.mark.heavy
@examples(4)
@given(st.floats(-1.0, 1.0), st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_ways_around_a_crate_touch_nothing(y: float, turn: float, goal_turn: float) -> None:
    floor, start, goal = floor_with(CRATE), (0.0, 0.2, turn), (3.0, y, goal_turn)
    found = plan_base_path(floor, start, goal)
    assert isinstance(found, list)
    assert math.dist(found[-1][:2], goal[:2]) < 1e-9
    assert abs(math.remainder(found[-1][2] - goal_turn, math.tau)) < 1e-9
    assert all(abs(b[2] - a[2]) < math.pi for a, b in itertools.pairwise([start, *found]))
    assert not touches(floor, [start, *found])


def test_straight_through_a_crate_touches_it() -> None:
    assert touches(floor_with(CRATE), [(0, 0, 0), (3, 0, 0)])
    assert "'crate'" in floor_with(CRATE).leg((0, 0, 0), (3, 0, 0))


def test_the_arm_counts_too() -> None:
    """The platform fits under a plate at 1 m; the parked arm reaches up to it."""
    assert "from 'plate'" in floor_with(PLATE).hit((1.5, 0, 0))


def test_a_robot_that_is_shut_in_is_told_so() -> None:
    found = plan_base_path(floor_with(*WALLS), (0, 0, 0), (3, 0, 0))
    assert isinstance(found, NoBasePath)
    assert found.shut_in
    assert "from the start" in found.reason
    assert "wall" in found.reason


def test_a_goal_that_is_shut_in_leaves_other_goals() -> None:
    found = plan_base_path(floor_with(*WALLS, start=Pose((3, 0, 0))), (3, 0, 0), (0, 0, 0))
    assert isinstance(found, NoBasePath)
    assert not found.shut_in
    assert "from the goal" in found.reason


def test_an_occupied_goal_is_named() -> None:
    found = plan_base_path(floor_with(CRATE), (0, 0, 0), (1.5, 0, 0))
    assert isinstance(found, NoBasePath)
    assert "at the goal" in found.reason
    assert "'crate'" in found.reason


def test_the_world_may_have_been_entered_from_anywhere() -> None:
    """The place of the mount does not matter: places are in the world."""
    turned = floor_with(CRATE, start=Pose.from_rotvec((0.4, -0.3, 0.0), (0, 0, 1.0)))
    assert turned.hit((1.5, 0, 0)) and not turned.hit((0, 0, 0))


@given(st.floats(-20, 20), st.floats(-20, 20))
def test_turns_are_the_shorter_way_round(turn: float, near: float) -> None:
    found = unwound((0, 0, turn), (0, 0, near))[2]
    assert abs(found - near) <= math.pi + 1e-9
    assert abs(math.remainder(found - turn, math.tau)) < 1e-9


def test_an_arm_that_is_bolted_down_has_no_ground() -> None:
    world = World((FLOOR,), (RobotMount("arm", "ur5e"),))
    with pytest.raises(ValueError, match="no platform"):
        ground(world, ROBOTS, "arm", UR5E.home, poses={}, opening=0.08)

"""Open vessels are carried upright, measured where the cup really was while the text ran."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Budget, Engine, read_scenario
from cramlite.model import Geom, Held, Location, Motion, Place, Pose, RobotMount, Rollout, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Unresolvable
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.cartesian import sampled
from cramlite_plugins.motion_planning.scene_of_world import scene
from cramlite_plugins.motion_planning.upright import BEFORE, Load, UprightScene, waypoints_over
from cramlite_plugins.motions.free_motion import resolve_motion
from cramlite_plugins.robots.ur5e import UR5E

SCENARIO = """
scenario: carry_cup
title: Carry a cup over a wall; another one keeps the arm from turning the other way round
tasks:
  - {task: Grasp, Patient: cup}
  - {task: PickUp, Locatum: cup, Relatum: floor}
  - {task: Place, Locatum: cup, Relatum: shelf}
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: shelf, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}
  - {name: wall, model: table, at: {position: [0.5, -0.07, 0.15]}, with: {size: [0.5 m, 20 mm, 0.3 m]}}
  - {name: back, model: table, at: {position: [-0.6, 0, 0.8]}, with: {size: [0.8 m, 20 mm, 0.8 m]}}
  - {name: cup, model: block, type: TYPE, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
"""
numbers = st.floats(0.2, 0.7)


def carried(type_: str, folder: Path) -> tuple[Rollout, str]:
    """How the first program for a thing of this class went, and its text."""
    file = folder / "carry_cup.yaml"
    file.write_text(SCENARIO.replace("TYPE", type_))
    found = next(Engine().resolve(read_scenario(file), budget=Budget(proofs=1)))
    assert found.candidate.rollout is not None
    assert found.candidate.code is not None
    return found.candidate.rollout, found.candidate.code.text


def most_tilted(rollout: Rollout) -> float:
    """Largest angle between the cup's z axis and the vertical [deg]."""
    x, y = rollout.poses["cup"][:, 4], rollout.poses["cup"][:, 5]
    return math.degrees(float(np.arccos(np.clip(1 - 2 * (x**2 + y**2), -1.0, 1.0)).max()))


def test_a_cup_stays_within_its_tolerance_while_the_text_runs(tmp_path: Path) -> None:
    rollout, text = carried("soma:Cup", tmp_path)
    assert most_tilted(rollout) < 15.0
    transfer = text.split("PuttingDown/transfer")[1].split("PuttingDown/lower")[0]
    assert ", r=0." in transfer and "movel" not in transfer, "up, over and down, and nowhere a stop"


def test_a_line_that_turns_the_arm_over_is_free_and_tilts_what_it_carries() -> None:
    world = World((), (RobotMount("arm", "ur5e", Pose()),))
    free = scene(world, {"ur5e": UR5E}, "arm")
    up, wrist = (-0.5, -1.6, 1.8, -1.77, -math.pi / 2, 0.0), (0.3, -1.6, 1.8, -1.77, -math.pi / 2, 0.0)
    over = (-0.5, -1.6, 1.8, -1.27, -math.pi / 2, 0.0)  # the wrist 0.5 rad further
    for limit, keeps in ((math.radians(14.5), False), (0.6, True)):
        in_tcp = forward(UR5E, up).inverse() * Pose(forward(UR5E, up).position)
        carried = UprightScene(free, Load("cup", limit, in_tcp, (0.0, 0.0, 1.0)))
        assert carried.line_free(up, wrist)
        assert free.line_free(up, over) and carried.line_free(up, over) == keeps


def under_a_bar(*more: Thing) -> list[Grounding]:
    """Ways of a hand to where the far end of the long cup that it holds by the near one is under a bar."""
    cup = Thing("cup", "soma:Cup", Pose((0.45, -0.35, 0.37)), (Geom("box", (0.1, 0.02, 0.03)),), mass=0.1)
    bar = Thing("bar", "soma:DesignedFurniture", Pose((0.55, 0.2, 0.27)), (Geom("box", (0.02, 0.1, 0.01)),))
    mount = RobotMount("arm", "ur5e")
    here, there, on = (Pose.from_axes(at, (0, 0, -1), (1, 0, 0)) for at in ((0.37, -0.35, 0.4), (0.37, 0.2, 0.23), (0.37, 0.2, 0.2)))
    context = Context(UR5E, mount, {"cup": "cup", "there": Place(on, there)}, Engine().knowledge.taxonomy, seed=0)
    start = initial_belief(World((cup, bar, *more), (mount,)), "arm", UR5E.home, 0.085)
    belief = start.grasped(Held("cup", here.inverse() * cup.pose, 0.04)).moved(inverse(UR5E, here, seed=UR5E.home)[0])
    answers = resolve_motion(Motion("1.PuttingDown/transfer", "transfer", Location("there", "on")), belief, context)
    return [a for a in answers or () if isinstance(a, Grounding)]


@pytest.mark.heavy
def test_a_load_comes_down_nearer_to_the_robot_where_something_hangs_over_its_place() -> None:
    ways = under_a_bar()
    assert ways and str(ways[-1].key).endswith(f" {BEFORE[1]}")
    near = Thing("near", "soma:DesignedFurniture", Pose((0.2, 0.12, 0.2)), (Geom("box", (0.01, 0.05, 0.1)),))
    with pytest.raises(Unresolvable, match="from upright"):
        under_a_bar(near)


@examples(40)
@given(st.tuples(numbers, numbers, numbers), st.tuples(numbers, numbers, numbers), st.floats(-3, 3), st.booleans(), st.sampled_from(BEFORE))
def test_a_way_between_upright_poses_is_upright_and_keeps_its_height(
    a: tuple[float, float, float], b: tuple[float, float, float], yaw: float, around: bool, before: float
) -> None:
    here, there = Pose(a), Pose.from_rotvec(b, (0.0, 0.0, yaw))
    load = Load("cup", math.radians(1.0), Pose(), (0.0, 0.0, 1.0))
    corners = waypoints_over(here, there, load.up, 0.1, around, before)
    assert corners[-1] == there
    if before:  # it comes down nearer to the robot, and on to its place level
        assert math.hypot(*there.position[:2]) - math.hypot(*corners[-2].position[:2]) == pytest.approx(before)
        assert corners[-2].position[2] == pytest.approx(there.position[2])
    assert max(load.tilt(p) for p in sampled(here, corners, 0.05, 0.1)) < 1e-3
    assert max(p.position[2] for p in corners) == pytest.approx(max(a[2], b[2]) + 0.1)
    assert load.tilt(Pose.from_rotvec(a, (0.3, 0.0, 0.0))) == pytest.approx(0.3)

"""The standard layout can be worked in: a product comes off its hanger and lands in the basket, by friction alone."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from helpers.arm import FORWARD, follow, line, ramp, solve
from helpers.standard import ROBOTS, standard_world
from msgspec.structs import replace

from cramlite.model import Physics, Pose, World
from cramlite_plugins.objects.products_and_fixtures import hung, product, table
from cramlite_plugins.objects.vessels import can
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

START = (3.02, -1.17, 2.0, -1.0, 1.45, -1.57)


def hanging(size: tuple[float, float, float], physics: Physics | None = None) -> World:
    world = standard_world(physics)
    item = product("product", Pose(), size=size)
    item = replace(item, pose=hung(item, world.thing("hanger"), 0.07))
    return replace(world, things=tuple(item if t.name == "product" else t for t in world.things))


def take_off(compiled: Compiled, rise: float) -> Any:
    """Grasp the hanging product from the front, pull it off (raised by ``rise`` at the tip), let go over the basket."""
    data, index = compiled.data(), compiled.robots["arm"]
    grasp = Pose(compiled.pose(data, "product").position) * FORWARD
    points = [(-0.15, 0), (0, 0), (0, 0.002), (-0.062, 0.002), (-0.085, rise), (-0.2, rise)]
    poses = [Pose((x, 0, z)) * grasp for x, z in points]
    q = solve(compiled, poses[0], START)
    data.qpos[list(index.joints)] = q
    data.ctrl[list(index.actuators)] = q
    mujoco.mj_forward(compiled.model, data)
    for i in range(5):
        path = line(compiled, poses[i], poses[i + 1], q, 6)
        q = path[-1]
        follow(compiled, data, path, 80)
        ramp(compiled, data, {index.gripper: 200.0 if i else data.ctrl[index.gripper]}, 100)
        if i == 0:
            ramp(compiled, data, {index.gripper: 200.0}, 200)
            ramp(compiled, data, {}, 100)
    over = Pose((0.30, -0.40, 0.33)) * FORWARD
    follow(compiled, data, line(compiled, poses[-1], over, q, 12), 100)
    ramp(compiled, data, {index.gripper: 0.0}, 300)
    ramp(compiled, data, {}, 500)
    return data


@pytest.mark.parametrize("size", [(0.04, 0.025, 0.15), (0.06, 0.05, 0.10), (0.08, 0.02, 0.12)])
def test_off_the_hanger_and_into_the_basket(size: tuple[float, float, float]) -> None:
    compiled = compile_world(hanging(size), ROBOTS)
    data = take_off(compiled, rise=0.012)
    inside = compiled.world.thing("basket").pose.inverse().apply(compiled.pose(data, "product").position)
    assert np.all(np.abs(inside[:2]) < (0.19, 0.14))
    assert 0 < inside[2] < 0.15
    assert {b for _, b in compiled.collisions(data)} == {"product"}


def test_without_friction_it_stays_on_the_hanger() -> None:
    compiled = compile_world(hanging((0.04, 0.025, 0.15), Physics(pad_friction=0.0)), ROBOTS)
    data = take_off(compiled, rise=0.012)
    assert compiled.collisions(data) == {("hanger/peg", "product/hole")}


@pytest.mark.parametrize(("friction", "rolls"), [(0.0001, False), (0.0, True)])
def test_what_is_round_comes_to_rest_when_it_rolls(friction: float, rolls: bool) -> None:
    """A can that rolls at 50 mm/s loses 20 mm/s each second by the lever of 0.1 mm: g times .004, and the can's own turning behind it."""
    lying = can("can", Pose.from_rotvec((0.0, 0.0, 0.034), (math.pi / 2, 0, 0)))
    compiled = compile_world(World((table("floor", Pose(), size=(1.0, 1.0, 0.02)), lying)), {})
    compiled.model.geom_friction[:, 2] = friction
    data = compiled.data()
    data.qvel[:] = (0.05, 0.0, 0.0, 0.0, 0.0, -0.05 / 0.033)  # of the free joint: in the world, then about the can's own axes
    for _ in range(round(3.0 / compiled.model.opt.timestep)):
        mujoco.mj_step(compiled.model, data)
    assert abs(data.qvel[0]) > 0.03 if rolls else abs(data.qvel[0]) < 0.003


def test_what_hangs_on_a_round_peg_has_no_rolling_friction() -> None:
    compiled = compile_world(hanging((0.06, 0.05, 0.10)), ROBOTS)
    model = compiled.model
    round_ones = np.isin(model.geom_type, (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE))
    assert round_ones.any() and (model.geom_condim[round_ones] <= 4).all()

"""The standard layout of scenario tests: robot at the origin, a hanger in front, a basket to its right."""

from __future__ import annotations

import math

from msgspec.structs import replace

from cramlite.model import Physics, Pose, RobotMount, World
from cramlite_plugins.objects.products_and_fixtures import basket, hanger, hung, product, table
from cramlite_plugins.robots.ur5e import UR5E

ROBOTS = {"ur5e": UR5E}
BACK = Pose((0, 0, 0), (math.cos(math.pi / 2), 0, 0, math.sin(math.pi / 2)))


def standard_world(physics: Physics | None = None, robot: bool = True) -> World:
    """Make the world with a product on a hanger whose peg points to the robot (-x), tip at x .72, z .45, and a basket at (.30, -.45, 0)."""
    hook = hanger("hanger", Pose((0.868, 0, 0.444)) * BACK)
    item = product("product", Pose())
    item = replace(item, pose=hung(item, hook, depth=0.07))
    things = (table("table", Pose((0.4, 0, -0.001))), hook, item, basket("basket", Pose((0.30, -0.45, 0))))
    return World(things, (RobotMount("arm", "ur5e"),) if robot else (), physics or Physics())


def standing_world(physics: Physics | None = None) -> World:
    """Make the world with a product that stands on the table in front of the robot, its depth along y."""
    item = product("product", Pose((0.65, 0.1, 0.075)), mass=0.8)
    return World((table("table", Pose((0.4, 0, 0))), item), (RobotMount("arm", "ur5e"),), physics or Physics())

"""Small worlds for the tests of motions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cramlite.model import Geom, Pose, RobotMount, Thing, World
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.planning_scene import PlanningScene
from cramlite_plugins.motion_planning.scene_of_world import scene
from cramlite_plugins.robots.ur5e import UR5E

ROBOTS = {"ur5e": UR5E}
Triple = tuple[float, float, float]


def box(name: str, half: Triple, position: Triple, mass: float | None = None) -> Thing:
    """Make a box from half-extents and position [m]."""
    return Thing(name, f"t:{name}", Pose(position), (Geom("box", half),), mass=mass)


TABLE = box("table", (0.6, 0.6, 0.02), (0.5, 0.0, -0.03))
WALL = box("wall", (0.3, 0.02, 0.25), (0.55, 0.0, 0.25))
BLOCK = box("block", (0.02, 0.02, 0.05), (0.45, 0.3, 0.045), 0.2)


def world(*things: Thing) -> World:
    """Make a world with one UR5e at its origin and the given things."""
    return World(things, (RobotMount("arm1", "ur5e"),))


def make(*things: Thing, **options: Any) -> PlanningScene:
    """Make the planning scene of a UR5e and the given things."""
    return scene(world(*things), ROBOTS, "arm1", **options)


def down(x: float, y: float, z: float) -> Pose:
    """Return a tool pose that points down at a position, with the fingers closing along y."""
    return Pose.from_axes((x, y, z), (0, 0, -1), (1, 0, 0))


def stance(scene_: PlanningScene, pose: Pose) -> tuple[float, ...]:
    """Return the collision-free inverse kinematics solution nearest to home."""
    return next(q for q in inverse(UR5E, pose) if scene_.free(q))


def named(clauses: Mapping[str, str] | str, name: str) -> bool:
    """Check whether a reason contains the quoted name of a thing."""
    return f"'{name}'" in str(clauses)

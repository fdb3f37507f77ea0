"""A robot is seen as the meshes of its bodies, and moves and touches with the shapes of its collision checks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Camera, Pose, RobotMount, World
from cramlite_plugins.robots.looks import Skin, covered

EYE = Pose.from_axes((0.0, -1.2, 0.3), z=(0.0, 1.0, -0.1), x=(1.0, 0.0, 0.0))


def test_cameras_see_a_robots_meshes(tmp_path: Path) -> None:
    trimesh.creation.box((0.3, 0.3, 0.3)).export(tmp_path / "box.obj")
    knowledge, world = Engine().knowledge, World((), (RobotMount("robot", "ur5e"),))
    plain = knowledge.robots["ur5e"]
    seen = replace(plain, looks=lambda: covered(plain.mjcf(), {"base_link": Skin(tmp_path / "box.obj", Pose((0.0, 0.0, 0.15)))}))
    before, after = (knowledge.simulator.look(world, {"ur5e": r}, Camera(EYE, noise=0.0), seed=0).depth for r in (plain, seen))
    changed = np.isfinite(after) & ~(np.abs(after - before) < 1e-6)
    assert 0.9 < after[changed].min() < 1.06 and changed.sum() > 500
    assert "base_link_skin" not in seen.mjcf()

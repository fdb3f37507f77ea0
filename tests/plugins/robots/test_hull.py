"""A link's shape that is a convex hull of circles."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from cramlite_plugins.robots.dh_arm import Cylinder, Link, arm_mjcf
from cramlite_plugins.robots.hull import Circle, Hull, corners

HULL = Hull((Circle("z", (0.0, 0.0, -0.1), 0.05), Circle("y", (0.02, 0.06, 0.0), 0.03)))
DIRECTIONS = np.random.default_rng(0).normal(size=(200, 3))
UNIT = DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)


def support(points: np.ndarray) -> np.ndarray:
    """The farthest that points reach in each direction [m]."""
    return np.asarray((points @ UNIT.T).max(axis=0))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_corners_lie_about_their_circle_and_little_beyond(axis: str) -> None:
    centre, radius = np.array((0.1, -0.2, 0.3)), 0.05
    found = corners(Hull((Circle(axis, tuple(centre), radius),)))
    k = "xyz".index(axis)
    assert np.allclose(found[:, k], centre[k])
    turns = np.linspace(0.0, math.tau, 100)
    circle = np.tile(centre, (100, 1))
    circle[:, (k + 1) % 3] += radius * np.cos(turns)
    circle[:, (k + 2) % 3] += radius * np.sin(turns)
    beyond = support(found) - support(circle)
    assert beyond.min() > -1e-9 and 0 < beyond.max() < 0.036 * radius


def test_a_link_collides_as_the_hull_of_its_circles_beside_links_of_cylinders() -> None:
    inertia = (0.01, 0.01, 0.01, 0.0, 0.0, 0.0)
    links = tuple(
        Link(n, 1.0, (0.0, 0.0, 0.0), inertia, 10.0, 100.0, shape)
        for n, shape in (("one", (HULL,)), ("other", (Cylinder((0, 0, 0), (0, 0, 0.1), 0.02),)))
    )
    text = arm_mjcf("two", ((0.0, 0.1, 0.0), (0.2, 0.0, 0.0)), links, ("a", "b"), ((-1, 1), (-1, 1)), (HULL,), ("", ""))
    model = mujoco.MjModel.from_xml_string(text)
    assert [mujoco.mjtGeom(t).name[7:] for t in model.geom_type] == ["MESH", "MESH", "CYLINDER"]
    for name in ("base_link", "one"):
        geom = model.geom(f"{name}/0")
        mesh = model.mesh(int(geom.dataid[0]))
        points = model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]].astype(float)
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, geom.quat)
        assert np.allclose(support(points @ turn.reshape(3, 3).T + geom.pos), support(corners(HULL)), atol=1e-6)

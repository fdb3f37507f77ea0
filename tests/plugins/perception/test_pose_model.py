"""Pose models: points on the outside only, holes open, symmetries that the shape has and no others."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from cramlite.model import Pose, Thing
from cramlite.plugin import UserError
from cramlite_plugins.objects.products_and_fixtures import block, product
from cramlite_plugins.objects.vessels import can, mug
from cramlite_plugins.perception.pose.model import cube_rotations, mesh_model, pose_model


def test_points_are_on_the_outside_and_the_hole_is_open() -> None:
    thing = product("tea", Pose())
    model = pose_model(thing)
    hole = thing.features[0].pose.inverse().apply(np.asarray(model.points, dtype=float))
    assert np.hypot(hole[:, 0], hole[:, 1]).min() > 0.0049
    inside = (np.abs(model.points) < np.array([0.0199, 0.0124, 0.0749])).all(1)
    assert not inside.any()
    assert np.allclose(np.linalg.norm(model.normals, axis=1), 1, atol=1e-4)


@pytest.mark.parametrize(
    ("thing", "count", "round_"),
    [
        (product("a", Pose()), 2, False),
        (block("b", Pose()), 24, False),
        (block("c", Pose(), (0.06, 0.05, 0.09)), 4, False),
        (mug("m", Pose()), 1, False),
        (can("t", Pose()), 73, True),
    ],
    ids=["product", "cube", "block", "mug", "can"],
)
def test_symmetries(thing: Thing, count: int, round_: bool) -> None:
    model = pose_model(thing)
    assert len(model.symmetries) == count and (model.axis == (0, 0, 1)) == round_


def test_a_difference_is_that_to_the_nearest_symmetric_pose() -> None:
    model = pose_model(product("a", Pose()))
    half, quarter = (Pose.from_rotvec((0.3, 0, 0), (0, 0, a)) for a in (math.pi, math.pi / 2))
    there = Pose((0.3, 0, 0))
    assert model.difference(half, there) == pytest.approx((0, 0), abs=1e-6)
    assert model.difference(quarter, there)[1] == pytest.approx(math.pi / 2)
    round_ = pose_model(can("t", Pose()))
    assert round_.difference(quarter, there) == pytest.approx((0, 0), abs=1e-6)


def test_the_grid_finds_the_nearest_points() -> None:
    model = pose_model(product("a", Pose()))
    rng = np.random.default_rng(0)
    points = (model.points[rng.integers(0, len(model.points), 500)] + rng.normal(0, 0.002, (500, 3))).astype(np.float32)
    exact = model.tree.query(points)[0]
    found = np.linalg.norm(points - model.points[model.grid.look_up(points)], axis=1)
    assert (found - exact).max() < 2 * model.grid.step
    assert model.grid.look_up(points + 10).max() < len(model.points)


def test_there_are_24_rotations_of_a_cube() -> None:
    turns = np.array([p.rotation for p in cube_rotations()])
    assert len(np.unique(turns.round(6).reshape(-1, 9), axis=0)) == 24 and np.allclose(np.linalg.det(turns), 1)


def test_a_mesh_with_a_hole_keeps_it() -> None:
    plate = trimesh.creation.annulus(0.005, 0.03, 0.002)
    model = mesh_model(plate, "washer", "cram:Product")
    assert np.hypot(model.points[:, 0], model.points[:, 1]).min() > 0.0048 and model.axis == (0, 0, 1)


def test_a_mesh_that_is_not_closed_is_closed_first() -> None:
    """A box without a face, some of its faces inside out: every normal then points outwards."""
    box = trimesh.creation.box((0.06, 0.05, 0.09))
    box.update_faces(np.arange(len(box.faces)) > 1)
    box.faces[:3] = box.faces[:3, ::-1]
    model = mesh_model(box, "box", "cram:Product")
    assert (np.einsum("ij,ij->i", model.points, model.normals) > 0).all()
    assert np.allclose(model.extents, (0.06, 0.05, 0.09), atol=0.002)


def test_what_has_no_shape_is_refused() -> None:
    with pytest.raises(UserError, match="'ghost' has no shape"):
        pose_model(Thing("ghost", "cram:Product", Pose(), ()))
    with pytest.raises(UserError, match="without triangles"):
        mesh_model(trimesh.Trimesh(), "ghost", "cram:Product")
    with pytest.raises(UserError, match="volume"):
        mesh_model(trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), "sheet", "cram:Product")

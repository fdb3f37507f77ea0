"""Pictures show what is there, without a display."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from helpers.scenes import BLOCK, WALL, down, make, world
from helpers.standard import ROBOTS, standard_world
from msgspec.structs import replace

from cramlite.model import Geom, Pose, RobotMount, Thing, World
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.camera.ray_tracer import Camera, backdrop, cast, part_still, render, render_before
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulation.recording.collision_pictures import collision_picture
from cramlite_plugins.simulation.recording.pictures import camera_of


def test_a_picture_shows_robot_product_and_basket() -> None:
    compiled = compile_world(standard_world(), ROBOTS)
    data = compiled.data()
    picture = render(compiled.model, data, width=160, height=120, shadows=True)
    assert picture.shape == (120, 160, 3)
    assert picture.dtype == np.uint8
    red, green = (picture[..., 0] > 1.6 * picture[..., 1]).sum(), (picture[..., 1] > 1.2 * picture[..., 0]).sum()
    assert red > 20
    assert green > 500
    compiled.place(data, "product", Pose((0, 0, -5)))
    from mujoco import mj_forward

    mj_forward(compiled.model, data)
    gone = render(compiled.model, data, width=160, height=120)
    assert (gone[..., 0] > 1.6 * gone[..., 1]).sum() == 0


def test_pictures_before_one_backdrop_are_those_without() -> None:
    """The arm in two postures; in the last one the camera is inside the box around a part of it."""
    compiled, size = compile_world(standard_world(), ROBOTS), (80, 60)
    model, data, arm = compiled.model, compiled.data(), list(compiled.robots["arm"].joints)
    part_still(model)
    for camera in (Camera(), Camera((0.3, 0.2, 0.4), (0.0, 0.0, 0.3))):
        behind = backdrop(model, compiled.data(), camera, size)
        for turned in (0.0, 0.9):
            data.qpos[arm[0]] += turned
            mujoco.mj_kinematics(model, data)
            one, other = render(model, data, camera, *size), render_before(behind, model, data)
            assert np.array_equal(one, other)


def test_rays_measure_distances_and_normals() -> None:
    wall = Thing("wall", "cram:Wall", Pose((2, 0, 0)), (Geom("box", (0.5, 5, 5)),))
    compiled = compile_world(World((wall,)), {})
    directions = np.array([[1.0, 0, 0], [-1.0, 0, 0], [np.sqrt(0.5), np.sqrt(0.5), 0]])
    geom, distance, normal = cast(compiled.model, compiled.data(), np.zeros(3), directions)
    assert list(geom) == [0, -1, 0]
    assert distance[[0, 2]] == pytest.approx([1.5, 1.5 * np.sqrt(2)])
    assert normal[0] == pytest.approx((-1, 0, 0))


@pytest.mark.parametrize(("wall", "side"), [(None, -1.0), ((0.1, -1.0, 0.7), 1.0), ((0.5, 0.1, 0.2), -1.0)])
def test_pictures_are_taken_beside_the_robot_wherever_it_stands(wall: tuple[float, float, float] | None, side: float) -> None:
    """A wall before the camera makes it change sides; one behind what it looks at does not."""
    base = Pose.from_rotvec((2.0, 3.0, 0.9), (0, 0, 1.2))
    things = () if wall is None else (Thing("wall", "cram:Wall", base * Pose(wall), (Geom("box", (0.5, 0.02, 0.5)),)),)
    there = World(things, (RobotMount("arm", "ur5e", base),))
    compiled = compile_world(there, ROBOTS)
    camera = camera_of(there, compiled.model, compiled.data())
    eye, target = ((base.inverse() * Pose(p)).position for p in (camera.eye, camera.target))
    assert eye == pytest.approx((-0.35, side * 1.55, 1.10)) and target == pytest.approx(Camera().target)
    assert camera_of(World(()), compiled.model, compiled.data()).target == Camera().target


def test_the_camera_sees_its_target_in_the_middle_and_up_is_up() -> None:
    ball = Thing("ball", "cram:Ball", Pose((1, 0, 1)), (Geom("sphere", (0.05,), rgba=(1, 0, 0, 1)),))
    compiled = compile_world(World((ball,)), {})
    data = compiled.data()

    def centre(camera: Camera) -> np.ndarray:
        picture = render(compiled.model, data, camera, 81, 61)
        rows, columns = np.nonzero(picture[..., 0] > 1.5 * picture[..., 1].astype(float))
        return np.array([rows.mean(), columns.mean()])

    assert centre(Camera((0, 0, 0), (1, 0, 1))) == pytest.approx((30, 40), abs=0.6)
    assert centre(Camera((0, 0, 0), (1, 0, 0.8)))[0] < 29
    assert centre(Camera((0, 0, 0), (1, 0.2, 1)))[1] > 41
    assert np.isnan(centre_or_nan(compiled, data))


def centre_or_nan(compiled: object, data: object) -> float:
    picture = render(compiled.model, data, Camera((0, 0, 0), (-1, 0, -1)), 81, 61)  # type: ignore[attr-defined]
    return float("nan") if not (picture[..., 0] > 1.5 * picture[..., 1].astype(float)).any() else 0.0


def test_a_refused_state_shows_both_bodies_and_no_others_in_colour() -> None:
    around = world(WALL, BLOCK)
    place = make(WALL, BLOCK)
    found = place.collision(inverse(UR5E, down(0.55, 0.0, 0.2))[0])
    assert found is not None
    assert "wall" in found.pair
    picture = collision_picture(around, ROBOTS, found, (160, 120)).astype(int)
    red, blue = (picture[..., a] - picture[..., b] > 20 for a, b in ((0, 2), (2, 0)))
    assert red[40:80, 60:100].any()
    assert blue[40:80, 60:100].any()
    apart = replace(found, one="block", other="arm1/base_link", moved={"block": Pose((0.1, 0.0, 0.1))})
    elsewhere = collision_picture(around, ROBOTS, apart, (160, 120)).astype(int)
    wall = collision_picture(around, ROBOTS, replace(apart, other="wall"), (160, 120)).astype(int)
    assert not np.array_equal(elsewhere, wall)
    with pytest.raises(KeyError):
        collision_picture(around, ROBOTS, replace(found, other="nobody"), (160, 120))

"""What neither belief nor an earlier picture explains is found, whatever the noise; a camera that was moved shows the robot elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Camera, Mask, Pose, RobotMount, Thing, View, World
from cramlite.perception.unexpected import compared, differ, predicted, share_of_robot, unexpected, without_robot
from cramlite_plugins.objects.products_and_fixtures import make

EYE, TARGET = np.array((1.5, 0.2, 0.9)), np.array((0.45, 0.0, 0.1))
CAMERA = Camera(Pose.from_axes(tuple(EYE), TARGET - EYE, np.cross(TARGET - EYE, (0, 0, 1))))
TABLE = make("table", "table", Pose((0.5, 0, -0.01)), {"size": (1.4, 1.6, 0.02)})


@pytest.fixture(scope="module")
def engine() -> Engine:
    """Engine with the shipped plugins."""
    return Engine()


def world(x: float = 0.5, *more: Thing) -> World:
    """A box on a table before an arm."""
    box = make("block", "box", Pose((x, 0.2, 0.041)), {"size": (0.08, 0.08, 0.08), "mass": 0.2})
    arm = RobotMount("arm", "ur5e", joints=(0.0, -1.9, 2.2, -1.9, -1.57, 0.0), opening=0.05)
    return World((TABLE, box, *more), (arm,))


def seen(engine: Engine, there: World, camera: Camera = CAMERA, seed: int = 1) -> View:
    """A picture with the noise of a camera, as if from the usual place."""
    view = engine.knowledge.simulator.look(there, engine.knowledge.robots_of(there), camera, seed=seed)
    return compared(replace(view, camera=CAMERA.pose))


def odd(engine: Engine, view: View, believed: World, before: View, held: str = "") -> Mask:
    """What is unexpected in a view, after one of which nothing but a box at 0.5 m was believed."""
    (now, own), (then, _) = predicted(view, believed, engine.knowledge, held), predicted(before, world(), engine.knowledge)
    return unexpected(without_robot(view, own), now, without_robot(before, own), then)


def test_what_is_as_believed_or_as_it_was_is_expected(engine: Engine) -> None:
    tower = make("block", "tower", Pose((0.6, -0.3, 0.101)), {"size": (0.1, 0.1, 0.2)})
    before = seen(engine, world(0.5, tower))
    later = seen(engine, world(0.5, tower), seed=2)
    assert not odd(engine, later, world(), before).any() and not differ(before, later), "the tower stood there before"
    moved = seen(engine, world(0.62, tower), seed=3)
    assert not odd(engine, moved, world(0.62), before).any(), "the box is where it is believed now"


def test_what_moved_is_not_expected(engine: Engine) -> None:
    before, view = seen(engine, world()), seen(engine, world(0.56), seed=2)
    points = view.world_cloud[odd(engine, view, world(), before)]
    assert len(points) > 10 and differ(before, view)
    assert (np.abs(points[:, 0] - 0.5) < 0.2).all() and (np.abs(points[:, 1] - 0.2) < 0.2).all()


def test_a_camera_that_was_moved_shows_the_robot_elsewhere(engine: Engine) -> None:
    askew = replace(CAMERA, pose=Pose.from_rotvec((0.02, 0, 0), (0, 0, 0.0873)) * CAMERA.pose)
    for camera, least, most in ((CAMERA, 0.9, 1.0), (askew, 0.0, 0.7)):
        view = seen(engine, world(), camera)
        assert least <= share_of_robot(view, predicted(view, world(), engine.knowledge)[1]) <= most


def test_what_should_have_moved_and_did_not_is_not_expected(engine: Engine) -> None:
    before, view = seen(engine, world()), seen(engine, world(), seed=2)
    points = view.world_cloud[odd(engine, view, world(0.7), before)]
    assert len(points) > 10, "it stands where it stood, and should not"
    assert (np.abs(points[:, 0] - 0.5) < 0.3).all()
    assert not odd(engine, view, world(), before, held="block").any()

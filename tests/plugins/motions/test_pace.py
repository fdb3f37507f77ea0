"""How fast motions of a robot are that has a pace: what touches nothing is gone faster, and what says its speed is not."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.scenes import TABLE, down, world
from msgspec.structs import replace

from cramlite.model import Location, Motion, Place, Pose, Release, Robot, initial_belief
from cramlite.plugin import Context
from cramlite.plugin.task_type import TaskType
from cramlite.testing.task_checks import sample_action, sample_belief
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motions import contact_motion, free_motion, gripping
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.tasks.closing import Closing
from cramlite_plugins.tasks.grasping import FREE, Grasping
from cramlite_plugins.tasks.putting_down import PuttingDown

FAST = replace(UR5E, pace=2.0)
ROOT = 2.0**0.5
HERE = down(0.5, 0.2, 0.3)
THERE = Pose((0.5, 0.25, 0.3), HERE.quaternion)
BELOW = Pose((0.5, 0.2, 0.24), HERE.quaternion)
SLOW, PACED = {"speed_m_s": 0.05}, {"speed_m_s": 0.05, "paced": 1.0}


def steps(robot: Robot, kind: str, parameters: dict[str, Any], to: Pose = THERE) -> tuple[Any, ...]:
    """The steps that a motion becomes, from 300 mm over the table."""
    room = world(TABLE)
    place = Place(to, to, path=(to,), release=Release(0.0))
    context = Context(robot, room.robots[0], {"there": place}, None)  # type: ignore[arg-type]
    belief = initial_belief(room, "arm1", inverse(robot, HERE, seed=robot.home)[0], 0.08)
    motion = Motion("1.Grasping/it", kind, Location("there", "on"), {"stage": "pose", **parameters})
    for plugin in (free_motion, contact_motion, gripping):
        if (answers := plugin.resolve_motion(motion, belief, context)) is not None:
            return tuple(next(iter(answers)).value)
    raise AssertionError(kind)


@pytest.mark.parametrize(
    ("robot", "parameters", "speed", "acceleration"),
    [
        (UR5E, {}, 0.1, 0.5), (FAST, {}, 0.2, 1.0), (UR5E, SLOW, 0.05, 0.5), (FAST, SLOW, 0.05, 0.5), (FAST, PACED, 0.1, 0.5 * ROOT),
        (UR5E, PACED | {"free_m_s": 0.1}, 0.05, 0.5), (FAST, PACED | {"free_m_s": 0.1}, 0.2, 0.5 * ROOT),
        (FAST, SLOW | {"free_m_s": 0.1}, 0.05, 0.5),
    ],
)  # fmt: skip
def test_straight_lines(robot: Robot, parameters: dict[str, float], speed: float, acceleration: float) -> None:
    (step,) = steps(robot, "linear", parameters)
    assert (step.speed, step.acceleration) == pytest.approx((speed, acceleration))


@pytest.mark.parametrize(("robot", "speed"), [(UR5E, 0.1), (replace(UR5E, pace=1.2), 0.12), (FAST, 0.15)])
def test_fingers_keep_the_pace_as_far_as_they_can(robot: Robot, speed: float) -> None:
    (step,) = steps(robot, "gripper", {"to": "shut"})
    assert step.speed == pytest.approx(speed)


@pytest.mark.parametrize(("robot", "acceleration"), [(UR5E, 0.25), (FAST, 0.5 * ROOT)])
def test_the_part_of_a_guarded_motion_in_the_air(robot: Robot, acceleration: float) -> None:
    air, guarded = steps(robot, "until_contact", {"free_m_s": 0.1, "beyond_m": 0.03}, BELOW)
    assert air.acceleration == pytest.approx(acceleration)
    assert guarded.distance == pytest.approx(0.045)


@pytest.mark.parametrize(("robot", "paced", "duration"), [(UR5E, 1.0, 0.3), (FAST, 1.0, 0.15), (FAST, 0.0, 0.3)])
def test_a_wait(robot: Robot, paced: float, duration: float) -> None:
    (step,) = steps(robot, "hold", {"duration_s": 0.3, "paced": paced})
    assert step.duration == pytest.approx(duration)


@pytest.mark.parametrize(
    ("task", "held", "kind", "parameters"),
    [
        (Grasping(), None, "linear", {"paced": 1.0, "free_m_s": FREE}), (PuttingDown(), "cube", "hold", {"paced": 1.0}),
        (Closing(), None, "force_path", {"paced": 1.0}),
    ],
)  # fmt: skip
def test_tasks_that_keep_the_pace(task: TaskType, held: str | None, kind: str, parameters: dict[str, float]) -> None:
    ways = task.decompose(sample_action(task), sample_belief(held))
    motions = [s for way in ways for s in way.steps if isinstance(s, Motion) and s.kind == kind]
    assert motions and all(parameters.items() <= m.parameters.items() for m in motions)

"""How fast motions of a robot are that has a pace: what touches nothing is gone faster, and what says its speed is not."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.placing import taxonomy
from helpers.scenes import TABLE, box, down, world
from msgspec.structs import replace

from cramlite.model import ErrorModel, Location, Motion, Place, Pose, Release, Robot, initial_belief
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


def touching(away: float, errors: ErrorModel | None) -> tuple[Any, ...]:
    """The steps of a guarded motion down to a plate whose origin is ``away`` [m] beside the place."""
    room = world(TABLE, box("plate", (0.02, 0.02, 0.02), (BELOW.position[0] + away, *BELOW.position[1:])))
    bindings = {"there": Place(BELOW, BELOW), "plate": "plate"}
    context = Context(FAST, room.robots[0], bindings, taxonomy(), errors=errors)
    belief = initial_belief(room, "arm1", inverse(FAST, HERE, seed=FAST.home)[0], 0.08)
    motion = Motion("1.Closing/touch", "until_contact", Location("there", "on"), {"free_m_s": 0.1}, ("plate",))
    answers = contact_motion.resolve_motion(motion, belief, context)
    assert answers is not None
    return tuple(next(iter(answers)).value)


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


@pytest.mark.parametrize(("robot", "acceleration", "guarded_m"), [(UR5E, 0.25, 0.015), (FAST, 0.5 * ROOT, 0.002)])
def test_the_part_of_a_guarded_motion_in_the_air(robot: Robot, acceleration: float, guarded_m: float) -> None:
    """A faster robot with nothing in its hand, and nothing to touch, has no error to guard against."""
    air, guarded = steps(robot, "until_contact", {"free_m_s": 0.1, "beyond_m": 0.03}, BELOW)
    assert air.acceleration == pytest.approx(acceleration)
    assert guarded.distance == pytest.approx(guarded_m + 0.03)


@pytest.mark.parametrize(("away", "guarded_m"), [(0.0, 0.002 + 3 * 0.002 / 5**0.5), (0.3, 0.01405), (0.6, 0.015)])
def test_a_faster_robot_guards_against_the_errors_of_what_it_touches(away: float, guarded_m: float) -> None:
    """The farther from where a thing stands, the less is its place known; half as large errors are half as long."""
    one, half = (touching(away, errors)[-1].distance - 0.03 for errors in (None, ErrorModel(scale=0.5)))
    assert one == pytest.approx(guarded_m, abs=1e-4)
    assert half - 0.002 == pytest.approx((guarded_m - 0.002) / 2, abs=1e-4) or one == 0.015


@pytest.mark.parametrize(("robot", "paced", "speed"), [(UR5E, 1.0, 0.015), (FAST, 1.0, 0.03), (FAST, 0.0, 0.015)])
def test_what_presses_keeps_the_pace_where_that_is_asked_for(robot: Robot, paced: float, speed: float) -> None:
    (step,) = steps(robot, "until_contact", {"speed_m_s": 0.015, "paced": paced}, BELOW)
    assert step.speed == pytest.approx(speed)


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

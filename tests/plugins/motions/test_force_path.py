"""Compliant paths: across what the arm gives way, and how fast it goes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.scenes import TABLE, down, world
from msgspec.structs import replace

from cramlite.model import ForceMove, Joint, Location, Motion, Place, Pose, initial_belief
from cramlite.plugin import Context
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motions.contact_motion import resolve_motion
from cramlite_plugins.robots.ur5e import UR5E

HERE = down(0.5, 0.2, 0.3)
LEANING = HERE * Pose.from_rotvec((0, 0, 0), (0, math.radians(15), 0))
FAST = replace(UR5E, pace=2.0)
SHIFTED = Pose((0.45, 0.2, 0.3), HERE.quaternion)


def follow(start: Pose, *path: Pose, paced: float = 0.0) -> ForceMove:
    """The step that a path becomes."""
    room = world(TABLE)
    motion = Motion("1.Opening/pull", "force_path", Location("way", "opened"), {"speed_m_s": 0.08, "paced": paced})
    context = Context(FAST, room.robots[0], {"way": Place(path[-1], path[-1], path=path)}, None)  # type: ignore[arg-type]
    belief = initial_belief(room, "arm1", inverse(FAST, start, seed=FAST.home)[0], 0.0)
    answers = resolve_motion(motion, belief, context)
    assert answers is not None
    step = next(iter(answers)).value[0]
    assert isinstance(step, ForceMove)
    return step


def turned(start: Pose, radius: float, radians: float = 0.4) -> Pose:
    """A pose that was led around an upright axis."""
    axis = Joint("hinge", Pose((start.position[0] - radius, *start.position[1:])), 0.0, 1.0)
    return axis.moved(Pose(), radians) * start


@pytest.mark.parametrize("radius", [0.0, 0.006])
def test_the_hand_at_a_knob_gives_way_across_its_axis_however_it_leans(radius: float) -> None:
    axis = follow(LEANING, turned(LEANING, radius)).frame.rotate((0.0, 0.0, 1.0))
    assert abs(axis[2]) == pytest.approx(1.0, abs=1e-6)


def test_at_a_door_it_gives_way_across_its_way() -> None:
    axis = follow(HERE, turned(HERE, 0.2)).frame.rotate((0.0, 0.0, 1.0))
    assert abs(axis[2]) < 1e-6
    assert abs(float(np.dot(axis, (0.0, 1.0, 0.0)))) > 0.95


@pytest.mark.parametrize(
    ("end", "paced", "speed"), [
        (SHIFTED, 1.0, 0.16), (SHIFTED, 0.0, 0.08),
        (turned(HERE, 0.2), 1.0, 0.08 * math.sqrt(2.0)), (turned(HERE, 0.2), 0.0, 0.08),
        (turned(HERE, 0.2, 0.16), 1.0, math.sqrt(0.25 * 0.25 * 0.16)), (turned(HERE, 0.2, 0.1), 1.0, 0.08),
    ],
)  # fmt: skip
def test_a_way_is_gone_at_the_robots_pace_where_that_is_asked_for(end: Pose, paced: float, speed: float) -> None:
    """A leg that turns is no faster than it becomes from rest to rest, at 0.25 m/s2, with 0.25 m for a radian."""
    assert follow(HERE, end, paced=paced).speed == pytest.approx(speed)

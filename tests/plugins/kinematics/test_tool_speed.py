"""The tool's speed on joint-space lines, and what a leading axis is slowed to for it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Motion
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.kinematics.tool_speed import passable_speed, tool_way
from cramlite_plugins.motion_planning.joint_move import joint_move
from cramlite_plugins.robots.ur5e import UR5E

STRETCHED = (0.0, -0.3, 0.2, 0.0, 0.0, 0.0)
FAR = 0.895


def turned(joints: tuple[float, ...], joint: int, angle: float) -> tuple[float, ...]:
    return (*joints[:joint], joints[joint] + angle, *joints[joint + 1 :])


def test_about_its_base_the_tool_goes_on_a_circle() -> None:
    x, y, _ = forward(UR5E, STRETCHED).position
    assert tool_way(UR5E, (STRETCHED, turned(STRETCHED, 0, 2.0))) == pytest.approx(math.hypot(x, y), rel=1e-3)


def test_the_fastest_part_of_a_path_counts() -> None:
    wrist, back = turned(STRETCHED, 5, 2.0), turned(turned(STRETCHED, 5, 2.0), 0, -2.0)
    alone = tool_way(UR5E, (wrist, back))
    assert tool_way(UR5E, (STRETCHED, wrist)) < 0.01 < alone
    assert tool_way(UR5E, (STRETCHED, wrist, back)) == pytest.approx(alone) == pytest.approx(tool_way(UR5E, (back, wrist, STRETCHED)))


def test_who_stays_moves_no_tool() -> None:
    assert tool_way(UR5E, (STRETCHED, STRETCHED)) == 0.0 == tool_way(UR5E, (STRETCHED,))
    assert passable_speed(UR5E, (STRETCHED, STRETCHED), 3.0, 1.4) == 3.0


@given(to=st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6), speed=st.floats(0.1, 3.0))
@examples(50)
def test_no_part_of_the_way_is_faster_than_it_may_be(to: list[float], speed: float) -> None:
    path = (STRETCHED, tuple(to))
    found = passable_speed(UR5E, path, speed, 1000.0)
    lead = float(np.abs(np.subtract(to, STRETCHED)).max())
    tips = np.array([forward(UR5E, q).position for q in np.linspace(*path, 500)])
    fastest = np.linalg.norm(np.diff(tips, axis=0), axis=1).max() * 499 / max(lead, 1e-9) * found
    assert 0 < found <= speed and fastest <= 1.5 * 0.92
    assert found == speed or fastest > 1.5 * 0.88


@pytest.mark.parametrize(("angle", "slowed"), [(1.5, False), (1.75, True)])
def test_what_a_short_way_never_reaches_slows_nothing(angle: float, slowed: bool) -> None:
    """With 1.4 rad/s2 an arm reaches 1.51 rad/s on 1.63 rad, at most; its tool is 0.895 m from the axis."""
    assert tool_way(UR5E, (STRETCHED, turned(STRETCHED, 0, angle))) == pytest.approx(FAR, abs=0.01)
    halves = (STRETCHED, turned(STRETCHED, 0, angle / 2), turned(STRETCHED, 0, angle))
    for path in (halves, halves[::2]):
        assert (passable_speed(UR5E, path, 3.0, 1.4) < 3.0) is slowed


def test_a_motion_that_is_slowed_says_why() -> None:
    motion = Motion("1.A/move", "transfer", reason="to the shelf")
    slow = joint_move(motion, UR5E, (STRETCHED, turned(STRETCHED, 0, 2.0)), (3.0, 4.0))
    assert slow.speed == pytest.approx(0.9 * 1.5 / math.hypot(*forward(UR5E, STRETCHED).position[:2]), abs=2e-3) and slow.speed < 3.0
    assert slow.comment == f"to the shelf; {slow.speed:g} instead of 3 rad/s, as the tool goes 1.5 m/s at most"
    usual = joint_move(motion, UR5E, (STRETCHED, turned(STRETCHED, 5, 2.0), STRETCHED), (1.05, 1.4), (0.01,))
    assert (usual.speed, usual.acceleration, usual.comment, usual.radii, usual.origin) == (1.05, 1.4, "to the shelf", (0.01,), "1.A/move")
    assert usual.path == (turned(STRETCHED, 5, 2.0), STRETCHED)

"""Fingers of a wider gripper are farther apart where they are open, and meet where they are closed."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Robot
from cramlite.model.wider_gripper import with_wider_gripper

ROBOTS = sorted(Engine().knowledge.robots.values(), key=lambda r: r.type)


def gaps(robot: Robot) -> list[float]:
    """Distance between the pads, with the slides at either end of their ranges [m]."""
    model = mujoco.MjModel.from_xml_string(robot.mjcf())
    data, found = mujoco.MjData(model), list[float]()
    slides = [model.joint(f"{side}_finger") for side in ("left", "right")]
    for end in (0, 1):
        for slide in slides:
            data.qpos[slide.qposadr] = slide.range[end]
        mujoco.mj_kinematics(model, data)
        apart = np.linalg.norm(np.subtract(*(data.geom(f"{side}_pad1").xpos for side in ("left", "right"))))
        found.append(float(apart) - 2 * float(min(model.geom("left_pad1").size)))
    return found


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda r: r.type)
def test_wider_fingers_open_by_as_much_and_close_as_before(robot: Robot) -> None:
    wider = with_wider_gripper(robot, 0.02)
    assert wider is not None and wider.gripper.opening[1] == pytest.approx(robot.gripper.opening[1] + 0.02)
    (wide, shut), (was, before) = gaps(wider), gaps(robot)
    assert wide - was == pytest.approx(0.02, abs=1e-6) and shut == pytest.approx(before, abs=1e-6)


def test_fingers_that_are_no_two_slides_have_no_wider_model() -> None:
    robot = ROBOTS[0]
    assert with_wider_gripper(replace(robot, mjcf=lambda: "<mujoco/>"), 0.02) is None
    one = robot.mjcf().replace('<joint joint="right_finger" coef="0.5"/>', "")
    assert with_wider_gripper(replace(robot, mjcf=lambda: one), 0.02) is None

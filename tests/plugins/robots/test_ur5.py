"""The UR5 of the paper: published kinematics, a sensor that shifts the gripper, and a program in CB3's words."""

from __future__ import annotations

import math

import mujoco
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Pose, Program, ZeroSensor
from cramlite_plugins.backends.urscript.emit import emit
from cramlite_plugins.robots.dh_arm import forward
from cramlite_plugins.robots.ur5 import DH, LINKS, UR5, mjcf
from cramlite_plugins.robots.ur5e import DH as DH_OF_E_SERIES
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.ur_controller.urscript.parser import parse

MODEL = mujoco.MjModel.from_xml_string(mjcf())
ANGLE = st.floats(-math.pi, math.pi)


def site(q: tuple[float, ...], name: str) -> Pose:
    data = mujoco.MjData(MODEL)
    data.qpos[:6] = q
    mujoco.mj_kinematics(MODEL, data)
    found = data.site(name)
    return Pose(tuple(found.xpos), Pose.from_matrix(found.xmat.reshape(3, 3)).quaternion)


@given(st.tuples(*[ANGLE] * 6))
@examples(60)
def test_the_model_is_the_dh_model(q: tuple[float, ...]) -> None:
    assert site(q, "flange").distance(forward(DH, q)) == pytest.approx((0, 0), abs=1e-4)
    assert site(q, "flange").distance(forward(DH_OF_E_SERIES, q))[0] > 1e-3  # the check tells the two arms apart


def test_the_sensor_shifts_the_gripper_and_weighs() -> None:
    assert site((0,) * 6, "tcp").distance(forward(DH, (0,) * 6) * UR5.gripper.tcp)[0] < 1e-6
    assert UR5.gripper.tcp.position[2] - UR5E.gripper.tcp.position[2] == pytest.approx(0.0254)
    assert MODEL.body_subtreemass[MODEL.body("gripper").id] == pytest.approx(UR5.gripper.mass)
    assert site(UR5.home, "ft").distance(site(UR5.home, "flange"))[0] < 1e-9


def test_home_is_free_and_the_mass_is_published() -> None:
    data = mujoco.MjData(MODEL)
    data.qpos[:6] = UR5.home
    mujoco.mj_forward(MODEL, data)
    assert data.ncon == 0
    data.qpos[:6] = (0, -1.57, 3.0, -1.57, 0, 0)
    mujoco.mj_forward(MODEL, data)
    assert data.ncon > 0
    assert sum(link.mass for link in LINKS) == pytest.approx(18.4 - 1.35, abs=0.1)  # less the base


def test_cb3_text_uses_nothing_of_the_e_series() -> None:
    program = Program("p", "arm", "ur5", UR5.gripper.tcp, UR5.home, (ZeroSensor(),), (), mass=1.2, center=(0, 0, 0.05))
    text = emit(program, UR5).text
    assert parse(text).name == "p"
    assert "axia80" in text
    assert "CB3" in text
    assert text.count("zero_sensor()") == 3  # its definition, the start, the step
    code = "\n".join(line.split("#")[0] for line in text.split("\n"))
    for word in ("zero_ftsensor", "set_target_payload", " force()"):
        assert word not in code
    same = emit(replace(program, robot_type="ur5e"), UR5E).text
    assert "zero_ftsensor()" in same
    assert "CB3" not in same

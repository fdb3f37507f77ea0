"""The UR5e model agrees with its published kinematics, and the gripper with its data sheet."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Pose
from cramlite_plugins.robots.dh_arm import forward
from cramlite_plugins.robots.ur5e import DH, LINKS, UR5E, mjcf

MODEL = mujoco.MjModel.from_xml_string(mjcf())
ANGLE = st.floats(-math.pi, math.pi)


def flange(q: tuple[float, ...]) -> Pose:
    data = mujoco.MjData(MODEL)
    data.qpos[:6] = q
    mujoco.mj_kinematics(MODEL, data)
    site = data.site("flange")
    return Pose(tuple(site.xpos), Pose.from_matrix(site.xmat.reshape(3, 3)).quaternion)


@given(st.tuples(*[ANGLE] * 6))
@examples(60)
def test_the_model_is_the_dh_model_to_a_tenth_of_a_millimetre(q: tuple[float, ...]) -> None:
    distance, angle = flange(q).distance(forward(DH, q))
    assert distance < 1e-4
    assert angle < 1e-4


def test_the_same_check_sees_the_rounded_public_model() -> None:
    """The popular MJCF has d4 = .134: the test above must be able to see that."""
    rounded = (*DH[:3], (0.0, 0.134, DH[3][2]), *DH[4:])
    q = (0.3, -1.0, 1.2, -0.4, 1.0, 0.2)
    assert flange(q).distance(forward(rounded, q))[0] > 1e-4


def test_reach_and_mass_are_the_published_ones() -> None:
    stretched = forward(DH, (0, 0, 0, 0, 0, 0)).position
    assert math.hypot(*stretched[:2]) == pytest.approx(0.85, abs=0.02)
    assert sum(link.mass for link in LINKS) == pytest.approx(17.7, abs=0.1)
    gripper = MODEL.body("gripper").id
    assert MODEL.body_subtreemass[gripper] == pytest.approx(UR5E.gripper.mass, abs=1e-6)


def test_names_are_those_of_the_robot_contract() -> None:
    for name in UR5E.joints:
        assert MODEL.joint(name).id >= 0
        assert MODEL.actuator(name).id >= 0
    assert {MODEL.site(n).name for n in ("flange", "tcp", "ft")} == {"flange", "tcp", "ft"}
    assert {MODEL.sensor(n).name for n in ("ft_force", "ft_torque")} == {"ft_force", "ft_torque"}
    with pytest.raises(KeyError):
        MODEL.actuator("griper")


def test_the_tool_frame_of_the_model_is_that_of_the_description() -> None:
    data = mujoco.MjData(MODEL)
    mujoco.mj_kinematics(MODEL, data)
    tool = Pose(tuple(data.site("tcp").xpos), Pose.from_matrix(data.site("tcp").xmat.reshape(3, 3)).quaternion)
    assert tool.distance(flange((0,) * 6) * UR5E.gripper.tcp)[0] < 1e-6
    left, right = data.geom("left_pad1").xpos, data.geom("right_pad1").xpos
    closing = (left - right) / np.linalg.norm(left - right)
    assert closing == pytest.approx(tool.rotate((0, 1, 0)), abs=1e-6)


def test_no_capsule_may_meet_a_plate() -> None:
    assert mujoco.mjtGeom.mjGEOM_CAPSULE not in set(MODEL.geom_type)


def test_home_is_within_the_limits_and_free() -> None:
    data = mujoco.MjData(MODEL)
    data.qpos[:6] = UR5E.home
    mujoco.mj_forward(MODEL, data)
    assert all(lo < q < hi for q, (lo, hi) in zip(UR5E.home, UR5E.limits, strict=True))
    assert data.ncon == 0
    folded = replace(UR5E, home=(0, -1.57, 3.0, -1.57, 0, 0))
    data.qpos[:6] = folded.home
    mujoco.mj_forward(MODEL, data)
    assert data.ncon > 0

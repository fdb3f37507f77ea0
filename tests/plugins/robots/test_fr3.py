"""The seven-axis arm agrees with its published kinematics, and its hand with what is published of it."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Pose
from cramlite_plugins.robots.dh_arm import forward
from cramlite_plugins.robots.fr3 import DH, FR3, FR3_2F85, LINKS, MODIFIED, mjcf, standard

MODEL = mujoco.MjModel.from_xml_string(mjcf())
JOINTS = st.tuples(*[st.floats(low, high) for low, high in FR3.limits])


def posed(q: tuple[float, ...]) -> mujoco.MjData:
    data = mujoco.MjData(MODEL)
    data.qpos[: len(q)] = q
    mujoco.mj_forward(MODEL, data)
    return data


def site(data: mujoco.MjData, name: str) -> Pose:
    found = data.site(name)
    return Pose(tuple(found.xpos), Pose.from_matrix(found.xmat.reshape(3, 3)).quaternion)


def published(q: tuple[float, ...], table: tuple[tuple[float, float, float], ...] = MODIFIED) -> Pose:
    """Craig's product of the rows as they are printed, flange included."""
    pose = Pose()
    for (a, d, alpha), angle in zip(table, (*q, 0.0), strict=True):
        pose = pose * Pose((0, 0, 0), (math.cos(alpha / 2), math.sin(alpha / 2), 0, 0)) * Pose((a, 0, 0))
        pose = pose * Pose((0, 0, d), (math.cos(angle / 2), 0, 0, math.sin(angle / 2)))
    return pose


@given(JOINTS)
@examples(30)
def test_model_and_table_are_the_published_product(q: tuple[float, ...]) -> None:
    assert site(posed(q), "flange").distance(published(q)) == pytest.approx((0, 0), abs=1e-6)
    assert forward(DH, q).distance(published(q)) == pytest.approx((0, 0), abs=1e-6)
    longer = (*MODIFIED[:2], (0.0, 0.3165, math.pi / 2), *MODIFIED[3:])
    assert site(posed(q), "flange").distance(published(q, longer))[0] > 1e-4


def test_a_table_that_no_standard_one_can_say_is_refused() -> None:
    with pytest.raises(ValueError, match="a = alpha = 0"):
        standard(((0.1, 0.333, 0.0), *MODIFIED[1:]))


def test_the_ready_posture_is_the_manufacturers_and_free() -> None:
    data = posed(FR3.home)
    assert data.ncon == 0
    # 306.9 mm ahead and 590.3 mm up is the flange of the ready posture; the hand looks down with its fingers along y
    assert site(data, "flange").position == pytest.approx((0.3069, 0.0, 0.5903), abs=1e-4)
    tool = site(data, "tcp")
    assert tool.rotate((0, 0, 1)) == pytest.approx((0, 0, -1), abs=1e-6)
    assert tool.rotate((0, 1, 0)) == pytest.approx((0, -1, 0), abs=1e-6)
    assert tool.distance(forward(DH, FR3.home) * FR3.gripper.tcp) == pytest.approx((0, 0), abs=1e-6)
    assert posed((0.0, 1.7, 0.0, -3.0, 0.0, 0.6, 0.0)).ncon > 0  # the hand meets the arm


def test_hand_and_masses_are_published() -> None:
    data = posed(FR3.home)
    left, right = (data.geom(f"{side}_pad1").xpos for side in ("left", "right"))
    thickness = 2 * MODEL.geom("left_pad1").size[1]
    assert np.linalg.norm(left - right) - thickness == pytest.approx(0.080)
    closing = (left - right) / np.linalg.norm(left - right)
    assert closing == pytest.approx(site(data, "tcp").rotate((0, 1, 0)), abs=1e-6)
    assert MODEL.body_subtreemass[MODEL.body("gripper").id] == pytest.approx(FR3.gripper.mass)
    assert sum(link.mass for link in LINKS) == pytest.approx(17.9 - 2.4, abs=0.1)  # 17.9 kg in all, less the base
    assert MODEL.actuator("gripper").forcerange[1] == pytest.approx(2 * 70.0)


def test_the_sensor_reads_in_the_axes_of_the_flange() -> None:
    data = posed(FR3.home)
    assert site(data, "ft").distance(site(data, "flange")) == pytest.approx((0, 0), abs=1e-6)
    assert site(data, "tcp").distance(site(data, "flange"))[1] == pytest.approx(math.pi / 4, abs=1e-6)


def test_with_a_2f85_the_tool_looks_the_same_way() -> None:
    other = mujoco.MjModel.from_xml_string(FR3_2F85.mjcf())
    data = mujoco.MjData(other)
    data.qpos[:7] = FR3_2F85.home
    mujoco.mj_forward(other, data)
    tool = site(data, "tcp")
    assert data.ncon == 0
    assert tool.distance(site(posed(FR3.home), "tcp"))[1] == pytest.approx(0.0, abs=1e-6)
    assert tool.distance(forward(DH, FR3_2F85.home) * FR3_2F85.gripper.tcp) == pytest.approx((0, 0), abs=1e-6)
    assert other.body_subtreemass[other.body("gripper").id] == pytest.approx(FR3_2F85.gripper.mass)


def test_no_capsule_may_meet_a_plate() -> None:
    assert mujoco.mjtGeom.mjGEOM_CAPSULE not in set(MODEL.geom_type)

"""The arms of Universal Robots agree with their published kinematics and masses, and write programs in their controller's words."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Program, ZeroSensor
from cramlite_plugins.backends.urscript.emit import emit
from cramlite_plugins.kinematics.forward import flange
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.robots.universal_robots import UrArm, mjcf, robot
from cramlite_plugins.robots.ur_arms import ARMS, CB3

WEIGHTS = {"ur3": 11.0, "ur3e": 11.2, "ur10": 28.9, "ur10e": 33.5, "ur16e": 33.1, "ur20": 64.0, "ur30": 63.5}
"""Of the whole arms, base and cable of the arm included [kg]: data sheets."""
each = pytest.mark.parametrize("arm", ARMS, ids=lambda a: a.type)


def urdf_flange(arm: UrArm, q: Floats) -> Pose:
    """The flange by the joint origins (xyz, rpy) of the maker's default_kinematics.yaml: a chain without Denavit-Hartenberg rows."""
    d1, a2, a3, d4, d5, d6 = arm.lengths
    right = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # a quarter turn about x
    back = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)  # roll 90, pitch 180, yaw 180 deg
    origins = (
        Pose((0, 0, d1)), Pose((0, 0, 0), right), Pose((a2, 0, 0)), Pose((a3, 0, d4)), Pose((0, -d5, 0), right),
        Pose((0, d6, 0), back),
    )  # fmt: skip
    pose = Pose()
    for origin, angle in zip(origins, q, strict=True):
        pose = pose * origin * Pose((0, 0, 0), (math.cos(angle / 2), 0, 0, math.sin(angle / 2)))
    return pose


def modelled(model: mujoco.MjModel, q: Floats, name: str) -> Pose:
    data = mujoco.MjData(model)
    data.qpos[:6] = q
    mujoco.mj_kinematics(model, data)
    site = data.site(name)
    return Pose(tuple(site.xpos), Pose.from_matrix(site.xmat.reshape(3, 3)).quaternion)


@each
def test_model_and_table_are_the_makers_chain(arm: UrArm) -> None:
    model, declared = mujoco.MjModel.from_xml_string(mjcf(arm)), robot(arm)
    longer = replace(arm, lengths=(*arm.lengths[:3], arm.lengths[3] + 1e-3, *arm.lengths[4:]))
    for q in np.random.default_rng(0).uniform(-math.pi, math.pi, (30, 6)):
        assert modelled(model, q, "flange").distance(urdf_flange(arm, q)) == pytest.approx((0, 0), abs=1e-6)
        assert flange(declared, tuple(q)).distance(urdf_flange(arm, q)) == pytest.approx((0, 0), abs=1e-6)
        assert flange(declared, tuple(q)).distance(urdf_flange(longer, q))[0] == pytest.approx(1e-3), "the check sees 1 mm"


@each
def test_inverse_kinematics_find_the_posture_again(arm: UrArm) -> None:
    declared = robot(arm)
    for q in np.random.default_rng(1).uniform(-2.5, 2.5, (10, 6)):
        target = flange(declared, tuple(q)) * declared.gripper.tcp
        assert np.abs(np.array(inverse(declared, target, seed=tuple(q))[0]) - q).max() < 1e-5
    assert not inverse(declared, Pose((arm.reach + 0.6, 0.0, 0.3)))


@each
def test_home_is_free_and_folding_is_seen(arm: UrArm) -> None:
    model = mujoco.MjModel.from_xml_string(mjcf(arm))
    data = mujoco.MjData(model)
    data.qpos[:6] = arm.home
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    assert data.site("tcp").xmat.reshape(3, 3)[:, 2] == pytest.approx((0, 0, -1), abs=1e-3)
    data.qpos[:6] = (0, -1.57, 3.0, -1.57, 0, 0)
    mujoco.mj_forward(model, data)
    assert data.ncon > 0


@each
def test_masses_are_physical_and_published(arm: UrArm) -> None:
    assert 0.75 * WEIGHTS[arm.type] < sum(arm.masses) < WEIGHTS[arm.type], "less the base"
    for xx, yy, zz, xy, xz, yz in arm.inertia:
        principal = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert principal[0] > 0
        assert principal[2] < principal[0] + principal[1], "no body has such an inertia"
    _, a2, a3, _, d5, _ = arm.lengths
    assert abs(a2 + a3) < arm.reach < abs(a2 + a3) + d5 + 1e-3, "data sheets count to some point of the wrist"


@each
def test_programs_are_in_the_words_of_the_controller(arm: UrArm) -> None:
    declared = robot(arm)
    program = Program("p", "arm", arm.type, declared.gripper.tcp, declared.home, (ZeroSensor(),), ())
    text = emit(program, declared).text
    assert ("zero_ftsensor()" in text) == (arm.controller != CB3)
    assert ("axia80" in text) == (arm.controller == CB3)

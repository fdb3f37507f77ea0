"""Forward against the MJCF model, Jacobian against differences, inverse against forward."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from helpers.scenes import down, make
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Pose
from cramlite_plugins.kinematics import forward as f
from cramlite_plugins.kinematics import inverse as k
from cramlite_plugins.kinematics import reach as r
from cramlite_plugins.robots.ur5e import UR5E

joints = st.tuples(*[st.floats(-3.1, 3.1)] * 6)


@given(joints)
@examples(50)
def test_forward_agrees_with_the_mjcf_model(q: f.Joints) -> None:
    metres, radians = make().tcp(q).distance(f.forward(UR5E, q))
    assert metres < 1e-6
    assert radians < 1e-6


def test_a_wrong_table_does_not_agree() -> None:
    rows = list(UR5E.dh or ())
    wrong = replace(UR5E, dh=(*rows[:1], (-0.4251, 0.0, 0.0), *rows[2:]))
    assert make().tcp(UR5E.home).distance(f.forward(wrong, UR5E.home))[0] > 5e-5


@given(joints)
@examples(50)
def test_jacobian_is_the_derivative(q: f.Joints) -> None:
    here, step = f.forward(UR5E, q), 1e-6
    for i, column in enumerate(f.jacobian(UR5E, q).T):
        moved = f.forward(UR5E, [v + step * (j == i) for j, v in enumerate(q)])
        assert f.twist(here.matrix, moved.matrix) / step == pytest.approx(column, abs=1e-4)


@given(joints)
def test_inverse_finds_every_pose_that_forward_makes(q: f.Joints) -> None:
    pose = f.forward(UR5E, q)
    found = k.inverse(UR5E, pose, seed=q)
    assert found or f.smallest_singular_value(UR5E, q) < 0.02
    for solution in found[:16]:
        assert max(f.forward(UR5E, solution).distance(pose)) < 2e-6
    assert all(low <= v <= high for s in found for v, (low, high) in zip(s, UR5E.limits, strict=True))


@given(joints)
def test_the_branch_it_came_from_is_first_away_from_singularities(q: f.Joints) -> None:
    if f.smallest_singular_value(UR5E, q) > 0.05:
        assert k.inverse(UR5E, f.forward(UR5E, q), seed=q)[0] == pytest.approx(q, abs=1e-4)


def test_all_turns_inside_the_limits_and_no_other() -> None:
    found = k.inverse(UR5E, down(0.5, 0.2, 0.2))
    assert len(found) == 8 * 2**5  # eight branches; five joints reach two turns, the elbow one
    assert len(set(found)) == len(found)
    narrow = replace(UR5E, limits=((-math.pi, math.pi),) * 6)
    assert len(k.inverse(narrow, down(0.5, 0.2, 0.2))) == 8
    assert list(found) == sorted(found, key=lambda q: max(abs(a - b) for a, b in zip(q, UR5E.home, strict=True)))


def test_out_of_reach_has_no_solution_and_a_reason_with_numbers() -> None:
    assert k.inverse(UR5E, down(1.3, 0.0, 0.2)) == ()
    assert "m > 0.9" in r.reach_shortfall(UR5E, down(1.3, 0.0, 0.2))
    assert k.inverse(UR5E, down(0.05, 0.0, 0.3)) == ()
    assert "m < 0.133 m from the base axis" in r.reach_shortfall(UR5E, down(0.05, 0.0, 0.3))
    assert r.reach_shortfall(UR5E, down(0.5, 0.2, 0.2)) == ""


def test_a_robot_without_a_table_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="'ur5e' has no Denavit-Hartenberg table"):
        k.inverse(replace(UR5E, dh=None), Pose())


def test_limits_are_named() -> None:
    assert "'elbow' at 3.500 rad is outside -3.142 .. 3.142" in r.out_of_limits(UR5E, (0, 0, 3.5, 0, 0, 0))
    assert r.out_of_limits(UR5E, UR5E.home) == ""


def test_mujoco_is_the_version_that_the_margins_were_measured_with() -> None:
    assert mujoco.__version__.split(".")[0] == "4"
    assert np.isfinite(f.smallest_singular_value(UR5E, UR5E.home))


def test_what_differs_by_whole_turns_is_one_posture() -> None:
    found = k.inverse(UR5E, f.forward(UR5E, UR5E.home))
    first = k.postures(found)
    assert len(first) <= 8 < len(found)
    assert next(iter(first.values())) == found[0]
    for posture, q in first.items():
        assert f.forward(UR5E, posture).distance(f.forward(UR5E, q)) == pytest.approx((0.0, 0.0), abs=1e-9)

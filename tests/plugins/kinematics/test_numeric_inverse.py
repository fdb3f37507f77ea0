"""Inverse kinematics of a seven-axis arm: exact, inside the limits, redundant, repeatable, and honest about reach."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import Pose
from cramlite.plugin import Refused
from cramlite_plugins.kinematics import forward as f
from cramlite_plugins.kinematics import inverse as k
from cramlite_plugins.kinematics import numeric_inverse
from cramlite_plugins.kinematics import reach as r
from cramlite_plugins.motion_planning.cartesian import JointPath, plan_straight_line
from cramlite_plugins.robots.dh_arm import arm_mjcf
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.robotiq_2f85 import gripper_mjcf
from cramlite_plugins.robots.ur5e import BASE, JOINTS, LIMITS, LINKS, UR5E

FORWARD = Pose.from_axes((0.6, 0.1, 0.4), (1, 0, 0), (0, 0, -1))


def positions(count: int) -> list[f.Joints]:
    low, high = np.array(FR3.limits).T
    return [tuple(map(float, q)) for q in np.random.default_rng(3).uniform(low, high, (count, 7))]


def test_every_pose_is_found_again_exactly() -> None:
    for q in positions(12):
        pose = f.forward(FR3, q)
        found = k.inverse(FR3, pose, seed=q)
        assert found, q
        assert found[0] == pytest.approx(q, abs=1e-4)
        assert all(max(f.forward(FR3, s).distance(pose)) < 2e-6 for s in found)
        assert all(numeric_inverse.inside(FR3, s) for s in found)


def test_the_redundant_joint_is_swept() -> None:
    found = k.inverse(FR3, FORWARD)
    assert len(found) >= 8
    last = sorted({round(q[-1], 3) for q in found})
    assert last[-1] - last[0] > 1.0
    assert list(found) == sorted(found, key=lambda q: max(abs(a - b) for a, b in zip(q, FR3.home, strict=True)))


def test_what_is_found_numerically_is_found_in_closed_form_too() -> None:
    """Where the last joint is at a value of the grid."""
    values, count = numeric_inverse.grid(FR3.limits[-1], k.STEPS[0]), 0
    for q in positions(6):
        pose = f.forward(FR3, q)
        exact = partial(k.refine, FR3, pose)
        swept = numeric_inverse.solutions(FR3, pose * FR3.gripper.tcp.inverse(), lambda near, held, exact=exact: exact(near, 8, held))
        on_grid = [s for s in swept if min(abs(s[-1] - v) for v in values) < 1e-9]
        found, count = k.inverse(FR3, pose), count + len(on_grid)
        assert all(min(math.dist(s, other) for other in found) < 1e-4 for s in on_grid)
    assert count > 10


def test_between_the_values_of_the_coarse_grid_the_fine_one_finds_a_solution() -> None:
    q = next(q for q in positions(200) if not list(k._locked(FR3, f.forward(FR3, q), numeric_inverse.grid(FR3.limits[-1], k.STEPS[0]))))
    assert k._many(FR3, f.forward(FR3, q))


def test_the_same_pose_has_the_same_solutions_from_scratch() -> None:
    first = k.inverse(FR3, FORWARD)
    k._many.cache_clear()
    numeric_inverse._solver.cache_clear()
    assert k.inverse(FR3, FORWARD) == first


def test_out_of_reach_has_no_solution_and_a_reason_with_numbers() -> None:
    far = Pose.from_axes((1.3, 0.0, 0.4), (1, 0, 0), (0, 0, -1))
    assert k.inverse(FR3, far) == ()
    assert "m > 0.807 m from the shoulder of 'fr3'" in r.reach_shortfall(FR3, far)
    assert r.reach_shortfall(FR3, FORWARD) == ""


def test_no_position_is_beyond_the_span() -> None:
    shoulder = np.array((0.0, 0.0, 0.333))
    for q in positions(300):
        root = f.flange(FR3, q).apply((0.0, 0.0, -0.107))
        assert math.dist(root, shoulder) <= numeric_inverse.span(FR3) + 1e-6


def test_a_straight_line_is_followed_and_one_out_of_reach_is_not() -> None:
    start = k.inverse(FR3, FORWARD)[0]
    ahead = FORWARD * Pose((0.0, 0.0, 0.1))
    path = plan_straight_line(None, FR3, start, ahead)
    assert isinstance(path, JointPath)
    assert f.forward(FR3, path.points[-1]).distance(ahead)[0] < 1e-6
    beyond = plan_straight_line(None, FR3, start, FORWARD * Pose((0.0, 0.0, 0.6)))
    assert isinstance(beyond, Refused)
    assert "stops after" in beyond.reason


def test_six_joints_without_a_closed_form_are_solved_too() -> None:
    rows = [list(row) for row in UR5E.dh or ()]
    rows[2][2], rows[3][0], rows[4][0] = 0.3, 0.03, 0.06  # joints 2 to 4 are not parallel, and the last three do not meet
    dh = tuple((a, d, alpha) for a, d, alpha in rows)
    text = arm_mjcf("odd", dh, LINKS, JOINTS, LIMITS, BASE, gripper_mjcf(LINKS[-1].name))
    odd = replace(UR5E, type="odd", dh=dh, mjcf=lambda: text)
    assert not k.has_closed_form(odd)
    assert k.has_closed_form(UR5E)
    rng = np.random.default_rng(1)
    for _ in range(5):
        q = tuple(float(v) for v in rng.uniform(-2.5, 2.5, 6))
        pose = f.forward(odd, q)
        found = k.inverse(odd, pose)
        assert found, q
        assert all(max(f.forward(odd, s).distance(pose)) < 2e-6 for s in found)
        assert k.inverse(odd, pose, seed=q)[0] == pytest.approx(q, abs=1e-4)
        assert r.reach_shortfall(odd, pose) == ""
    assert k.inverse(odd, Pose((1.5, 0.0, 0.4))) == ()

"""Arms whose controller leads the tool: the one posture that they take at a pose, and how near a singularity that may be."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import Floats, Pose
from cramlite_plugins.kinematics import forward as f
from cramlite_plugins.kinematics import inverse as k
from cramlite_plugins.kinematics.arm_inertia import inertia
from cramlite_plugins.robots.fr3 import FR3

LED = replace(FR3, type="led_fr3", posture=FR3.home)
DOWN = f.forward(FR3, FR3.home).quaternion
ASIDE = Pose((0.45, 0.3, 0.2), DOWN)
FAR = f.forward(FR3, (0.0, 1.1, 0.0, -0.7, 0.0, 1.9, 0.785))
"""With the arm nearly stretched: its elbow is straight at -0.467 rad."""


def led_by(weight: bool, motors: tuple[float, ...] = (0.1,) * 7) -> Floats:
    """Where an operational space controller leads a resting FR3 that holds its home in the null space, weighted by inertia or not."""
    q, more = np.array(FR3.home), np.diag(motors) - 0.1 * np.eye(7)
    for _ in range(2000):
        j, m = f.jacobian(FR3, q), inertia(FR3, q) + more if weight else np.eye(7)
        back = np.linalg.solve(m, j.T) @ np.linalg.inv(j @ np.linalg.solve(m, j.T))
        error = f.twist(f.forward(FR3, q).matrix, ASIDE.matrix)
        q = q + 0.02 * (back @ error + (np.eye(7) - back @ j) @ (FR3.home - q))
    return q


def test_an_arm_that_is_led_has_the_one_posture_that_its_controller_takes() -> None:
    (found,) = k.inverse(LED, ASIDE)
    assert max(f.forward(FR3, found).distance(ASIDE)) < 1e-6
    assert found == pytest.approx(led_by(True), abs=0.003)
    assert k.inverse(LED, ASIDE, seed=(*FR3.home[:6], 2.0)) == (found,)  # wherever it was before


def test_what_leaves_inertia_out_takes_another_posture_and_an_arm_whose_joints_are_commanded_has_many() -> None:
    (found,) = k.inverse(LED, ASIDE)
    assert np.abs(led_by(False) - found).max() > 0.03
    assert len(k.inverse(FR3, ASIDE)) > 5


def test_the_inertia_of_motors_counts_in_the_posture() -> None:
    heavy = tuple(5.0 / n for n in range(1, 8))
    (found,), (light,) = k.inverse(replace(LED, rotors=heavy), ASIDE), k.inverse(LED, ASIDE)
    assert found == pytest.approx(led_by(True, heavy), abs=0.003)
    assert np.abs(np.subtract(light, found)).max() > 0.02


@pytest.mark.parametrize("rotors", [(1.0,), (1.0,) * 6 + (-0.1,), (1.0,) * 6 + (float("nan"),)])
def test_an_inertia_that_makes_no_sense_is_refused(rotors: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="rotors"):
        replace(FR3, rotors=rotors)


def test_a_pose_that_takes_a_joint_out_of_its_range_is_refused_with_its_name() -> None:
    tight = replace(LED, limits=(*FR3.limits[:3], (-2.0, -0.15), *FR3.limits[4:]))
    assert k.inverse(LED, FAR) and k.inverse(LED, ASIDE) and not k.inverse(tight, ASIDE)
    assert "joint4" in k.why_no_inverse(tight, ASIDE) and "-2.000" in k.why_no_inverse(tight, ASIDE)


@pytest.mark.parametrize("robot", [LED, FR3])
def test_a_stretched_arm_is_refused_where_a_distance_from_singularities_is_kept(robot: k.Robot) -> None:
    careful = replace(robot, conditioning=0.08)
    assert k.inverse(robot, FAR) and not k.inverse(careful, FAR)
    assert "near a singularity" in k.why_no_inverse(careful, FAR) and "limit 0.08" in k.why_no_inverse(careful, FAR)
    assert k.inverse(careful, ASIDE)


@pytest.mark.parametrize("value", [-0.1, 1.0])
def test_a_distance_that_makes_no_sense_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="conditioning"):
        replace(FR3, conditioning=value)

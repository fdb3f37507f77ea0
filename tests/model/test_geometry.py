"""Poses form a group, and every way to write one leads back to it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Pose, seen_from

number = st.floats(-10, 10, allow_nan=False, width=32)
vector = st.tuples(number, number, number)
quaternion = st.tuples(number, number, number, number).filter(lambda q: math.hypot(*q) > 1e-3)
pose = st.builds(Pose, vector, quaternion)
turn = st.tuples(*[st.floats(-1.75, 1.75, width=32)] * 3).filter(lambda v: math.hypot(*v) < 3.1)


def _same(a: Pose, b: Pose) -> bool:
    metres, radians = a.distance(b)
    return metres < 1e-6 and radians < 1e-6


@given(pose)
def test_the_inverse_undoes(a: Pose) -> None:
    assert _same(a * a.inverse(), Pose())
    assert _same(a.inverse() * a, Pose())


@given(pose, pose, pose)
def test_composition_is_associative(a: Pose, b: Pose, c: Pose) -> None:
    assert _same((a * b) * c, a * (b * c))


@given(pose, pose, vector)
def test_composition_is_application(a: Pose, b: Pose, point: tuple[float, float, float]) -> None:
    assert np.allclose((a * b).apply(point), a.apply(b.apply(point)), atol=1e-6)
    assert np.allclose((a * b).matrix, a.matrix @ b.matrix, atol=1e-6)


@given(pose)
def test_matrix_and_rotation_vector_lead_back(a: Pose) -> None:
    assert _same(Pose.from_matrix(a.matrix), a)
    assert _same(Pose.from_rotvec(a.position, a.rotvec), a)


@given(vector, turn)
def test_a_rotation_vector_is_kept(position: tuple[float, float, float], v: tuple[float, float, float]) -> None:
    assert np.allclose(Pose.from_rotvec(position, v).rotvec, v, atol=1e-6)


@given(pose)
def test_rotations_are_rotations(a: Pose) -> None:
    assert np.allclose(a.rotation @ a.rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(a.rotation) == pytest.approx(1)


@given(vector, st.floats(-3, 3))
def test_distance_is_the_angle(position: tuple[float, float, float], angle: float) -> None:
    metres, radians = Pose(position).distance(Pose.from_rotvec(position, (0, 0, angle)))
    assert metres == 0
    assert radians == pytest.approx(abs(angle), abs=1e-6)


@given(pose, pose)
def test_points_are_seen_from_frames(a: Pose, b: Pose) -> None:
    frames = np.array([(*p.position, *p.quaternion) for p in (a, b)])
    points = np.array([b.position, a.position])
    assert seen_from(frames, points) == pytest.approx(np.array([(a.inverse() * b).position, (b.inverse() * a).position]), abs=1e-9)


def test_axes() -> None:
    a = Pose.from_axes((1, 2, 3), z=(0, 0, -2), x=(1, 0, 5))
    assert np.allclose(a.rotate((0, 0, 1)), (0, 0, -1))
    assert np.allclose(a.rotate((1, 0, 0)), (1, 0, 0))


@pytest.mark.parametrize(
    ("position", "quaternion"),
    [((0, 0, math.nan), (1, 0, 0, 0)), ((0, 0, math.inf), (1, 0, 0, 0)), ((0, 0, 0), (0, 0, 0, 0)), ((0, 0), (1, 0, 0, 0))],
)
def test_what_is_no_pose(position: tuple[float, ...], quaternion: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="not a pose"):
        Pose(position, quaternion)  # type: ignore[arg-type]

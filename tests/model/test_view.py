"""Views: back-projection, the round trip through the intrinsics, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Intrinsics, Pose, View
from cramlite.plugin import UserError

SMALL = Intrinsics(50.0, 52.0, 31.5, 23.5, 64, 48)


def _view(depth: float = 1.0, camera: Pose | None = None) -> View:
    return View(np.zeros((48, 64, 3), np.uint8), np.full((48, 64), depth, np.float32), SMALL, camera or Pose())


@given(st.integers(0, 63), st.integers(0, 47), st.floats(0.1, 5.0))
def test_a_point_is_seen_where_it_was_back_projected_from(u: int, v: int, depth: float) -> None:
    point = SMALL.rays[v, u] * depth
    assert np.allclose(SMALL.project(point), (u, v), atol=1e-9)


def test_a_point_behind_the_camera_is_not_seen() -> None:
    assert np.isnan(SMALL.project(np.array([0.0, 0.0, -1.0]))).all()


def test_the_cloud_is_where_the_camera_looks() -> None:
    camera = Pose.from_axes((1, 0, 0), (-1, 0, 0), (0, 1, 0))  # looks along -x
    points = camera.apply(_view(0.5, camera).points())
    assert np.allclose(points[:, 0], 0.5) and len(points) == 64 * 48


def test_what_was_not_measured_is_no_point() -> None:
    depth = np.ones((48, 64), np.float32)
    depth[0, :4] = (0.0, -1.0, np.inf, np.nan)
    view = View(np.zeros((48, 64, 3), np.uint8), depth, SMALL)
    assert np.isnan(view.depth[0, :4]).all() and len(view.points()) == 64 * 48 - 4
    mask = np.zeros((48, 64), bool)
    mask[0, :5] = True
    assert len(view.points(mask)) == 1


def test_views_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        _view().depth[0, 0] = 2.0


def test_sizes_that_do_not_fit_are_refused() -> None:
    with pytest.raises(UserError, match="64 x 48"):
        View(np.zeros((48, 64, 3), np.uint8), np.zeros((24, 32), np.float32), SMALL)
    with pytest.raises(UserError, match="colour"):
        View(np.zeros((48, 64), np.uint8), np.zeros((48, 64), np.float32), SMALL)
    with pytest.raises(UserError, match="uint8"):
        View(np.zeros((48, 64, 3)), np.zeros((48, 64), np.float32), SMALL)
    with pytest.raises(UserError, match="mask"):
        _view().points(np.zeros((2, 2), bool))


@pytest.mark.parametrize("numbers", [(0, 50, 32, 24), (50, -1, 32, 24), (50, 50, np.nan, 24), (50, 50, 900, 24)])
def test_intrinsics_of_no_camera_are_refused(numbers: tuple[float, ...]) -> None:
    with pytest.raises(UserError):
        Intrinsics(*numbers, 64, 48)  # type: ignore[arg-type]

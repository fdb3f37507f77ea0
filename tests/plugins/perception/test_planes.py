"""Background by planes: what lies on a large one, and a face that stands on a table, which is none."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite_plugins.perception.segmentation.planes import on_planes
from cramlite_plugins.perception.values import Cloud, Plane

COLUMNS = np.linspace(-1.0, 1.0, 201)
"""y of the columns of a picture [m]."""
TABLE, FACE = Plane(np.array([0.0, 0.0, 1.0]), 0.0, 0.6, 2.0), Plane(np.array([-1.0, 0.0, 0.0]), -1.0, 0.2, 2.0)
"""z = 0, and x = 1 m, with the table's points that are near it."""


def pictured(wide: float) -> Cloud:
    """A table, and a face of a width [m] and 0.2 m height that stands on it at x = 1 m, 10 mm between rows."""
    points = np.zeros((60, len(COLUMNS), 3), np.float32)
    points[..., 1] = COLUMNS
    points[..., 0] = np.linspace(1.19, 0.6, 60)[:, None]
    covered = np.abs(COLUMNS) <= wide / 2
    points[:20, covered, 0], points[:20, covered, 2] = 1.0, np.linspace(0.2, 0.01, 20)[:, None]
    return Cloud(points, np.ones(points.shape[:2], bool))


@pytest.mark.parametrize(("wide", "wall"), [(0.44, False), (0.6, True)])
def test_a_face_on_a_table_is_a_wall_if_it_is_long_itself(wide: float, wall: bool) -> None:
    """The table goes on beside it, and its points at the foot of the face are near both planes."""
    cloud = pictured(wide)
    mask = on_planes(cloud, (TABLE, FACE), 0.01, 0.5)
    face = cloud.points[..., 2] > 0.03
    assert mask[face].all() if wall else not mask[face].any()
    assert mask[cloud.points[..., 2] == 0.0].all()

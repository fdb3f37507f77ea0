"""Whether what a hand lets go of over a container falls out of it, by how the hand is turned."""

from __future__ import annotations

import math
from typing import Any

import pytest

from cramlite.model import Pose
from cramlite_plugins.locations.placing.checks.shapes import falls
from cramlite_plugins.locations.placing.query import Placement

ANY: Any = None  # it is about the hand alone


def turned(x: float, y: float) -> Placement:
    """A hand that is turned about its closing direction and then about its third axis from pointing down [deg]."""
    pose = Pose.from_rotvec((0, 0, 0), (math.pi, 0, 0)) * Pose.from_rotvec((0, 0, 0), (math.radians(x), 0, 0))
    pose = pose * Pose.from_rotvec((0, 0, 0), (0, math.radians(y), 0))
    return Placement("spot", Pose(), pose, pose, 0.1)


@pytest.mark.parametrize(("x", "y"), [(0, 0), (40, 0), (0, 90), (0, 130)])
def test_it_falls_from_fingers_that_open_sideways(x: float, y: float) -> None:
    assert falls(turned(x, y), ANY) == ""


@pytest.mark.parametrize(("x", "y", "where"), [(50, 0, "lower finger"), (90, 0, "lower finger"), (0, 140, "palm"), (0, 180, "palm")])
def test_it_stays_on_what_is_below_it(x: float, y: float, where: str) -> None:
    assert where in falls(turned(x, y), ANY)

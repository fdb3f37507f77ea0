"""Speed of the tool on joint-space lines, and the largest joint speed with which it stays below a
controller's limit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from cramlite.model import TOOL_SPEED, Robot

from .forward import forward
from .timing import leading

CHORD = 0.05
"""Turn of the leading axis between two positions at which the tool's speed is computed [rad]."""
KEPT = 0.9
"""Share of the limit that motions are planned with: the tool was measured at most 3 % faster than this
bound says, over 66 programs, and 5 % with an arm at 2.5 times the usual pace."""
DIGIT = 1e-3
"""Step to which lowered speeds of a leading axis are rounded down [rad/s]."""


def tool_way(robot: Robot, path: Sequence[Sequence[float]]) -> float:
    """Return the largest motion of the tool per radian of the leading (farthest moving) joint, on lines
    between joint positions [m/rad].

    Corners that are rounded are no faster: their joint speeds are between those of both lines.
    """
    most = 0.0
    for a, b in pairwise(path):
        count = max(1, math.ceil(leading(a, b) / CHORD))
        points = np.linspace(a, b, count + 1)
        tips = np.array([forward(robot, q).position for q in points])
        way = np.linalg.norm(np.diff(tips, axis=0), axis=1).max()
        most = max(most, float(way) * count / leading(a, b)) if leading(a, b) > 0 else most
    return most


def passable_speed(robot: Robot, path: Sequence[Sequence[float]], speed: float, acceleration: float) -> float:
    """Return the wanted speed of the leading (farthest moving) joint, or a lower one that keeps the tool
    within its limit [rad/s].

    Args:
        path: joint positions, the start included [rad].
        speed, acceleration: that are wanted [rad/s, rad/s2]; a short way from rest to rest is too short for
            more than sqrt(a D).
    """
    way = tool_way(robot, path)
    top = min(speed, math.sqrt(acceleration * sum(leading(a, b) for a, b in pairwise(path))))
    return speed if top * way <= KEPT * TOOL_SPEED else math.floor(KEPT * TOOL_SPEED / way / DIGIT) * DIGIT

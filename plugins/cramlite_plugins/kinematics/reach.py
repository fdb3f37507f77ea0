"""Reach of arms: by how much a pose is too far or too near, and joints outside their limits."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cramlite.model import Pose, Robot

from . import numeric_inverse
from .forward import Table, from_root, table


def reach_shortfall(robot: Robot, target: Pose) -> str:
    """Explain in words and numbers why a pose is out of reach; "" if the wrist centre is within reach."""
    return reach_gap(robot, target)[1]


def reach_gap(robot: Robot, target: Pose) -> tuple[float, str]:
    """Return by how much a pose is out of reach [m], negative if it is too near, with an explanation in
    numbers.

    It is (0, "") for a pose within reach.

    For a six-axis arm whose joints 2 to 4 are parallel, the wrist centre (the origin of frame 5, on the axis
    of joint 6 behind the flange) lies within the annulus that both links and the offset along joint 4 span
    around the shoulder (Hawkins, Analytic Inverse Kinematics for the Universal Robots UR-5/UR-10 Arms, 2013).
    For other arms the root of the last axis lies within what the joints before it span around joint 2
    (``numeric_inverse.span``).
    """
    rows = table(robot)
    wrist = from_root(robot, target) * Pose((0.0, 0.0, -rows[-1][1]))
    x, y, z = wrist.position
    if len(rows) != 6 or not _parallel(rows):
        out, most = math.hypot(x, y, z - rows[0][1]), abs(rows[0][0]) + numeric_inverse.span(robot)
        return (
            (out - most, f"wrist at {out:.3f} m > {most:.3f} m from the shoulder of '{robot.type}'")
            if out > most
            else (0.0, "")
        )
    around, side = math.hypot(x, y), abs(rows[1][1] + rows[2][1] + rows[3][1])
    if around < side:
        return (
            around - side,
            f"wrist centre {around:.3f} m < {side:.3f} m from the base axis of '{robot.type}'",
        )
    out = math.hypot(math.sqrt(around**2 - side**2), z - rows[0][1])
    links, elbow = abs(rows[1][0]) + abs(rows[2][0]), abs(rows[4][1])
    if out > links + elbow:
        return (
            out - links - elbow,
            f"wrist centre at {out:.3f} m > {links + elbow:.3f} m of arm '{robot.type}'",
        )
    return 0.0, ""


def _parallel(rows: Table) -> bool:
    """Whether the axes of joints 2, 3 and 4 are parallel and all other neighbouring axes intersect, as on a
    UR arm."""
    return rows[1][2] == rows[2][2] == 0.0 and rows[0][0] == rows[3][0] == rows[4][0] == 0.0


def out_of_limits(robot: Robot, q: Sequence[float]) -> str:
    """Name the first joint outside its limits, with value and limits; "" if all joints are inside."""
    for name, value, (low, high) in zip(robot.joints, q, robot.limits, strict=True):
        if not low <= value <= high:
            return f"joint '{name}' at {value:.3f} rad is outside {low:.3f} .. {high:.3f} rad"
    return ""

"""Remedies for things out of an arm's reach."""

from __future__ import annotations

import math

from cramlite.model import Pose, Remedy, Robot

from ..kinematics.reach import reach_gap

NEAR = 0.01  # what lacks less is told in whole millimetres [m]
NEARER = "or the robot ('robot: {at: ...}')"


def too_far(thing: str, gap: float, robot: Robot) -> Remedy:
    """Return the remedy for a thing that is out of reach by a distance [m]."""
    return Remedy(f"reach {thing}", f"'{thing}' {_says(gap, robot)}", gap)


def no_inverse(robot: Robot, pose: Pose) -> Remedy | None:
    """Return the remedy for a pose of the TCP that has no inverse solution; None where it is within reach."""
    gap, _ = reach_gap(robot, pose)
    return Remedy("", f"the place {_says(gap, robot)}", abs(gap)) if gap else None


def _says(gap: float, robot: Robot) -> str:
    far = f"{abs(gap):.2f} m" if abs(gap) >= NEAR else f"{math.ceil(1000 * abs(gap))} mm"
    how, to = (
        (f"{far} out of reach of", "nearer")
        if gap > 0
        else (f"{far} too near to the base of", "farther away")
    )
    return f"is {how} arm '{robot.type}': move it at least so much {to}, {NEARER}"

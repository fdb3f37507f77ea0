"""Limits of a robot that every run must keep: ``preflight`` shows them, and proofs refuse runs that exceed them."""

from __future__ import annotations

from collections.abc import Iterator

from ...base.value import Value
from ..program.program_safety import TOOL_SPEED
from ..robot import Robot
from .run_peaks import RunPeaks

OVERSHOOT = 1.05
"""Measured joint speeds may exceed a limit by this factor: the model's position servo lags, then catches up."""


class Reached(Value):
    """Highest value that a run reached of a quantity that the robot's controller limits, and that limit.

    Args:
        limit: "tool_speed", "tool_force" or "joint_speed".
        of: name of the joint; "" for the tool.
        unit: of both numbers.
        value: the most in the run.
        most: that may be reached, and ``source``, whose limit that is.
        line: of the text where it is reached; 0 where that is nowhere in particular.
    """

    limit: str
    of: str
    unit: str
    value: float
    most: float
    source: str
    line: int = 0

    @property
    def passed(self) -> bool:
        """Whether the highest value of the run is within the limit."""
        return self.value <= self.most


def reached(peaks: RunPeaks, robot: Robot, force_limit: float, force_source: str) -> Iterator[Reached]:
    """Yield, for each limit of the robot, the value that the run reached.

    Args:
        force_limit: protective limit on the TCP force [N], and ``force_source``, whose it is.
    """
    yield Reached("tool_speed", "", "m/s", peaks.tool_speed, TOOL_SPEED, "factory preset", peaks.tool_speed_line)
    yield Reached("tool_force", "", "N", peaks.force, force_limit, force_source, peaks.force_line)
    source = f"of robot '{robot.type}', plus {OVERSHOOT - 1:.0%} for overshoot"
    for name, speed, limit in zip(robot.joints, peaks.joint_speeds, robot.velocity, strict=False):
        yield Reached("joint_speed", name, "rad/s", speed, limit * OVERSHOOT, source)

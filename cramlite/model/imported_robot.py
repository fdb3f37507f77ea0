"""Robot read from a file such as a URDF, as a robot model of cramlite."""

from __future__ import annotations

from ..base.value import Value
from .geometry import Pose
from .robot import Robot


class ImportedRobot(Value):
    """Robot read from a file, with notes on what the file stated and what was missing.

    Args:
        robot: joints count as its Denavit-Hartenberg table does; ``axis_zeros`` is where the file counts zero.
        found: what was found there, for people.
        notes: what is missing and was taken from elsewhere or changed, and what says another; one sentence each.
        tool: of the file's flange in the table's last frame.
        flange: kind and name, as the file has them, of what tools are bolted to: "site" or "body", and its name.
        root: body that carries the first joint, as the file calls it; "world" if it stands in the room.
    """

    robot: Robot
    found: tuple[str, ...]
    notes: tuple[str, ...]
    tool: Pose = Pose()
    flange: tuple[str, str] = ("", "")
    root: str = "world"

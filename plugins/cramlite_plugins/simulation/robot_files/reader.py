"""The reader of robot files: MJCF and URDF become robots, with a list of what was found and what is missing."""

from __future__ import annotations

from pathlib import Path

from cramlite.model import ImportedRobot, RobotFile
from cramlite.plugin import hookimpl

SUFFIXES = (".xml", ".mjcf", ".urdf")


@hookimpl
def read_robot(file: RobotFile, name: str) -> ImportedRobot | None:
    """Read the robot in an MJCF or URDF file; None if it is no such file."""
    if Path(file.path).suffix.lower() not in SUFFIXES:
        return None
    from ..model.no_window import import_mujoco

    import_mujoco()
    from .robot_file import read_robot as read

    return read(file.path, name, file.stated)

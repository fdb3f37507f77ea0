"""Reader of robot files: MJCF and URDF become robots, with notes on missing and unused parts."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from cramlite.model import ImportedRobot, RobotFile
from cramlite.plugin import hookimpl

SUFFIXES = (".xml", ".mjcf", ".urdf")


@hookimpl
def read_robot(file: RobotFile, name: str) -> ImportedRobot | None:
    """Read the robot in an MJCF or URDF file; None if it is no such file."""
    if Path(file.path).suffix.lower() not in SUFFIXES:
        return None
    from ...simulation.model.no_window import import_mujoco

    import_mujoco()
    from .robot_file import read_robot as read

    return read(file.path, called(Path(file.path), name), file.stated)


def called(path: Path, name: str) -> str:
    """Return a robot's type, made of the model's name in its file and the file's name: "MODEL (FILE)".

    It is the file's name alone if the model has no name or the same. Many a vendor's file is called "robot.xml".
    """
    try:
        _, root = next(ElementTree.iterparse(path, events=("start",)))
    except (ElementTree.ParseError, OSError, ValueError):
        return name  # what is wrong with the file is said when it is read
    model = " ".join((root.get("model") or root.get("name") or "").split())
    return name if model in ("", path.stem) else f"{model} ({name})"

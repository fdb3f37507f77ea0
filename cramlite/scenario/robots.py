"""Robot of a scenario: of a type that a plugin declares, or read from a robot file such as a URDF."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..model.robot_file import HandFile, RobotFile, Stated
from ..model.world.world import RobotMount
from ..plugin.catalogue import pick
from .model_files import existing_file

if TYPE_CHECKING:
    from ..model.imported_robot import ImportedRobot
    from ..model.robot import Robot
    from ..plugin.catalogue import Knowledge
    from .robot_spec import GripperSpec, RobotSpec
    from .scenario import Scenario


def mount_of(scenario: Scenario) -> RobotMount:
    """Return the mount of a scenario's robot: its name, type, base pose and file.

    The file is not read here, so its name is given as the type of a robot from a file.
    """
    spec = scenario.spec.robot
    kind = spec.type or scenario.resolve_path(spec.file or "").name
    return RobotMount(spec.name, kind, spec.at.pose(), file=file_of(scenario))


def robot_of(scenario: Scenario, knowledge: Knowledge) -> Robot:
    """Return the model of a scenario's robot.

    Raises:
        UserError: no plugin declares its type, or its file cannot be used; with file and line.
    """
    read = imported_robot(scenario, knowledge)
    if read is not None:
        return read.robot
    found: Robot = pick("robot", knowledge.robots, scenario.spec.robot.type or "", scenario.where("robot", "type"))
    return found


def imported_robot(scenario: Scenario, knowledge: Knowledge) -> ImportedRobot | None:
    """Read the file of a scenario's robot; None if the robot's type is declared by a plugin.

    Raises:
        UserError: it cannot be used; with file and line.
    """
    file = file_of(scenario)
    if file is None:
        return None
    try:
        return knowledge.read_robot(file)
    except UserError as error:
        raise UserError(f"{scenario.where('robot')}: {error}") from error


def file_of(scenario: Scenario) -> RobotFile | None:
    """Return the file of a scenario's robot with the data that the scenario adds; None if the type is
    declared by a plugin.

    Raises:
        UserError: there is no such file; with file and line.
    """
    spec = scenario.spec.robot
    if spec.file is None:
        return None
    return RobotFile(_existing(scenario, spec.file, "file"), _stated(scenario, spec))


def _stated(scenario: Scenario, spec: RobotSpec) -> Stated:
    return Stated(
        payload=spec.payload or 0.0,
        gripper=spec.gripper if isinstance(spec.gripper, str) else _hand(scenario, spec.gripper),
        flange=spec.flange,
        home=spec.home,
        speed=spec.speed,
        torques=spec.torques,
        limits=tuple((name, low, high) for name, (low, high) in spec.limits.items()),
        sensor=spec.sensor,
        apart=spec.apart,
        packages=tuple((name, str(scenario.resolve_path(folder).absolute())) for name, folder in spec.packages.items()),
    )


def _hand(scenario: Scenario, spec: GripperSpec) -> HandFile:
    path = _existing(scenario, spec.file, "gripper", "file") if spec.file else ""
    return HandFile(path, spec.at.pose(), spec.pads, spec.tcp, spec.opening, spec.force, spec.speed, spec.torsion)


def _existing(scenario: Scenario, name: str, *keys: str) -> str:
    return str(existing_file(scenario, name, "robot", "robot", *keys).absolute())

"""``cramlite calibrate``: where a camera is and how it sees, from pictures of a printed board."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from ..base.errors import UserError
from ..base.json_text import as_json
from ..base.resources import find_scenario
from ..engine.engine import Engine
from ..model.geometry import Pose
from ..model.view import Intrinsics
from ..model.world.world import Camera, RobotMount, World
from ..perception.calibration.board import BoardSpec, opencv, write_board
from ..perception.calibration.hand_eye import calibrated
from ..perception.calibration.recording import FlangeOf, read_recording, read_spec
from ..perception.calibration.result import (
    calibration_file,
    calibration_text,
    correction_file,
    warnings,
    write_calibration,
)
from ..perception.camera_check import camera_offset, moved_text
from ..plugin.catalogue import Knowledge, pick
from ..plugin.registry import Registry
from ..scenario.scenario import read_scenario
from .arguments import Add, plugin_choice
from .perceive import fixtures_of


def calibrate(arguments: argparse.Namespace) -> int:
    """Calibrate a camera by pictures of a printed board or of known fixtures, or write the board to be printed.

    Raises:
        UserError: OpenCV is not installed, or what is read cannot tell where the camera is.
    """
    registry = plugin_choice(arguments).registry()
    folder: Path | None = arguments.folder
    if arguments.view is not None:
        return _by_fixtures(folder, arguments)
    opencv()
    if arguments.board is not None:
        board = read_spec(folder).board if folder else BoardSpec()
        write_board(arguments.board, board)
        width, height = (1000 * s for s in board.size)
        print(
            f"Written: {arguments.board}: {board.kind} board, {board.columns} columns x {board.rows} rows, {width:g} x {height:g} mm, "
            f"dictionary {board.dictionary}. Print it at 100 %, glue it to a flat plate, and measure a square: its side "
            f"is {1000 * board.square:g} mm."
        )
        return 0
    if folder is None:
        raise UserError("Name the folder with the pictures and calibration.yaml, or write a board with --board FILE.png.")
    return _calibrate(folder, registry, arguments)


def _calibrate(folder: Path, registry: Registry, arguments: argparse.Namespace) -> int:
    spec = read_spec(folder)
    knowledge = Knowledge(registry)
    recording = read_recording(folder, spec, flange_of(spec.robot, folder, knowledge))
    found = calibrated(recording.stations, spec.mount, recording.intrinsics, recording.given)
    told, keys = warnings(found, recording), calibration_file(found, recording)
    print(as_json({**keys, "warnings": told}) if arguments.json else calibration_text(found, recording, told))
    if arguments.out is not None:
        write_calibration(arguments.out, keys)
    if arguments.page is not None:
        from ..report.calibration_page import write_page

        write_page(arguments.page, found, recording, told)
    if not arguments.json:
        written = [str(p) for p in (arguments.out, arguments.page and arguments.page / "calibration.html") if p]
        print(f"Written: {', '.join(written)}" if written else "--out FILE.yaml writes what a scenario's camera takes as 'calibration'.")
    return 0


def _by_fixtures(scenario: Path | None, arguments: argparse.Namespace) -> int:
    """Correct the pose of a scenario's camera by the fixtures in a recorded view."""
    if scenario is None or scenario.is_dir():
        raise UserError("--view needs a scenario, whose furniture is in the view: cramlite calibrate SCENARIO.yaml --view RECORDING.")
    engine = Engine.with_plugins(plugin_choice(arguments))
    source = read_scenario(find_scenario(str(scenario)))
    view = engine.registry.first("read_view", path=arguments.view)
    if view is None:
        raise UserError(f"'{arguments.view}' is in no format that a plugin reads as a view; docs/reference/perception.md lists them.")
    offset, reason = camera_offset(view, fixtures_of(str(scenario), engine.knowledge, 0), engine.knowledge)
    if offset is None:
        raise UserError(
            f"{arguments.view}: fixtures do not tell where the camera is: {reason}. The picture has to show faces of fixtures "
            "in three directions, and the recording's 'camera' has to be right to 25 mm and 1 deg."
        )
    told = f"move it by {moved_text(offset.moved)}" if offset.off else "that is no more than programs are proven for"
    keys = correction_file(source, view, offset)
    print(as_json(keys) if arguments.json else f"{reason}; {told}")
    if arguments.out is not None:
        write_calibration(arguments.out, keys)
        print(f"Written: {arguments.out}")
    return 0


def flange_of(robot: str | None, where: Path, knowledge: Knowledge) -> FlangeOf:
    """Return a function from a robot's joint positions to the pose of its flange in the robot's base frame."""
    def pose(joints: Sequence[float]) -> Pose:
        if robot is None:
            raise UserError(f"{where}: pictures state joint positions, but no robot; add its type, such as 'robot: ur5e'.")
        model = pick("robot", knowledge.robots, robot, f"{where}: robot")
        if len(joints) != len(model.joints):
            has = f"the robot '{robot}' has {len(model.joints)} joints"
            raise UserError(f"{where}: a picture states {len(joints)} joint positions, but {has}.")
        world = World((), (RobotMount("robot", robot),))
        eye = Camera(Pose(), "robot", tuple(joints), Intrinsics.from_field_of_view(16, 16), noise=False)
        return knowledge.simulator.look(world, knowledge.robots, eye, seed=0).camera

    return pose


def add_commands(add: Add) -> None:
    """Add the command ``calibrate``, with its arguments, to the command line."""
    command = add("calibrate", calibrate)
    folder = "pictures with calibration.yaml, which says board, robot and poses; with --view a scenario"
    command.add_argument("folder", type=Path, nargs="?", help=folder)
    view = "recorded view with depth: correct the camera by the scenario's furniture in it"
    command.add_argument("--view", type=Path, metavar="RECORDING", help=view)
    board = "write a board to print, as .png or .pdf: that of the folder, else a usual one"
    command.add_argument("--board", type=Path, metavar="FILE", help=board)
    command.add_argument("--out", type=Path, metavar="FILE", help="write a YAML file that a scenario's camera takes as 'calibration'")
    command.add_argument("--page", type=Path, metavar="FOLDER", help="write calibration.html there: error bars and residuals by picture")
    command.add_argument("--json", action="store_true", help="print as JSON")

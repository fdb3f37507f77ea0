"""Calibration: boards are drawn and found, poses come out within their error bars, and what cannot be told is refused."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from helpers import as_a_user
from helpers.board_pictures import BEFORE, IN_HAND, PINHOLE, flange_of, picture, seen_from, stations
from PIL import Image as Pictures

from cramlite.model import Pose
from cramlite.perception.calibration.board import BoardSpec, drawn, found
from cramlite.perception.calibration.hand_eye import Station, calibrated
from cramlite.plugin import UserError
from cramlite.scenario.scenario import read_scenario
from cramlite.scenario.worlds import camera_of

Mount = Literal["flange", "world"]
PLACE = Pose.from_rotvec((0.5, 0.1, 0.0), (0.0, 0.0, 0.3))
TRUE: dict[Mount, Pose] = {"flange": IN_HAND, "world": BEFORE}
APRIL = BoardSpec(kind="grid", columns=5, rows=4, square=0.045, marker=0.036, dictionary="APRILTAG_36h11")


@pytest.mark.parametrize("spec", [BoardSpec(), APRIL, BoardSpec(dictionary="5X5_100")], ids=["charuco", "april", "5x5"])
def test_a_board_is_found_where_it_is(spec: BoardSpec) -> None:
    board = seen_from(np.random.default_rng(3), spec)
    sighting = found(spec, picture(spec, board))
    assert sighting is not None
    off = np.linalg.norm(PINHOLE.project(board.apply(sighting.corners)) - sighting.pixels, axis=1)
    inner = spec.kind == "charuco"  # corners of a chess board are sharper than those of a marker
    assert np.median(off) < (0.25 if inner else 0.4) and off.max() < (1.0 if inner else 2.0)
    assert found(BoardSpec(dictionary="7X7_50"), picture(spec, board)) is None


def test_a_printed_board_has_its_size() -> None:
    assert drawn(BoardSpec(), 1000.0).shape == (175, 245)


@pytest.mark.parametrize("given", [True, False], ids=["given", "found"])
@pytest.mark.parametrize("mount", ["flange", "world"])
def test_a_camera_is_where_calibration_says(mount: Mount, given: bool) -> None:
    result = calibrated(stations(100, mount=mount), mount, PINHOLE, given)
    position, angle = result.camera.distance(TRUE[mount])
    assert position < 0.006 and angle < math.radians(0.5) and result.error < 1.0 and not result.strays


@pytest.mark.heavy
@pytest.mark.parametrize("mount", ["flange", "world"])
@pytest.mark.parametrize(("pixel", "robot_mm"), [(0.5, 0.0), (0.1, 1.0)])
def test_error_bars_hold_what_they_say(mount: Mount, pixel: float, robot_mm: float) -> None:
    """Of 95 % bars 50 draws may miss 6 (probability of more: 4 %); bars that were ten times too wide would be none."""
    inside, shares = np.zeros(2), []
    for seed in range(50):
        result = calibrated(stations(seed, mount=mount, pixel=pixel, robot_mm=robot_mm, robot_deg=0.1 * robot_mm), mount, PINHOLE, True)
        position, angle = result.camera.distance(TRUE[mount])
        inside += (position <= result.position, angle <= result.angle)
        shares.append(position / result.position)
    assert inside.min() >= 44
    assert 0.2 < np.median(shares) < 0.75


def _shifted(seed: int) -> list[Station]:
    made = stations(seed)
    return [Station(s.name, made[k - 1].flange, s.sighting) for k, s in enumerate(made)]


REFUSED: dict[str, tuple[Any, Mount, str]] = {
    "one axis": (lambda: stations(3, one_axis=True), "flange", "about one axis"),
    "another size": (lambda: stations(3, size=30.1 / 35), "flange", "0.86[0-9] times"),
    "another mount": (lambda: stations(3), "world", "write 'mount: flange'"),
    "other pictures' poses": (lambda: _shifted(3), "flange", "do not belong together"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_told_is_refused(case: str) -> None:
    made, mount, said = REFUSED[case]
    with pytest.raises(UserError, match=said):
        calibrated(made(), mount, PINHOLE, True)


def test_a_board_that_is_printed_as_said_is_not_refused() -> None:
    assert calibrated(stations(3, size=1.002), "flange", PINHOLE, True).error < 1.0


def test_a_picture_in_which_something_moved_is_named() -> None:
    made = stations(5)
    off = made[4].flange * Pose.from_rotvec((0.006, 0, 0), (0, 0, 0.005))
    made[4] = Station("04.png", off, made[4].sighting)
    assert "04.png" in calibrated(made, "flange", PINHOLE, True).strays


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight pictures by a camera in the hand, with a ninth of an empty table."""
    path, rng, spec = tmp_path_factory.mktemp("board"), np.random.default_rng(5), BoardSpec()
    rows = ["file,x,y,z,qw,qx,qy,qz"]
    for k in range(9):
        board = seen_from(rng, spec)
        flange = flange_of(board, "flange", IN_HAND, PLACE)
        shown = picture(spec, board, k) if k < 8 else np.full((480, 640), 120, np.uint8)
        Pictures.fromarray(shown).save(path / f"{k}.png")
        rows.append(f"{k}.png," + ",".join(f"{v:.7f}" for v in (*flange.position, *flange.quaternion)))
    (path / "poses.csv").write_text("\n".join(rows) + "\n")
    (path / "calibration.yaml").write_text("pictures: poses.csv\n")
    return path


def test_a_folder_becomes_the_camera_of_a_scenario(folder: Path, tmp_path: Path) -> None:
    done = as_a_user.cramlite("calibrate", folder, "--out", tmp_path / "camera.yaml", "--page", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "no board in 1: 8.png" in done.stdout and "error bars (95 %" in done.stdout
    assert "<svg" in (tmp_path / "calibration.html").read_text()
    scenario = (
        "scenario: a\ntasks: [{task: LookingAt, Patient: b}]\nrobot: {type: ur5e}\ncamera: {calibration: camera.yaml}\n"
        "things: [{name: b, model: block, at: {position: [0.45, 0, 30 mm]}}]\n"
    )
    (tmp_path / "a.yaml").write_text(scenario)
    camera = camera_of(read_scenario(tmp_path / "a.yaml"))
    assert camera is not None and camera.mount == "arm"
    assert camera.pose.distance(IN_HAND)[0] < 0.002 and abs(camera.intrinsics.fx - PINHOLE.fx) < 3


def _edited(folder: Path, into: Path, **keys: str) -> Path:
    for file in folder.iterdir():
        (into / file.name).write_bytes(file.read_bytes())
    lines = {"pictures": "poses.csv", **keys}
    (into / "calibration.yaml").write_text("".join(f"{k}: {v}\n" for k, v in lines.items()))
    return into


JOINTS = "[" + ", ".join(f"{{file: {k}.png, joints: [0]}}" for k in range(8)) + "]"
WRONG: dict[str, tuple[dict[str, str], str]] = {
    "dictionary": ({"board": "{dictionary: 5X5_50}"}, "markers of the dictionary 4X4_50"),
    "no such dictionary": ({"board": "{dictionary: 4X4_51}"}, "4X4_50"),
    "square": ({"board": "{square: 30 mm, marker: 22.3 mm}"}, "another size"),
    "key": ({"borad": "{}"}, "board"),
    "no table": ({"pictures": "there.csv"}, "there.csv"),
    "few": ({"pictures": "[{file: 0.png, flange: {}}]"}, "1 pictures are named"),
    "joints of nobody": ({"pictures": JOINTS}, "but no robot"),
    "joints too few": ({"robot": "ur5e", "pictures": JOINTS}, "has 6"),
    "intrinsics": ({"intrinsics": "{fx: 610, fy: 612, cx: 900, cy: 236}"}, "outside the image"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_folder_is_one_paragraph(case: str, folder: Path, tmp_path: Path) -> None:
    keys, said = WRONG[case]
    done = as_a_user.cramlite("calibrate", _edited(folder, tmp_path, **keys))
    assert done.returncode == 2 and said in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_joints_are_poses_by_the_named_robot(folder: Path) -> None:
    from cramlite.cli.calibrate import flange_of as by_joints
    from cramlite.plugin.catalogue import Knowledge
    from cramlite.plugin.selection import INSTALLED
    from cramlite_plugins.kinematics.forward import flange
    from cramlite_plugins.robots.arms import robots

    q = (0.3, -1.2, 1.4, -1.0, -1.5, 0.2)
    robot = next(r for r in robots() if r.type == "ur5e")
    assert by_joints("ur5e", folder, Knowledge(INSTALLED.registry()))(q).distance(flange(robot, q)) < (1e-6, 1e-6)


def test_a_board_is_written_and_found_again(tmp_path: Path) -> None:
    done = as_a_user.cramlite("calibrate", "--board", tmp_path / "board.png")
    assert done.returncode == 0 and "245 x 175 mm" in done.stdout
    printed = Pictures.open(tmp_path / "board.png")
    assert printed.info["dpi"] == pytest.approx((300, 300), abs=0.1)
    assert found(BoardSpec(), np.asarray(printed.convert("L"))) is not None
    assert as_a_user.cramlite("calibrate", "--board", tmp_path / "board.pdf").returncode == 0
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")
    assert as_a_user.cramlite("calibrate", "--board", tmp_path / "board.doc").returncode == 2


def test_calibration_and_pose_of_a_camera_are_not_both_said(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("scenario: a\ntasks: []\nrobot: {type: ur5e}\ncamera: {calibration: c.yaml, width: 640}\n")
    with pytest.raises(UserError, match="leave out width"):
        read_scenario(tmp_path / "a.yaml")


def test_without_opencv_the_command_says_what_to_install(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    done = as_a_user.cramlite("calibrate", folder)
    assert done.returncode == 2 and "pip install 'cramlite[calibration]'" in done.stderr

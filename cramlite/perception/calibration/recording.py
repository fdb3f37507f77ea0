"""Folders of pictures for calibration; ``calibration.yaml`` states the board, and the robot's pose in each picture."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import ValidationError, model_validator

from ...base.errors import UserError
from ...base.quantities import Angle
from ...base.spec import Spec
from ...base.value import Value
from ...base.yaml_file import explain_validation, load_yaml
from ...model.geometry import Pose
from ...model.view import Intrinsics
from ...scenario.camera_spec import IntrinsicsSpec
from ...scenario.pose_spec import PoseSpec
from .board import BoardSpec, found, other_dictionary
from .hand_eye import Station

if TYPE_CHECKING:
    from ...model.view import Image

FILE = "calibration.yaml"
LEAST = 6
"""Least number of pictures that show the board: three determine the camera's pose, three more its error bars."""
MOST_PICTURES = 500
MOST_BYTES = 2**26
"""Largest size of a picture [bytes]: 40 megapixels without compression are less."""
NAMED = 4
"""Largest number of pictures that an error message names."""
POSE_COLUMNS = ("x", "y", "z", "qw", "qx", "qy", "qz")

FlangeOf = Callable[[Sequence[float]], Pose]
"""Function from joint positions [rad] to the pose of the flange in the base frame."""


class PictureSpec(Spec):
    """Picture of a calibration, with the robot's joints or its flange pose in the base frame."""

    file: str
    joints: tuple[Angle, ...] | None = None
    flange: PoseSpec | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> PictureSpec:
        if (self.joints is None) == (self.flange is None):
            raise ValueError("a picture has 'joints' or 'flange', one of the two")
        return self


class RecordingSpec(Spec):
    """Keys of ``calibration.yaml``; ``pictures`` may be the name of a CSV file beside it."""

    mount: Literal["flange", "world"] = "flange"
    robot: str | None = None
    board: BoardSpec = BoardSpec()
    intrinsics: IntrinsicsSpec | None = None
    pictures: tuple[PictureSpec, ...] | str = ()


class Recording(Value, eq=False):
    """Recording for a calibration: the pictures in which the board was found.

    Args:
        intrinsics: as given; else only their size counts.
        given: whether intrinsics were given.
        stations: the pictures with a board.
        without: names of the others.
    """

    spec: RecordingSpec
    intrinsics: Intrinsics
    given: bool
    stations: tuple[Station, ...]
    without: tuple[str, ...]


def read_spec(folder: Path) -> RecordingSpec:
    """Read ``calibration.yaml`` of a folder.

    Raises:
        UserError: there is none, or it is wrong; says where and what would be right.
    """
    path = folder / FILE
    if not path.is_file():
        raise UserError(
            f"{folder}: there is no {FILE}, which describes the board, the robot and its position in each picture; "
            "docs/how-to/calibrate.md has one to copy."
        )
    data = load_yaml(path)
    if not isinstance(data, Mapping):
        raise UserError(f"{path}:1: this file is a mapping with the keys {', '.join(RecordingSpec.model_fields)}.")
    try:
        return RecordingSpec.model_validate(data)
    except ValidationError as error:
        raise explain_validation(path, data, error, list(RecordingSpec.model_fields)) from error


def read_recording(folder: Path, spec: RecordingSpec, flange_of: FlangeOf) -> Recording:
    """Find the board in the pictures of a folder.

    Raises:
        UserError: a picture or pose cannot be read, pictures differ in size, or the board is in too few of them.
    """
    listed = _table(folder / spec.pictures) if isinstance(spec.pictures, str) else spec.pictures
    if not LEAST <= len(listed) <= MOST_PICTURES:
        few = f"{LEAST} are the fewest and {MOST_PICTURES} the most, 12 to 20 good"
        raise UserError(f"{folder / FILE}: {len(listed)} pictures are named; {few}.")
    stations, without, sizes = list[Station](), list[str](), dict[tuple[int, int], str]()
    for picture in listed:
        flange = picture.flange.pose() if picture.flange else flange_of(picture.joints or ())
        grey = _grey(folder / picture.file)
        sizes.setdefault((grey.shape[1], grey.shape[0]), picture.file)
        sighting = found(spec.board, grey)
        if sighting is None:
            without.append(picture.file)
        else:
            stations.append(Station(picture.file, flange, sighting))
    if len(sizes) > 1:
        said = ", ".join(f"{name} has {w} x {h}" for (w, h), name in sizes.items())
        raise UserError(f"{folder}: the pictures are of several sizes: {said}; take all with one camera at one resolution.")
    if len(stations) < LEAST:
        raise UserError(_too_few(folder, spec, len(listed), without))
    (width, height) = next(iter(sizes))
    rough = Intrinsics.from_field_of_view(width, height)
    given = spec.intrinsics
    try:
        intrinsics = Intrinsics(**given.model_dump(), width=width, height=height) if given else rough
    except UserError as error:
        raise UserError(f"{folder / FILE}: {error}") from error
    return Recording(spec, intrinsics, given is not None, tuple(stations), tuple(without))


def _too_few(folder: Path, spec: RecordingSpec, count: int, without: Sequence[str]) -> str:
    b = spec.board
    names = ", ".join(without[:NAMED]) + (f" and {len(without) - NAMED} more" if len(without) > NAMED else "")
    other = other_dictionary(b, _grey(folder / without[0]))
    hint = f" In {without[0]} there are markers of the dictionary {other}." if other else ""
    return (
        f"{folder}: no board was found in {len(without)} of {count} pictures ({names}), and {LEAST} with one are needed. It was looked "
        f"for as {b.kind}, {b.columns} columns x {b.rows} rows, dictionary {b.dictionary}.{hint} Compare that with the printed board; it "
        "should fill a third of the picture, flat, evenly lit and sharp."
    )


def _grey(path: Path) -> Image:
    from PIL import Image as Pictures

    try:
        if path.stat().st_size > MOST_BYTES:
            raise UserError(f"{path}: the picture is larger than {MOST_BYTES // 2**20} MB.")
        with Pictures.open(path, formats=("PNG", "JPEG")) as picture:
            return np.asarray(picture.convert("L"))
    except (OSError, SyntaxError, ValueError, Pictures.DecompressionBombError) as error:
        raise UserError(f"{path}: cannot be read as a picture: {error}.") from error


def _table(path: Path) -> tuple[PictureSpec, ...]:
    """Read pictures from a CSV file.

    Its columns are ``file`` and joints ``j1`` ... [rad], or ``file`` and the flange's x, y, z [m], qw, qx,
    qy, qz.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            table = csv.DictReader(file, skipinitialspace=True)
            rows, names = list(table), [n.strip() for n in table.fieldnames or ()]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"{path}: cannot be read as a table of pictures: {error}.") from error
    joints = [n for n in names if n[:1] == "j" and n[1:].isdigit()]
    if "file" not in names or not (joints or set(POSE_COLUMNS) <= set(names)):
        needed = f"'file' and j1, j2, ... [rad], or 'file' and {', '.join(POSE_COLUMNS)}"
        raise UserError(f"{path}:1: the columns are {', '.join(names) or 'none'}; needed are {needed}.")
    return tuple(_row(row, joints, f"{path}:{k}") for k, row in enumerate(rows, 2))


def _row(row: Mapping[str, Any], joints: Sequence[str], where: str) -> PictureSpec:
    try:
        values = [float(row[n]) for n in joints or POSE_COLUMNS]
    except (TypeError, ValueError) as error:
        raise UserError(f"{where}: a value is missing, or is not a number: {error}.") from error
    if not all(map(math.isfinite, values)):
        raise UserError(f"{where}: a number is not finite.")
    name = str(row["file"]).strip()
    if joints:
        return PictureSpec(file=name, joints=tuple(values))
    if not 0.99 < math.hypot(*values[3:]) < 1.01:
        raise UserError(f"{where}: the quaternion {values[3:]} has the length {math.hypot(*values[3:]):.3f}, not 1.")
    pose = Pose((values[0], values[1], values[2]), (values[3], values[4], values[5], values[6]))
    return PictureSpec(file=name, flange=written(pose))


def written(pose: Pose) -> PoseSpec:
    """Convert a pose to the form that files use: position, and rotations about the fixed axes x, y, z."""
    r = pose.rotation
    pitch = math.atan2(-r[2, 0], math.hypot(r[0, 0], r[1, 0]))
    if math.hypot(r[0, 0], r[1, 0]) < 1e-9:  # about x and z it turns about one axis
        return PoseSpec(position=pose.position, pitch=pitch, yaw=math.atan2(-r[0, 1], r[1, 1]))
    return PoseSpec(position=pose.position, roll=math.atan2(r[2, 1], r[2, 2]), pitch=pitch, yaw=math.atan2(r[1, 0], r[0, 0]))

"""Printed boards for calibration, ChArUco boards and grids of ArUco or AprilTag markers: drawing, and detection in pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from ...base.errors import UserError, nearest
from ...base.quantities import Length
from ...base.spec import Spec
from ...base.value import Value

if TYPE_CHECKING:
    from ...model.view import Image, Points

DPI = 300
"""Resolution of a printed board [dots per inch], which office printers reach."""
LEAST = 6
"""Least number of visible corners: four determine a pose, two more check it."""
LEAST_MARKERS = 4
"""Least number of markers in a picture that make another dictionary a proposal: one marker alone may be a false detection."""
MARGIN = 0.005
"""White border around a printed board [m]: a marker is found by the white around it."""


class BoardSpec(Spec):
    """Board of ``columns`` x ``rows`` fields: a chess board with markers (charuco), or markers with gaps
    (grid)."""

    kind: Literal["charuco", "grid"] = "charuco"
    columns: int = Field(default=7, ge=2, le=40)
    rows: int = Field(default=5, ge=2, le=40)
    square: Length = Field(default=0.035, gt=0.002, le=1.0)
    marker: Length = Field(default=0.026, gt=0.001, le=1.0)
    dictionary: str = "4X4_50"

    @model_validator(mode="after")
    def _fits(self) -> BoardSpec:
        if not self.marker < self.square:
            raise ValueError("'marker', the side of a marker, must be smaller than 'square', the distance from one marker to the next")
        return self

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the printed board [m]."""
        gap = self.square - self.marker if self.kind == "grid" else 0.0
        return self.columns * self.square - gap, self.rows * self.square - gap


class Sighting(Value, eq=False):
    """Corners of a board in a picture: (N, 3) on the board [m], and (N, 2) in the image [pixel]."""

    corners: Points
    pixels: Points


def opencv() -> Any:
    """Import and return OpenCV's module cv2.

    Raises:
        UserError: it is not installed, or a version without what is needed.
    """
    try:
        import cv2
    except ImportError as error:
        raise UserError("Calibration needs OpenCV, which is not installed: pip install 'cramlite[calibration]'.") from error
    if not hasattr(cv2, "calibrateHandEye"):
        raise UserError(f"OpenCV {cv2.__version__} has no calibrateHandEye: pip install 'cramlite[calibration]' installs one that has.")
    return cv2


def made(spec: BoardSpec) -> Any:
    """Return OpenCV's object for a board.

    Raises:
        UserError: there is no such dictionary, or it has too few markers.
    """
    cv2 = opencv()
    names = [n.removeprefix("DICT_") for n in dir(cv2.aruco) if n.startswith("DICT_")]
    if spec.dictionary not in names:
        raise UserError(f"board: there is no dictionary of markers '{spec.dictionary}'; {nearest(spec.dictionary, names)}.")
    markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{spec.dictionary}"))
    needed = spec.columns * spec.rows // (2 if spec.kind == "charuco" else 1)
    if (there := len(markers.bytesList)) < needed:
        raise UserError(f"board: it needs {needed} markers, and dictionary '{spec.dictionary}' has {there}; take a larger one.")
    size = (spec.columns, spec.rows)
    if spec.kind == "charuco":
        return cv2.aruco.CharucoBoard(size, spec.square, spec.marker, markers)
    return cv2.aruco.GridBoard(size, spec.marker, spec.square - spec.marker, markers)


def drawn(spec: BoardSpec, dots_per_metre: float = DPI / 0.0254) -> Image:
    """Return a board as a grey picture (rows, columns) at its true size, without a border."""
    width, height = (round(s * dots_per_metre) for s in spec.size)
    picture: Image = made(spec).generateImage((width, height), marginSize=0)
    return picture


def write_board(path: Path, spec: BoardSpec) -> None:
    """Write a board for printing at its true size, as PNG or PDF.

    Raises:
        UserError: it is neither, or it cannot be written.
    """
    from PIL import Image as Pictures

    if path.suffix.lower() not in (".png", ".pdf"):
        raise UserError(f"--board {path}: a board is written as .png or .pdf.")
    picture = Pictures.fromarray(np.pad(drawn(spec), round(MARGIN / 0.0254 * DPI), constant_values=255))
    try:
        picture.save(path, dpi=(DPI, DPI), resolution=DPI)
    except OSError as error:
        raise UserError(f"--board {path}: it cannot be written: {error.strerror or error}.") from error


def found(spec: BoardSpec, grey: Image) -> Sighting | None:
    """Find a board in a grey picture; None if fewer than ``LEAST`` corners are visible, or only corners on
    one line."""
    cv2, board = opencv(), made(spec)
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    if spec.kind == "charuco":
        seen, names, _, _ = cv2.aruco.CharucoDetector(board, detectorParams=settings).detectBoard(grey)
    else:
        seen, names, _ = cv2.aruco.ArucoDetector(board.getDictionary(), settings).detectMarkers(grey)
    if names is None or len(names) == 0:
        return None
    corners, pixels = board.matchImagePoints(seen, names)
    if corners is None or len(corners) < LEAST:
        return None
    corners, pixels = np.asarray(corners, float).reshape(-1, 3), np.asarray(pixels, float).reshape(-1, 2)
    spread = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    return Sighting(corners, pixels) if spread[1] > 0.5 * spec.square else None


def other_dictionary(spec: BoardSpec, grey: Image) -> str:
    """Return the smallest dictionary of markers, other than the stated one, whose markers are in a picture; "" if there is none."""
    cv2 = opencv()
    names = (n.removeprefix("DICT_") for n in dir(cv2.aruco) if n.startswith("DICT_"))
    for name in sorted(names, key=lambda n: (int(size) if (size := n.rpartition("_")[2]).isdigit() else 10**6, n)):
        markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))
        _, seen, _ = cv2.aruco.ArucoDetector(markers).detectMarkers(grey)
        if seen is not None and len(seen) >= LEAST_MARKERS and name != spec.dictionary:
            return str(name)
    return ""

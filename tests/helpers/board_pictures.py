"""Pictures of printed boards by known cameras: corners by projection, pictures by warping the board, both with noise."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from cramlite.model import Image, Intrinsics, Pose
from cramlite.perception.calibration.board import BoardSpec, Sighting, drawn, opencv
from cramlite.perception.calibration.hand_eye import Station

PINHOLE = Intrinsics(610.0, 612.0, 322.0, 236.0, 640, 480)
IN_HAND = Pose.from_rotvec((0.01, -0.08, 0.05), (0.03, -0.02, 0.4))
"""Camera in the flange frame."""
ON_TABLE = Pose.from_rotvec((0.5, 0.1, 0.0), (0.0, 0.0, 0.3))
ON_FLANGE = Pose.from_rotvec((0.02, 0.01, 0.1), (0.1, 3.0, 0.0))
BEFORE = Pose.from_rotvec((1.1, 0.05, 0.55), tuple(np.multiply((1, -1, 1), 1.2)))
"""Fixed camera in the base frame: it looks at the arm obliquely."""


def corners(spec: BoardSpec) -> Any:
    """Inner corners of a chess board (N, 3) [m]."""
    x, y = np.meshgrid(np.arange(1, spec.columns), np.arange(1, spec.rows))
    return np.column_stack([x.ravel() * spec.square, y.ravel() * spec.square, np.zeros(x.size)])


def seen_from(rng: Any, spec: BoardSpec, tilt: float = math.radians(25), one_axis: bool = False) -> Pose:
    """Draw a pose of the board in the camera's frame, its middle near the optical axis."""
    axis = rng.normal(size=3) * (1, 1, 0.8)
    turn = [0.0, 0.0, rng.uniform(-0.6, 0.6)] if one_axis else tilt * rng.uniform(0.5, 1.2) * axis / np.linalg.norm(axis)
    middle = np.array([rng.uniform(-0.04, 0.04), rng.uniform(-0.03, 0.03), rng.uniform(0.4, 0.6)])
    turned = Pose.from_rotvec((0, 0, 0), tuple(turn))
    width, height = spec.size
    return Pose(tuple(middle - turned.rotate((width / 2, height / 2, 0))), turned.quaternion)


def flange_of(board: Pose, mount: str, camera: Pose, place: Pose) -> Pose:
    """Return the flange pose at which the camera sees the board at a pose in the camera's frame; ``place`` is the board's pose in the
    base frame, or in the flange frame if the camera is fixed."""
    return place * board.inverse() * camera.inverse() if mount == "flange" else camera * board * place.inverse()


def stations(
    seed: int, *, mount: Literal["flange", "world"] = "flange", count: int = 12, pixel: float = 0.15, robot_mm: float = 0.2,
    robot_deg: float = 0.02, one_axis: bool = False, size: float = 1.0, spec: BoardSpec | None = None,
) -> list[Station]:  # fmt: skip
    """Return simulated sightings of a board for a hand-eye calibration, with noise of corners [pixel] and of the robot's poses; ``size``
    is the ratio of the real board to that of the file."""
    rng, spec = np.random.default_rng(seed), spec or BoardSpec()
    camera = IN_HAND if mount == "flange" else BEFORE
    place = ON_TABLE if mount == "flange" else ON_FLANGE
    found = []
    for k in range(count):
        board = seen_from(rng, spec, one_axis=one_axis)
        flange = flange_of(board, mount, camera, place)
        off = Pose.from_rotvec(tuple(rng.normal(size=3) * robot_mm / 1000), tuple(rng.normal(size=3) * math.radians(robot_deg)))
        points = corners(spec)
        pixels = PINHOLE.project(board.apply(points * size)) + rng.normal(size=(len(points), 2)) * pixel
        found.append(Station(f"{k:02}.png", flange * off, Sighting(points, pixels)))
    return found


def picture(spec: BoardSpec, board: Pose, seed: int = 0, noise: float = 6.0) -> Image:
    """Return a grey picture of a board on a grey table, blurred by half a pixel, with noise; the board's frame is at its corner."""
    cv2, rng = opencv(), np.random.default_rng(seed)
    dots = 6000.0
    flat = np.pad(drawn(spec, dots), round(0.01 * dots), constant_values=255)
    k = PINHOLE
    matrix = np.array([[k.fx, 0, k.cx], [0, k.fy, k.cy], [0, 0, 1]])
    metres = np.array([[1 / dots, 0, 0.5 / dots - 0.01], [0, 1 / dots, 0.5 / dots - 0.01], [0, 0, 1]])
    onto = matrix @ np.column_stack([board.rotation[:, 0], board.rotation[:, 1], np.array(board.position)]) @ metres
    big = np.diag([4.0, 4.0, 1.0]) @ np.array([[1, 0, 0.375], [0, 1, 0.375], [0, 0, 1]]) @ onto  # 4 x 4 samples of a pixel
    drawn_big = cv2.warpPerspective(flat, big, (4 * k.width, 4 * k.height), flags=cv2.INTER_LINEAR, borderValue=120)
    small = cv2.GaussianBlur(cv2.resize(drawn_big, (k.width, k.height), interpolation=cv2.INTER_AREA).astype(float), (3, 3), 0.5)
    return np.asarray(np.clip(small + rng.normal(size=small.shape) * noise, 0, 255).astype(np.uint8))

"""Calibration of a camera: its pose and intrinsics, with error bars, from corners of a board in several pictures.

A first guess by Park and Martin (IEEE TRA 10, 1994) for the pose and Zhang (PAMI 22, 2000) for intrinsics, as OpenCV has them;
then all at once by least squares of the reprojection errors, with the robot's poses as given. Error bars are a jackknife over
pictures (CR3: Bell and McCaffrey, Survey Methodology 28, 2002): errors of corners of one picture belong together, above all
where the robot is not where it says.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from ...base.errors import UserError
from ...base.value import Value
from ...model.geometry import Pose
from ...model.view import Intrinsics
from .board import Sighting, opencv

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURNED = math.radians(5.0)
"""Least rotation of the hand about a second axis, root mean square over pairs of poses [rad]: with less, the position of the camera along
the first axis is lost in the noise."""
SCALE = 0.01
"""Relative error of a board's size that is tolerated, since printers and focal lengths are not exact."""
WORST = 5.0
"""Reprojection error [pixel] above which the pictures do not fit the robot's poses: good ones have 0.1 to 0.5 pixel."""
STRAY = 3.0
"""Multiple of the median reprojection error beyond which a picture counts as taken while something moved."""


class Station(Value, eq=False):
    """Picture of a board together with the robot's flange pose at that time.

    Args:
        name: of the picture.
        flange: of the robot, in its base frame.
        sighting: of the board.
    """

    name: str
    flange: Pose
    sighting: Sighting


class Calibration(Value, eq=False):
    """Calibrated camera: pose, intrinsics and their uncertainty.

    Args:
        mount: "flange" of a camera on the robot, "world" of a fixed one.
        camera: its optical frame in the flange frame, or in the frame of the robot's base.
        board: the board's frame in the frame of the robot's base, or in the flange frame.
        intrinsics: as given or as found.
        covariance: (6, 6) of the camera's pose, in its own frame: rotation vector [rad], position [m].
        spread: standard deviations of fx, fy, cx, cy [pixel]; zeros where they were given.
        pixels: residuals (N, 2) of each picture [pixel], by name.
        freedom: degrees of freedom of the covariance: pictures less one.
    """

    mount: str
    camera: Pose
    board: Pose
    intrinsics: Intrinsics
    covariance: Floats
    spread: tuple[float, float, float, float]
    pixels: dict[str, Floats]
    freedom: int

    @property
    def position(self) -> float:
        """Radius within which the true position is in 95 % of calibrations [m]."""
        return _radius(self.covariance[3:, 3:], self.freedom)

    @property
    def angle(self) -> float:
        """Angle within which the true orientation is in 95 % of calibrations [rad]."""
        return _radius(self.covariance[:3, :3], self.freedom)

    @property
    def error(self) -> float:
        """Root mean square of the reprojection error over all corners [pixel]."""
        return _rms(np.concatenate(list(self.pixels.values())))

    @property
    def strays(self) -> list[str]:
        """Names of the pictures whose reprojection error is much larger than that of the others."""
        each = {n: _rms(p) for n, p in self.pixels.items()}
        limit = max(STRAY * float(np.median(list(each.values()))), 0.5)
        return [n for n, e in each.items() if e > limit]


def calibrated(stations: Sequence[Station], mount: str, intrinsics: Intrinsics, given: bool) -> Calibration:
    """Calibrate a camera from pictures of a board.

    Args:
        intrinsics: as known; else only their image size counts.
        given: whether they are known.

    Raises:
        UserError: the pictures cannot tell: turns about one axis only, a board of another size, poses of other pictures.
    """
    _turned_enough(stations, mount)
    start = intrinsics if given else _intrinsics(stations, intrinsics)
    problem = _Problem(tuple(stations), mount, start, not given)
    camera, board = _guess(stations, mount, start)
    found = _solved(problem, camera, board)
    if found.error > WORST:
        raise UserError(_unrelated(stations, mount, start, found))
    _right_size(replace(problem, intrinsics=found.intrinsics), found)
    return found


def _radius(covariance: Floats, freedom: int) -> float:
    """Return the radius that contains 95 % of a normal distribution with an estimated covariance.

    The squared length is nearly F distributed (Satterthwaite, Biometrics Bulletin 2, 1946).
    """
    from scipy.stats import f

    sizes = np.linalg.eigvalsh(covariance)
    total = float(sizes.sum())
    return math.sqrt(total * float(f.ppf(0.95, total**2 / float((sizes**2).sum()), freedom)))


def _rms(pixels: Floats) -> float:
    return math.sqrt(float((pixels**2).sum(axis=1).mean()))


def _turned_enough(stations: Sequence[Station], mount: str) -> None:
    turns = [(a.flange.inverse() * b.flange).rotvec for k, a in enumerate(stations) for b in stations[:k]]
    _, sizes, axes = np.linalg.svd(np.array(turns) / math.sqrt(len(turns)))
    if sizes[1] >= TURNED:
        return
    first, second = (math.degrees(s) for s in sizes[:2])
    axis = ", ".join(f"{v:.2f}" for v in axes[0])
    how = "the hand" if mount == "flange" else "the hand with the board"
    raise UserError(
        f"The {len(stations)} pictures do not tell where the camera is: {how} turned by {first:.1f} deg about one axis ({axis} of the "
        f"flange), and by {second:.1f} deg about any other, so that the position along that axis is unknown. Tilt {how} by 15 to 40 deg "
        "about two axes."
    )


def _intrinsics(stations: Sequence[Station], size: Intrinsics) -> Intrinsics:
    """Return a camera's intrinsics by Zhang's method, without lens distortion."""
    cv2 = opencv()
    flat = cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST
    points = [s.sighting.corners.astype(np.float32) for s in stations]
    pixels = [s.sighting.pixels.astype(np.float32) for s in stations]
    _, matrix, _, _, _ = cv2.calibrateCamera(points, pixels, (size.width, size.height), None, None, flags=flat)
    try:
        return Intrinsics(matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], size.width, size.height)
    except UserError as error:
        raise UserError(f"The pictures do not tell the intrinsics: {error} Tilt the board, or state 'intrinsics'.") from error


def _seen(station: Station, intrinsics: Intrinsics) -> Pose:
    """Pose of the board in the camera's frame, from one picture."""
    cv2 = opencv()
    _, turn, shift = cv2.solvePnP(station.sighting.corners, station.sighting.pixels, _matrix(intrinsics), None, flags=cv2.SOLVEPNP_IPPE)
    return Pose.from_rotvec(tuple(shift.ravel().tolist()), tuple(turn.ravel().tolist()))


def _matrix(k: Intrinsics) -> Floats:
    return np.array([[k.fx, 0, k.cx], [0, k.fy, k.cy], [0, 0, 1]])


def _guess(stations: Sequence[Station], mount: str, intrinsics: Intrinsics) -> tuple[Pose, Pose]:
    """Return first guesses of two poses: of the camera on its mount, and of the board on the other one (flange or robot base)."""
    cv2, seen = opencv(), [_seen(s, intrinsics) for s in stations]
    flanges = [s.flange if mount == "flange" else s.flange.inverse() for s in stations]
    turn, shift = cv2.calibrateHandEye(
        [f.rotation for f in flanges], [np.array(f.position) for f in flanges],
        [p.rotation for p in seen], [np.array(p.position) for p in seen], method=cv2.CALIB_HAND_EYE_PARK,
    )  # fmt: skip
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = turn, shift.ravel()
    camera = Pose.from_matrix(whole)
    return camera, flanges[0] * camera * seen[0]


class _Problem(Value, eq=False, dict=True):
    """Least-squares problem of the reprojection errors, over small motions of camera and board, and over
    unknown intrinsics."""

    stations: tuple[Station, ...]
    mount: str
    intrinsics: Intrinsics
    open: bool
    scaled: bool = False

    def residuals(self, camera: Pose, board: Pose, x: Floats) -> Floats:
        """Return the reprojection errors of all corners (N, 2) [pixel].

        ``x`` has the motions of camera and board in their own frames, then unknown intrinsics.
        """
        k = x[12:16] if self.open else np.zeros(4)
        scale = math.exp(x[-1]) if self.scaled else 1.0
        eyes, corners, pixels, at = self._arrays
        to_eye = np.linalg.inv((camera * _motion(x[:6])).matrix) @ eyes @ (board * _motion(x[6:12])).matrix
        p = np.einsum("nij,nj->ni", to_eye[at, :3, :3], scale * corners) + to_eye[at, :3, 3]
        z = np.maximum(p[:, 2], 1e-3)
        u = self.intrinsics.fx * (1 + k[0]) * p[:, 0] / z + self.intrinsics.cx + self.intrinsics.fx * k[2]
        v = self.intrinsics.fy * (1 + k[1]) * p[:, 1] / z + self.intrinsics.cy + self.intrinsics.fy * k[3]
        return np.column_stack([u, v]) - pixels

    @cached_property
    def _arrays(self) -> tuple[Floats, Floats, Floats, Any]:
        """Data from which the reprojection errors are computed, as arrays over all pictures and corners.

        For each picture the transform (M, 4, 4) from the board's mount to the camera's mount; for each corner
        its position on the board, its pixel and the number of its picture.
        """
        flanges = [s.flange.inverse() if self.mount == "flange" else s.flange for s in self.stations]
        at = np.repeat(np.arange(len(flanges)), [len(s.sighting.pixels) for s in self.stations])
        sightings = [s.sighting for s in self.stations]
        corners, pixels = np.concatenate([s.corners for s in sightings]), np.concatenate([s.pixels for s in sightings])
        return np.array([f.matrix for f in flanges]), corners, pixels, at

    def solve(self, camera: Pose, board: Pose) -> Any:
        """Fit the poses of camera and board, and unknown intrinsics, to the pictures by least squares from
        first guesses of the poses; return SciPy's result."""
        from scipy.optimize import least_squares

        start = np.zeros(12 + 4 * self.open + self.scaled)
        return least_squares(lambda x: self.residuals(camera, board, x).ravel(), start, x_scale="jac", method="trf")

    def jackknife(self, jacobian: Floats, residuals: Floats) -> Floats:
        """Return the covariance of the solution by the jackknife: from how much it changes when each picture
        is left out."""
        ends = np.cumsum([2 * len(s.sighting.pixels) for s in self.stations])
        whole, moved = jacobian.T @ jacobian, []
        for j, r in zip(np.split(jacobian, ends[:-1]), np.split(residuals, ends[:-1]), strict=True):
            moved.append(np.linalg.lstsq(whole - j.T @ j, j.T @ r, rcond=None)[0])
        n, off = len(moved), np.array(moved)
        return np.asarray((n - 1) / n * off.T @ off)


def _motion(x: Floats) -> Pose:
    return Pose.from_rotvec(tuple(x[3:6].tolist()), tuple(x[:3].tolist()))


def _solved(problem: _Problem, camera: Pose, board: Pose) -> Calibration:
    first = problem.solve(camera, board).x
    camera, board = camera * _motion(first[:6]), board * _motion(first[6:12])
    k, off = problem.intrinsics, (first[12:16] if problem.open else np.zeros(4))
    try:
        k = replace(k, fx=k.fx * (1 + off[0]), fy=k.fy * (1 + off[1]), cx=k.cx + k.fx * off[2], cy=k.cy + k.fy * off[3])
    except UserError as error:
        raise UserError(f"The pictures do not tell the intrinsics: {error} Tilt the board, or state 'intrinsics'.") from error
    here = replace(problem, intrinsics=k)
    last = here.solve(camera, board)  # in the frames of the solution, so that its derivatives are small motions
    covariance = here.jackknife(last.jac, last.fun)
    fx, fy, cx, cy = np.sqrt(np.diag(covariance)[12:16]) * [k.fx, k.fy, k.fx, k.fy] if problem.open else np.zeros(4)
    ends = np.cumsum([len(s.sighting.pixels) for s in problem.stations])
    parts = np.split(last.fun.reshape(-1, 2), ends[:-1])
    return Calibration(
        problem.mount, camera * _motion(last.x[:6]), board * _motion(last.x[6:12]), k, covariance[:6, :6],
        (float(fx), float(fy), float(cx), float(cy)), {s.name: p for s, p in zip(problem.stations, parts, strict=True)},
        len(problem.stations) - 1,
    )  # fmt: skip


def _right_size(problem: _Problem, found: Calibration) -> None:
    """Refuse a calibration if the robot's motions show that the board's size is not the stated one."""
    scaled = replace(problem, scaled=True)
    said = scaled.solve(found.camera, found.board)
    size, bar = math.exp(said.x[-1]), math.sqrt(scaled.jackknife(said.jac, said.fun)[-1, -1])
    if abs(size - 1) <= max(SCALE, 4 * bar):
        return
    raise UserError(
        f"The board has another size than the file says: the robot's motions fit {size:.3f} times (+-{bar:.3f}) its lengths, with "
        f"which the reprojection error falls from {found.error:.2f} to {_rms(said.fun.reshape(-1, 2)):.2f} pixels. Measure a printed "
        "square (a printer may have scaled it to the page); a focal length that is off by as much looks the same."
    )


def _unrelated(stations: Sequence[Station], mount: str, intrinsics: Intrinsics, found: Calibration) -> str:
    """Return advice for pictures that do not fit the robot's poses: another ``mount``, or what to check.

    The mount is wrong if the pictures fit much better with the other one.
    """
    other = "world" if mount == "flange" else "flange"
    again = _solved(_Problem(tuple(stations), other, intrinsics, False), *_guess(stations, other, intrinsics))
    if again.error < found.error / 5:
        return (
            f"With 'mount: {mount}' corners are {found.error:.1f} pixels from where they should be, with 'mount: {other}' "
            f"{again.error:.1f}: write 'mount: {other}' (flange: the camera is on the hand; world: it is fixed and the board is in the "
            "hand)."
        )
    return (
        f"Pictures and poses do not belong together: corners are {found.error:.1f} pixels from where they should be (below 1 if they do). "
        "Check that each picture has its own pose, that poses are the flange's in the base frame and no tool's, joints in degrees or "
        "radians as said, and the robot's type."
    )

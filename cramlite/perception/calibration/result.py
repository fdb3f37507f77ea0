"""Output of a calibration: text for people, and the calibration file that a scenario's camera can name."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.errors import UserError
from ...model.geometry import Pose
from .hand_eye import Calibration
from .recording import Recording, written

if TYPE_CHECKING:
    from ...model.view import CameraOffset, Intrinsics, View
    from ...scenario.scenario import Scenario

AXES = ("right", "down", "forward")
DISTORTED = 1.0
"""Shift of pixels by lens distortion above which a warning is given [pixel]. A few badly found corners cause shifts up to this size."""


def calibration_text(found: Calibration, recording: Recording, warned: Sequence[str] = ()) -> str:
    """Return lines of text on a calibration, with error bars."""
    k, spec = found.intrinsics, recording.spec
    sizes = np.sqrt(np.diag(found.covariance))
    x, y, z = (1000 * v for v in found.camera.position)
    at = written(found.camera)
    frame = "flange frame" if found.mount == "flange" else "frame of the robot's base"
    lines = [
        f"{len(found.pixels)} pictures, {sum(map(len, found.pixels.values()))} corners of a {spec.board.kind} board"
        + (f"; no board in {len(recording.without)}: {', '.join(recording.without)}" if recording.without else ""),
        f"camera in the {frame}: [{x:.2f}, {y:.2f}, {z:.2f}] mm, roll {_deg(at.roll)}, pitch {_deg(at.pitch)}, yaw {_deg(at.yaw)}",
        f"error bars (95 %, jackknife over pictures): {1000 * found.position:.2f} mm, {_deg(found.angle)}",
        "standard deviations: "
        + ", ".join(f"{1000 * s:.2f} mm {a}" for s, a in zip(sizes[3:], AXES, strict=True))
        + "; "
        + ", ".join(f"{_deg(s)} about {a}" for s, a in zip(sizes[:3], AXES, strict=True)),
        f"intrinsics ({'given' if recording.given else 'found'}): fx {k.fx:.2f}, fy {k.fy:.2f}, cx {k.cx:.2f}, cy {k.cy:.2f} pixels"
        + ("" if recording.given else ", standard deviations " + ", ".join(f"{s:.2f}" for s in found.spread)),
        f"reprojection error: {found.error:.2f} pixels, largest {max(float(np.hypot(*p.T).max()) for p in found.pixels.values()):.2f}",
        *(f"warning: {w}" for w in warned),
    ]
    return "\n".join(lines)


def warnings(found: Calibration, recording: Recording) -> list[str]:
    """Return warnings about a calibration: pictures that do not fit, and lens distortion."""
    told = []
    if found.strays:
        each = ", ".join(f"{n} ({np.sqrt((found.pixels[n] ** 2).sum(axis=1).mean()):.2f} pixels)" for n in found.strays)
        told.append(f"these pictures fit much worse than the others: {each}; was something moving? Take them again, or leave them out.")
    bent = distortion(recording, found)
    if bent > DISTORTED:
        lens = f"the lens shifts corners by up to {bent:.1f} pixels, and cramlite's camera model has no lens distortion"
        told.append(f"{lens}; take the camera's rectified pictures.")
    return told


def distortion(recording: Recording, found: Calibration) -> float:
    """Return the largest shift of a calibration board's corner by radial lens distortion, as estimated from the
    pictures [pixel]."""
    from .board import opencv

    cv2, k = opencv(), found.intrinsics
    matrix = np.array([[k.fx, 0, k.cx], [0, k.fy, k.cy], [0, 0, 1]])
    points = [s.sighting.corners.astype(np.float32) for s in recording.stations]
    pixels = [s.sighting.pixels.astype(np.float32) for s in recording.stations]
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST
    flags |= cv2.CALIB_FIX_FOCAL_LENGTH | cv2.CALIB_FIX_PRINCIPAL_POINT
    _, _, lens, _, _ = cv2.calibrateCamera(points, pixels, (k.width, k.height), matrix, np.zeros(5), flags=flags)
    rays = (np.concatenate(pixels) - [k.cx, k.cy]) / [k.fx, k.fy]
    square = (rays**2).sum(axis=1)
    bend = lens.ravel()[0] * square + lens.ravel()[1] * square**2
    return float((np.abs(bend) * np.sqrt(square)).max() * k.fx)


def calibration_file(found: Calibration, recording: Recording) -> dict[str, Any]:
    """Return the content of a calibration file, which a scenario names under ``camera: {calibration:
    FILE}``."""
    return {
        "camera": _camera(found.mount, found.camera, found.intrinsics),
        "error_95": {"position": f"{1000 * found.position:.3f} mm", "angle": f"{math.degrees(found.angle):.4f} deg"},
        "measured": {
            "method": "least squares of reprojection errors; error bars by a jackknife over pictures",
            "pictures": len(found.pixels),
            "corners": sum(map(len, found.pixels.values())),
            "reprojection_pixels": round(found.error, 3),
            "intrinsics": "given" if recording.given else "found",
            **({} if recording.given else {"intrinsics_sd": [round(s, 3) for s in found.spread]}),
            "pose_sd": {
                "mm": [round(1000 * float(s), 4) for s in np.sqrt(np.diag(found.covariance))[3:]],
                "deg": [round(math.degrees(s), 5) for s in np.sqrt(np.diag(found.covariance))[:3]],
            },
        },
    }


def _camera(mount: str, pose: Pose, intrinsics: Intrinsics) -> dict[str, Any]:
    at = written(pose)
    return {
        "mount": mount,
        "at": {
            "position": [round(v, 6) for v in pose.position],
            **{n: f"{math.degrees(getattr(at, n)):.4f} deg" for n in ("roll", "pitch", "yaw")},
        },
        "width": intrinsics.width,
        "height": intrinsics.height,
        "intrinsics": {n: round(float(getattr(intrinsics, n)), 3) for n in ("fx", "fy", "cx", "cy")},
    }


def correction_file(scenario: Scenario, view: View, offset: CameraOffset) -> dict[str, Any]:
    """Return the content of a calibration file for a camera whose pose was corrected by fixtures in its
    picture.

    It is the scenario's camera, else a fixed one at the pose of the view.
    """
    from ...scenario.worlds import camera_of

    before, base = camera_of(scenario), scenario.spec.robot.at.pose()
    on_flange = before is not None and before.mount is not None
    pose = before.pose * offset.moved if before is not None and on_flange else base.inverse() * offset.camera
    position, angle = offset.moved.distance(Pose())
    return {
        "camera": _camera("flange" if on_flange else "world", pose, view.intrinsics),
        "error_95": {"position": f"{2000 * offset.position:.3f} mm", "angle": f"{math.degrees(2 * offset.angle):.4f} deg"},
        "measured": {
            "method": "points to surfaces of fixtures; error bars: two standard deviations",
            "off_by": {"mm": round(1000 * position, 2), "deg": round(math.degrees(angle), 3)},
            "fixtures_seen_off_mm": [round(1000 * offset.before, 2), round(1000 * offset.after, 2)],
            "open_directions": offset.open,
        },
    }


def write_calibration(path: Any, keys: Mapping[str, Any]) -> None:
    """Write a calibration file.

    Raises:
        UserError: it exists and is no such file, or it cannot be written.
    """
    import yaml

    try:
        if path.exists() and "error_95:" not in path.read_text(encoding="utf-8", errors="replace"):
            raise UserError(f"'{path}' exists and is no calibration; nothing was written. Choose another file.")
        head = "# Written by cramlite calibrate; a scenario takes it as camera: {calibration: FILE}.\n"
        path.write_text(head + yaml.safe_dump(dict(keys), sort_keys=False, default_flow_style=None), encoding="utf-8")
    except OSError as error:
        raise UserError(f"'{path}' cannot be written: {error.strerror or error}.") from error


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.3f} deg"

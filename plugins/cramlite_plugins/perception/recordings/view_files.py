"""RGB-D recordings of real cameras: images with intrinsics, and clouds, read as views.

- a folder with ``depth.png`` (16 bit, millimetres), ``color.png`` or ``rgb.png``, and ``intrinsics.json``
- an ``.npz`` with ``depth`` (metres as float, or millimetres as uint16), ``rgb``, and ``intrinsics`` (JSON text)
- a ``.ply`` or ``.pcd`` cloud in the optical frame, with ``NAME.json`` beside it; an organised PCD needs none

The JSON has fx, fy, cx, cy, width, height (or ppx, ppy, as librealsense writes them); and, where they are known,
``depth_scale`` (metres per unit of a 16 bit image) and ``camera`` (position and quaternion w, x, y, z in the world).
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import AliasChoices, BaseModel, ConfigDict, Field, ValidationError

from cramlite.model import Depth, Image, Intrinsics, Points, Pose, Value, View
from cramlite.plugin import UserError, check_file, nearest, read_arrays

from .cloud_files import Cloud, read_cloud

DEPTH, COLOUR, CAMERA = "depth.png", ("color.png", "rgb.png"), "intrinsics.json"
MOST_BYTES = 2**29
"""Largest size of a view's unpacked arrays [bytes]: the largest depth cameras give 50 MB."""
MOST_PIXELS = 2**26
"""Largest number of pixels of an image: the largest depth cameras have 2 million."""
GREY = 128
"""Grey level of points and pixels of a recording that has no colours."""
NEAR, FAR = 0.05, 30.0
"""Range of plausible median depths [m]: values outside of it are in another unit, as no depth camera measures them."""
NARROW, WIDE = np.radians(5), np.radians(150)
"""Range of plausible fields of view [rad]: with a value outside of it, the intrinsics are in another unit, or of another image."""

MISFIT = 0.5
"""Largest median distance between the pixels of an organised cloud's points and their projections by a pinhole camera [pixel]; stored
points are rounded."""


class _Pose(BaseModel):
    model_config = ConfigDict(extra="forbid")
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


class _Camera(BaseModel):
    """Intrinsics, pose and depth unit as intrinsics.json states them; other keys, which cameras write, are ignored."""

    fx: float
    fy: float
    cx: float = Field(validation_alias=AliasChoices("cx", "ppx"))
    cy: float = Field(validation_alias=AliasChoices("cy", "ppy"))
    width: int
    height: int
    depth_scale: float = Field(default=0.001, gt=0)
    camera: _Pose = _Pose()


class CameraFile(Value):
    """Camera description from JSON: intrinsics, camera pose, and metres per unit of a 16 bit depth image."""

    intrinsics: Intrinsics
    camera: Pose
    depth_scale: float


def read_view(path: Path) -> View:
    """Read a recorded view.

    Raises:
        UserError: it cannot be read, images and intrinsics do not fit each other, or there is no depth in it; says where,
            what, and what would be right.
    """
    if path.is_dir():
        return _from_images(path)
    kinds = {".npz": _from_arrays, ".ply": _from_cloud, ".pcd": _from_cloud}
    if path.suffix.lower() not in kinds:
        what = f"'{path.suffix}' is no kind of recording that can be read; {nearest(path.suffix, kinds)}; or give a folder with {DEPTH}"
        raise UserError(f"{path}: {what}.")
    if not path.is_file():
        raise UserError(f"{path}: there is no such file.")
    return kinds[path.suffix.lower()](path)


def read_camera(text: str, where: Path) -> CameraFile:
    """Parse camera intrinsics from JSON text.

    Raises:
        UserError: not JSON, a key is missing, or the numbers are no camera's.
    """
    try:
        spec = _Camera.model_validate_json(text)
    except ValidationError as error:
        problem = error.errors()[0]
        key = ".".join(map(str, problem["loc"]))
        wanted = "intrinsics are JSON with fx, fy, cx, cy, width and height"
        raise UserError(f"{where}: {f'{key!r}: ' if key else ''}{problem['msg']}; {wanted}.") from error
    try:
        intrinsics = Intrinsics(spec.fx, spec.fy, spec.cx, spec.cy, spec.width, spec.height)
        camera = Pose(spec.camera.position, spec.camera.quaternion)
    except (UserError, ValueError) as error:
        raise UserError(f"{where}: {error}") from error
    for name, size, focal in (("wide", spec.width, spec.fx), ("high", spec.height, spec.fy)):
        field = 2 * np.arctan(size / (2 * focal))
        if not NARROW < field < WIDE:
            raise UserError(
                f"{where}: the image would be {np.degrees(field):.1f} degrees {name}; a focal length of {focal:g} pixels does "
                f"not fit {size} pixels. Focal lengths are in pixels of this very image."
            )
    return CameraFile(intrinsics, camera, spec.depth_scale)


def _from_images(folder: Path) -> View:
    camera = read_camera(_text(folder / CAMERA), folder / CAMERA)
    depth = _image(folder / DEPTH)
    if depth.ndim != 2 or depth.dtype.kind not in "ui" or depth.dtype.itemsize < 2:
        raise UserError(
            f"{folder / DEPTH}: a depth image has one channel of 16 bit; this has shape {depth.shape}, {depth.dtype}. "
            "It looks like a picture of depths; save the raw values."
        )
    colour = next((folder / n for n in COLOUR if (folder / n).is_file()), None)
    rgb = _image(colour) if colour else None
    return _view(depth.astype(np.float32) * camera.depth_scale, rgb, camera, folder)


def _from_arrays(path: Path) -> View:
    arrays = read_arrays(path, MOST_BYTES)
    for key in ("depth", "intrinsics"):
        if key not in arrays:
            raise UserError(f"{path}: there is no array '{key}'; {nearest(key, arrays)}.")
    camera = read_camera(str(arrays["intrinsics"]), path)
    depth = arrays["depth"]
    scale = camera.depth_scale if depth.dtype.kind in "ui" else 1.0
    if depth.dtype.kind not in "uif":
        raise UserError(f"{path}: depth has values of type {depth.dtype}; it must be numbers.")
    return _view(depth.astype(np.float32) * scale, arrays.get("rgb", arrays.get("color")), camera, path)


def _from_cloud(path: Path) -> View:
    beside, cloud = path.with_suffix(".json"), read_cloud(path)
    if cloud.size is not None and not beside.is_file():
        return _organised_view(cloud, path)
    camera = read_camera(_text(beside), beside)
    return cloud_view(cloud, camera.intrinsics, camera.camera, path)


def _organised_view(cloud: Cloud, where: Path) -> View:
    """View of an organised cloud: the pixel of each point is known, and from points and pixels follow the
    intrinsics.

    Raises:
        UserError: no pinhole camera sees the points where they are.
    """
    assert cloud.size is not None and cloud.pixels is not None
    height, width = cloud.size
    v, u = np.divmod(cloud.pixels, width)
    focal, centre, off = zip(*(_line(cloud.points[:, k] / cloud.points[:, 2], at) for k, at in ((0, u), (1, v))), strict=True)
    if not max(off) < MISFIT:
        raise UserError(
            f"{where}: the points of this organised cloud are {max(off):.1f} pixels from where a pinhole camera would see "
            "them; save it in the optical frame (x right, y down, z forward), or put intrinsics beside it as NAME.json."
        )
    try:
        intrinsics = Intrinsics(focal[0], focal[1], centre[0], centre[1], width, height)
    except UserError as error:
        raise UserError(f"{where}: {error}") from error
    depth, rgb = np.full(cloud.size, np.nan, np.float32), np.full((*cloud.size, 3), GREY, np.uint8)
    depth[v, u] = cloud.points[:, 2]
    if cloud.colours is not None:
        rgb[v, u] = cloud.colours
    return _view(depth, rgb, CameraFile(intrinsics, Pose(), 1.0), where)


def _line(ratio: Points, at: Any) -> tuple[float, float, float]:
    """Focal length and principal point [pixel], from a line fitted to image coordinates over the ratios x /
    z; and its median misfit [pixel]."""
    if np.ptp(ratio) == 0 or not np.isfinite(ratio).all():
        return 0.0, 0.0, math.inf
    slope, start = np.polyfit(ratio, at, 1)
    return float(slope), float(start), float(np.median(np.abs(start + slope * ratio - at)))


def cloud_view(cloud: Cloud, intrinsics: Intrinsics, camera: Pose, where: Path) -> View:
    """Project a cloud in the optical frame to a depth image; of points on one pixel, the nearest counts.

    Raises:
        UserError: fewer than one point in a hundred is in front of the camera and in its image: intrinsics or frame of
            another camera.
    """
    size = (intrinsics.height, intrinsics.width)
    at = np.rint(intrinsics.project(cloud.points))
    inside = np.asarray((at >= 0) & (at < [intrinsics.width, intrinsics.height])).all(axis=1)
    if inside.mean() < 0.01:
        raise UserError(
            f"{where}: only {int(inside.sum())} of {len(at)} points fall into the image. The cloud must be in the camera's "
            "optical frame (x right, y down, z forward) [m], and the intrinsics those of this camera."
        )
    far_to_near = np.argsort(-cloud.points[inside, 2], kind="stable")
    u, v = at[inside][far_to_near].astype(int).T
    depth, rgb = np.full(size, np.nan, np.float32), np.full((*size, 3), GREY, np.uint8)
    depth[v, u] = cloud.points[inside, 2][far_to_near]
    if cloud.colours is not None:
        rgb[v, u] = cloud.colours[inside][far_to_near]
    return _view(depth, rgb, CameraFile(intrinsics, camera, 1.0), where)


def _view(depth: Depth | Points, rgb: Any, camera: CameraFile, where: Path) -> View:
    if rgb is None:
        rgb = np.full((*depth.shape, 3), GREY, np.uint8)
    if rgb.ndim == 3 and rgb.shape[2] == 4:
        rgb = rgb[..., :3]
    try:
        view = View(rgb, depth.astype(np.float32), camera.intrinsics, camera.camera)
    except UserError as error:
        raise UserError(f"{where}: {error}") from error
    if not view.valid.any():
        raise UserError(
            f"{where}: no pixel has a depth: all are zero, NaN or negative. Was the emitter off, or the lens covered?"
        )
    middle = float(np.median(view.depth[view.valid]))
    if not NEAR < middle < FAR:
        raise UserError(
            f"{where}: the median depth is {middle:g} m, which no depth camera measures; set 'depth_scale' in the "
            "intrinsics to metres per unit (0.001 for millimetres)."
        )
    return view


def _image(path: Path) -> Image | Any:
    from PIL import Image as Pictures

    try:
        if not path.exists():
            raise UserError(f"{path}: there is no such file.")
        check_file(path, MOST_BYTES)
        with warnings.catch_warnings(action="error"), Pictures.open(path, formats=("PNG",)) as picture:
            if math.prod(picture.size) > MOST_PIXELS:
                raise ValueError(f"it has {picture.width} x {picture.height} pixels, and at most {MOST_PIXELS} are read")
            return np.asarray(picture)
    except (Pictures.DecompressionBombError, Pictures.DecompressionBombWarning) as error:
        raise UserError(f"{path}: cannot be read as an image: {error}.") from error
    except (OSError, SyntaxError, ValueError) as error:
        raise UserError(f"{path}: cannot be read as an image: {error}.") from error


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(
            f"{path}: cannot be read: {error}; it holds the camera's fx, fy, cx, cy, width and height."
        ) from error

"""Camera views, the only data that perception experts get: the RGB-D image of a depth camera, its intrinsics
and its pose."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from msgspec.structs import force_setattr
from numpy.typing import NDArray

from ..base.errors import UserError
from ..base.value import Value
from .geometry import Pose

Image = NDArray[np.uint8]
"""Colour image, (height, width, 3) uint8, RGB."""
Depth = NDArray[np.float32]
"""Depth image, (height, width) float32 along the optical axis [m]; NaN where nothing was measured."""
Mask = NDArray[np.bool_]
"""Pixel mask, (height, width) bool."""
Points = NDArray[np.float64]
"""Points, (..., 3) float64 [m], or image coordinates, (..., 2) [pixel]."""


class Intrinsics(Value, dict=True):
    """Intrinsics of a pinhole camera without distortion.

    The centre of the pixel (column u, row v) is at image coordinates (u, v); a point (x, y, z) of the optical frame is
    seen at (cx + fx x / z, cy + fy y / z). This is the convention of OpenCV, ROS and librealsense.

    Args:
        fx, fy: focal lengths [pixel].
        cx, cy: principal point [pixel].
        width, height: of the image [pixel].

    Raises:
        UserError: a focal length or size is not positive, or the principal point is outside the image.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        numbers = (self.fx, self.fy, self.cx, self.cy, self.width, self.height)
        if not all(math.isfinite(n) for n in numbers) or min(self.fx, self.fy, self.width, self.height) <= 0:
            raise UserError(f"No camera has the intrinsics {self}; focal lengths and size must be positive.")
        if not (0 <= self.cx <= self.width and 0 <= self.cy <= self.height):
            raise UserError(
                f"The principal point ({self.cx:g}, {self.cy:g}) lies outside the image of {self.width} x {self.height} "
                "pixels; are these the intrinsics of another resolution?"
            )

    @cached_property
    def rays(self) -> Points:
        """(height, width, 3) rays through the pixels: points of the optical frame at z = 1, to be multiplied with depth."""
        x = (np.arange(self.width) - self.cx) / self.fx
        y = (np.arange(self.height) - self.cy) / self.fy
        rays = np.ones((self.height, self.width, 3))
        rays[..., 0], rays[..., 1] = x, y[:, None]
        return rays

    def thinned(self, step: int) -> Intrinsics:
        """Return the intrinsics of a picture of which only every ``step``-th pixel of every ``step``-th row is kept."""
        fx, fy, cx, cy = (v / step for v in (self.fx, self.fy, self.cx, self.cy))
        return Intrinsics(fx, fy, cx, cy, -(-self.width // step), -(-self.height // step))

    def project(self, points: Points) -> Points:
        """Project points (..., 3) [m] of the optical frame to image coordinates (..., 2) [pixel]; NaN for points
        not in front of the camera."""
        z = np.where(points[..., 2] > 0, points[..., 2], np.nan)
        return np.stack([self.cx + self.fx * points[..., 0] / z, self.cy + self.fy * points[..., 1] / z], axis=-1)


    @property
    def min_half_field_of_view(self) -> float:
        """Half the smallest field of view [rad]: a point is certainly in the image if its ray is at a smaller angle
        to the optical axis."""
        beside, below = min(self.cx, self.width - self.cx), min(self.cy, self.height - self.cy)
        return min(math.atan2(beside, self.fx), math.atan2(below, self.fy))

    @classmethod
    def from_field_of_view(cls, width: int, height: int, horizontal_fov: float | None = None) -> Intrinsics:
        """Return the intrinsics of a camera with square pixels and the principal point in the middle of the image.

        Args:
            width, height: of the image [pixel].
            horizontal_fov: horizontal field of view [rad]; None for that of a D435.

        Raises:
            UserError: the field of view is not between 0 and pi.
        """
        if horizontal_fov is not None and not 0 < horizontal_fov < math.pi:
            raise UserError(f"no pinhole camera sees {math.degrees(horizontal_fov):.0f} degrees; it must be between 0 and 180")
        focal = D435.fx * width / D435.width
        if horizontal_fov is not None:
            focal = width / 2 / math.tan(horizontal_fov / 2)
        return cls(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)


D435 = Intrinsics(385.0, 385.0, 319.5, 239.5, 640, 480)
"""An Intel RealSense D435's depth stream at 640 x 480, colour registered to it: 79 x 64 degrees (data sheet 337029,
"Depth field of view"; focal length as measured, docs/explanation/perception.md)."""


class View(Value, eq=False, dict=True):
    """RGB-D image of a depth camera, colour and depth registered to each other; frozen, its arrays read-only.

    Args:
        rgb: (height, width, 3) uint8.
        depth: (height, width) float32, along the optical axis [m]; NaN where nothing was measured. Zero, negative and
            infinite values, with which cameras say the same, become NaN.
        intrinsics: of both images.
        camera: the optical frame in the world: x right, y down, z forward.
        stamp: when it was taken [s].

    Raises:
        UserError: an image is not of the intrinsics' size, or of another type.
    """

    rgb: Image
    depth: Depth
    intrinsics: Intrinsics
    camera: Pose = Pose()
    stamp: float = 0.0

    def __post_init__(self) -> None:
        size = (self.intrinsics.height, self.intrinsics.width)
        rgb, depth = np.array(self.rgb), np.array(self.depth, dtype=np.float32)
        for name, image, shape in (("colour", rgb, (*size, 3)), ("depth", depth, size)):
            if image.shape != shape:
                raise UserError(
                    f"The {name} image has the shape {image.shape}, but the intrinsics are of {size[1]} x {size[0]} "
                    f"pixels, shape {shape}; take images and intrinsics of one stream."
                )
        if rgb.dtype != np.uint8:
            raise UserError(f"The colour image has values of type {rgb.dtype}; it must be uint8, 0 to 255.")
        depth[~(np.isfinite(depth) & (depth > 0))] = np.nan
        rgb.flags.writeable = depth.flags.writeable = False
        force_setattr(self, "rgb", rgb)
        force_setattr(self, "depth", depth)

    @cached_property
    def valid(self) -> Mask:
        """(height, width) mask of the pixels where depth was measured."""
        return ~np.isnan(self.depth)

    @cached_property
    def cloud(self) -> Points:
        """Organised point cloud (height, width, 3) in the optical frame [m]; NaN where the depth image is
        NaN."""
        return self.intrinsics.rays * self.depth[..., None]

    @cached_property
    def world_cloud(self) -> Points:
        """Organised point cloud (height, width, 3) in the world frame [m]; NaN where the depth image is NaN."""
        return self.camera.apply(self.cloud)

    def thinned(self, step: int) -> View:
        """Return the view with every ``step``-th pixel of every ``step``-th row."""
        few = self.intrinsics.thinned(step)
        return View(self.rgb[::step, ::step], self.depth[::step, ::step], few, self.camera, self.stamp)

    def points(self, mask: Mask | None = None) -> Points:
        """Return the (N, 3) measured points of a mask or of the whole image, row by row, optical frame [m].

        Raises:
            UserError: the mask is not of the image's size.
        """
        chosen = self._measured(mask)
        return np.asarray(self.intrinsics.rays[chosen] * self.depth[chosen][:, None])

    def _measured(self, mask: Mask | None) -> Mask:
        if mask is None:
            return self.valid
        if mask.shape != self.depth.shape:
            raise UserError(
                f"The mask has the shape {mask.shape}, the image {self.depth.shape}; they must be the same."
            )
        return np.asarray(self.valid & mask)


class CameraOffset(Value):
    """Offset of a camera from its believed pose, estimated from the fixtures and the robot in its picture.

    Args:
        camera: where it is, optical frame in the world.
        moved: from where it is believed, in its own frame.
        position: standard deviation of its position [m].
        angle: standard deviation of its orientation [rad].
        before, after: median distances of the points from their surfaces [m].
        shift: of the points on surfaces, root of the mean square [m].
        off: whether that is more than errors of depth explain, and than programs are proven for.
        open: directions that the surfaces do not tell, of six.
    """

    camera: Pose
    moved: Pose
    position: float
    angle: float
    before: float
    after: float
    shift: float
    off: bool
    open: int

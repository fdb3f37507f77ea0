"""Rendering without a display or OpenGL: one ray a pixel through MuJoCo's ray caster, Lambert shading."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Pose, Value, Vector3

from ..model.index import Data, Model

Image = NDArray[np.uint8]
SKY_TOP, SKY_LOW = np.array([0.93, 0.95, 0.98]), np.array([0.99, 0.99, 0.99])
LIGHT = np.array([-0.45, -0.55, 0.85]) / np.linalg.norm([-0.45, -0.55, 0.85])
AMBIENT, FILL = 0.42, 0.16
STILL, MOVING = 0, 1
"""Groups of the geoms that never move, and of those that can."""
NEAR = 0.01
"""Depth before the camera from which on the outline of a geom is computed [m]."""
CORNERS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
"""Of a box of half sizes 1."""


class Camera(Value):
    """A pinhole camera.

    Args:
        eye, target: where it is and what it looks at, world frame [m].
        vertical_fov: vertical field of view [rad].
    """

    eye: Vector3 = (-0.35, -1.55, 1.10)
    target: Vector3 = (0.40, -0.10, 0.25)
    vertical_fov: float = math.radians(42)

    @property
    def pose(self) -> Pose:
        """Return the optical frame in the world: x right, y down, z forward."""
        forward = np.subtract(self.target, self.eye)
        right = np.cross(forward, (0.0, 0.0, 1.0))
        return Pose.from_axes(self.eye, forward, right if np.linalg.norm(right) > 1e-9 else (1.0, 0.0, 0.0))


def render(
    model: Model, data: Data, camera: Camera | None = None, width: int = 480, height: int = 360, shadows: bool = False
) -> Image:
    """Render a MuJoCo state, whose kinematics must be up to date, as an image (height, width, 3).

    Args:
        shadows: cast a second ray from each point to the light; about twice the time.
    """
    camera = camera or Camera()
    directions = rays_of(camera, width, height)
    eye = np.asarray(camera.eye, dtype=float)
    geom, distance, normal = cast(model, data, eye, directions)
    lit = np.ones(len(directions))
    if shadows:
        hit = geom >= 0
        points = eye + directions[hit] * distance[hit, None] + normal[hit] * 1e-4
        lit[hit] = np.where(_shaded(model, data, points), 0.25, 1.0)
    return (shade(model, geom, normal, directions, lit) * 255).astype(np.uint8).reshape(height, width, 3)


class Backdrop(Value):
    """What a camera sees of the geoms that never move, by pixel: distances (N,) [m], infinite for none, and colours (N, 3), 0 to 1."""

    camera: Camera
    size: tuple[int, int]
    directions: Floats
    distance: Floats
    colour: Floats


def part_still(model: Model) -> None:
    """Sort a model's geoms into two groups, by which rays tell them apart: ``MOVING`` those that can move, ``STILL`` the others."""
    moves = (model.body_weldid != 0) | (model.body_mocapid >= 0)
    model.geom_group[:] = np.where(moves[model.geom_bodyid], MOVING, STILL)


def backdrop(model: Model, data: Data, camera: Camera, size: tuple[int, int]) -> Backdrop:
    """Render the geoms that never move, for all pictures of one camera (``render_before``).

    Args:
        model: with groups (``part_still``).
        size: (width, height) [pixel].
    """
    directions = rays_of(camera, *size)
    geom, distance, normal = cast(model, data, np.asarray(camera.eye), directions, only(STILL))
    colour = shade(model, geom, normal, directions)
    return Backdrop(camera, size, directions, np.where(geom >= 0, distance, np.inf), colour)


def render_before(behind: Backdrop, model: Model, data: Data) -> Image:
    """Render a MuJoCo state as ``render`` does, with rays for the pixels alone on which geoms that can move may be seen."""
    width, height = behind.size
    pixels = np.flatnonzero(_where_moving(model, data, behind.camera, behind.size))
    directions, colour = behind.directions[pixels], behind.colour.copy()
    geom, distance, normal = cast(model, data, np.asarray(behind.camera.eye), directions, only(MOVING))
    front = (geom >= 0) & (distance < behind.distance[pixels])
    colour[pixels[front]] = shade(model, geom[front], normal[front], directions[front])
    return (colour * 255).astype(np.uint8).reshape(height, width, 3)


def only(group: int) -> NDArray[np.uint8]:
    """Return the ``groups`` of ``cast`` for rays that hit one group of geoms alone."""
    return np.asarray(np.arange(mujoco.mjNGROUP) == group, dtype=np.uint8)


def _where_moving(model: Model, data: Data, camera: Camera, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Flags (height, width) of the pixels on which geoms that can move may be seen."""
    focal = size[1] / 2 / math.tan(camera.vertical_fov / 2)
    frame = np.asarray(camera.eye), camera.pose.rotation
    return where_seen(model, data, np.flatnonzero(model.geom_group == MOVING), frame, ((focal, focal), np.array(size) / 2), size)


def where_seen(
    model: Model, data: Data, geoms: Any, frame: tuple[Floats, Floats], optics: tuple[Any, Any], size: tuple[int, int]
) -> NDArray[np.bool_]:
    """Return flags (height, width) of the pixels in the outlines, as rectangles, of the boxes around some geoms.

    All pixels where such a box is endless or reaches behind the camera.

    Args:
        frame: of the camera in the world, position (3,) and rotation (3, 3); x right, y down, z forward.
        optics: focal lengths (2,) and principal point (2,) [pixel], from the picture's corner.
        size: (width, height) of the picture [pixel].
    """
    shown = np.zeros(size[::-1], dtype=bool)
    boxes = model.geom_aabb[geoms].reshape(-1, 2, 3)
    corners = (boxes[:, :1] + CORNERS * boxes[:, 1:]) @ data.geom_xmat[geoms].reshape(-1, 3, 3).transpose(0, 2, 1)
    seen = (corners + data.geom_xpos[geoms, None] - frame[0]) @ frame[1]
    if np.any(seen[..., 2] <= NEAR) or np.any(model.geom_rbound[geoms] <= 0):
        return ~shown
    places = (optics[0] * seen[..., :2] / seen[..., 2:] + optics[1]).clip(0, size)
    first, last = np.floor(places.min(axis=1)).astype(int), np.ceil(places.max(axis=1)).astype(int)
    for (left, top), (right, bottom) in zip(first.tolist(), last.tolist(), strict=True):
        shown[top:bottom, left:right] = True
    return shown


def rays_of(camera: Camera, width: int, height: int) -> Floats:
    """Return the directions (height * width, 3) of a camera's pixels, row by row; unit length, world frame."""
    return camera.pose.rotate(_rays(width, height, camera.vertical_fov))


def shade(
    model: Model, geom: NDArray[np.int32], normal: Floats, directions: Floats, lit: Floats | float = 1.0,
    own: tuple[NDArray[np.bool_], Floats] | None = None,
) -> Floats:
    """Compute the colour (N, 3), 0 to 1, that rays see: each geom's own under one light, the sky where there is none.

    Args:
        geom, normal: as ``cast`` gives them for the ``directions``.
        lit: share of the light that reaches each point.
        own: where a texture is seen (N,), and its colours there (N, 3).
    """
    colour = _sky(directions)
    hit = geom >= 0
    diffuse = (np.clip(normal @ LIGHT, 0.0, 1.0) * lit)[hit]
    facing = np.abs(np.einsum("ij,ij->i", normal[hit], directions[hit]))
    light = AMBIENT + FILL * facing + (1 - AMBIENT - FILL) * diffuse
    plain = model.geom_rgba[geom[hit], :3]
    if own is not None:
        plain = np.where(own[0][hit, None], own[1][hit], plain)
    colour[hit] = plain * light[:, None]
    return np.asarray(np.clip(colour, 0, 1) ** (1 / 1.15))


def cast(
    model: Model, data: Data, eye: Floats, directions: Floats, groups: NDArray[np.uint8] | None = None
) -> tuple[NDArray[np.int32], Floats, Floats]:
    """Cast rays from one point, and find the geom that each ray hits first.

    Args:
        eye: (3,) and directions: (N, 3), unit length, world frame.
        groups: of each group of geoms (6,) 1 where rays hit it, else 0; None for all.

    Returns:
        Geom ids (N,), -1 where nothing is hit; distances (N,) [m]; surface normals (N, 3).
    """
    count = len(directions)
    geom, distance, normal = np.full(count, -1, np.int32), np.zeros(count), np.zeros(3 * count)
    flat = np.ascontiguousarray(directions).reshape(-1)
    mujoco.mj_multiRay(model, data, eye, flat, groups, True, -1, geom, distance, normal, count, 20.0)
    return geom, distance, normal.reshape(-1, 3)


def _shaded(model: Model, data: Data, points: Floats) -> NDArray[np.bool_]:
    geom = np.zeros(1, np.int32)
    return np.array([mujoco.mj_ray(model, data, p, LIGHT, None, True, -1, geom) >= 0 for p in points])


def _sky(directions: Floats) -> Floats:
    share = np.clip(directions[:, 2:3] * 2 + 0.5, 0, 1)
    return SKY_LOW * (1 - share) + SKY_TOP * share


@lru_cache(maxsize=4)
def _rays(width: int, height: int, vertical_fov: float) -> Floats:
    """Unit directions (height * width, 3) in the camera frame, row by row."""
    scale = math.tan(vertical_fov / 2) / (height / 2)
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    rays = np.stack([x * scale, y * scale, np.ones_like(x)], axis=-1).reshape(-1, 3)
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

"""A depth camera without OpenGL: one ray a pixel through MuJoCo's ray caster, with a stereo camera's noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cramlite.geometry import Pose
from cramlite.view import D435, Intrinsics, View

from ..simulation.index import Data, Model
from ..simulation.render import cast, shade
from .noise import Noise, noisy_colour, noisy_depth

InstanceIds = NDArray[np.int32]


def render(
    model: Model,
    data: Data,
    camera: Pose,
    intrinsics: Intrinsics = D435,
    noise: Noise | None = Noise(),  # noqa: B008 - frozen
    seed: int = 0,
    stamp: float = 0.0,
) -> tuple[View, InstanceIds]:
    """What a camera sees of a state; needs kinematics.

    Args:
        camera: the optical frame in the world: x right, y down, z forward.
        noise: None gives exact depths and colours.
        seed: of the noise.

    Returns:
        The view, all that an expert may be given; and, for tests and benchmarks only, the id of the body that each
        pixel sees, (height, width), -1 where there is nothing.
    """
    rays = intrinsics.rays.reshape(-1, 3)
    lengths = np.linalg.norm(rays, axis=1)
    directions = camera.turn(rays / lengths[:, None])
    geom, distance, normal = cast(model, data, np.asarray(camera.position), directions)
    size = (intrinsics.height, intrinsics.width)
    depth = np.where(geom >= 0, distance / lengths, np.inf).reshape(size)
    rgb = shade(model, geom, normal, directions).reshape(*size, 3) * 255.0
    if noise is not None:
        rng = np.random.default_rng([seed, 4351])
        cosine = np.abs(np.einsum("ij,ij->i", normal, directions)).reshape(size)
        depth = noisy_depth(depth, cosine, intrinsics, noise, rng)
        rgb = noisy_colour(rgb, noise, rng)
    ids = np.where(geom >= 0, model.geom_bodyid[geom], -1).astype(np.int32).reshape(size)
    pixels = np.clip(np.rint(rgb), 0, 255).astype(np.uint8)
    return View(pixels, depth.astype(np.float32), intrinsics, camera, stamp), ids


def looking_at(eye: tuple[float, float, float], target: tuple[float, float, float]) -> Pose:
    """The optical frame of a camera at ``eye`` [m] that looks at ``target``, its image upright."""
    forward = np.subtract(target, eye)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    return Pose.from_axes(eye, forward, right if np.linalg.norm(right) > 1e-9 else (1.0, 0.0, 0.0))

"""A depth camera without OpenGL: one ray a pixel through MuJoCo's ray caster, with a stereo camera's noise."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from cramlite.model import D435, Camera, Floats, Intrinsics, Pose, Robot, View, World
from cramlite.plugin import UserError

from ..model.compile import compile_world
from ..model.index import Data, Model, site_pose
from .noise import Noise, noisy_colour, noisy_depth
from .ray_tracer import cast, shade, where_seen
from .skins import Hits, Skins, skins_of

InstanceIds = NDArray[np.int32]


def render(
    model: Model,
    data: Data,
    camera: Pose,
    intrinsics: Intrinsics = D435,
    noise: Noise | None = Noise(),  # noqa: B008 - frozen
    seed: int = 0,
    stamp: float = 0.0,
    skins: Skins | None = None,
) -> tuple[View, InstanceIds]:
    """Render a camera's view of a MuJoCo state, whose kinematics must be up to date: colour, depth, and the body at
    each pixel.

    Args:
        camera: the optical frame in the world: x right, y down, z forward.
        noise: None gives exact depths and colours.
        seed: of the noise.
        skins: visual meshes of textured things, which are seen in the place of their collision shapes.

    Returns:
        The view, all that an expert may be given; and, for tests and benchmarks only, the id of the body that each
        pixel sees, (height, width), -1 where there is nothing.
    """
    rays = intrinsics.rays.reshape(-1, 3)
    lengths = np.linalg.norm(rays, axis=1)
    directions = camera.rotate(rays / lengths[:, None])
    eye = np.asarray(camera.position)
    if skins is None:
        geom, distance, normal = _met(model, data, camera, intrinsics, directions)
        own = None
    else:
        (geom, distance, normal), which, colours = skins.met(model, data, eye, directions)
        own = (which >= 0, colours)
    size = (intrinsics.height, intrinsics.width)
    depth = np.where(geom >= 0, distance / lengths, np.inf).reshape(size)
    rgb = shade(model, geom, normal, directions, own=own).reshape(*size, 3) * 255.0
    if noise is not None:
        rng = np.random.default_rng([seed, 4351])
        cosine = np.abs(np.einsum("ij,ij->i", normal, directions)).reshape(size)
        depth = noisy_depth(depth, cosine, intrinsics, noise, rng)
        rgb = noisy_colour(rgb, noise, rng)
    ids = np.where(geom >= 0, model.geom_bodyid[geom], -1).astype(np.int32).reshape(size)
    pixels = np.clip(np.rint(rgb), 0, 255).astype(np.uint8)
    return View(pixels, depth.astype(np.float32), intrinsics, camera, stamp), ids


def _met(model: Model, data: Data, camera: Pose, intrinsics: Intrinsics, directions: Floats) -> Hits:
    """Cast the rays of those pixels alone on which geoms may be seen."""
    i, eye = intrinsics, np.asarray(camera.position)
    optics, size = (np.array((i.fx, i.fy)), np.array((i.cx, i.cy)) + 0.5), (i.width, i.height)
    pixels = np.flatnonzero(where_seen(model, data, np.arange(model.ngeom), (eye, camera.rotation), optics, size))
    geom, distance, normal = np.full(len(directions), -1, np.int32), np.zeros(len(directions)), np.zeros(directions.shape)
    geom[pixels], distance[pixels], normal[pixels] = cast(model, data, eye, directions[pixels])
    return geom, distance, normal


def look(world: World, robots: Mapping[str, Robot], camera: Camera, *, seed: int) -> View:
    """Render a camera's view of a world at its start, robots as they look.

    For a camera on a flange the arm is at the joint positions that the camera states.

    Raises:
        UserError: the joints are not the robot's.
    """
    from .noise import Noise

    compiled = compile_world(world, {name: replace(r, mjcf=r.looks) if r.looks else r for name, r in robots.items()})
    data, pose = compiled.data(), camera.pose
    if camera.mount is not None:
        index = compiled.robots[camera.mount]
        if len(camera.joints) != len(index.joints):
            count = f"{len(camera.joints)} joint positions, and robot '{camera.mount}' has {len(index.joints)} joints"
            raise UserError(f"The camera on the flange needs one position for each joint: there are {count}")
        data.qpos[list(index.joints)] = camera.joints
        mujoco.mj_forward(compiled.model, data)
        pose = site_pose(data, index.flange) * camera.pose
    noise = Noise().times(camera.noise) if camera.noise else None
    skins = skins_of(compiled.world.things, compiled.things)
    view, _ = render(compiled.model, data, pose, camera.intrinsics, noise, seed, skins=skins)
    return view

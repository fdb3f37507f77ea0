"""What a camera of a world sees before anything moves."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco

from cramlite.errors import UserError
from cramlite.robots import Robot
from cramlite.view import View
from cramlite.world import Camera, World

from .compile import compile_world
from .index import site_pose


def look(world: World, robots: Mapping[str, Robot], camera: Camera, *, seed: int) -> View:
    """A view, with a D435's noise if the camera has any; a camera on a flange looks from the joints that it names.

    Raises:
        UserError: the joints are not the robot's.
    """
    from cramlite_plugins.perception.camera import render
    from cramlite_plugins.perception.noise import Noise

    compiled = compile_world(world, robots)
    data, pose = compiled.data(), camera.pose
    if camera.mount is not None:
        index = compiled.robots[camera.mount]
        if len(camera.joints) != len(index.joints):
            count = f"{len(camera.joints)} joint positions, robot '{camera.mount}' has {len(index.joints)} joints"
            raise UserError(f"The camera on the flange looks from {count}")
        data.qpos[list(index.joints)] = camera.joints
        mujoco.mj_forward(compiled.model, data)
        pose = site_pose(data, index.flange) * camera.pose
    noise = Noise() if camera.noise else None
    view, _ = render(compiled.model, data, pose, camera.intrinsics, noise, seed)
    return view

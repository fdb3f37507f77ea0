"""The robot's own body in its camera's picture: the depth at which it is expected."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from ..model.view import Depth, Intrinsics
from ..model.world.world import Camera, World

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge

SLIM = 0.02
"""Distance by which a robot is wider than its model [m]: in ten pictures its points were seen up to 19 mm beside it."""


def own_depth(world: World, camera: Camera, knowledge: Knowledge) -> Depth:
    """Return the depth at which a camera is expected to see the robots of a world, also beside them, where their models are too slim
    [m]; not finite elsewhere."""
    alone, ideal = replace(world, things=()), replace(camera, noise=0.0)
    own = knowledge.simulator.look(alone, knowledge.robots_of(alone), ideal, seed=0).depth
    return _widened(own, camera.intrinsics)


def _widened(own: Depth, intrinsics: Intrinsics) -> Depth:
    from scipy import ndimage

    seen = np.isfinite(own)
    if not seen.any():
        return own
    away, nearest = ndimage.distance_transform_edt(~seen, return_indices=True)
    beside: Depth = own[tuple(nearest)]
    return np.where(away * beside < SLIM * intrinsics.fx, beside, own)

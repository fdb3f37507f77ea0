"""The robot's own body in its camera's picture: the depth at which it is expected."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..model.view import Depth
from ..model.world.world import Camera, World

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge


def own_depth(world: World, camera: Camera, knowledge: Knowledge) -> Depth:
    """Return the depth at which a camera is expected to see the robots of a world [m]; not finite elsewhere."""
    alone, ideal = replace(world, things=()), replace(camera, noise=0.0)
    return knowledge.simulator.look(alone, knowledge.robots_of(alone), ideal, seed=0).depth

"""Pixels of a picture that neither the believed world nor an earlier picture explains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..model.view import Depth, Intrinsics, Mask, View
from ..model.world.world import Camera, World
from .own_body import own_depth

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge

STEP = 4
"""Pixels of the picture, along each side, for each one that is compared."""
OFF = 0.02
"""Least difference of depth that counts, at up to a metre [m]: errors of poses, of shapes and of depth are smaller. Beyond, it grows with
the square of the depth, as a stereo camera's errors do."""
BESIDE = 3
"""Compared pixels around the robot's predicted body that may show it: encoders and the camera's pose have errors."""
SURE = 1
"""Compared pixels by which a patch is eroded: what is left is no edge of a thing."""
FEW = 30
"""Least number of the robot's pixels that tell whether the camera is where it was."""


def thinned(view: View) -> View:
    """Return a view with every ``STEP``-th pixel of every ``STEP``-th row."""
    i = view.intrinsics
    size = -(-i.width // STEP), -(-i.height // STEP)
    few = Intrinsics(i.fx / STEP, i.fy / STEP, i.cx / STEP, i.cy / STEP, *size)
    return View(view.rgb[::STEP, ::STEP], view.depth[::STEP, ::STEP], few, view.camera, view.stamp)


def share_of_robot(view: View, world: World, knowledge: Knowledge) -> float:
    """Return the share of the robot's predicted pixels that show it in a thinned view, or something before it; 1 if there are few."""
    from scipy.ndimage import binary_erosion

    own = own_depth(world, Camera(view.camera, intrinsics=view.intrinsics), knowledge)
    inner = binary_erosion(np.isfinite(own), iterations=SURE) & view.valid
    return float((view.depth[inner] < own[inner] + OFF).mean()) if inner.sum() >= FEW else 1.0


def without_robot(view: View, world: World, knowledge: Knowledge) -> Depth:
    """Return the depth image of a thinned view, NaN on and beside the robots of a world."""
    from scipy.ndimage import binary_dilation

    own = np.isfinite(own_depth(world, Camera(view.camera, intrinsics=view.intrinsics), knowledge))
    return np.where(binary_dilation(own, iterations=BESIDE), np.nan, view.depth)


def unexpected(view: View, believed: World, before: Depth, knowledge: Knowledge) -> Mask:
    """Mask the pixels of a thinned view that are neither as the believed world predicts them nor as an earlier picture shows them.

    Args:
        believed: world with the arm as it stands, and things where they should be.
        before: thinned depth image from the same place, NaN where it tells nothing [m].
    """
    depth = without_robot(view, believed, knowledge)
    ideal = Camera(view.camera, intrinsics=view.intrinsics, noise=0.0)
    predicted = knowledge.simulator.look(believed, knowledge.robots_of(believed), ideal, seed=0).depth
    with np.errstate(invalid="ignore"):
        return _patches(_off(depth, before) & (_off(depth, predicted) | np.isnan(predicted)))


def differ(one: View, other: View) -> bool:
    """Return whether two thinned views from the same place differ in more than the edges of things: something moves."""
    with np.errstate(invalid="ignore"):
        return bool(_patches(_off(one.depth, other.depth)).any())


def _off(depth: Depth, other: Depth) -> Mask:
    """Mask the pixels at which two depth images differ [m]; none where one of them tells nothing."""
    found: Mask = np.abs(depth - other) > OFF * np.maximum(1.0, depth) ** 2
    return found


def _patches(off: Mask) -> Mask:
    """Mask the pixels of those patches of a mask that are more than edges."""
    from scipy.ndimage import binary_erosion, binary_propagation

    found: Mask = binary_propagation(binary_erosion(off, np.ones((3, 3)), iterations=SURE), mask=off)
    return found

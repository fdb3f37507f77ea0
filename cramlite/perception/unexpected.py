"""Pixels of a picture that neither the believed world nor an earlier picture explains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from ..model.view import Depth, Mask, View
from ..model.world.world import Camera, World

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge

STEP = 4
"""Pixels of the picture, along each side, for each one that is compared."""
OFF = 0.03
"""Least difference between a measured and a predicted depth that counts, at up to a metre [m]: errors of poses, of shapes and of depth are
smaller, and so is that of a table whose height is off by 12 mm, seen at 30 deg."""
CHANGED = 0.012
"""Least difference between two measured depths that counts, at up to a metre [m]: four times the error of a difference. A plate of 20 mm
on a table makes twice that. Beyond a metre both limits grow with the square of the depth, as a stereo camera's errors do."""
SAME = 0.002
"""Largest difference between predicted depths that are the same [m]."""
BESIDE = 3
"""Compared pixels around the robot's predicted body that may show it: encoders and the camera's pose have errors."""
SURE = 1
"""Compared pixels by which a patch is eroded, so that edges of things leave none."""
FEW = 30
"""Least number of the robot's pixels that tell whether the camera is where it was."""


def compared(view: View) -> View:
    """Return the pixels of a view that are compared."""
    return view.thinned(STEP)


def predicted(view: View, world: World, knowledge: Knowledge, held: str = "") -> tuple[Depth, Depth]:
    """Return the depth images that a view should be in a believed world, and of the robots with their payload alone; infinite where nothing
    is [m].

    Args:
        world: with the arm as it stands, and things where they should be.
        held: name of the payload; "" for none.
    """
    ideal = Camera(view.camera, intrinsics=view.intrinsics, noise=0.0)
    alone = replace(world, things=tuple(t for t in world.things if t.name == held))
    whole, own = (knowledge.simulator.look(w, knowledge.robots_of(w), ideal, seed=0).depth for w in (world, alone))
    return np.where(np.isnan(whole), np.inf, whole), np.where(np.isnan(own), np.inf, own)


def share_of_robot(view: View, own: Depth) -> float:
    """Return the share of the robot's predicted pixels that show it in a view, or something before it; 1 if there are few."""
    from scipy.ndimage import binary_erosion

    inner = binary_erosion(np.isfinite(own), iterations=SURE) & view.valid
    return float((view.depth[inner] < own[inner] + OFF).mean()) if inner.sum() >= FEW else 1.0


def without_robot(view: View, own: Depth) -> Depth:
    """Return the depth image of a view, NaN on and beside the robot's predicted pixels."""
    from scipy.ndimage import binary_dilation

    return np.where(binary_dilation(np.isfinite(own), iterations=BESIDE), np.nan, view.depth)


def unexpected(depth: Depth, believed: Depth, before: Depth, then: Depth) -> Mask:
    """Mask the pixels of a depth image that have changed and should not, and those that should have and are not as predicted.

    Args:
        depth: NaN where it tells nothing [m].
        believed: as predicted.
        before: earlier, from the same place.
        then: as predicted for that.
    """
    with np.errstate(invalid="ignore"):
        other = _off(believed, then, SAME) & ~np.isnan(before)
        return _patches(np.where(other, _off(depth, believed, OFF), _off(depth, before, CHANGED)))


def differ(one: View, other: View) -> bool:
    """Return whether two views from the same place differ in more than the edges of things: something moves."""
    with np.errstate(invalid="ignore"):
        return bool(_patches(_off(one.depth, other.depth, CHANGED)).any())


def _off(depth: Depth, other: Depth, most: float) -> Mask:
    """Mask the pixels at which two depth images differ by more than a distance [m]; none where one of them tells nothing."""
    found: Mask = np.abs(depth - other) > most * np.maximum(1.0, np.fmin(depth, other)) ** 2
    return found


def _patches(off: Mask) -> Mask:
    """Mask the pixels of those patches of a mask that are more than edges."""
    from scipy.ndimage import binary_erosion, binary_propagation

    found: Mask = binary_propagation(binary_erosion(off, np.ones((3, 3)), iterations=SURE), mask=off)
    return found

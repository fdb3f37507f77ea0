"""Overlaps of many boxes with the convex parts of a body, by separating axes (Gottschalk, Lin and Manocha,
SIGGRAPH 1996)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats

from .ray_casting import Body
from .segment_casting import SKIN

AHEAD, BEHIND = [1, 2, 0], [2, 0, 1]  # of each axis the next and the one before
ROUNDING = 1e-12  # parallel axes have no product: nothing is apart along that [m]


def overlaps(shape: Body, centres: Floats, turns: Floats, half: Floats) -> NDArray[np.bool_]:
    """Check which boxes reach into which geoms by more than ``SKIN``; hulls and round geoms are replaced by
    boxes around them.

    Args:
        centres: of the boxes (n, 3) [m].
        turns: their axes as columns (n, 3, 3).
        half: side lengths (3,), halved [m].

    Returns:
        (n, geoms).
    """
    reach = shape.radii + float(np.linalg.norm(half))
    found: NDArray[np.bool_] = np.linalg.norm(shape.centres - centres[:, None, :], axis=2) < reach
    rows, parts = np.nonzero(found)
    if not len(rows):
        return found
    own = np.array([g.pose.rotation for g in shape.geoms])[parts]
    sizes = np.array([g.half_extents for g in shape.geoms])[parts]
    between = np.einsum("kij,ki->kj", turns[rows], shape.centres[parts] - centres[rows])
    found[rows, parts] = _meet(
        between, np.einsum("kij,kil->kjl", turns[rows], own), np.asarray(half) - SKIN, sizes
    )
    return found


def _meet(off: Floats, turn: Floats, one: Floats, other: Floats) -> NDArray[np.bool_]:
    """Mask of those pairs of boxes that overlap, since no axis separates them.

    Args:
        off: centre of the other in the frame of the one (k, 3) [m].
        turn: its axes there as columns (k, 3, 3).
        one, other: halved side lengths (3,) and (k, 3) [m].
    """
    flat = np.abs(turn)
    apart = np.abs(off) - one - np.einsum("kij,kj->ki", flat, other)
    back = np.abs(np.einsum("kij,ki->kj", turn, off)) - other - np.einsum("kij,i->kj", flat, one)
    met: NDArray[np.bool_] = (apart.max(axis=1) < 0) & (back.max(axis=1) < 0)
    for i in range(3):  # along the products of axis i of the one with each of the other's
        j, k = (i + 1) % 3, (i + 2) % 3
        far = np.abs(off[:, k, None] * turn[:, j] - off[:, j, None] * turn[:, k])
        mine = one[j] * flat[:, k] + one[k] * flat[:, j]
        its = other[:, AHEAD] * flat[:, i, BEHIND] + other[:, BEHIND] * flat[:, i, AHEAD]
        met &= (far - mine - its < ROUNDING).all(axis=1)
    return met

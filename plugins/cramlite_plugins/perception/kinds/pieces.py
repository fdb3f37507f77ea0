"""Pieces of a cluster of points, bounded by jumps in depth and concave edges; each piece belongs to one
thing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from cramlite.model import Floats, Mask, View

from ..pose.outline import tolerance
from ..segmentation.concave import parted

LIMITS = {
    "step": 0.030, "bend": 0.008, "reach": 7, "smooth": 5, "border": 12, "grow": 30,
    "core": 40,  # a strip of a carton that another thing hides
}  # fmt: skip
"""Parameters of the division into pieces: those of ``concave_segments``, where their origin is stated, except for the smallest piece."""
OWN = 0.6
"""Least share of a piece's pixels that a thing must claim; with less the piece belongs to another thing."""


def pieces(view: View, mask: Mask, least: float) -> list[Mask]:
    """Return the pieces of an image mask, divided at jumps in depth and at concave edges, the largest first.

    Pieces with fewer than ``least`` pixels are left out.
    """
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    area = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    known = view.valid[area]
    inverse = np.where(known, 1.0 / np.where(known, view.depth[area], 1.0), np.nan)
    around = 2 * int(LIMITS["reach"])
    labels = parted(np.pad(inverse, around, constant_values=np.nan), np.pad(mask[area] & known, around), LIMITS)
    labels = labels[around:-around, around:-around]
    sizes = np.bincount(labels.ravel())
    found = []
    for k in sorted(np.flatnonzero(sizes >= least), key=lambda k: -sizes[k]):
        if k > 0:
            piece = np.zeros(mask.shape, bool)
            piece[area] = labels == k
            found.append(piece)
    return found


def given_back(own: Mask, among: Sequence[Mask], drawn: Mask) -> Mask:
    """Return the pixels that a thing claims, without pieces of the picture of which it claims only a small share where it is drawn.

    A piece is given back if the thing claims less than the share ``OWN`` of it there: what it stands on is near it, and beside it in the
    picture.
    """
    kept = own.copy()
    for piece in among:
        if (own & drawn & piece).sum() < OWN * piece.sum():
            kept &= ~piece
    return kept if kept.any() else own


RING = 4
"""Pixels beside a region that are looked at: flying pixels are two or three wide."""


def covered(view: View, mask: Mask, front: Mask) -> float:
    """Return the share of a picture region's border where its thing may continue out of sight, 0 to 1.

    That is beside foreground that is not farther away, which may hide more of the thing, and at the picture's
    border.
    """
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    area = tuple(slice(max(0, k[0] - RING), k[-1] + RING + 1) for k in (rows, columns))
    own = mask[area]
    ring = ndimage.binary_dilation(own, iterations=RING) & ~own
    inner = ndimage.distance_transform_edt(~own, return_distances=False, return_indices=True)[:, ring]
    depth = view.depth[area]
    beside = depth[tuple(inner)]
    hides = front[area][ring] & (depth[ring] < beside + tolerance(beside))
    cut = sum(int(np.count_nonzero(e)) for e in (mask[0], mask[-1], mask[:, 0], mask[:, -1])) * RING
    border = int(np.count_nonzero(ring)) + cut
    return (int(np.count_nonzero(hides)) + cut) / max(1, border)


def middles(where: Floats, mask: Mask, number: int, least: float) -> list[Mask]:
    """Split a cluster of points into regions by k-means (Lloyd, 1982) in the horizontal plane.

    Two parts are also sought one above the other. Parts with fewer than ``least`` pixels are left out.
    """
    from scipy.cluster.vq import kmeans2

    points = where[mask].astype(float)
    found = []
    for axes in (slice(0, 2), slice(2, 3)) if number == 2 else (slice(0, 2),):
        own_points = points[:, axes]
        centres, _ = kmeans2(own_points[:: max(1, len(points) // 1500)], number, minit="++", seed=0)
        label = ((own_points[:, None] - centres[None]) ** 2).sum(axis=2).argmin(axis=1)
        for k in range(number):
            if int((label == k).sum()) >= least:
                own = np.zeros(mask.shape, bool)
                own[mask] = label == k
                found.append(own)
    return found

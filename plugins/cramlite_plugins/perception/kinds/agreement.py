"""Agreement of colours between a picture and a model at a pose: the colour of a pixel is compared with the
model's texture at that point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from cramlite.model import Floats, Mask, Pose, Value, View

from ..pose.outline import tolerance
from .appearance import Appearance

POINTS = 350
GAIN = (0.3, 1.4)
"""Least and largest brightness of the picture relative to the print: in shade, and under a lamp."""
SHADE = (0.8, 1.25)
"""Factors by which folds and shadows change a point's brightness, at least and at most."""
EVEN = 0.03
"""Weight of the assumption of even light, as a share of the print's weight: the colours of a single side do not determine the light's
direction."""
OFF = 0.16
"""Mean difference of a colour channel at which the agreement is 0, as a share of full scale: the grey of a print against its black."""
TWICE, GRAIN = 2.0, 0.008
"""Factor by which a plain colour may explain the picture better than the print before the agreement is lowered, and noise of a smoothed
channel, of full scale."""
FEW = 25
"""Points below which a pose shows too little to be judged by colour."""


CLOSED, RING = 3, 4
"""Number of dilations that close the gaps between projected points of a surface, and width of the ring around it that is compared with
it [pixel]."""
PLAIN, STEP = 14.0, 0.015
"""Mean difference of the channels, of 255, and share of the depth, above which there is an edge: three times noise and grain."""


class Picture(Value, eq=False):
    """Smoothed colours (height, width, 3), 0 to 255, and depth [m] of a view."""

    view: View
    rgb: Floats

    @classmethod
    def of(cls, view: View) -> Picture:
        """Smooth a view's colours over 3 x 3 pixels."""
        return cls(view, ndimage.uniform_filter(view.rgb.astype(np.float32), (3, 3, 1)))


def agreement(picture: Picture, mask: Mask, appearance: Appearance, poses: Sequence[Pose], least: float = -1.0) -> Floats:
    """Return how well the picture's colours agree with the model at each of P poses in the world, 0 to 1; for a pose that certainly
    reaches no more than ``least``, an upper bound.

    Only points count that face the camera, lie in the mask and are as deep as what is seen. The light is that which
    explains the picture best.
    """
    view = picture.view
    step = max(1, len(appearance.colours) // (4 * POINTS))
    points, normals = appearance.surface.points[::step], appearance.surface.normals[::step]
    printed = appearance.colours[::step]
    back = view.camera.inverse()
    found = np.zeros(len(poses))
    for k, pose in enumerate(poses):
        in_camera = back * pose
        seen = in_camera.apply(points)
        turned = in_camera.rotate(normals)
        facing = np.einsum("ij,ij->i", turned, seen) < -0.15 * np.linalg.norm(seen, axis=1)
        found[k] = _agreement(picture, mask, seen[facing], turned[facing], printed[facing], least)
    return found


def best_by_print(picture: Picture, mask: Mask, appearance: Appearance, poses: Sequence[Pose], fits: Floats) -> tuple[int, float]:
    """Return the index of the pose with the greatest product of squared fit and agreement of colours, and that agreement.

    Poses are taken in the order of their fits, and no more when even full agreement could not make one of them the best.
    """
    first, colour, most = 0, 0.0, 0.0
    for k in np.argsort(-fits, kind="stable"):
        if fits[k] * fits[k] <= most:
            break
        own = float(agreement(picture, mask, appearance, [poses[k]], most / (fits[k] * fits[k]))[0])
        if fits[k] * fits[k] * own > most:
            first, colour, most = int(k), own, float(fits[k] * fits[k] * own)
    return first, colour


def silhouette(view: View, appearance: Appearance, pose: Pose) -> Mask:
    """Return the pixels (height, width) on which a model at a pose is drawn, whatever is before it."""
    pixels = view.intrinsics.project((view.camera.inverse() * pose).apply(appearance.surface.points))
    own = np.zeros(view.depth.shape, bool)
    inside = np.isfinite(pixels).all(1) & (pixels > -0.5).all(1)
    inside &= (pixels[:, 0] < view.intrinsics.width - 0.5) & (pixels[:, 1] < view.intrinsics.height - 0.5)
    column, row = np.rint(pixels[inside]).astype(int).T
    own[row, column] = True
    return np.asarray(ndimage.binary_closing(own, iterations=CLOSED))


def edged(picture: Picture, mask: Mask, appearance: Appearance, pose: Pose) -> float:
    """Return the share of a model's outline at a pose that has an edge of depth or colour beside it, 0 to 1.

    Only the outline inside of the mask is judged.

    A thing ends where one of them changes; a piece of a larger face has no edge around it.
    """
    view = picture.view
    own = silhouette(view, appearance, pose)
    ring = ndimage.binary_dilation(own, iterations=RING) & ~ndimage.binary_dilation(own) & mask
    inner = ndimage.binary_erosion(own, iterations=2) & mask
    if ring.sum() < FEW or not inner.any():
        return 1.0
    beside = ndimage.distance_transform_edt(~inner, return_distances=False, return_indices=True)[:, ring]
    other = np.abs(picture.rgb[ring] - picture.rgb[tuple(beside)]).mean(axis=1) > PLAIN
    step = np.abs(view.depth[ring] - view.depth[tuple(beside)]) > STEP * view.depth[ring]
    return float((other | step).mean())


def _agreement(picture: Picture, mask: Mask, seen: Floats, normals: Floats, printed: Floats, least: float) -> float:
    view = picture.view
    pixels = view.intrinsics.project(seen)
    inside = np.isfinite(pixels).all(1) & (pixels > -0.5).all(1)
    inside &= (pixels[:, 0] < view.intrinsics.width - 0.5) & (pixels[:, 1] < view.intrinsics.height - 0.5)
    column, row = np.rint(pixels[inside]).astype(int).T
    z = seen[inside, 2]
    near = mask[row, column] & (np.abs(view.depth[row, column] - z) < 2 * tolerance(z.astype(np.float32)))
    if near.sum() < FEW:
        return 0.0
    shown, own = picture.rgb[row[near], column[near]].astype(float), printed[inside][near]
    off = _off(shown, own, normals[inside][near])
    agrees = float(np.clip(1.0 - off / OFF, 0.0, 1.0).mean())
    if agrees <= least:
        return agrees
    plain = _off(shown, np.broadcast_to(shown.mean(axis=0), shown.shape), normals[inside][near])
    better = TWICE * (plain.mean() + GRAIN) / (off.mean() + GRAIN)
    return agrees * min(1.0, float(better))


def _off(shown: Floats, own: Floats, normals: Floats) -> Floats:
    """Mean difference of the channels (N,), as a share of full scale, between a picture and a texture in
    the light that explains it best."""
    lit = _light(shown, own, normals)[:, None] * own
    shade = np.clip((shown * lit).sum(axis=1) / np.maximum((lit * lit).sum(axis=1), 1.0), *SHADE)
    return np.asarray(np.abs(shown - shade[:, None] * lit).mean(axis=1) / 255.0)


def _light(shown: Floats, own: Floats, normals: Floats) -> Floats:
    """Brightness factors (N,), linear in the normal as under one lamp (Lambert), by which the colours (N, 3) of a
    texture best explain those of the picture."""
    terms = np.concatenate([np.ones((len(normals), 1)), normals], axis=1)
    weight, product = (own * own).sum(axis=1), (own * shown).sum(axis=1)
    matrix = (terms * weight[:, None]).T @ terms
    matrix += EVEN * weight.sum() * np.diag((0.0, 1.0, 1.0, 1.0)) + 1e-6 * np.eye(4)
    return np.asarray(np.clip(terms @ np.linalg.solve(matrix, terms.T @ product), *GAIN))

"""Noise of a stereo depth camera, an Intel RealSense D435, as errors of its disparities."""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec.structs import replace
from scipy import ndimage

from cramlite.model import Intrinsics, Mask, Points, Value

Generator = Any  # numpy.random.Generator


class Noise(Value):
    """Parameters of the noise; the defaults are a D435's at 640 x 480.

    Disparity, not depth, is what a stereo camera measures: d = focal * baseline / z. Its noise, its steps and its
    shadows follow from that. The numbers are those of docs/explanation/perception.md; they give a median error
    of 2 mm below 1 m and 97 % valid pixels.

    Args:
        focal: of the infrared pair [pixel]; baseline: between its two cameras [m].
        disparity: standard deviation of the disparity [pixel], correlated over ``smooth`` pixels.
        steps: sub-pixel steps per pixel of disparity.
        millimetres: whether depth is stored in whole millimetres.
        flying, dropped: shares of the pixels at a depth edge that lie between both surfaces, and that have no depth.
        grazing: cosine of the angle of incidence below which drop-outs begin; at 0 all is lost.
        nearest, farthest: range in which depth is measured [m].
        colour: standard deviation of each colour channel, of 255.
    """

    focal: float = 385.0
    baseline: float = 0.050
    disparity: float = 0.09
    smooth: float = 1.0
    steps: int = 32
    millimetres: bool = True
    flying: float = 0.15
    dropped: float = 0.20
    grazing: float = 0.12
    nearest: float = 0.17
    farthest: float = 10.0
    colour: float = 3.0

    def times(self, factor: float) -> Noise:
        """Return the noise with ``factor`` times the errors of disparity and colour, and steps as much larger."""
        return replace(self, disparity=factor * self.disparity, steps=max(1, round(self.steps / factor)), colour=factor * self.colour)


EDGE = 0.012
"""Depths of neighbouring pixels that differ by more than this share belong to two surfaces: 6 mm at 0.5 m, which a
surface seen at 75 degrees from its normal just reaches at 385 pixels focal length."""

NOTHING = 1e3
"""Depth of pixels whose ray hits nothing, for comparison with their neighbours [m]: beyond any camera's range."""


def noisy_depth(depth: Points, cosine: Points, intrinsics: Intrinsics, noise: Noise, rng: Generator) -> Points:
    """Add the camera's noise to exact depths.

    Args:
        depth: (height, width) along the optical axis [m]; infinite where there is nothing.
        cosine: (height, width) of the angle between ray and surface normal.

    Returns:
        (height, width) [m]; NaN where nothing was measured.
    """
    depth = np.minimum(depth, NOTHING)
    shadow = _shadow(depth, intrinsics, noise)
    low, high = _neighbours(depth)
    edge = high - low > EDGE * low
    draw = rng.random(depth.shape)
    blend = rng.random(depth.shape)
    seen = np.where(edge & (draw < noise.flying), low + blend * (high - low), depth)
    lost = shadow | (edge & (draw > 1 - noise.dropped)) | (rng.random(depth.shape) > cosine / noise.grazing)
    seen = _measured(seen, noise, rng)
    seen[lost | (seen < noise.nearest) | ~(seen <= noise.farthest)] = np.nan
    return seen


def noisy_colour(rgb: Points, noise: Noise, rng: Generator) -> Points:
    """Add Gaussian noise to a colour image (0 to 255)."""
    return np.asarray(rgb + rng.normal(0.0, noise.colour, rgb.shape))


def _measured(depth: Points, noise: Noise, rng: Generator) -> Points:
    """Depths computed from disparities with smoothed noise and finite steps; the smoothing does not change
    the noise's standard deviation."""
    white = ndimage.gaussian_filter(rng.normal(size=depth.shape), noise.smooth)
    white *= noise.disparity / max(float(white.std()), 1e-12)
    scale = noise.focal * noise.baseline
    disparity = np.round((scale / depth + white) * noise.steps) / noise.steps
    measured = scale / np.where(disparity > 0, disparity, np.nan)
    return np.asarray(np.round(measured, 3) if noise.millimetres else measured)


def _neighbours(depth: Points) -> tuple[Points, Points]:
    """For each pixel the least and the greatest depth among itself and its four neighbours."""
    cross = ndimage.generate_binary_structure(2, 1)
    low = ndimage.minimum_filter(depth, footprint=cross)
    return low, ndimage.maximum_filter(depth, footprint=cross)


def _shadow(depth: Points, intrinsics: Intrinsics, noise: Noise) -> Mask:
    """Pixels that the second camera, a baseline to the right, does not see: something nearer covers them there."""
    height, width = depth.shape
    shift = intrinsics.fx * noise.baseline / depth
    rows = np.broadcast_to(np.arange(height)[:, None], depth.shape)
    place = np.rint(np.arange(width) - shift).astype(np.int64)
    front = np.zeros((height, width + 2))
    for extra in (0, 1):  # a slanted surface is wider there than here and would leave gaps
        column = np.clip(place + extra, -1, width) + 1
        np.maximum.at(front, (rows, column), shift)
    covered = front[rows, np.clip(place, -1, width) + 1] > shift * (1 + 2 * EDGE) + 0.5
    return np.asarray(covered & (place >= 0) & (place < width))

"""Images for people: a depth image in colours, and recognised objects drawn over the colour image."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ..model.view import View
    from ..model.world.thing import Thing
    from .result import Perceived

COLOURS = ((42, 110, 187), (214, 106, 20), (40, 140, 80), (150, 70, 170), (190, 150, 20), (205, 60, 105), (20, 150, 160),
           (120, 120, 60))  # fmt: skip


def colour(number: int) -> tuple[int, int, int]:
    """Return the colour for drawing the percept with a given number, from 1 [RGB, 0 to 255]."""
    return COLOURS[(number - 1) % len(COLOURS)]


def overlay(found: Perceived, view: View, models: Sequence[Thing]) -> Any:
    """Draw the percepts over the faded colour image (rows, columns, 3).

    Each has its segment, its number and, where it is an answer with a pose, the boxes of its model.
    """
    from PIL import Image, ImageDraw

    grey = view.rgb.mean(axis=2, keepdims=True)
    image = (0.45 * view.rgb + 0.25 * grey + 76).clip(0, 255)
    seen = (*found.dropped, *found.answers)
    answers = {p.number for p in found.answers}
    for percept in seen:
        mask = percept.value("segment").mask
        share = 0.55 if percept.number in answers else 0.25
        image[mask] = (1 - share) * image[mask] + share * np.array(colour(percept.number))
    drawn = Image.fromarray(image.astype(np.uint8))
    pen = ImageDraw.Draw(drawn)
    for percept in seen:
        rows, columns = np.nonzero(percept.value("segment").mask)
        model = next((m for m in models if m.name == percept.value("model")), None)
        if percept.number in answers and model is not None and percept.value("pose") is not None:
            for line in wires(view, percept.value("pose"), model):
                pen.line(line, fill=(255, 255, 255), width=3)
                pen.line(line, fill=colour(percept.number), width=1)
        spot = (float(columns.mean()) - 4, float(rows.min()) - 22)
        pen.text(
            spot,
            str(percept.number),
            font_size=18,
            fill=colour(percept.number),
            stroke_width=2,
            stroke_fill=(255, 255, 255),
        )
    return np.asarray(drawn)


def wires(view: View, pose: Any, model: Thing) -> Iterator[list[tuple[float, float]]]:
    """Project the edges of the boxes around a model's geoms into the image [pixel].

    Edges with an end behind the camera are left out.
    """
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    pairs = [(i, j) for i in range(8) for j in range(i) if np.abs(signs[i] - signs[j]).sum() == 2]
    to_camera = view.camera.inverse() * pose
    for geom in model.geoms:
        pixels = view.intrinsics.project((to_camera * geom.pose).apply(signs * geom.half_extents))
        for i, j in pairs:
            if np.isfinite(pixels[[i, j]]).all():
                yield [(float(pixels[k][0]), float(pixels[k][1])) for k in (i, j)]


def depth_range(view: View) -> tuple[float, float]:
    """Return the depths between which nearly all of a view lies [m]: its 1st and 97th percentile."""
    if not view.valid.any():
        return 0.0, 1.0
    low, high = np.percentile(view.depth[view.valid], (1, 97))
    return float(low), float(max(high, low + 1e-3))


def depth_image(view: View) -> Any:
    """Return a depth image in colours (rows, columns, 3) uint8: near bright, far dark, nothing measured a dull red."""
    low, high = depth_range(view)
    share = 1 - np.clip((np.nan_to_num(view.depth, nan=high) - low) / (high - low), 0, 1)
    stops = np.array([[16, 22, 60], [40, 90, 150], [80, 175, 170], [250, 240, 170]], float)
    grid = np.linspace(0, 1, len(stops))
    image = np.stack([np.interp(share, grid, stops[:, k]) for k in range(3)], axis=-1)
    image[~view.valid] = (92, 60, 60)
    return image.astype(np.uint8)

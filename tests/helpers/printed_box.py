"""Boxes with a print, one colour a side or a picture, and cans with a label, written as mesh files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

SIDES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
COLOURS = ((255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0), (255, 0, 255), (0, 255, 255))
"""Colours of the sides, in the order of ``SIDES``: red, green, blue, yellow, magenta, cyan."""


def printed_box(path: Path, size: tuple[float, float, float], tiles: tuple[np.ndarray, ...] | None = None) -> Path:
    """Write a box, centred on its frame, each side with a picture of its own.

    Args:
        path: of a GLB, or of an OBJ, beside which its material and texture come to be.
        size: [m].
        tiles: six square pictures (n, n, 3) uint8 of one size, in the order of ``SIDES``; None for ``COLOURS``.
    """
    tiles = tiles or tuple(np.full((20, 20, 3), c, np.uint8) for c in COLOURS)
    vertices, faces, places = [], [], []
    for k, side in enumerate(SIDES):
        normal = np.array(side, float)
        right = np.cross((0, 0, 1), normal) if not side[2] else np.array((1.0, 0, 0))
        up = np.cross(normal, right)
        for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
            vertices.append((normal + (2 * u - 1) * right + (2 * v - 1) * up) * np.array(size) / 2)
            places.append(((k + 0.02 + 0.96 * u) / 6, 0.02 + 0.96 * v))
        faces += [(4 * k, 4 * k + 1, 4 * k + 2), (4 * k, 4 * k + 2, 4 * k + 3)]
    image = Image.fromarray(np.concatenate(tiles, axis=1))
    material = trimesh.visual.material.SimpleMaterial(image=image)
    look = trimesh.visual.TextureVisuals(np.array(places), material=material)
    trimesh.Trimesh(vertices, faces, process=False, visual=look).export(str(path))
    return path


def labelled_can(path: Path, radius: float, height: float, fin: float, label: np.ndarray) -> Path:
    """Write a can around the z axis, with a fin that stands off it at -x, so that its box's middle is beside its axis; sizes in metres.

    Args:
        label: (h, w, 3) uint8, around the can.
    """
    angles = np.linspace(-np.pi, np.pi, 37)
    radii = np.where(np.abs(angles) > np.pi - 0.1, radius + fin, radius)
    ring = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
    vertices = [(*ring[k], z) for z in (-height / 2, height / 2) for k in range(len(ring))] + [(0, 0, height / 2)]
    n = len(ring)
    faces = [f for k in range(n - 1) for f in ((k, k + 1, n + k + 1), (k, n + k + 1, n + k), (n + k, n + k + 1, 2 * n))]
    places = [(k / (n - 1), v) for v in (0.02, 0.98) for k in range(n)] + [(0.5, 0.98)]
    material = trimesh.visual.material.SimpleMaterial(image=Image.fromarray(label))
    look = trimesh.visual.TextureVisuals(np.array(places), material=material)
    trimesh.Trimesh(vertices, faces, process=False, visual=look).export(str(path))
    return path


def tiles(seed: int, darkest: int = 20) -> tuple[np.ndarray, ...]:
    """Return prints of a carton's six sides: four by four patches of four colours, none of a channel darker than ``darkest``."""
    rng = np.random.default_rng(seed)
    palette = rng.integers(darkest, 255, (4, 3))
    return tuple(np.kron(palette[rng.integers(0, 4, (4, 4))], np.ones((6, 6, 1))).astype(np.uint8) for _ in range(6))

"""Appearance of an object model: triangles with textures, merged to one mesh with one image, as a GLB file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cramlite.model import Floats, Value

LARGEST = 1024
"""Pixels of a texture's longer side: 0.3 mm on a carton of 0.3 m, finer than any depth camera's pixel."""


class Part(Value, eq=False):
    """Triangles of an object model that share one texture.

    Args:
        corners: (F, 3, 3) in the kind's frame [m].
        places: (F, 3, 2) of the corners in the image, as a ``Skin`` has them.
        image: (height, width, 3) uint8.
        printed: whether the image is a texture; else it is one colour.
    """

    corners: Floats
    places: Floats
    image: Any
    printed: bool = True


def plain(corners: Floats, rgb: Sequence[float]) -> Part:
    """Return triangles of one colour, each channel 0 to 1."""
    image = np.broadcast_to(np.clip(np.rint(np.array(rgb[:3]) * 255), 0, 255).astype(np.uint8), (8, 8, 3))
    return Part(corners, np.full((len(corners), 3, 2), 0.5), image, printed=False)


def scaled_down(image: Any) -> Any:
    """Return an image (height, width, 3) uint8 whose longer side has at most ``LARGEST`` pixels."""
    from PIL.Image import Resampling, fromarray

    height, width = image.shape[:2]
    share = LARGEST / max(height, width)
    if share >= 1:
        return image
    size = max(1, round(width * share)), max(1, round(height * share))
    return np.asarray(fromarray(image).resize(size, Resampling.BOX))


def whole(parts: Sequence[Part]) -> Any:
    """Return the triangles of all parts as one trimesh.Trimesh, with their texture images stacked into one."""
    import trimesh
    from PIL.Image import fromarray

    images = [scaled_down(np.asarray(p.image)) for p in parts]
    width, height = max(i.shape[1] for i in images), sum(i.shape[0] for i in images)
    atlas = np.zeros((height, width, 3), np.uint8)
    places, top = [], 0
    for part, image in zip(parts, images, strict=True):
        h, w = image.shape[:2]
        atlas[top : top + h, :w] = image
        inside = np.clip(part.places - np.floor(part.places.mean(axis=1, keepdims=True)), 0.0, 1.0)
        margin = 0.5 / np.array((w, h))
        inside = np.clip(inside, margin, 1 - margin)
        places.append(np.stack([inside[..., 0] * w / width, (height - top - h + inside[..., 1] * h) / height], axis=-1))
        top += h
    corners = np.concatenate([p.corners for p in parts]).reshape(-1, 3)
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=fromarray(atlas))
    look = trimesh.visual.TextureVisuals(np.concatenate(places).reshape(-1, 2), material=material)
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False, visual=look)


def write(mesh: Any, path: Path) -> None:
    """Write a mesh with its texture as a GLB file."""
    path.write_bytes(mesh.export(file_type="glb"))

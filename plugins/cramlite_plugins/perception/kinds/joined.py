"""Explanation of neighbouring regions of a picture as one thing whose middle is hidden, if no region alone fits a model well."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cramlite.model import Mask

from .interpret import claimed, extent, read
from .reading import Part, Scene, bad, rarity
from .region import Region


def joined(scene: Scene, parts: Sequence[Part]) -> list[Part]:
    """Explain neighbouring regions of a picture by one thing, if that explains more of their pixels than a
    thing for each."""
    found = list(parts)
    for group in _groups(scene, parts):
        whole = np.logical_or.reduce([p.mask for p in group])
        if extent(scene, whole) > max(a.surface.diameter for a in scene.appearances):
            continue
        one = read(Region(scene, whole))
        if one.score < bad(whole, scene.limits) or one.score * whole.sum() <= _explained(scene, group):
            continue
        one = claimed(scene, one, [p.mask for p in group])
        found = [p for p in found if not any(p is q and (q.mask & one.mask).any() for q in group)] + [one]
    return found


def _explained(scene: Scene, group: Sequence[Part]) -> float:
    """Number of pixels that the known models chosen for some regions of a picture explain, each weighted by
    its score."""
    return sum(p.score * float(p.mask.sum()) for p in group if p.score >= bad(p.mask, scene.limits))


def _groups(scene: Scene, parts: Sequence[Part]) -> Iterator[list[Part]]:
    """Yield groups of neighbouring image regions that known models do not explain well, at least one of them badly."""
    limits = scene.limits
    left = [p for p in parts if p.score < limits["full"] * rarity(p.mask, limits)]
    boxes = {id(p): _box(scene, p.mask) for p in left}
    while left:
        group = [left.pop(0)]
        for own in group:
            near = [p for p in left if _apart(boxes[id(own)], boxes[id(p)]) < limits["apart_m"]]
            group += near
            left = [p for p in left if not any(p is q for q in near)]
        if len(group) > 1 and any(p.score < bad(p.mask, limits) for p in group):
            yield group


def _box(scene: Scene, mask: Mask) -> tuple[np.ndarray, np.ndarray]:
    points = scene.points[mask]
    return points.min(axis=0), points.max(axis=0)


def _apart(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> float:
    """Distance between two boxes [m]."""
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(one[0] - other[1], other[0] - one[1]))))

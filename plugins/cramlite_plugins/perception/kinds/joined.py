"""Explanation of neighbouring regions of a picture as one thing whose middle is hidden, if no region alone fits a model well."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cramlite.model import Mask
from cramlite.plugin import checkpoint

from .interpret import claimed, clusters, extent, partial, read, several, whole_or_split, wholes
from .reading import Part, Scene, bad, rarity
from .region import Region

Ones = dict[frozenset[Part], Part | None]
"""Groups of regions that were read as one thing, with what explains them."""


def interpreted(scene: Scene) -> list[Part]:
    """Interpret the foreground of a picture, cluster by cluster; the rest of a cluster beside an explained part is interpreted again.

    Neighbouring regions that no thing explains alone, and one thing explains well, are taken for it before they are taken for several: a
    rack in three pieces is found at once. What is divided by edges is taken apart first, as it is likeliest to be several things.
    """
    found, ones = list[Part](), Ones()
    left = dict.fromkeys(wholes(scene, scene.front), 0)
    while left:
        checkpoint()
        mask, part, depth = _next(scene, left, ones)
        left = {p: d for p, d in left.items() if not (p.mask & mask).any()}
        found.append(part)
        if depth < scene.limits["again"]:
            left |= {p: depth + 1 for p in wholes(scene, mask & ~part.mask) if extent(scene, p.mask) > scene.limits["least_m"]}
    return joined(scene, found, ones)


def _next(scene: Scene, left: Mapping[Part, int], ones: Ones) -> tuple[Mask, Part, int]:
    """Return the next regions of a picture that are interpreted, the part of them that is explained, and how often rests were taken."""
    for group in (g for most in ("bad", "full") for g in _groups(scene, [*left], scene.limits[most])):
        one = _known(scene, group, ones)
        if one is not None and one.score >= scene.limits["good"] * rarity(union(group), scene.limits):
            own = [p for p in group if (p.mask & one.mask).any()]
            return union(own), one, max(left[p] for p in own)
    whole = max(left, key=lambda p: (p.score >= bad(p.mask, scene.limits) or several(scene, p), p.score))
    return whole.mask, whole_or_split(Region(scene, whole.mask), whole), left[whole]


def joined(scene: Scene, parts: Sequence[Part], ones: Ones) -> list[Part]:
    """Explain neighbouring regions of a picture by one thing, if that explains more of their pixels than a
    thing for each.

    Regions that known models do not explain are joined first, since the neighbours of a thing in many pieces are none of it; of those
    that are not one thing, furniture is taken out first.
    """
    found, tried = list(parts), set[frozenset[Part]]()
    for most in ("bad", "full"):
        for group in _groups(scene, found, scene.limits[most]):
            if frozenset(group) not in tried:
                tried.add(frozenset(group))
                if (one := _known(scene, group, ones)) is not None:
                    found = [p for p in found if not any(p is q and (q.mask & one.mask).any() for q in group)] + [one]
                elif most == "bad" and (apart := _without_furniture(scene, group)):
                    found = [p for p in found if not any(p is q for q in group)] + apart
    return found


def _known(scene: Scene, group: Sequence[Part], ones: Ones) -> Part | None:
    """Return regions of a picture as one thing, as ``_as_one``; worked out once."""
    if (key := frozenset(group)) not in ones:
        ones[key] = _as_one(scene, group)
    return ones[key]


def _as_one(scene: Scene, group: Sequence[Part]) -> Part | None:
    """Return regions of a picture as one thing; None if nothing of that size is known, or a thing for each explains more."""
    whole = union(group)
    if extent(scene, whole) > max(a.surface.diameter for a in scene.appearances):
        return None
    one = read(Region(scene, whole))
    if one.score < bad(whole, scene.limits) or one.score * whole.sum() <= _explained(scene, group):
        return None
    return claimed(scene, one, [p.mask for p in group])


def _without_furniture(scene: Scene, group: Sequence[Part]) -> list[Part]:
    """Return furniture that explains a part of some regions of a picture that touch, and then what it leaves of them; nothing if no
    furniture is found.

    The furniture must explain its own points as one thing alone would.
    """
    whole, among = union(group), [p.mask for p in group]
    for number in (2, 3):
        for first in partial(Region(scene, whole), number, furniture=True):
            if first.score >= bad(whole, scene.limits):
                one = read(Region(scene, claimed(scene, Part(whole, (first,)), among).mask))
                if one.score >= bad(one.mask, scene.limits) and one.readings[0].appearance.model.furniture:
                    one = claimed(scene, Part(whole, one.readings), among)
                    return [one, *_rest(scene, whole & ~one.mask)]
    return []


def _rest(scene: Scene, mask: Mask) -> list[Part]:
    """Return what is left beside furniture: neighbouring regions as one thing or beside more furniture, others one by one."""
    left = [Part(m, ()) for m in clusters(scene, mask) if extent(scene, m) > scene.limits["least_m"]]
    found: list[Part] = []
    for group in _groups(scene, left, scene.limits["bad"]):
        one = _as_one(scene, group)
        if apart := [one] if one is not None else _without_furniture(scene, group):
            found += apart
            left = [p for p in left if not any(p is q for q in group)]
    return found + [read(Region(scene, p.mask)) for p in left]


def union(group: Sequence[Part]) -> Mask:
    """Return the pixels of some regions of a picture."""
    return np.asarray(np.logical_or.reduce([p.mask for p in group]))


def _explained(scene: Scene, group: Sequence[Part]) -> float:
    """Number of pixels that the known models chosen for some regions of a picture explain, each weighted by
    its score."""
    return sum(p.score * float(p.mask.sum()) for p in group if p.score >= bad(p.mask, scene.limits))


def _groups(scene: Scene, parts: Sequence[Part], most: float) -> Iterator[list[Part]]:
    """Yield groups of neighbouring image regions that known models explain with lower scores than ``most``, at least one of them
    badly."""
    limits = scene.limits
    left = [p for p in parts if p.score < most * rarity(p.mask, limits)]
    boxes = {id(p): _box(scene, p.mask) for p in left}
    while left:
        group = [left.pop(0)]
        for own in group:
            near = [p for p in left if _apart(boxes[id(own)], boxes[id(p)]) < limits["apart_m"]]
            group += near
            left = [p for p in left if not any(p is q for q in near)]
        if len(group) > 1 and any(p.score < bad(p.mask, limits) for p in group):
            yield group


def beside(scene: Scene, part: Part, others: Sequence[Part], most: float) -> list[Part]:
    """Return those of other regions of a picture whose boxes are at most so far [m] from a region's."""
    own = _box(scene, part.mask)
    return [p for p in others if p is not part and _apart(own, _box(scene, p.mask)) < most]


def _box(scene: Scene, mask: Mask) -> tuple[np.ndarray, np.ndarray]:
    points = scene.points[mask]
    return points.min(axis=0), points.max(axis=0)


def _apart(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> float:
    """Distance between two boxes [m]."""
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(one[0] - other[1], other[0] - one[1]))))

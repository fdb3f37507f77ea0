"""Bearers of what hovers: strips of a picture that are seen under a thing, read as the kinds that are as high as its feet stand."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace
from scipy.spatial import cKDTree

from cramlite.model import Floats, Mask, Value, Vector3
from cramlite.plugin import checkpoint

from ..pose.estimate import COARSE, best
from ..pose.icp import register
from ..pose.prior import Alignment, Prior
from ..pose.starts import slid, starts_for
from .appearance import Appearance, histogram, likeness
from .interpret import claimed, clusters
from .possible import hovers
from .reading import Part, Reading, Scene, bad, rarity
from .region import Region
from .registered import Started, coarse_reading, full_readings
from .standing import standing_at, tops

UP: Vector3 = (0.0, 0.0, 1.0)
TILT = math.radians(8)
"""Largest tilt of what bears a thing: it stands on the furniture; small things seen by a strip are registered to some degrees."""
INNER = 0.03
"""Distance from a kind's middle within which its hollow is [m], if it has one: what stands on it may have its feet in there."""


class Hovering(Value, eq=False):
    """Thing that touches nothing that is known: its middle, the half width of its outline from above, the height of its lowest point, and
    that of the known furniture under it [m]."""

    middle: Floats
    half: float
    low: float
    floor: float

    @property
    def gap(self) -> float:
        """Return how far it is above the furniture [m]."""
        return self.low - self.floor


def with_bearers(scene: Scene, parts: Sequence[Part]) -> list[Part]:
    """Return parts of a picture, with what is seen under hovering things read as bearers of their height where that explains it better."""
    found = list(parts)
    for part in parts:
        if (thing := _hovering(scene, part, parts)) is not None and (mask := _under(scene, found, part, thing)).any():
            rivals = [p for p in found if p is not part and not _is_known(scene, p) and (p.mask & mask).any()]
            if (one := _bearer(scene, mask, rivals, thing)) is not None:
                found = [p for p in found if not any(p is r for r in rivals)] + [one]
    return found


def _hovering(scene: Scene, part: Part, parts: Sequence[Part]) -> Hovering | None:
    """Return the thing that explains a part of the picture, if its feet touch nothing."""
    if not _stands(scene, part):
        return None
    points = _surface(part.readings[0])
    others = [_surface(p.readings[0])[::3] for p in parts if p is not part and _is_known(scene, p)]
    low, high = points.min(axis=0), points.max(axis=0)
    feet = points[points[:, 2] < low[2] + scene.limits["bears_m"]]
    if not hovers(scene, part.readings[0].appearance, points[::10]) or _touch(feet, others, scene.limits["touches_m"]):
        return None
    floor = max((top for top in tops(scene.fixtures, (low + high) / 2) if top < low[2]), default=None)
    return Hovering((low + high) / 2, float((high - low)[:2].max()) / 2, float(low[2]), floor) if floor is not None else None


def _stands(scene: Scene, part: Part) -> bool:
    return part.score >= bad(part.mask, scene.limits)


def _is_known(scene: Scene, part: Part) -> bool:
    """Whether a part of the picture shows furniture, or beyond doubt a thing that can be moved."""
    if not _stands(scene, part):
        return False
    return part.readings[0].appearance.model.furniture or part.score >= scene.limits["good"] * rarity(part.mask, scene.limits)


def _surface(reading: Reading) -> Floats:
    return reading.pose.apply(reading.appearance.surface.points)


def _touch(points: Floats, others: Sequence[Floats], most: float) -> bool:
    """Whether a point is near one of other surfaces."""
    return bool(others) and float(cKDTree(np.concatenate(others)).query(points, distance_upper_bound=most)[0].min()) < most


def _under(scene: Scene, parts: Sequence[Part], part: Part, thing: Hovering) -> Mask:
    """Pixels of the picture's foreground under the thing that a part shows, which nothing explains well."""
    known = [p.mask for p in parts if _is_known(scene, p) or p is part]
    left = scene.front & ~np.logical_or.reduce(known) & (scene.points[..., 2] < thing.middle[2])
    return np.asarray(np.logical_or.reduce([np.zeros_like(left), *(m for m in clusters(scene, left) if _begins_under(scene, m, thing))]))


def _begins_under(scene: Scene, mask: Mask, thing: Hovering) -> bool:
    return bool(np.linalg.norm(scene.points[mask][:, :2] - thing.middle[:2], axis=1).min() < thing.half)


def _bearer(scene: Scene, mask: Mask, rivals: Sequence[Part], thing: Hovering) -> Part | None:
    """Return a part of the picture as the likeliest of the kinds that a thing may stand on; None if none explains it better than others
    do."""
    region = Region(scene, mask)
    found = [r for a, ups in _as_high(region, thing) for r in _readings(region, a, ups, thing)]
    found = sorted((replace(r, held=scene.limits["bearer"]) for r in found), key=lambda r: -r.score)
    if not found or found[0].score < max([region.bad, *(p.score for p in rivals)]):
        return None
    return claimed(scene, Part(mask, tuple(found)), [])


def _as_high(region: Region, thing: Hovering) -> list[tuple[Appearance, tuple[Vector3, ...]]]:
    """Return the kinds that are as high as a thing hovers, and whose colours are like those of a region, with the directions up in which
    they are."""
    limits = region.scene.limits
    high = {id(a): _ups(a, thing.gap, limits["bears_m"]) for a in region.scene.appearances if a.model.movable}
    own = histogram(region.scene.picture.view.rgb[region.mask].astype(float))
    alike = [(likeness(own, a), a) for a in region.scene.appearances if high.get(id(a))]
    least = limits["alike"] * max((share for share, _ in alike), default=0.0)
    return [(a, high[id(a)]) for share, a in alike if share >= least]


def _ups(appearance: Appearance, gap: float, most: float) -> tuple[Vector3, ...]:
    """Directions of a kind that point up where it bears what is so high, on its rim or in a hollow of its middle."""
    found = []
    for up in appearance.up:
        along = appearance.surface.points @ np.array(up)
        across = appearance.surface.points - np.outer(along, up)
        middle = (across.min(axis=0) + across.max(axis=0)) / 2
        inner = (np.linalg.norm(across - middle, axis=1) < INNER) & (appearance.surface.normals @ np.array(up) > 0)
        hollow = along[inner].max(initial=along.min()) if inner.any() else along.max()
        if hollow - along.min() - most < gap < np.ptp(along) + most:
            found.append(up)
    return tuple(found)


def _readings(region: Region, appearance: Appearance, ups: tuple[Vector3, ...], thing: Hovering) -> list[Reading]:
    """Explanations of a region by a kind that stands under a thing, with one of some directions up."""
    checkpoint()
    seen, model = region.seen, appearance.surface
    if seen is None:
        return []
    prior = Prior((Alignment(ups, (UP,), after=TILT),))
    begun = starts_for(region.scene.picture.view.camera, model, prior, seen[0])
    starts = standing_at(region.scene, appearance, begun, thing.floor, thing.middle[:2])
    starts = register(model, seen[0], slid(model, seen[1], starts), COARSE, seen[1])
    ranked = coarse_reading(region, Started(appearance, best(model, *seen, starts, 2 * int(region.scene.limits["yaws"]), 200), 1.0))
    return full_readings(region, ranked, prior) if ranked is not None else []


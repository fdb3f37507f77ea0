"""Poses of models that stand on the furniture whose place is known."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Geom, Pose, Thing

from ..pose.icp import PoseBatch
from ..pose.prior import Alignment, Prior
from .appearance import Appearance
from .reading import Scene


def standing(appearance: Appearance) -> Prior:
    """Return the prior that a model stands as it usually does, in any direction about the vertical."""
    return Prior((Alignment(appearance.up, ((0.0, 0.0, 1.0),)),))


def as_high(appearance: Appearance, prior: Prior, height: float, limits: Mapping[str, float], *, whole: bool) -> Prior:
    """Return a prior of standing without the directions up in which a model is lower than what is seen of it over its floor [m] and,
    if the ``whole`` is seen, without those in which it is higher; unchanged if no direction is left."""
    if not prior.alignments:
        return prior
    first, *others = prior.alignments
    high = np.ptp(appearance.surface.points @ np.array(first.axes, np.float32).T, axis=0)
    fits = (high > height - limits["larger_m"]) & ((high < height + limits["larger_m"]) | (not whole))
    if fits.all() or not fits.any():
        return prior
    axes = tuple(a for a, fit in zip(first.axes, fits.tolist(), strict=True) if fit)
    return Prior((replace(first, axes=axes), *others))


def tops(fixtures: Iterable[Thing], point: Floats) -> list[float]:
    """Return the heights of the upper faces of boxes of furniture under or over a point (3,) [m]."""
    faces = [_top(t.pose * g.pose, g, point) for t in fixtures for g in t.geoms if g.shape == "box"]
    return [top for top in faces if top is not None]


def _top(pose: Pose, box: Geom, point: Floats) -> float | None:
    x, y, _ = np.abs(pose.inverse().apply(point)) <= box.half_extents
    return float(pose.apply((0.0, 0.0, box.half_extents[2]))[2]) if x and y else None


def standing_at(scene: Scene, appearance: Appearance, starts: PoseBatch, floor: float, middle: Floats | None = None) -> PoseBatch:
    """Move poses of a model, turned as they are, to where its lowest point is at a height [m], and the middle of its outline from
    above (2,) at a place, if one is given."""
    camera = scene.picture.view.camera
    turned = (starts.turn @ camera.rotation.T.astype(np.float32)).transpose(0, 2, 1)
    surface = turned @ appearance.surface.points.T
    place = camera.apply(-np.einsum("hji,hj->hi", starts.turn, starts.shift).astype(float))
    place[:, 2] = floor - surface[:, 2].min(axis=1)
    if middle is not None:
        place[:, :2] = middle - (surface[:, :2].min(axis=2) + surface[:, :2].max(axis=2)) / 2
    origins = camera.inverse().apply(place).astype(np.float32)
    return PoseBatch(starts.turn, -np.einsum("hij,hj->hi", starts.turn, origins))

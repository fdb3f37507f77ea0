"""Expert that associates objects with fixtures of the map, such as a peg or a basket."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.model import Floats, Geom, Thing
from cramlite.plugin import Expert, Inputs, Judged, Parameter, hookimpl

if TYPE_CHECKING:
    from cramlite.model import Mask

    from .values import Cloud


def fixture(inputs: Inputs) -> Mapping[str, Any]:
    """Return the fixture on whose surface most of an object's points lie; None where there is none."""
    points = np.asarray(inputs["points"], dtype=float)
    points = points[:: max(1, len(points) // 150)]
    best: tuple[float, Thing | None] = (0.0, None)
    for thing in inputs["fixtures"]:
        share = float((distance(points, thing) < inputs.parameters["tolerance_m"]).mean())
        best = max(best, (share, thing), key=lambda b: b[0])
    share, found = best
    if found is None or share < inputs.parameters["share"]:
        return {"fixture": Judged(None, min(1.0, 1 - share / 2), f"{100 * share:.0f} % of its points are on a fixture")}
    return {"fixture": Judged(found, share, f"{100 * share:.0f} % of its points are on '{found.name}'")}


def distance(points: Floats, thing: Thing) -> Floats:
    """Return the distances (N,) [m] of points (N, 3) in the world frame to a thing's surface; 0 inside."""
    away = np.full(len(points), np.inf)
    local = thing.pose.inverse().apply(points)
    for geom in thing.geoms:
        away = np.minimum(away, np.maximum(signed_distances(geom.pose.inverse().apply(local), geom)[0], 0.0))
    return away


def depth_within(points: Floats, thing: Thing) -> Floats:
    """Return how deep points (N, 3) in the world frame are inside of a thing's solids (N,) [m]; 0 outside."""
    deep = np.zeros(len(points))
    local = thing.pose.inverse().apply(points)
    for geom in (g for g in thing.geoms if g.shape != "convex"):
        deep = np.maximum(deep, -signed_distances(geom.pose.inverse().apply(local), geom)[0])
    return deep


def on_fixtures(cloud: Cloud, fixtures: Iterable[Thing], tolerance: float) -> Mask:
    """Return the mask of a cloud's points within ``tolerance`` [m] of the surface of things whose poses are known."""
    from ..shapes.bounds import corners

    index = np.flatnonzero(cloud.mask)
    points = cloud.points.reshape(-1, 3)[index].astype(float)
    near = np.zeros(len(index), bool)
    for thing in (t for t in fixtures if t.geoms):
        edges = corners(thing, thing.pose)
        around = ((points > edges.min(axis=0) - tolerance) & (points < edges.max(axis=0) + tolerance)).all(axis=1) & ~near
        near[around] = distance(points[around], thing) < tolerance
    mask = np.zeros(cloud.mask.size, bool)
    mask[index[near]] = True
    return mask.reshape(cloud.mask.shape)


def signed_distances(p: Floats, geom: Geom) -> tuple[Floats, Floats]:
    """Return signed distances (N,) [m] of points to a primitive's surface, positive outside, and its normals there.

    A convex hull counts as its bounding box.

    Args:
        p: points (N, 3) in the primitive's frame [m].

    Returns:
        The distances, and the outward unit normals (N, 3).
    """
    if geom.shape in ("box", "convex"):
        return _on_box(p, np.array(geom.size))
    radius, axis = geom.size[0], np.array([0.0, 0.0, 1.0])
    if geom.shape == "cylinder":
        return _on_cylinder(p, radius, geom.size[1])
    along = np.clip(p[:, 2], -geom.size[1], geom.size[1]) if geom.shape == "capsule" else np.zeros(len(p))
    out = p - np.outer(along, axis)
    length = np.linalg.norm(out, axis=1)
    return length - radius, out / np.maximum(length, 1e-9)[:, None]


def _on_box(p: Floats, half: Floats) -> tuple[Floats, Floats]:
    beyond = np.abs(p) - half
    outside = np.maximum(beyond, 0.0)
    length = np.linalg.norm(outside, axis=1)
    face = beyond.argmax(axis=1)
    inner = np.eye(3)[face] * np.sign(p[np.arange(len(p)), face])[:, None]
    outer = np.sign(p) * outside / np.maximum(length, 1e-9)[:, None]
    is_out = length > 0
    return np.where(is_out, length, beyond.max(axis=1)), np.where(is_out[:, None], outer, inner)


def _on_cylinder(p: Floats, radius: float, half: float) -> tuple[Floats, Floats]:
    across, beyond = np.hypot(p[:, 0], p[:, 1]), np.abs(p[:, 2]) - half
    side = np.column_stack([p[:, :2] / np.maximum(across, 1e-9)[:, None], np.zeros(len(p))])
    cap = np.outer(np.sign(p[:, 2]), (0.0, 0.0, 1.0))
    on_cap = beyond > across - radius
    return np.where(on_cap, beyond, across - radius), np.where(on_cap[:, None], cap, side)


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("tolerance_m", 0.010, "5 mm of error of the fixture's pose, and the noise of a D435 at 0.8 m"),
        Parameter("share", 0.7, "flying pixels are no more than 15 % of an edge; a tab touches a peg with less"),
    )
    return [
        Expert("known_fixture", "whether it is a part of the known surroundings", ("points", "fixtures"), ("fixture",),
               fixture, "object", cost_ms=2.0, parameters=parameters),
    ]  # fmt: skip

"""Expert for unknown obstacles: convex hulls of points that nothing known explains."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cramlite.model import Floats, Geom, Pose, Thing
from cramlite.plugin import Expert, Inputs, Parameter, hookimpl

from ..fixtures import distance

TYPE = "dul:PhysicalObject"


def obstacles(inputs: Inputs) -> Mapping[str, Any]:
    """Return convex hulls of the clusters of measured points on no fixture and on no recognised object.

    A hull of what a camera sees is open behind and below: it is let down to what is known right beneath it.
    """
    limits = inputs.parameters
    known = (*inputs["fixtures"], *inputs.get("recognised", ()))
    rest, seen = _unexplained(inputs, known)
    bodies: list[Thing] = []
    for cluster in _clusters(rest, limits):
        points = _let_down(cluster, known, limits)
        bodies += [_body(part, len(bodies) + k) for k, part in enumerate(_parts(points, seen, limits), 1)]
    return {"obstacles": tuple(bodies)}


def _unexplained(inputs: Inputs, known: Sequence[Thing]) -> tuple[Floats, Floats]:
    """Mean points of well-filled voxels, in two arrays: unexplained by any known thing, and explained by one.

    A thing explains points that are no farther from it than noise and errors of poses make likely.
    """
    view, cloud, limits = inputs["view"], inputs["cloud"], inputs.parameters
    points, depth = cloud.points[cloud.mask].astype(float), view.depth[cloud.mask].astype(float)
    points, depth = _thinned(points, depth, limits)
    away = np.full(len(points), np.inf)
    for thing in known:
        away = np.minimum(away, distance(points, thing))
    spread = limits["disparity"] * depth**2 / (view.intrinsics.fx * limits["baseline_m"])
    free = away > limits["tolerance_m"] + 3.0 * spread
    return points[free], points[~free]


def _thinned(points: Floats, depth: Floats, limits: Mapping[str, float]) -> tuple[Floats, Floats]:
    """Mean points and depths of voxels; those with few points, which may be flying pixels, are left out."""
    cells = np.floor((points - points.min(axis=0)) / limits["cell_m"]).astype(np.int64)
    size = cells.max(axis=0) + 1
    _, index, count = np.unique(
        (cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2], return_inverse=True, return_counts=True
    )
    index = index.reshape(-1)
    means = [np.bincount(index, weights=column, minlength=len(count)) / count for column in (*points.T, depth)]
    dense = count >= limits["filled"]
    return np.column_stack(means[:3])[dense], means[3][dense]


def _clusters(points: Floats, limits: Mapping[str, float]) -> Iterator[Floats]:
    """Groups of touching voxels, without groups too small to be told from noise."""
    from .clean import voxel_components

    if not len(points):
        return
    labels = voxel_components(points.astype(np.float32), {"cell_m": 1.5 * limits["cell_m"]})
    for label in range(int(labels.max()) + 1):
        own = points[labels == label]
        if len(own) >= limits["least"] and float(np.ptp(own, axis=0).max()) >= limits["smallest_m"]:
            yield own


def _let_down(points: Floats, known: Sequence[Thing], limits: Mapping[str, float]) -> Floats:
    """Extend an obstacle's points down to the surface of a fixture right beneath them, if the gap is small."""
    low = float(points[:, 2].min())
    tops = [(t.pose * f.pose).position[2] for t in known if t.mass is None for f in t.features
            if f.type == "vrps:SurfaceFeature" and _above(points, t)]  # fmt: skip
    beneath = max((z for z in tops if z <= low + limits["tolerance_m"]), default=None)
    if beneath is None or low - beneath > limits["stands_m"]:
        return points
    shadow = points.copy()
    shadow[:, 2] = beneath
    return np.concatenate([points, shadow])


def _above(points: Floats, thing: Thing) -> bool:
    """Whether the middle of some points is inside the box around a thing, seen from above."""
    from ...shapes.bounds import corners

    edges, middle = corners(thing, thing.pose)[:, :2], points.mean(axis=0)[:2]
    return bool((edges.min(axis=0) <= middle).all() and (middle <= edges.max(axis=0)).all())


def _parts(points: Floats, known: Floats, limits: Mapping[str, float]) -> Iterator[Floats]:
    """Split points in halves along the longest side of their box until no part's convex hull encloses known
    things."""
    spans = np.ptp(points, axis=0)
    if spans.max() <= 2 * limits["smallest_m"] or not _holds(points, known, limits["tolerance_m"]).any():
        yield points
        return
    axis = int(spans.argmax())
    lower = points[:, axis] < (points[:, axis].min() + points[:, axis].max()) / 2
    for part in (points[lower], points[~lower]):
        if len(part) >= 4:
            yield from _parts(part, known, limits)


def _holds(points: Floats, others: Floats, depth: float) -> Any:
    """Return a flag for each of ``others`` in the box around ``points``: whether it is over ``depth`` [m] deep
    in the convex hull of ``points``."""
    near = others[((others > points.min(axis=0)) & (others < points.max(axis=0))).all(axis=1)]
    faces = _hull(points).equations
    return (near @ faces[:, :3].T + faces[:, 3] < -depth).all(axis=1) if len(near) else np.zeros(0, bool)


def _hull(points: Floats) -> Any:
    from scipy.spatial import ConvexHull

    return ConvexHull(points, qhull_options="QJ Pp")  # flat ones are given some thickness, not refused


def _body(points: Floats, number: int) -> Thing:
    """A fixed body that is the convex hull of the points, its frame in the middle of the box around them."""
    corners = points[_hull(points).vertices]
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, 0.001)
    local = tuple(tuple(float(v) for v in c) for c in corners - middle)
    geom = Geom("convex", tuple(half.tolist()), corners=local, rgba=(0.9, 0.2, 0.6, 0.6))  # type: ignore[arg-type]
    name = f"obstacle_{number}"
    return Thing(name, TYPE, Pose(tuple(middle.tolist())), (geom,), notes=("seen; no known model explains it",))


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("cell_m", 0.008, "as the clusters of one object's points"),
        Parameter("filled", 3, "points of a voxel: a surface at 1.2 m has 6, flying pixels hardly more than one"),
        Parameter("least", 12, "voxels: 30 mm by 30 mm of a surface"),
        Parameter("smallest_m", 0.02, "what is smaller in all directions is not told from noise"),
        Parameter("tolerance_m", 0.012, "5 mm of error of a fixture's pose, 5 mm of a product's"),
        Parameter("disparity", 0.09, "of a D435, in pixels; three standard deviations are allowed"),
        Parameter("baseline_m", 0.05, "of a D435"),
        Parameter("stands_m", 0.06, "the lowest visible point of what stands on a surface is not far above it"),
    )
    return [
        Expert("unexplained", "bodies around points that nothing known explains", ("view", "cloud", "fixtures"),
               ("obstacles",), obstacles, uses=("recognised",), cost_ms=150.0, parameters=parameters),
    ]  # fmt: skip

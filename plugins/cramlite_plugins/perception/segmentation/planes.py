"""Experts for plane segmentation by RANSAC, and for the background mask that planes make."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import Expert, Inputs, Parameter, Unresolvable, hookimpl

if TYPE_CHECKING:
    from cramlite.model import Mask

    from ..values import Cloud, Plane, Points32

SAMPLE, TRIALS, MOST = 3000, 200, 5  # points that are counted, triples that are tried, planes that are looked for


def planes(inputs: Inputs) -> Mapping[str, Any]:
    """Fit the largest planes, one after another (RANSAC: Fischler and Bolles, CACM 24, 1981)."""
    cloud, view = inputs["cloud"], inputs["view"]
    points = cloud.points[cloud.mask]
    rng = np.random.default_rng(0)  # the same picture has the same planes
    sample = points[rng.integers(len(points), size=min(SAMPLE, len(points)))]
    eye = np.asarray(view.camera.position, dtype=np.float32)
    return {"planes": tuple(_largest(sample, eye, inputs.parameters, rng))}


def _largest(sample: Points32, eye: Points32, parameters: Mapping[str, float], rng: Any) -> Iterator[Plane]:
    total = len(sample)
    for _ in range(MOST):
        if len(sample) < max(50, parameters["share"] * total):
            return
        plane = _best(sample, eye, parameters["tolerance_m"], rng, total)
        if plane is None or plane.share < parameters["share"]:
            return
        on = np.abs(plane.distance(sample)) < 2 * parameters["tolerance_m"]
        if plane.extent >= parameters["extent_m"]:
            yield plane
        sample = sample[~on]


def _best(sample: Points32, eye: Points32, tolerance: float, rng: Any, total: int) -> Plane | None:
    """The plane of three points with most points near it, fitted to those by least squares."""
    from ..values import Plane

    triples = sample[rng.integers(len(sample), size=(TRIALS, 3))]
    normals = np.cross(triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    if not (lengths > 1e-6).any():
        return None
    normals = normals[lengths > 1e-6] / lengths[lengths > 1e-6, None]
    offsets = np.einsum("ij,ij->i", normals, triples[lengths > 1e-6, 0])
    near = np.abs(sample @ normals.T - offsets) < tolerance
    on = sample[near[:, int(near.sum(axis=0).argmax())]]
    centre = on.mean(axis=0)
    _, _, axes = np.linalg.svd(on - centre, full_matrices=False)
    normal = axes[2] if (eye - centre) @ axes[2] > 0 else -axes[2]
    along = (on - centre) @ axes[0]
    extent = float(np.subtract(*np.percentile(along, (97, 3)))) if len(on) else 0.0
    inside = np.abs((sample - centre) @ normal) < tolerance
    return Plane(normal, float(normal @ centre), float(inside.sum()) / total, extent)


def background(inputs: Inputs) -> Mapping[str, Any]:
    """Return the mask of background pixels: large parts of planes that are connected in the image.

    Being connected and large keeps the fronts of two boxes in one plane from being taken for a wall.
    """
    return {"background": on_planes(inputs["cloud"], inputs["planes"], inputs.parameters["thickness_m"], inputs.parameters["extent_m"])}


def on_planes(cloud: Cloud, found: Iterable[Plane], thickness: float, extent: float) -> Mask:
    """Return the mask of a cloud's points within ``thickness`` [m] of a plane, in connected parts of at least ``extent`` [m].

    Points near several planes are of the first: a face that stands on a table does not go on along the table.
    """
    from scipy import ndimage

    mask, left = np.zeros(cloud.mask.shape, bool), cloud.mask.copy()
    for plane in found:
        on = np.zeros(cloud.mask.shape, bool)
        on[left] = np.abs(plane.distance(cloud.points[left])) < thickness
        left &= ~on
        labels, _ = ndimage.label(on)
        for k, box in enumerate(ndimage.find_objects(labels), 1):
            part = labels[box] == k
            if part.sum() > 200 and _span(cloud.points[box][part]) >= extent:
                mask[box] |= part
    return mask


def _span(points: Points32) -> float:
    """Longest extent of points along a coordinate axis [m], without the lowest and the highest hundredth of them."""
    return float(np.max(np.subtract(*np.percentile(points, (99, 1), axis=0))))


def whole(inputs: Inputs) -> Mapping[str, Any]:
    """Return an empty background mask, for views without planes.

    Raises:
        Unresolvable: there are no points.
    """
    cloud = inputs["cloud"]
    if not cloud.mask.any():
        raise Unresolvable("there are no points")
    return {"background": np.zeros(cloud.mask.shape, bool)}


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("tolerance_m", 0.006, "three times the median error of a D435 below 1 m, 2 mm"),
        Parameter("share", 0.06, "of the points: a wall panel of 0.3 m in a view of 1 m"),
        Parameter("extent_m", 0.28, "longer than any product that a gripper of 85 mm takes"),
    )
    thick = (
        Parameter("thickness_m", 0.010, "five times the median error of a D435 below 1 m"),
        Parameter("extent_m", 0.20, "longer than any product that a gripper of 85 mm takes"),
    )
    return [
        Expert("ransac_planes", "large planes, by RANSAC", ("view", "cloud"), ("planes",), planes, cost_ms=60.0,
               parameters=parameters),
        Expert("plane_background", "what lies on a large plane", ("cloud", "planes"), ("background",), background,
               cost_ms=10.0, parameters=thick),
        Expert("no_background", "takes everything for foreground, where no plane is found", ("cloud",), ("background",),
               whole, cost_ms=500.0),
    ]  # fmt: skip

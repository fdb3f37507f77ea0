"""Experts that remove outliers of an object's points, by three clusterings; the fastest is asked first.

Which one is asked makes little difference (docs/explanation/perception.md): all three keep the largest cluster.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import Expert, Inputs, Parameter, Unresolvable, hookimpl

if TYPE_CHECKING:
    from ..values import Points32

    Labels = np.ndarray[Any, np.dtype[np.int64]]

Clustering = Callable[["Points32", Mapping[str, float]], "Labels"]


def _cleaned(cluster: Clustering) -> Callable[[Inputs], Mapping[str, Any]]:
    def run(inputs: Inputs) -> Mapping[str, Any]:
        segment, cloud = inputs["segment"], inputs["cloud"]
        points = cloud.points[segment.mask]
        if len(points) < inputs.parameters["least"]:
            raise Unresolvable(f"a segment of {len(points)} points is too small to be cleaned")
        labels = cluster(points, inputs.parameters)
        sizes = np.bincount(labels + 1)[1:]
        if not len(sizes):
            raise Unresolvable("all points are outliers")
        keep = labels >= 0
        large = np.flatnonzero(sizes >= inputs.parameters["share"] * len(points))
        keep &= np.isin(labels, large)
        if not keep.any():
            raise Unresolvable("no cluster has the share of the points that one object would have")
        mask = segment.mask.copy()
        mask[segment.mask] = keep
        return {"points": points[keep], "clean": mask}

    return run


def voxel_components(points: Points32, parameters: Mapping[str, float]) -> Labels:
    """Cluster points by connected voxels; faces, edges and corners connect."""
    from scipy import ndimage

    cells = np.floor((points - points.min(axis=0)) / parameters["cell_m"]).astype(np.int64)
    grid = np.zeros(np.minimum(cells.max(axis=0) + 1, 400), bool)
    cells = np.minimum(cells, np.array(grid.shape) - 1)
    grid[tuple(cells.T)] = True
    labels, _ = ndimage.label(grid, np.ones((3, 3, 3)))
    return np.asarray(labels[tuple(cells.T)].astype(np.int64) - 1)


def density(points: Points32, parameters: Mapping[str, float]) -> Labels:
    """Cluster points by DBSCAN (Ester et al., KDD 1996), with a radius and a least number of neighbours."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    near = cKDTree(points).query_pairs(parameters["radius_m"], output_type="ndarray")
    count = np.bincount(near.ravel(), minlength=len(points)) + 1
    core = count >= parameters["neighbours"]
    linked = near[core[near].all(axis=1)]
    graph = csr_matrix((np.ones(len(linked), bool), linked.T), (len(points), len(points)))
    _, labels = connected_components(graph, directed=False)
    labels = np.where(core, labels, -1)
    for a, b in ((0, 1), (1, 0)):  # a border point belongs to a core that it is near to
        border = near[core[near[:, a]] & ~core[near[:, b]]]
        labels[border[:, b]] = labels[border[:, a]]
    return _numbered(labels)


def hierarchical(points: Points32, parameters: Mapping[str, float]) -> Labels:
    """Cluster points by single linkage, cut at a distance.

    Some 2,000 of the points are clustered; each of the others gets the cluster of the nearest of these.
    """
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial import cKDTree

    step = max(1, len(points) // 2000)
    some = points[::step]
    found = fcluster(linkage(some, "single"), parameters["cut_m"], "distance")
    nearest = cKDTree(some).query(points)[1]
    return _numbered(np.asarray(found, np.int64)[nearest])


def _numbered(labels: Labels) -> Labels:
    """Cluster labels of points, renumbered as 0, 1, 2, ...; the label of noise stays -1."""
    _, numbers = np.unique(labels, return_inverse=True)
    numbers = numbers.reshape(-1).astype(np.int64)
    return np.asarray(numbers - 1 if (labels < 0).any() else numbers)


@hookimpl
def experts() -> Iterable[Expert]:
    shared = (
        Parameter("least", 40, "fewer points than a tab shows at 1 m say nothing"),
        Parameter("share", 0.10, "of the points: two sides of an occluder stay, flying pixels go"),
    )

    def expert(name: str, cluster: Clustering, cost: float, summary: str, *own: Parameter) -> Expert:
        return Expert(name, summary, ("cloud", "segment"), ("points", "clean"), _cleaned(cluster), "object",
                      cost_ms=cost, parameters=(*shared, *own))  # fmt: skip

    return [
        expert("voxel_clusters", voxel_components, 1.5, "points whose voxels touch",
               Parameter("cell_m", 0.008, "twice the distance of neighbouring pixels at 1 m")),
        expert("dbscan", density, 30.0, "points in dense places",
               Parameter("radius_m", 0.008, "as the voxels"), Parameter("neighbours", 6, "a third of a full disc's")),
        expert("single_linkage", hierarchical, 60.0, "hierarchical clustering, as in the paper",
               Parameter("cut_m", 0.012, "as the voxels, for every second point")),
    ]  # fmt: skip

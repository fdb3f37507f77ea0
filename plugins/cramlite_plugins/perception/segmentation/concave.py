"""Expert for object segmentation by shape alone: things meet at steps and concave edges, and printed textures
do not divide them.

Everything is computed in inverse depth: a plane is linear in it across the image, so bends show as second differences, and
the noise of a camera that triangulates, which grows with the square of the depth, is the same everywhere.
Concave edges part things: Stein et al., Object partitioning using local convexity, CVPR 2014.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import SEGMENTS, Expert, Inputs, Parameter, Unresolvable, hookimpl

from ..category import printed

if TYPE_CHECKING:
    from cramlite.model import Mask

    from ..values import Cloud, Plane

    Inverse = np.ndarray[Any, np.dtype[np.float64]]
    Labels = np.ndarray[Any, np.dtype[np.int32]]

DIRECTIONS = ((0, 1), (1, 0), (1, 1), (1, -1))
NEIGHBOURS = ((0, 1), (0, -1), (1, 0), (-1, 0))


def segments(inputs: Inputs) -> Mapping[str, Any]:
    """Segment the things in front of the background planes of a view, along steps of depth and concave edges.

    Raises:
        Unresolvable: the map has fixtures, on which products hang flush with each other; a known model has a print, by which
            it is told from what touches it; or nothing stands out.
    """
    from ..values import Segment

    if inputs["fixtures"]:
        raise Unresolvable("the map has fixtures, and things flush with them are separated by colour instead")
    if printed(inputs.get("looks", ())):
        raise Unresolvable("a known model has a printed texture, which separates objects better than shape")
    view, cloud, limits = inputs["view"], inputs["cloud"], inputs.parameters
    inverse = np.where(cloud.mask, 1.0 / np.where(cloud.mask, view.depth, 1.0), np.nan)
    front = _front(cloud, inverse, inputs["planes"], limits)
    labels = parted(inverse, front, limits)
    sizes = np.bincount(labels.ravel())
    found = [Segment(labels == k) for k in np.flatnonzero(sizes >= limits["pixels"]) if k > 0]
    if not found:
        raise Unresolvable(f"nothing stands out from the planes behind: {int(front.sum())} pixels in front of them")
    return {SEGMENTS: tuple(found), "explanations": ()}


def _front(cloud: Cloud, inverse: Inverse, planes: Sequence[Plane], limits: Mapping[str, float]) -> Mask:
    """Pixels whose points stand out from the planes that bound the scene, by more than noise.

    A plane with little behind it keeps the pixels in front of it, and a wide one with more behind it those on
    both sides.
    """
    from scipy import ndimage

    front, points = cloud.mask.copy(), cloud.points[cloud.mask]
    spread = limits["noise"] / inverse[cloud.mask] ** 2
    for plane in planes:
        away = plane.distance(points)
        behind = away < -limits["thickness_m"] - 3 * spread
        before = away > limits["thickness_m"] + 3 * spread
        if behind.mean() < limits["behind"]:
            front[cloud.mask] &= before
        elif plane.extent > limits["wide_m"]:
            front[cloud.mask] &= before | behind
    return np.asarray(ndimage.binary_opening(front, np.ones((3, 3))))


def parted(inverse: Inverse, front: Mask, limits: Mapping[str, float]) -> Labels:
    """Label the parts of a mask that are separated by steps and concave edges; 0 is none.

    Args:
        inverse: (height, width) inverse depth [1/m], NaN where nothing was measured.
        front: what is to be parted.
    """
    from scipy import ndimage

    steps = [_step(np.where(front, inverse, np.nan), d, limits["step"]) for d in DIRECTIONS]
    bends = _bends(inverse, front, steps, limits)
    edge = np.any([b > limits["bend"] for b in bends], axis=0)
    for (down, right), step in zip(DIRECTIONS[:2], steps[:2], strict=True):
        edge |= step | _shifted(step, -down, -right, False)
    core = ndimage.binary_erosion(front & ~edge)
    labels, _ = ndimage.label(core)
    sizes = np.bincount(labels.ravel())
    labels[sizes[labels] < limits["core"]] = 0
    return _joined(_grown(np.asarray(labels, np.int32), inverse, front, limits), bends, limits)


def _step(inverse: Inverse, direction: tuple[int, int], least: float) -> Mask:
    """Mask of pixels whose next pixel in a direction is on another surface, nearer or farther by a step."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(_shifted(inverse, *direction, np.nan) - inverse) > least)


def _bends(inverse: Inverse, front: Mask, steps: Sequence[Mask], limits: Mapping[str, float]) -> list[Inverse]:
    """Inverse depth of the chord between two pixels, less that of the pixel in the middle of them, for
    each direction in the image; NaN across a step."""
    from scipy import ndimage

    size, reach = int(limits["smooth"]), int(limits["reach"])
    share = ndimage.uniform_filter(front.astype(float), size)
    mean = ndimage.uniform_filter(np.where(front, inverse, 0.0), size) / np.maximum(share, 1e-9)
    mean = np.where(front, mean, np.nan)
    found = []
    for (down, right), step in zip(DIRECTIONS, steps, strict=True):
        far = reach if down * right == 0 else round(reach / 2**0.5)
        chord = (_shifted(mean, far * down, far * right, np.nan) + _shifted(mean, -far * down, -far * right, np.nan)) / 2
        crossed = np.zeros(front.shape, bool)
        for k in range(-far - size // 2, far + size // 2):
            crossed |= _shifted(step, k * down, k * right, False)
        found.append(np.where(crossed, np.nan, chord - mean))
    return found


def _joined(labels: Labels, bends: Sequence[Inverse], limits: Mapping[str, float]) -> Labels:
    """Return segment labels of a picture after merging segments whose common border is mostly flat or convex."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    across, most = [], int(labels.max()) + 1
    for (down, right), bend in zip(DIRECTIONS, bends, strict=True):
        theirs = _shifted(labels, down, right, 0)
        border = (labels > 0) & (theirs > 0) & (labels != theirs) & ~np.isnan(bend)
        pair = np.minimum(labels, theirs)[border] * most + np.maximum(labels, theirs)[border]
        across.append(np.column_stack([pair, bend[border]]))
    pairs = np.concatenate(across)
    same = [k for k in np.unique(pairs[:, 0]) if (own := pairs[pairs[:, 0] == k, 1]).size >= limits["border"]
            and np.median(own) < limits["bend"] / 2]  # fmt: skip
    first, second = np.divmod(np.array(same, int), most)
    graph = coo_matrix((np.ones(len(same)), (first, second)), (most, most))
    return np.asarray(connected_components(graph, directed=False)[1][labels], np.int32)


def _grown(labels: Labels, inverse: Inverse, front: Mask, limits: Mapping[str, float]) -> Labels:
    """Extend labels over unlabelled edge pixels: each pixel takes the label of the neighbour on whose surface
    it lies."""
    for _ in range(int(limits["grow"])):
        after, best = labels.copy(), np.full(labels.shape, limits["step"])
        for down, right in NEIGHBOURS:
            theirs = _shifted(labels, down, right, 0)
            with np.errstate(invalid="ignore"):
                away = np.abs(_shifted(inverse, down, right, np.nan) - inverse)
                take = front & (labels == 0) & (theirs > 0) & (away < best)
            after[take], best[take] = theirs[take], away[take]
        if np.array_equal(after, labels):
            break
        labels = after
    return labels


def _shifted(image: Any, down: int, right: int, fill: Any) -> Any:
    """Image moved so that its pixel (v, u) is the original's pixel (v + down, u + right)."""
    height, width = image.shape
    moved = np.full_like(image, fill)
    there = image[max(0, down) : height + min(0, down), max(0, right) : width + min(0, right)]
    moved[max(0, -down) : height - max(0, down), max(0, -right) : width - max(0, right)] = there
    return moved


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("noise", 0.0025, "per metre, of inverse depth: .1 pixel of disparity of a Kinect (525 pixels, 75 mm)"),
        Parameter("thickness_m", 0.004, "a plane is found to that, and tables bend"),
        Parameter("behind", 0.02, "of the points may be behind a plane that bounds the view: flying pixels"),
        Parameter("wide_m", 0.6, "a plane that long is a table or a wall, even with something behind it"),
        Parameter("step", 0.030, "per metre, of inverse depth: 17 mm at .75 m between neighbouring pixels"),
        Parameter("bend", 0.008, "per metre, of inverse depth: 4.5 mm at .75 m, three times the noise"),
        Parameter("reach", 7, "pixels to both ends of the chord: 10 mm at .75 m"),
        Parameter("smooth", 5, "pixels whose mean is compared: the noise of one is as large as a flat corner"),
        Parameter("core", 100, "pixels without an edge that make a part: a cube of 15 mm at .75 m"),
        Parameter("border", 12, "pairs of pixels, in four directions: a border 4 pixels long"),
        Parameter("grow", 30, "pixels: three times the width of a concave edge"),
        Parameter("pixels", 200, "a cube of 20 mm at .75 m"),
    )
    return [
        Expert("concave_segments", "parts between steps and concave edges, where nothing is known of the surroundings",
               ("view", "cloud", "planes", "fixtures"), (SEGMENTS, "explanations"), segments, uses=("looks",), cost_ms=5.0,
               parameters=parameters),
    ]  # fmt: skip

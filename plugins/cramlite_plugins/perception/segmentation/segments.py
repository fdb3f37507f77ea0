"""Experts for object segmentation of RGB-D images, by edges of depth and colour."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import Value
from cramlite.plugin import SEGMENTS, Expert, Inputs, Parameter, Unresolvable, hookimpl

from ..category import printed
from ..dimensions import extents

if TYPE_CHECKING:
    from cramlite.model import Mask

    from ..category import Known
    from ..values import Points32

    Floats32 = np.ndarray[Any, np.dtype[np.float32]]
    Labels = np.ndarray[Any, np.dtype[np.int32]]

BRIGHT = 40.0  # below this mean brightness (of 255) hues are noise


def segments(inputs: Inputs) -> Mapping[str, Any]:
    """Segment the foreground into connected parts between edges, and merge parts of one object.

    What an edge covers goes to its neighbour.

    Raises:
        Unresolvable: nothing stands out, or a known model has a print, whose colours have edges of their own.
    """
    from ..values import Segment

    if printed(inputs.get("looks", ())):
        raise Unresolvable("a known model has a printed texture, whose edges are no borders of objects")
    view, cloud, behind = inputs["view"], inputs["cloud"], inputs["background"]
    front = cloud.mask & ~behind
    chroma = chromaticity(view.rgb)
    labels = _labelled(front, view.depth, chroma, inputs.parameters)
    parts = [p for p in _parts(labels, cloud.points, chroma) if p.count >= inputs.parameters["pixels"]]
    merged = _merged(parts, inputs.get("looks", ()), inputs.parameters)
    found = [Segment(np.isin(labels, p.labels)) for p in merged]
    if not found:
        raise Unresolvable(f"nothing stands out from the background: {int(front.sum())} pixels in front of it")
    return {SEGMENTS: tuple(found), "explanations": ()}


def chromaticity(rgb: np.ndarray[Any, np.dtype[np.uint8]]) -> Floats32:
    """Return the red and green shares (height, width, 2) of an RGB image; shading does not change them.

    Smoothed over a pixel and its four neighbours' neighbourhood (3 x 3); dark pixels count as grey.
    """
    from scipy import ndimage

    smooth = ndimage.uniform_filter(rgb.astype(np.float32), (3, 3, 1))
    total = smooth.sum(axis=-1)
    shares = smooth[..., :2] / np.maximum(total, 1.0)[..., None]
    shares[total < 3 * BRIGHT] = 1 / 3
    return np.asarray(shares)


def _labelled(front: Mask, depth: Any, chroma: Floats32, parameters: Mapping[str, float]) -> Labels:
    """Labels of the foreground's areas between edges, grown over the pixels of the edges."""
    from scipy import ndimage

    edge = _edges(front, depth, chroma, parameters)
    labels, _ = ndimage.label(front & ~edge)
    labels = labels.astype(np.int32)
    for _ in range(int(parameters["grow"])):
        spread = ndimage.maximum_filter(labels, size=3)
        labels = np.where((labels == 0) & front, spread, labels)
    return np.asarray(labels)


def _edges(front: Mask, depth: Any, chroma: Floats32, parameters: Mapping[str, float]) -> Mask:
    """Pixels whose neighbours differ in depth by more than a step, or in colour."""
    z = np.where(front, depth, np.nan)
    edge = np.zeros(front.shape, bool)
    for axis in (0, 1):
        ahead, here = _shifted(axis)
        step = np.abs(z[ahead] - z[here]) > parameters["step"] * np.fmin(z[ahead], z[here])
        other = np.abs(chroma[ahead] - chroma[here]).max(axis=-1) > parameters["chroma"]
        edge[here] |= step | other
        edge[ahead] |= other
    return edge


def _shifted(axis: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    all_, tail, head = slice(None), slice(1, None), slice(None, -1)
    return ((tail, all_), (head, all_)) if axis == 0 else ((all_, tail), (all_, head))


class _Part(Value, eq=False):
    """Part of a picture, of one or several segments, with the properties by which parts are compared.

    These are the number of pixels, the colour, a sample of points, and the rectangle around the part.
    """

    labels: tuple[int, ...]
    count: int
    chroma: Floats32
    points: Points32
    box: tuple[int, int, int, int]


def _parts(labels: Labels, points: Points32, chroma: Floats32) -> list[_Part]:
    from scipy import ndimage

    found = []
    for k, box in enumerate(ndimage.find_objects(labels), 1):
        if box is None:
            continue
        mask = labels[box] == k
        own, colours = points[box][mask], chroma[box][mask]
        step = max(1, len(own) // 200)
        rows, columns = box
        around = (rows.start, rows.stop, columns.start, columns.stop)
        found.append(_Part((k,), len(own), np.median(colours, axis=0), own[::step], around))
    return found


def _merged(parts: list[_Part], looks: Sequence[Known], parameters: Mapping[str, float]) -> list[_Part]:
    """Join parts of a picture that may show one object; return all parts, the smallest first.

    Such parts are a box and its tab, or what is seen on both sides of an occluder.
    """
    left = sorted(parts, key=lambda p: p.count)
    done: list[_Part] = []
    while left:
        small = left.pop(0)
        partners = [p for p in left if _belong(small, p, looks, parameters)]
        if not partners:
            done.append(small)
            continue
        partner = min(partners, key=lambda p: _gap(small.points, p.points))
        left[left.index(partner)] = _joined(small, partner)
    return sorted(done, key=lambda p: p.labels)


def _joined(a: _Part, b: _Part) -> _Part:
    box = (min(a.box[0], b.box[0]), max(a.box[1], b.box[1]), min(a.box[2], b.box[2]), max(a.box[3], b.box[3]))
    return replace(
        b, labels=(*a.labels, *b.labels), count=a.count + b.count, points=np.concatenate([a.points, b.points]), box=box
    )


def _belong(small: _Part, large: _Part, looks: Sequence[Known], parameters: Mapping[str, float]) -> bool:
    """Whether two parts of a picture may show one object: alike in colour, near each other, and together not
    too large for one.

    Too large is larger than each known model of that colour; without such a model, longer than any product.
    """
    if np.abs(small.chroma - large.chroma).max() > parameters["same_chroma"]:
        return False
    gap = _gap(small.points, large.points)
    if gap > parameters["occluder_m"]:
        return False
    both = np.concatenate([small.points, large.points])
    alike = [k for k in looks if np.abs(k.chroma - large.chroma).max() < 2 * parameters["same_chroma"]]
    if alike:
        found = extents(both)
        lengths = np.sort([found.height, found.width, found.depth])
        return any((lengths <= np.array(k.lengths) + parameters["larger_m"]).all() for k in alike)
    return gap < parameters["gap_m"] and float(np.max(np.ptp(both, axis=0))) < parameters["longest_m"]


def _gap(a: Points32, b: Points32) -> float:
    return float(np.sqrt(((a[:, None] - b[None]) ** 2).sum(axis=-1).min()))


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("step", 0.025, "of the depth: ten times the noise of a D435, steeper than a face at 70 degrees"),
        Parameter("chroma", 0.030, "share of red or green: three times the noise of a smoothed pixel of 3 of 255"),
        Parameter("same_chroma", 0.035, "as above, of the medians of two parts"),
        Parameter("grow", 2, "pixels: an edge is as wide as the filters that find it"),
        Parameter("pixels", 60, "the tab of a product at 0.8 m has 100"),
        Parameter("gap_m", 0.022, "from the front of a box to its tab is half its depth, 25 mm of which edges take 5"),
        Parameter("occluder_m", 0.06, "what hides the middle of a product is at most that wide at its depth"),
        Parameter("larger_m", 0.012, "flying pixels at both ends make an object that much larger"),
        Parameter("longest_m", 0.30, "no product of the shipped scenarios is longer"),
    )
    return [
        Expert("edge_segments", "parts between edges of depth and colour", ("view", "cloud", "background"),
               (SEGMENTS, "explanations"), segments, uses=("looks",), cost_ms=70.0, parameters=parameters),
    ]  # fmt: skip

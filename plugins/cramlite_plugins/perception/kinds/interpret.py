"""Interpretation of a cluster of points: known models at poses, in any attitude, with probabilities; touching things are told apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from msgspec.structs import replace
from scipy import ndimage

from cramlite.model import Floats, Mask

from ..pose.icp import PoseBatch
from ..pose.model import Floats32, PoseModel
from ..pose.outline import Outline, tolerance
from ..pose.prior import Prior
from ..pose.score import ENOUGH, score_poses
from ..pose.starts import slid
from ..segmentation.clean import voxel_components
from .agreement import best_by_print, edged, silhouette
from .appearance import Appearance, histogram, likeness
from .joint_search import settled
from .pieces import given_back, middles, pieces
from .possible import hovers, possible
from .reading import Part, Reading, Scene, bad
from .region import Region
from .registered import (
    Ranked,
    Started,
    coarse_poses,
    coarse_reading,
    full_readings,
    pose_batch,
    posed,
    started,
)
from .standing import standing

ANY = Prior()
BESIDE = 2
"""Pixels beside a model's outline that may still show it: errors of its pose, and half a pixel."""


def wholes(scene: Scene, mask: Mask) -> list[Part]:
    """Explain each cluster of a part of the picture as one thing."""
    return [read(Region(scene, m)) for m in clusters(scene, mask)]


def several(scene: Scene, part: Part) -> bool:
    """Check whether concave edges or jumps in depth divide a region of the picture."""
    return len(pieces(scene.picture.view, part.mask, scene.limits["pixels"])) > 1


def clusters(scene: Scene, front: Mask) -> list[Mask]:
    """Return the masks of clusters of points, the largest first: points in voxels that touch are one cluster.

    Pixels beside an edge of depth are left out.
    """
    inner = front & ~scene.beside_edges
    points = scene.points[inner]
    if len(points) < scene.limits["pixels"]:
        return []
    labels = voxel_components(points.astype(np.float32), {"cell_m": scene.limits["cell_m"]})
    sizes = np.bincount(labels)
    found = []
    for k in np.argsort(-sizes, kind="stable"):
        if sizes[k] < scene.limits["pixels"]:
            break
        mask = np.zeros(front.shape, bool)
        mask[inner] = labels == k
        found.append(mask)
    return found


def extent(scene: Scene, mask: Mask) -> float:
    """Return the longest side of the box around a part of the picture, along the world's axes [m]."""
    return float(np.ptp(scene.points[mask], axis=0).max())


def whole_or_split(region: Region, whole: Part) -> Part:
    """Explain a cluster of points, which was explained as one thing, so or a part of it as one of several touching things.

    The part is returned if its explanation is better than that of the whole cluster.
    """
    scene, mask, limits = region.scene, region.mask, region.scene.limits
    among = pieces(scene.picture.view, mask, limits["pixels"])
    if whole.score < limits["good"] * region.rarity and int(mask.sum()) >= 3 * limits["pixels"]:
        least = max(limits["good"], whole.score + limits["gain"])
        for found in _ways(region, among):
            held = _held(region, found, whole.readings)
            parts = [claimed(scene, Part(mask, (r,)), among) for r in held if r.score >= least and _beside(scene, r)]
            for part in sorted(parts, key=lambda p: -p.score * p.mask.sum()):
                if _stands_out(scene, mask, part, whole.score):
                    return part
    return claimed(scene, whole, among)


def _ways(region: Region, among: Sequence[Mask]) -> Iterator[list[Reading]]:
    """Yield explanations of a cluster as several things: of its pieces, then of two and of three parts of it."""
    if len(among) > 1:
        pieces_ = among[: int(region.scene.limits["pieces"])]
        yield [r for p in pieces_ for r in read(Region(region.scene, p)).readings]
    yield from (list(partial(region, number)) for number in (2, 3))


def _stands_out(scene: Scene, mask: Mask, part: Part, whole: float) -> bool:
    """Whether one thing explains a part of a cluster better than one thing explains the whole cluster.

    The outline of the part's best explanation must run along edges of depth or colour. If one thing explains
    the whole cluster at all, the part must also have the greater product of score and pixels.
    """
    first = part.readings[0]
    if whole >= bad(mask, scene.limits) and first.score * part.mask.sum() < whole * mask.sum():
        return False
    return edged(scene.picture, mask, first.appearance, first.pose) >= scene.limits["edged"]


def partial(region: Region, number: int, *, furniture: bool = False) -> Iterator[Reading]:
    """Yield explanations of single things in a cluster of touching things: the cluster is cut into ``number``
    parts, and models are registered with each part.

    The rest of the cluster does not count against them, and hides nothing. With ``furniture``, only kinds of furniture are looked for.
    """
    scene = region.scene
    if region.seen is None:
        return
    whole = region.seen[0], region.seen[1].strict
    for mask in middles(scene.points, region.mask, number, scene.limits["pixels"]):
        part = Region(scene, mask)
        likely = [a for a in _candidates(part, partly=True) if a.model.furniture or not furniture]
        few = _of_kinds(likely, int(scene.limits["partly"]), 1)
        for begun in _begun(part, few):
            if (starts := coarse_poses(part, begun)) is not None:
                yield _touching(scene, region.mask, whole, begun.appearance, starts)


def _touching(scene: Scene, mask: Mask, whole: tuple[Floats32, Outline], appearance: Appearance, starts: PoseBatch) -> Reading:
    """Best pose of a model for one of several things that touch each other in the picture.

    It is chosen among given poses, these shifted to the ends of the cluster, and their equivalents by the
    model's symmetries.
    """
    model = appearance.surface
    near = slid(model, whole[1], starts.pick(slice(0, 4)))
    order = np.argsort(-_partly(model, whole, near), kind="stable")[: int(scene.limits["yaws"])]
    poses = [h.pose * s for h in posed(scene, near.pick(order)) for s in model.symmetries[:4]]
    fits = _partly(model, whole, pose_batch(scene, poses))
    k, colour = best_by_print(scene.picture, mask, appearance, poses, fits)
    said = f"{100 * colour:.0f} % of its printed texture agrees with the picture", "it touches something"
    return Reading(appearance, poses[k], float(fits[k]), colour, said)


def _partly(model: PoseModel, whole: tuple[Floats32, Outline], poses: PoseBatch) -> Floats:
    """Scores of poses of a model; they are not lowered by pixels of the cluster that the model leaves unexplained."""
    scores = score_poses(model, *whole, poses, 200)
    return np.asarray(scores.free**2 * np.sqrt(np.minimum(1, scores.seen / ENOUGH)), dtype=float)


def read(region: Region) -> Part:
    """Explain a region of the picture: register in full the models that coarse registration ranks first, in
    any attitude if no usual one fits."""
    limits, quick = region.scene.limits, ranked(region)
    hopeless = limits["hopeless"] * region.rarity**2
    least = max(hopeless, limits["near"] * quick[0].reading.score) if quick else 1.0
    tried = [q for q in quick[: int(limits["models"])] if q.reading.score >= least]
    found = [r for q in tried for r in full_readings(region, q, standing(q.reading.appearance))]
    some = [q for q in quick if q.reading.score >= limits["strip"]]
    if _most(found) < region.bad and region.is_covered:  # coarse ranks of a strip tell little
        others = [q for q in some[: 2 * int(limits["models"])] if q not in tried]
        found += [r for q in others for r in full_readings(region, q, standing(q.reading.appearance))]
    if _most(found) < region.bad and (some or not region.is_covered):
        loose = [q.reading.appearance for q in quick[:3] if q.reading.appearance.model.movable]  # what is fixed stands
        begun = [s for a in loose if (s := started(region, a, ANY)) is not None]
        first = max((c for s in begun if (c := coarse_reading(region, s)) is not None), key=lambda q: q.reading.score, default=None)
        if first is not None and first.reading.score >= hopeless:
            found += full_readings(region, first, ANY)
    found = _settled(region, found)
    full = {r.appearance.model.name for r in found}
    found += [q.reading for q in quick if q.reading.appearance.model.name not in full]
    found = [r for r in found if _beside(region.scene, r)]
    return Part(region.mask, tuple(sorted(_held(region, found, found), key=lambda r: -r.score)))


def _held(region: Region, readings: Sequence[Reading], rivals: Sequence[Reading]) -> list[Reading]:
    """Return explanations, less likely where they hover and one of their rivals explains the region standing on known furniture."""
    scene = region.scene
    if not any(r.score >= region.bad and not _hovers(scene, r) for r in rivals):
        return [*readings]
    return [replace(r, held=scene.limits["hover"]) if _hovers(scene, r) else r for r in readings]


def _hovers(scene: Scene, reading: Reading) -> bool:
    return hovers(scene, reading.appearance, reading.pose.apply(reading.appearance.surface.points[::10]))


def _settled(region: Region, readings: Sequence[Reading]) -> list[Reading]:
    """Return explanations, of which the best by each kind with joints, if it is not far from the best, has them where the picture
    shows them."""
    best, least = dict[str, Reading](), region.scene.limits["started"] * _most(readings)
    for reading in sorted(readings, key=lambda r: -r.score):
        best.setdefault(reading.appearance.model.name, reading)
    jointed = [r for r in best.values() if len(r.appearance.moved) and r.score >= least]
    return [settled(region, r) if any(r is j for j in jointed) else r for r in readings]


def _most(readings: Sequence[Reading]) -> float:
    return max((r.score for r in readings), default=0.0)


def _beside(scene: Scene, reading: Reading) -> bool:
    points = reading.pose.apply(reading.appearance.surface.points[::10])
    return bool(possible(scene, reading.appearance, points[None])[0])


def ranked(region: Region) -> list[Ranked]:
    """Return the best coarse registration of each model whose colours and size fit a region of the picture,
    best first."""
    quick = [q for s in _begun(region, _candidates(region)) if (q := coarse_reading(region, s)) is not None]
    best: dict[str, Ranked] = {}
    for q in sorted(quick, key=lambda q: -q.reading.score):
        best.setdefault(q.reading.appearance.model.name, q)  # of a kind's states, the likeliest
    return list(best.values())


def _begun(region: Region, appearances: Sequence[Appearance]) -> list[Started]:
    """Return the first stage of registration of models with a region, without those whose shapes fit far worse than the best.

    Joints elsewhere than in a model's file are tried where no model fits well as it is there.
    """
    begun: list[Started] = []
    for filed in (True, False):
        if filed or max((s.score for s in begun), default=0.0) < region.scene.limits["shape"]:
            begun += [s for a in appearances if a.as_filed == filed and (s := started(region, a, standing(a))) is not None]
    least = region.scene.limits["started"] * max((s.score for s in begun), default=0.0)
    return [s for s in begun if s.score >= least]


def _candidates(region: Region, *, partly: bool = False) -> list[Appearance]:
    """Known models whose colours and size fit a region of the picture, the likeliest first.

    With ``partly``, only colours decide, since the region may show two things.
    """
    scene, seen = region.scene, region.extents
    own = histogram(scene.picture.view.rgb[region.mask].astype(float))
    lengths, whole = np.sort([seen.height, seen.width, seen.depth]), not region.is_covered
    alike = [(likeness(own, a) * (1.0 if partly else _sized(lengths, a, scene.limits, whole)), a) for a in scene.appearances]
    alike.sort(key=lambda p: (-p[0], p[1].model.name))
    least = scene.limits["alike"] * (alike[0][0] if alike else 0.0)
    kept = [a for share, a in alike if share >= least and (a.as_filed or _shows(region, a))]
    return _of_kinds(kept, int(scene.limits["candidates"]), int(scene.limits["states"]))


def _shows(region: Region, appearance: Appearance) -> bool:
    """Whether a region has enough pixels of a model to show where its joints are.

    The whole model has, seen from anywhere, those of half of its box's sides on the average (Cauchy).
    """
    a, b, c = appearance.surface.extents
    view = region.scene.picture.view
    metres = float(np.nanmedian(view.depth[region.mask])) / view.intrinsics.fx
    return bool(int(region.mask.sum()) * metres * metres > region.scene.limits["shows"] * (a * b + b * c + c * a) / 2)


def _of_kinds(appearances: Sequence[Appearance], kinds: int, states: int) -> list[Appearance]:
    """Return the appearances of the first few kinds, with the first few states of each; if one, that of its file before others."""
    found: dict[str, list[Appearance]] = {}
    for a in appearances:
        if a.model.name in found or len(found) < kinds:
            found.setdefault(a.model.name, []).append(a)
    if states == 1:
        return [next((a for a in own if a.as_filed), own[0]) for own in found.values()]
    return [a for own in found.values() for a in own[:states]]


def _sized(lengths: Floats, appearance: Appearance, limits: Mapping[str, float], whole: bool) -> float:
    """Likelihood of the sorted visible extents [m] of a part of the picture, if it shows a given model.

    The smallest extent may be partly hidden, and all of them if the part may not be the whole thing; the box
    around a tilted thing is larger than the model.
    """
    own = np.sort(appearance.surface.extents)
    if lengths[2] > appearance.surface.diameter + limits["larger_m"] or lengths[1] > math.hypot(own[1], own[2]) + limits["larger_m"]:
        return 0.0
    missing = whole * np.maximum(0.0, own - lengths)[1:] / limits["missing_m"]
    excess = np.maximum(0.0, lengths - own) / limits["excess_m"]
    return math.exp(-float(missing @ missing + excess @ excess) / 2)


def claimed(scene: Scene, part: Part, among: Sequence[Mask]) -> Part:
    """Return a part of the picture reduced to the pixels that its best explanation covers, without pieces that belong to
    other parts; unchanged if it is not explained."""
    if not part.readings or part.score < bad(part.mask, scene.limits):
        return part
    first, mask, view = part.readings[0], part.mask, scene.picture.view
    local = first.pose.inverse().apply(scene.points[mask])
    nearest = first.appearance.surface.points[first.appearance.surface.grid.look_up(local.astype(np.float32))]
    away = np.linalg.norm(local - nearest, axis=1)
    own = np.zeros(mask.shape, bool)
    own[mask] = away < scene.limits["owns_m"] + tolerance(view.depth[mask])
    if not own.any():
        return part
    drawn = ndimage.binary_dilation(silhouette(view, first.appearance, first.pose), iterations=BESIDE)
    return Part(given_back(own, among, drawn), part.readings)

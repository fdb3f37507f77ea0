"""Furniture turned to where it explains its neighbours, too: the handles of a box are often regions of their own."""

from __future__ import annotations

import math
from collections.abc import Sequence

from msgspec.structs import replace
from scipy import ndimage

from cramlite.model import Pose

from .interpret import claimed, clusters, read
from .joined import beside, union
from .joint_search import settled
from .pieces import pieces
from .reading import Part, Reading, Scene, bad, rarity
from .region import Region
from .registered import Started, again, coarse_reading, full_readings, pose_batch, started
from .standing import standing

TURNS = 4
"""Number of turns of furniture about the vertical that are tried: a box looks alike from that many sides."""


def turned(scene: Scene, parts: Sequence[Part]) -> list[Part]:
    """Return parts of a picture, with furniture turned about the vertical where it explains its unexplained neighbours, too, and without
    what is on it and was taken for a part of it."""
    found = list(parts)
    for part in (p for p in parts if p.readings and p.readings[0].appearance.model.furniture and _stands(scene, p)):
        now = part
        for better, most in ((_with, "handle_m"), (_under, "apart_m")):
            near = beside(scene, now, [p for p in found if not _stands(scene, p)], scene.limits[most])
            if those := better(scene, now, near):
                mask = union(those)
                found = [p for p in found if p is not now and not any(p is n and (n.mask & mask).any() for n in near)] + those
                now = those[0]
    return found


def _under(scene: Scene, part: Part, near: Sequence[Part]) -> list[Part]:
    """Return the furniture that explains a part of its region and some of its neighbours, and the thing that explains the rest; nothing
    if edges do not divide the region, or both explain no more than the furniture alone does."""
    thing = _on(scene, part)
    if thing is None or not (rest := clusters(scene, part.mask & ~thing.mask)):
        return []
    one = _beside(scene, [*(Part(m, ()) for m in rest), *near])
    explained = sum(p.score * float(p.mask.sum()) for p in (thing, one))
    return [one, thing] if _stands(scene, one) and explained > part.score * float(part.mask.sum()) else []


def _on(scene: Scene, part: Part) -> Part | None:
    """Return the thing that can be moved and explains one of the large pieces of a part of a picture best; None if there is none.

    Its frayed border is left out: a few pixels there may join two pieces.
    """
    among = pieces(scene.picture.view, ndimage.binary_opening(part.mask), scene.limits["pixels"])
    large = [p for p in among if p.sum() >= scene.limits["divided"] * part.mask.sum()]
    found = [read(Region(scene, p)) for p in large] if len(large) > 1 else []
    good = [p for p in found if p.score >= scene.limits["good"] * rarity(p.mask, scene.limits) and p.readings[0].appearance.model.movable]
    best = max(good, key=lambda p: p.score * float(p.mask.sum()), default=None)
    return None if best is None else claimed(scene, Part(part.mask, best.readings), among)


def _beside(scene: Scene, group: Sequence[Part]) -> Part:
    whole = union(group)
    return claimed(scene, read(Region(scene, whole)), [p.mask for p in group])


def _with(scene: Scene, part: Part, near: Sequence[Part]) -> list[Part]:
    """Return furniture as it explains some of its neighbours, too; nothing if it does so no better than it explains itself."""
    if not near:
        return []
    whole = union([part, *near])
    other = _turned(Region(scene, whole), part.readings[0])
    if other is None:
        return []
    one = claimed(scene, Part(whole, (other,)), [p.mask for p in near])
    if not any((p.mask & one.mask).any() for p in near):
        return []
    own = again(Region(scene, one.mask), other.appearance, other.pose, other.reasons)
    if own is None or own.score < bad(one.mask, scene.limits):
        return []
    rivals = [r for r in part.readings if r.appearance.model.name != own.appearance.model.name]
    return [Part(one.mask, (replace(own, joints=other.joints), *rivals))]


def _stands(scene: Scene, part: Part) -> bool:
    return part.score >= bad(part.mask, scene.limits)


def _turned(region: Region, reading: Reading) -> Reading | None:
    """Return a better explanation of a region by the same model, turned about the vertical or found anew, with its joints as the picture
    shows them; None if there is none."""
    scene, now = region.scene, again(region, reading.appearance, reading.pose, ())
    filed = next(a for a in scene.appearances if a.model.name == reading.appearance.model.name and a.as_filed)
    middle = reading.pose.apply(filed.surface.centre)
    there, back = Pose(tuple(middle)), Pose(tuple(-middle))
    ways = [there * Pose.from_rotvec((0, 0, 0), (0, 0, 2 * math.pi * k / TURNS)) * back * reading.pose for k in range(TURNS)]
    begun = started(region, filed, standing(filed))
    starts = pose_batch(scene, ways) if begun is None else begun.starts.joined(pose_batch(scene, ways))
    ranked = coarse_reading(region, Started(filed, starts, 1.0))
    found = full_readings(region, ranked, standing(filed)) if ranked is not None else []
    best = max(found, key=lambda r: r.score, default=None)
    if best is None or (now is not None and best.score <= now.score):
        return None
    return settled(region, best) if len(filed.moved) else best

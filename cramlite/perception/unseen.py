"""Unseen places: volumes above furniture that occluders hide, and the share of them that a camera would see."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..model.geometry import Pose
from ..model.view import Depth, Intrinsics, Mask, Points
from ..model.world.thing import Geom, Thing
from ..ontology.foundation import BEARS, OBJECT
from ..ontology.taxonomy import Taxonomy
from .active_perception import Picture

CELL, HEIGHTS = 0.02, (0.02, 0.05)
"""Distance between sampled points along a surface, and their heights above the surface [m]. Of a box of 40 x 25 x 100 mm some four points
are inside."""
BEHIND = 0.02
"""Distance behind a measured point beyond which a place counts as hidden [m]: it exceeds three
times the noise of depth, and what a pixel at an edge is wide."""
GAP = 0.02
"""Margin of the boxes around a thing's parts, within which points count as points of the thing [m]. It covers errors of poses and depth,
half a cell, and what a grasp needs."""


def places_above(thing: Thing, taxonomy: Taxonomy) -> Points:
    """Return places (n, 3) [m] above the surfaces of a thing on which others can stand, in the world's frame."""
    tops = [f for f in thing.features if "standing" in taxonomy.fillers(f.type, BEARS) and {"width", "depth"} <= f.size.keys()]
    found = [np.empty((0, 3))]
    for top in tops:
        x, y = (np.arange(CELL / 2 - top.size[side] / 2, top.size[side] / 2, CELL) for side in ("width", "depth"))
        grid = np.stack(np.meshgrid(x, y, HEIGHTS, indexing="ij"), axis=-1).reshape(-1, 3)
        found.append((thing.pose * top.pose).apply(grid))
    return np.concatenate(found)


def hidden_behind(thing: Thing, points: Points, pictures: Sequence[Picture]) -> Points:
    """Return the points (n, 3) [m] that a thing hides in at least one picture and that no picture shows."""
    unseen, hidden = np.ones(len(points), bool), np.zeros(len(points), bool)
    for taken in pictures:
        view = taken.view
        unseen &= ~_shown(points, view.depth, view.camera, view.intrinsics)
        far, depth = _depths(points, view.depth, view.camera, view.intrinsics)
        with np.errstate(invalid="ignore"):
            before = view.camera.apply(view.camera.inverse().apply(points) * np.nan_to_num(depth / far)[:, None])
            hidden |= (far > depth + BEHIND) & _inside(before, thing)
    return points[unseen & hidden & ~_inside(points, thing)]


def unknown_body(name: str, points: Points) -> Thing:
    """Return a fixed body that fills unseen places (n, 3) [m], so that nothing is put there and no path leads through them."""
    half = (CELL / 2, CELL / 2, (HEIGHTS[1] - HEIGHTS[0]) / 2)
    geoms = tuple(Geom("box", half, Pose((x, y, z))) for x, y, z in points.tolist())
    return Thing(name, OBJECT, Pose(), geoms, notes=("nobody has seen what is there",))


def share_shown(points: Points, depth: Depth, camera: Pose, intrinsics: Intrinsics) -> float:
    """Return the share of points (n, 3) [m] that a noiseless depth image [m] shows from an optical frame's
    pose.

    A depth of NaN means infinitely far.
    """
    far = np.where(np.isnan(depth), np.inf, depth)
    return float(_shown(points, far, camera, intrinsics).mean()) if len(points) else 0.0


def _shown(points: Points, depth: Depth, camera: Pose, intrinsics: Intrinsics) -> Mask:
    far, seen = _depths(points, depth, camera, intrinsics)
    with np.errstate(invalid="ignore"):
        shown: Mask = far <= seen + BEHIND
    return shown


def _depths(points: Points, depth: Depth, camera: Pose, intrinsics: Intrinsics) -> tuple[Points, Points]:
    """Return the depth of points along the optical axis, and the image's depth at the same pixels; NaN
    outside of the image."""
    local = camera.inverse().apply(points)
    pixels = np.nan_to_num(np.round(intrinsics.project(local)), nan=-1.0).astype(int)
    within = (pixels >= 0).all(axis=-1) & (pixels < (intrinsics.width, intrinsics.height)).all(axis=-1)
    seen = np.full(len(points), np.nan)
    seen[within] = depth[pixels[within, 1], pixels[within, 0]]
    return np.where(within, local[:, 2], np.nan), seen


def _inside(points: Points, thing: Thing) -> Mask:
    """Mask of points in the boxes around a thing's parts, or within ``GAP`` of them."""
    found = np.zeros(len(points), bool)
    for geom in thing.geoms:
        local = (thing.pose * geom.pose).inverse().apply(points)
        found |= (np.abs(local) <= np.add(geom.half_extents, GAP)).all(axis=1)
    return found

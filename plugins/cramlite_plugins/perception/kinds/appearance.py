"""Appearance of known models: surface, colours on it, colour histograms of their sides, and which side is up."""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import Any

import numpy as np
from scipy import ndimage

from cramlite.model import Floats, Mask, Pose, Thing, Value, Vector3

from ...imports.library.attitudes import upward
from ...shapes.skins import Skin, skin_of
from ..pose.model import Lookups, ModelKey, NearestGrid, PoseModel, pose_model, with_symmetries
from .joint_states import moved_by
from .kept import Arrays, file_of, keep, kept
from .samples import sampled

CHROMA, BRIGHTNESS = 8, 3
"""Bins of red and green shares each, and of brightness relative to the brightest."""
LOW, HIGH = 0.05, 0.75
"""Range of the shares of red and green that the bins divide: values outside of it, such as 0.9 of pure colours in white light, go to the
first or the last bin."""
BLUR = 0.8
"""Standard deviation of a colour in bins: shading, gamma and noise move it over a border."""
DARK = 40.0
"""Sum of channels below which shares are noise and count as grey."""

STANDING = 0.9
"""Least cosine between an upward direction of furniture and the same one where it is turned to look alike."""


class Appearance(Value, eq=False):
    """Appearance of a known model.

    Args:
        model: the thing, at the origin, its joints at some values.
        surface: for registration.
        colours: (N, 3) of the surface's points, 0 to 255.
        sides: (14, bins) colour histograms of what is seen along each axis and diagonal.
        up: directions of its frame that may point up where it stands.
        printed: whether it has a texture.
        moved: (J, N) which of the surface's points each joint moves.
    """

    model: Thing
    surface: PoseModel
    colours: Floats
    sides: Floats
    up: tuple[Vector3, ...]
    printed: bool
    moved: Mask

    @property
    def as_filed(self) -> bool:
        """Check whether the model's joints stand as in its file."""
        mesh = self.model.mesh
        return mesh is None or all(value == j.joint.value for value, j in zip(mesh.values, mesh.joints, strict=False))


def appearance_of(model: Thing) -> Appearance:
    """Return the appearance of a model; computed once for each shape and texture."""
    return _made(ModelKey(repr(model), model))


@lru_cache(maxsize=512)
def _made(key: ModelKey) -> Appearance:
    model = key.thing
    file = file_of(model.mesh)
    known = kept(file)
    if known is None:
        skin = skin_of(model.mesh)
        if skin is None:
            return _plain(model)
        known = _arrays(model, skin)
        keep(file, known)
    return _printed(model, known)


def _plain(model: Thing) -> Appearance:
    """Appearance of a model without a texture: it has the colour of its largest shape."""
    surface = pose_model(model)
    largest = max(model.geoms, key=lambda g: float(np.prod(sorted(g.half_extents)[-2:])))
    colours = np.tile(np.array(largest.rgba[:3]) * 255.0, (len(surface.points), 1))
    still = np.zeros((0, len(colours)), bool)
    return Appearance(model, surface, colours, _sides(surface, colours), ((0.0, 0.0, 1.0),), False, still)


def _arrays(model: Thing, skin: Skin) -> Arrays:
    """Return surface, colours, symmetries and lookup tables of a model with a texture as arrays."""
    found = sampled(skin)
    points, normals, colours = (a.astype(np.float32) for a in (found.points, found.normals, found.colours))
    surface = with_symmetries(PoseModel(model.name, model.type, points, normals))
    up = model.mesh.up if model.mesh is not None else None
    standing = (up,) if up is not None else tuple(u for u, _ in upward(_hull(found.points)))
    grid, joints = surface.grid, model.mesh.joints if model.mesh is not None else ()
    return {
        "moved": moved_by(joints, skin, found.points, found.normals),
        "points": points, "normals": normals, "colours": colours, "up": np.array(standing, float),
        "symmetries": np.array([(*s.position, *s.quaternion) for s in surface.symmetries]), "axis": np.array(surface.axis or (), float),
        "low": grid.low, "step": np.array(grid.step), "index": grid.index, "opposite": surface.opposite_points,
    }  # fmt: skip


def _printed(model: Thing, known: Arrays) -> Appearance:
    """Return the appearance of a model with a texture from its arrays."""
    up = tuple(map(tuple, known["up"].tolist()))
    symmetries = tuple(s for row in known["symmetries"].tolist() if _stands(model, s := Pose(tuple(row[:3]), tuple(row[3:])), up))
    lookups = Lookups(NearestGrid(known["low"], float(known["step"]), known["index"]), known["opposite"])
    axis = tuple(known["axis"].tolist()) or None
    surface = PoseModel(model.name, model.type, known["points"], known["normals"], symmetries, axis, model.features, lookups)
    colours = known["colours"].astype(float)
    return Appearance(model, surface, colours, _sides(surface, colours), up, True, known["moved"])


def _stands(model: Thing, turned: Pose, up: tuple[Vector3, ...]) -> bool:
    """Whether a turned model may stand so: what is fixed does not stand on its top."""
    return model.movable or all(float(np.dot(turned.rotate(u), u)) > STANDING for u in up)


def _hull(points: Floats) -> Any:
    import trimesh

    return trimesh.Trimesh(points, process=False)


def _sides(surface: PoseModel, colours: Floats) -> Floats:
    ways = [np.array(w, float) for w in itertools.product((-1, 0, 1), repeat=3) if sum(map(abs, w)) in (1, 3)]
    found = []
    for way in ways:
        facing = np.clip(surface.normals @ (way / np.linalg.norm(way)), 0.0, None)
        found.append(histogram(colours, facing))
    return np.array(found)


def histogram(colours: Floats, weights: Floats | None = None) -> Floats:
    """Return the blurred colour histogram (bins,) of colours (N, 3), with the sum 1.

    Brightness is relative to that of the brightest colours, whatever the light.
    """
    weights = np.ones(len(colours)) if weights is None else weights
    if not weights.sum() > 0:
        return np.zeros(CHROMA * CHROMA * BRIGHTNESS)
    total = colours.sum(axis=1)
    shares = np.where(total[:, None] > DARK, colours[:, :2] / np.maximum(total, 1.0)[:, None], 1 / 3)
    brightest = np.percentile(total[weights > 0], 95)
    bright = np.clip(total / max(float(brightest), 1.0), 0.0, 0.999)
    bins = np.clip(((shares - LOW) / (HIGH - LOW) * CHROMA).astype(int), 0, CHROMA - 1)
    level = (bright * BRIGHTNESS).astype(int)
    flat = np.bincount((bins[:, 0] * CHROMA + bins[:, 1]) * BRIGHTNESS + level, weights, CHROMA * CHROMA * BRIGHTNESS)
    soft = ndimage.gaussian_filter(flat.reshape(CHROMA, CHROMA, BRIGHTNESS), BLUR, mode="constant")
    return np.asarray(soft.reshape(-1) / max(float(soft.sum()), 1e-12))


def likeness(own: Floats, appearance: Appearance) -> float:
    """Return how well a colour histogram agrees with the most similar side of a known model, 0 to 1.

    The agreement is the histograms' intersection.
    """
    return float(np.minimum(own[None], appearance.sides).sum(axis=1).max())

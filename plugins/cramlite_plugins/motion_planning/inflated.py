"""Inflated collision models: one MuJoCo collision check of bigger shapes finds every pair that is near.

A contact margin would do the same in theory. In MuJoCo 4.0.0 it does not: of 15,000 random pairs of boxes
nearer than the margin 1,078 gave no contact, the nearest at 1.0 mm, and the distances of cylinders come out
up to 0.6 mm too large. Overlaps are always found, so each shape grows by half of the distance, and
``mj_geomDistance``, which agrees with Coal to 1e-6 m, measures the few pairs that then overlap.
"""

from __future__ import annotations

import copy
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Value

BITS = 31  # of a collision mask
CORNER = 3**0.5  # a corner of a grown box moves further out than its faces
MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
# A convex hull does not grow with its size; for it a margin is right: with half of the distance none of 153
# pairs that were missed without it was missed (300 arm positions, two hulls), and this is a little more.
MESH_MARGIN = 0.6
COARSE = 1e-4
"""Tolerance of collision detection between inflated shapes [m], which are inflated by as much more: no near
pair is missed, and the distances of found pairs are measured exactly. With MuJoCo's 1e-6 a position that is
blocked takes a quarter longer."""
GROWS = np.zeros((int(mujoco.mjtGeom.mjGEOM_MESH) + 1, 3))  # sizes of a geom that are lengths, by type
GROWS[int(mujoco.mjtGeom.mjGEOM_SPHERE), :1] = GROWS[int(mujoco.mjtGeom.mjGEOM_CYLINDER), :2] = 1.0
GROWS[int(mujoco.mjtGeom.mjGEOM_CAPSULE), :2] = GROWS[int(mujoco.mjtGeom.mjGEOM_BOX), :3] = 1.0


class Inflated(Value):
    """Planning model whose shapes are inflated, so that bodies nearer than a distance overlap in it.

    Args:
        distance: pairs nearer than this overlap, and some that are up to sqrt(3) times as far [m].
        model: of the same sizes as the planning model, so that it shares its data.
    """

    distance: float
    model: Any

    def near(self, data: Any) -> set[tuple[int, int]]:
        """Return the pairs of geoms that may be near; forward kinematics must have been computed in
        ``data``."""
        mujoco.mj_collision(self.model, data)
        return {(g, h) for g, h in data.contact.geom.tolist()} if data.ncon else set()

    def near_apart(self, data: Any) -> set[tuple[int, int]]:
        """Return the pairs of geoms that may be near, where geoms were moved without their bodies: MuJoCo's
        bounding boxes of bodies are not used."""
        options, flags = self.model.opt, self.model.opt.disableflags
        options.disableflags = flags | int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
        found = self.near(data)
        options.disableflags = flags
        return found


def inflated(model: Any, apart: Floats, distance: float) -> Inflated:
    """Inflate the geoms of a model; only pairs that some joint of the arm moves relative to each other
    collide.

    Args:
        model: the planning model; it is not changed.
        apart: (geoms, geoms) above 0 where a joint changes where one is as seen from the other.
        distance: see ``Inflated`` [m].
    """
    grown, by = copy.copy(model), (distance + COARSE) / 2
    grown.geom_size[:] = model.geom_size + by * GROWS[model.geom_type]
    grown.geom_margin[model.geom_type == MESH] = MESH_MARGIN * distance
    grown.geom_rbound[:] = model.geom_rbound + by * CORNER
    by = max(by, MESH_MARGIN * distance)
    grown.geom_aabb[:, 3:] = model.geom_aabb[:, 3:] + by
    grown.bvh_aabb[:, 3:] = model.bvh_aabb[:, 3:] + by * CORNER
    grown.opt.ccd_tolerance = COARSE
    grown.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)  # one contact of each pair is enough
    _mask(grown, apart > 0)
    return Inflated(distance, grown)


def _mask(model: Any, meets: Any) -> None:
    """Set the contact bits of geoms such that MuJoCo compares only the pairs that ``meets`` (geoms, geoms)
    allows.

    Geoms that meet the same ones share a bit; the last bit is for all geoms beyond the available bits.
    """
    rows, group = np.unique(meets, axis=0, return_inverse=True)
    group, others = np.minimum(group.reshape(-1), BITS - 1), (1 << (BITS - 1)) if len(rows) > BITS else 0
    first = [int(np.flatnonzero(group == k)[0]) for k in range(min(len(rows), BITS))]
    masks = [others | sum(1 << k for k, one in enumerate(first) if meets[of, one]) for of in first]
    if others:
        masks[-1] = (1 << BITS) - 1
    collides = (model.geom_contype | model.geom_conaffinity) > 0
    model.geom_contype[:] = np.where(collides, np.left_shift(1, group), 0)
    model.geom_conaffinity[:] = np.where(collides, np.array(masks)[group], 0)

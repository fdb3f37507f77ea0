"""Distances between boxes, which MuJoCo's contact margin gets wrong.

MuJoCo 4.0.0 reports every overlap of two boxes, but of 15,000 random pairs of boxes nearer than the margin
1,078 gave no contact, the nearest at 1.0 mm. ``mj_geomDistance`` agrees with Coal and with a numerical
minimum to 1e-6 m, but costs some microseconds a pair, so it is only asked where a bound is not enough.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from cramlite.geometry import Floats

BOX = int(mujoco.mjtGeom.mjGEOM_BOX)
EXACT_BELOW = 0.012  # where the bound is below this, the exact distance is asked for [m]


@dataclass(frozen=True)
class Boxes:
    """The boxes that move with the arm and those that stand.

    Args:
        moving, standing: geom ids, (m,) and (s,).
        reach: bounding radii of the moving ones (m, 1) [m]; where a pair need not keep apart, it is -inf: (m, s).
        half: half-extents of the standing ones, one after the other: (3 s,) [m].
        turn: their rotations side by side: (3, 3 s); origin: their centres, each in its own axes: (3 s,) [m].
        both: pairs of moving boxes that can meet: (p, 2).
    """

    moving: Any
    standing: Any
    reach: Floats
    half: Floats
    turn: Floats
    origin: Floats
    both: Any

    def placed(self, data: Any) -> Boxes:
        """The same boxes with the standing ones where ``data`` has them; needs kinematics."""
        turns = data.geom_xmat[self.standing].reshape(-1, 3, 3)
        origin = np.einsum("sij,si->sj", turns, data.geom_xpos[self.standing]).reshape(-1)
        return replace(self, turn=turns.transpose(1, 0, 2).reshape(3, -1).copy(), origin=origin)

    def near(self, model: Any, data: Any, horizon: float) -> tuple[Any, Floats]:
        """The pairs (n, 2) within the horizon and a lower bound of each distance, exact where it is small [m].

        The bound is the distance of the moving one's centre from the standing box, less its bounding radius.
        """
        local = np.abs(data.geom_xpos[self.moving] @ self.turn - self.origin) - self.half
        np.maximum(local, 0.0, out=local)
        np.multiply(local, local, out=local)
        bound = np.sqrt(local.reshape(len(self.moving), -1, 3).sum(axis=2)) - self.reach
        row, column = (bound < horizon).nonzero()
        pairs = np.stack([self.moving[row], self.standing[column]], axis=1)
        distances: Floats = bound[row, column]
        if len(self.both):
            pairs = np.concatenate([pairs, self.both])
            distances = np.concatenate([distances, np.zeros(len(self.both))])
        for k in (distances < EXACT_BELOW).nonzero()[0].tolist():
            distances[k] = mujoco.mj_geomDistance(model, data, int(pairs[k, 0]), int(pairs[k, 1]), horizon, None)
        return pairs, distances


def boxes(model: Any, data: Any, need: Floats, movers: Any) -> Boxes:
    """Take the distances of boxes out of MuJoCo's hands: afterwards its collision check leaves pairs of boxes out.

    Args:
        data: state after kinematics, with everything that does not move with the arm in its place.
        need: (geoms, geoms) distance to keep; -inf for pairs that are not looked at.
        movers: ids of the geoms that move with the arm.
    """
    pairs = [pair for pair in np.argwhere(np.triu(need > -np.inf, 1)).tolist() if _collide(model, *pair)]
    moves = np.isin(np.arange(model.ngeom), movers)
    box = model.geom_type == BOX
    moving, standing = np.flatnonzero(moves & box), np.flatnonzero(~moves & box)
    wanted = {(g, h) if moves[g] else (h, g) for g, h in pairs if moves[g] != moves[h]}
    mask = np.array([[(g, h) in wanted for h in standing.tolist()] for g in moving.tolist()], dtype=bool)
    reach = np.where(mask.reshape(len(moving), len(standing)), model.geom_rbound[moving][:, None], -np.inf)
    both = np.array([p for p in pairs if moves[p[0]] and moves[p[1]]], dtype=int).reshape(-1, 2)
    half = model.geom_size[standing].reshape(-1)
    _mask(model, moves, box)
    return Boxes(moving, standing, reach, half, np.zeros((3, 0)), np.zeros(0), both).placed(data)


def _mask(model: Any, moves: Any, box: Any) -> None:
    """Contact bits: 1 and 2 moving others and boxes, 4 and 8 standing others and boxes; boxes never meet boxes."""
    model.geom_contype[:] = np.select([moves & ~box, moves & box, ~moves & ~box], [1, 2, 4], 8)
    model.geom_conaffinity[:] = np.select([moves & ~box, moves & box], [1 | 2 | 4 | 8, 1 | 4], 0)


def _collide(model: Any, g: int, h: int) -> bool:
    """Two boxes that MuJoCo's filters let collide: masks, one body, parent and child, excluded bodies."""
    if not model.geom_type[g] == model.geom_type[h] == BOX:
        return False
    a, b = int(model.geom_bodyid[g]), int(model.geom_bodyid[h])
    masks = model.geom_contype[g] & model.geom_conaffinity[h] or model.geom_contype[h] & model.geom_conaffinity[g]
    one, other = int(model.body_weldid[a]), int(model.body_weldid[b])
    parents = {int(model.body_weldid[model.body_parentid[w]]) for w in (one, other) if w}
    kin = one == other or (bool(parents & {one, other}) and 0 not in (one, other))
    excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
    return bool(masks) and not kin and (a, b) not in excluded and (b, a) not in excluded

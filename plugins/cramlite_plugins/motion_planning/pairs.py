"""Collision pairs: which joints move which geoms, and what distance each pair must keep."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from cramlite.model import Floats

from ..simulation.model.compile import Compiled
from ..simulation.model.index import Owner, RobotIndex

Pairs = frozenset[frozenset[str]]


def movers(compiled: Compiled, index: RobotIndex) -> Floats:
    """Return (geoms, joints): 1 where joint j of the arm is above geom g in the kinematic tree, else 0."""
    model = compiled.model
    bodies = [int(model.jnt_bodyid[np.flatnonzero(model.jnt_qposadr == a)[0]]) for a in index.joints]
    result = np.zeros((model.ngeom, len(bodies)))
    for g in range(model.ngeom):
        body = int(model.geom_bodyid[g])
        while body > 0:
            if body in bodies:
                result[g, bodies.index(body)] = 1.0
            body = int(model.body_parentid[body])
    return result


def required_distances(
    compiled: Compiled, moved: Floats, allowed: Pairs, clearance: float, wider: Mapping[str, float] = MappingProxyType({})
) -> Floats:
    """Return the distance (geoms, geoms) [m] that each pair of geoms must keep.

    Two that no joint moves apart, or that are allowed to touch, need none (-inf).

    Args:
        wider: thing -> what its pairs must keep beyond the clearance [m]; of two the larger counts.
    """
    apart = (moved[:, None, :] != moved[None, :, :]).any(axis=2)
    more = np.array([wider.get(o.name, 0.0) if o.kind == "thing" else 0.0 for o in compiled.owners])
    need = np.where(apart, clearance + np.maximum(more[:, None], more[None, :]), -np.inf)
    for pair in allowed:
        one, other = (tuple(pair) * 2)[:2]
        first = np.array([_is(o, one) for o in compiled.owners])
        second = np.array([_is(o, other) for o in compiled.owners])
        both = np.outer(first, second)
        need[both | both.T] = -np.inf
    return need


def _is(owner: Owner, name: str) -> bool:
    """Whether a geom's owner is what an allowed pair names."""
    return name in (owner.name, owner.touch, owner.kind) and name != "thing"

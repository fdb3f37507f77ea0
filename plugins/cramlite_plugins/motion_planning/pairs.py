"""Collision pairs: which joints move which geoms, and what distance each pair must keep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    alike = moved @ 2.0 ** np.arange(moved.shape[1])  # the same number for geoms that the same joints move
    apart = alike[:, None] != alike[None, :]
    more = np.array([wider.get(o.name, 0.0) if o.kind == "thing" else 0.0 for o in compiled.owners])
    need = np.where(apart, clearance + np.maximum(more[:, None], more[None, :]), -np.inf)
    named = _named(compiled.owners)
    for pair in allowed:
        one, other = (tuple(pair) * 2)[:2]
        first, second = named.get(one, []), named.get(other, [])
        need[np.ix_(first, second)] = need[np.ix_(second, first)] = -np.inf
    return need


def _named(owners: Sequence[Owner]) -> Mapping[str, list[int]]:
    """The geoms of each name that an allowed pair may have."""
    found: dict[str, list[int]] = {}
    for g, owner in enumerate(owners):
        for name in {owner.name, owner.touch, owner.kind} - {"thing"}:
            found.setdefault(name, []).append(g)
    return found
